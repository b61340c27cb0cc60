"""Where a model fails: in which region of speed, position, load, direction or time.

`series` is the residual of a model along a motion, `coordinates` lists what it may depend on, one
small object each. `bins` averages the residual over one of them, `regions` finds the few places
that hold most of the error, `orders` the waves over the joint's angle, and `locate` does it all for
one comparison.
"""

from lagrangian_ff.diagnosis.where.bins import Bins, bins_of
from lagrangian_ff.diagnosis.where.coordinates import COORDINATES, PAIRS
from lagrangian_ff.diagnosis.where.locate import Compared, Localisation, locate
from lagrangian_ff.diagnosis.where.orders import Spectrum, order_spectrum
from lagrangian_ff.diagnosis.where.regions import Condition, Region, find_regions
from lagrangian_ff.diagnosis.where.series import ResidualSeries

__all__ = [
    "COORDINATES",
    "PAIRS",
    "Bins",
    "Compared",
    "Condition",
    "Localisation",
    "Region",
    "ResidualSeries",
    "Spectrum",
    "bins_of",
    "find_regions",
    "locate",
    "order_spectrum",
]
