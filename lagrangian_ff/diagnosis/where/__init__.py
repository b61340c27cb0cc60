"""Where a model fails: in which region of speed, position, load, direction or time.

`coordinates` lists what the error is looked at against, one small object each. `bins` averages the
residual over one of them, `regions` finds the few places that hold most of the error, `orders` the
waves over the joint's angle, and `locate` does it all for one comparison.
"""

from lagrangian_ff.diagnosis.where.bins import Bins, bins_of
from lagrangian_ff.diagnosis.where.coordinates import COORDINATES, Coordinate
from lagrangian_ff.diagnosis.where.course import Course
from lagrangian_ff.diagnosis.where.locate import Whereabouts, locate
from lagrangian_ff.diagnosis.where.orders import Spectrum, order_spectrum
from lagrangian_ff.diagnosis.where.regions import Condition, Region, find_regions

__all__ = [
    "COORDINATES",
    "Bins",
    "Condition",
    "Coordinate",
    "Course",
    "Region",
    "Spectrum",
    "Whereabouts",
    "bins_of",
    "find_regions",
    "locate",
    "order_spectrum",
]
