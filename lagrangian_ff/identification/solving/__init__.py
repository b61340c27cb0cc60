"""Solving the semi-parametric model, its hyperparameters given: exactly or on landmarks."""
