"""The library that draws interactive figures, as text to be put into a page once."""

from importlib.resources import files

from lagrangian_ff.errors import UserError


class PlotlyMissingError(UserError):
    """plotly, whose JavaScript draws the figures, is not installed or not whole."""


def scripts() -> str:
    """plotly.js and what starts it, as script elements.

    Raises:
        PlotlyMissingError: what to install.
    """
    try:
        from plotly.offline import get_plotlyjs

        library = get_plotlyjs()
    except (ImportError, OSError) as error:
        raise PlotlyMissingError(
            f"interactive pages need the Python package plotly with its JavaScript ({error}); "
            "install it: pip install plotly"
        ) from error
    start = files(__package__).joinpath("start.js").read_text(encoding="utf-8")
    return f"<script>{library}</script>\n<script>\n{start}</script>\n"
