"""Theorem 2: with ever more samples, only what the friction basis cannot be is left."""
