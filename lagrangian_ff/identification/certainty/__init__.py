"""Calibrated uncertainty of a model's torques and of its effects' parameters."""
