"""Torque error over speed with masses on the arm: Fig. 7 of the paper."""
