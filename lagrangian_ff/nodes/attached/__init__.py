"""What is shown of a running arm, and the motions it is sent; `sender` alone knows ROS."""
