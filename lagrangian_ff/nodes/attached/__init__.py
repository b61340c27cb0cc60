"""What a page is shown of a running arm, and the motions it sends; `sender` alone knows ROS."""
