"""Robot dynamics that are learned, explained and used, inside ROS 2."""

__version__ = "1.0.0"
