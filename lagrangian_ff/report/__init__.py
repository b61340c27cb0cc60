"""Figures and pages that show a person what was found.

`figures` holds one figure a file, drawn by matplotlib without a display; `interactive` those that
are drawn in the reader's browser; `sections` one part of a page a file, each a function that turns
findings into a `Section`. `write_page` puts sections into one file that needs nothing else: styles,
pictures and scripts are inside. `pages` holds the pages of compare, diagnose and history. Whoever
makes a page lists the sections it shall have, once.
"""

from lagrangian_ff.report.page import write_page
from lagrangian_ff.report.pages.compare import compare_page
from lagrangian_ff.report.pages.diagnose import diagnose_page
from lagrangian_ff.report.pages.history import history_page
from lagrangian_ff.report.section import Section
from lagrangian_ff.report.tracking import Tracking

__all__ = [
    "Section",
    "Tracking",
    "compare_page",
    "diagnose_page",
    "history_page",
    "write_page",
]
