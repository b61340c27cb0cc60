"""The list of targets. A new one is a file of this folder, and its line here."""

from fuzz.target import Target
from fuzz.targets import bags, models, tables, urdf

TARGETS: tuple[Target, ...] = (
    bags.SQLITE,
    bags.MCAP,
    tables.CSV,
    tables.NPZ,
    models.MODEL,
    urdf.URDF,
    tables.TRAJECTORY,
)
