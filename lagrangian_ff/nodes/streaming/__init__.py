"""The way from a reference to a safe stream of torques. Free of rclpy."""
