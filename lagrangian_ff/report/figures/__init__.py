"""One figure a file; each returns a matplotlib figure and shows nothing on a screen."""

from lagrangian_ff.report.figures.torque import torque_figure
from lagrangian_ff.report.figures.tracking_bars import tracking_bars_figure
from lagrangian_ff.report.figures.tracking_time import tracking_time_figure

__all__ = ["torque_figure", "tracking_bars_figure", "tracking_time_figure"]
