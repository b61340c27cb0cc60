"""Figures and pages that show a person what was found.

`figures` holds one figure a file, drawn by matplotlib without a display; `interactive` those that
are drawn in the reader's browser; `sections` one part of a page a file, each a function that turns
findings into a `Section`. `write_page` puts sections into one file that needs nothing else: styles,
pictures and scripts are inside. `pages` holds the pages of compare, diagnose and history. Whoever
makes a page lists the sections it shall have, once.
"""

from lagrangian_ff.lazy import attach

__getattr__, __all__ = attach(__name__, __file__)
