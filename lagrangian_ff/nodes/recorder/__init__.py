"""Recording joint states and identifying from them. Nothing here imports rclpy."""
