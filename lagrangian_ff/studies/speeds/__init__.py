"""Torque error over speed: Fig. 5 of the paper."""
