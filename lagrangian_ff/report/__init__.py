"""Pages and figures that show a person what was found.

`pages` holds the pages of compare, diagnose and history; each lists its sections once. A section is
one file in `sections`: a function that turns a result into text and figures. To add one, write its
file and put it in the list of its page. `write_page` makes one file of them that needs nothing
else: styles, pictures and scripts are inside.
"""

from lagrangian_ff.lazy import attach

__getattr__, __all__ = attach(__name__, __file__)
