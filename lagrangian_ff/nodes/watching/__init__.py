"""The comparison of a model with live joint states. Free of rclpy."""
