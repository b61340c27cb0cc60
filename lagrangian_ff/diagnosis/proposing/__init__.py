"""Formulas proposed for a torque that no effect of the catalogue explains."""
