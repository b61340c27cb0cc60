"""Learning torques from independent samples: as the paper does, and as this package does."""
