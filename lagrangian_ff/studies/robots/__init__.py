"""Random serial robots: how they are drawn, their torques, and samples of them."""
