"""The solution of a problem, its hyperparameters given: exact or on inducing points."""
