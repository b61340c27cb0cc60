"""The simulated arm: links with the dynamics of PyBullet; drives, servo, sensors and motions.

Names are imported on first use, so that a trajectory can be read without PyBullet.
"""

from lagrangian_ff.lazy import attach

__getattr__, __all__ = attach(__name__, __file__)
