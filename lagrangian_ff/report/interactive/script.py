"""The library that draws interactive figures, put into a page once.

plotly.js, its cartesian bundle (npm: plotly.js-cartesian-dist-min 4.1.1), lies beside this file as
gzip packed it. Pages hold it, and the figures' data, in that form: a third of their size.
"""

import base64
import gzip
from importlib.resources import files

LIBRARY = "plotly-cartesian.min.js.gz"


def packed(text: str) -> str:
    """A text as gzip packs it, written in base64."""
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode("ascii")


def scripts() -> str:
    """plotly.js and what unpacks and starts it, as script elements."""
    here = files(__package__)
    library = base64.b64encode(here.joinpath(LIBRARY).read_bytes()).decode("ascii")
    start = here.joinpath("start.js").read_text(encoding="utf-8")
    return (
        f'<script type="text/plain" id="library">{library}</script>\n<script>\n{start}</script>\n'
    )
