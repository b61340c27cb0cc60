"""From a reference to a safe stream of torques. Nothing here imports rclpy."""
