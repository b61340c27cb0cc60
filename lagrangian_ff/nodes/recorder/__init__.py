"""Recording joint states, and the jobs done with recordings. Free of rclpy."""
