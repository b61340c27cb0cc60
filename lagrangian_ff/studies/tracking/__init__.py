"""Tracking error over speed with precomputed torque: Fig. 6 of the paper."""
