"""Figures and pages that show a person what was found.

`figures` holds one figure a file, drawn by matplotlib without a display; `sections` one part of a
page a file, each a function that turns findings into a `Section`. `write_page` puts sections into
one file that needs nothing else: styles and pictures are inside. Whoever makes a page lists the
sections it shall have, once.
"""

from lagrangian_ff.report.page import write_page
from lagrangian_ff.report.section import Section
from lagrangian_ff.report.tracking import Tracking

__all__ = ["Section", "Tracking", "write_page"]
