"""Choosing a kernel, its hyperparameters and the effects' shapes."""
