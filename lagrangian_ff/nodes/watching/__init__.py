"""Holding a model against joint states as they come. Nothing here imports rclpy."""
