"""Figures that can be zoomed, hovered and switched, drawn by plotly.js in the reader's browser.

A figure is a small function that returns a `Plot`: what plotly.js is to draw, as plain data.
`embed` puts it into a section; `write_page` then adds the library once, inside the page, so that
the page works from the file alone, without a network.
"""

from lagrangian_ff.report.interactive.plot import Plot, embed

__all__ = ["Plot", "embed"]
