"""What a page is shown of a running arm, and the motions that it sends; `sender` alone knows ROS."""
