"""Figures: valid pictures that show what they are given."""

from dataclasses import replace
from typing import cast

import matplotlib
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from report_examples import JOINTS, comparison, motion, runs

from lagrangian_ff.diagnosis.compare import Interval
from lagrangian_ff.numbers import mrad
from lagrangian_ff.report import html
from lagrangian_ff.report.sections.torque import torque_figure
from lagrangian_ff.report.sections.tracking import tracking_bars_figure, tracking_time_figure
from lagrangian_ff.report.style import MOST_POINTS, png, thinned


def figures() -> dict[str, Figure]:
    """One of each."""
    found = comparison()
    return {
        "torque": torque_figure(found.motion, found.predicted),
        "bars": tracking_bars_figure({"one": runs(), "other": runs()}),
        "time": tracking_time_figure(runs()),
    }


@pytest.mark.parametrize("name", ["torque", "bars", "time"])
def test_a_figure_is_a_png_of_its_size(name: str) -> None:
    figure = figures()[name]
    data = png(figure)
    assert data.startswith(html.PNG)
    width, height = (int.from_bytes(data[k : k + 4], "big") for k in (16, 20))
    inches = figure.get_size_inches()
    assert (width, height) == pytest.approx(tuple(inches * figure.dpi), abs=1)


@pytest.mark.parametrize(
    ("count", "name", "size"),
    [
        (1, 30 * "long", 1.0), (2, "shoulder_pan_joint", 1.3e4), (3, 30 * "long", 1.0),
        (7, "joint", 0.0171),
    ],
)  # fmt: skip
def test_any_number_of_titles_stay_in_their_column_and_above_their_axes(
    count: int, name: str, size: float
) -> None:
    found = motion(joints=tuple(f"{name}_{n}" for n in range(count)))
    tau = size * found.tau
    figure = torque_figure(replace(found, tau=tau), 0.81 * tau)
    assert len(figure.axes) == 2 * count
    assert png(figure).startswith(html.PNG)  # lays it out
    assert isinstance(figure.canvas, FigureCanvasAgg)
    renderer = figure.canvas.get_renderer()
    torques = figure.axes[::2]
    for n, (axes, joint) in enumerate(zip(torques, found.joints, strict=True)):
        title = axes.get_title(loc="left")
        assert title.replace("\n", "").startswith(joint)
        around = axes.get_tightbbox(renderer)
        assert around is not None
        assert around.y1 <= figure.bbox.y1
        right = figure.bbox.x1
        if n % 2 == 0 and n + 1 < count:
            beside = torques[n + 1].yaxis.get_tightbbox(renderer)
            assert beside is not None
            right = beside.x0
        assert around.x1 <= right


def line(figure: Figure, axes: int, label: str) -> Line2D:
    """The line of this label."""
    lines = figure.axes[axes].get_lines()
    return next(one for one in lines if one.get_label() == label)


def values(one: Line2D) -> np.ndarray:
    """What is drawn, without the breaks between segments."""
    drawn = np.asarray(cast(np.ndarray, one.get_ydata()), dtype=np.float64)
    return np.asarray(drawn[np.isfinite(drawn)])


def test_measured_predicted_and_residual_torque_are_drawn() -> None:
    found = comparison()
    figure = torque_figure(found.motion, found.predicted)
    for n in range(len(JOINTS)):
        np.testing.assert_allclose(values(line(figure, 2 * n, "measured")), found.motion.tau[:, n])
        np.testing.assert_allclose(values(line(figure, 2 * n, "predicted")), found.predicted[:, n])
        residual = values(line(figure, 2 * n + 1, "measured − predicted"))
        np.testing.assert_allclose(residual, found.residual[:, n])


def test_the_interval_is_a_band_around_the_prediction_and_around_zero() -> None:
    found = comparison()
    at = np.arange(0, len(found.motion), 3)
    reach = np.tile([0.2, 0.4], (len(at), 1))
    interval = Interval(JOINTS, at, reach, np.array([0.9, 0.9]), 2)
    figure = torque_figure(found.motion, found.predicted, interval)
    for n in range(len(JOINTS)):
        for axes, middle in ((figure.axes[2 * n], found.predicted[at, n]), (figure.axes[2 * n + 1],
                             0.0 * at)):  # fmt: skip
            ends = np.concatenate([p.vertices for p in axes.collections[0].get_paths()])
            assert ends[:, 1].max() == pytest.approx((middle + reach[:, n]).max())
            assert ends[:, 1].min() == pytest.approx((middle - reach[:, n]).min())
    shown = {text.get_text() for text in figure.legends[0].get_texts()}
    assert "90 % interval" in shown


def test_no_line_is_drawn_across_a_gap() -> None:
    found = comparison()
    drawn = np.asarray(
        line(torque_figure(found.motion, found.predicted), 0, "measured").get_ydata()
    )
    assert np.isnan(drawn).sum() == 1


def test_torque_and_residual_have_the_same_scale() -> None:
    found = comparison()
    figure = torque_figure(found.motion, found.predicted)
    png(figure)  # lays it out
    torque, residual = figure.axes[:2]
    per_inch = [np.ptp(axes.get_ylim()) / axes.get_position().height for axes in (torque, residual)]
    assert per_inch[0] == pytest.approx(per_inch[1], rel=0.05)


def test_everything_drawn_is_inside_the_axes() -> None:
    for figure in figures().values():
        for axes in figure.axes:
            low, high = axes.get_ylim()
            for one in axes.get_lines():
                data = values(one)
                assert low <= data.min()
                assert data.max() <= high


def test_a_prediction_of_another_motion_is_refused() -> None:
    with pytest.raises(ValueError, match="prediction of"):
        torque_figure(motion(), np.zeros((3, 2)))


def test_tracking_is_drawn_in_mrad() -> None:
    figure = tracking_time_figure(runs())
    for run in runs():
        np.testing.assert_allclose(values(line(figure, 0, run.label)), 1e3 * run.error[:, 0])


def test_bars_are_as_high_as_the_errors_and_say_so() -> None:
    axes = tracking_bars_figure({"one": runs()}).axes[0]
    bars = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
    heights = sorted(bar.get_height() for bar in bars)
    expected = sorted(1e3 * x for run in runs() for x in (*run.rms, run.total))
    np.testing.assert_allclose(heights, expected)
    said = {text.get_text() for text in axes.texts}
    assert said == {mrad(float(x)) for run in runs() for x in (*run.rms, run.total)}


@pytest.mark.parametrize("nothing", [{}, {"one": []}])
def test_nothing_cannot_be_drawn_as_bars(nothing: dict[str, list[object]]) -> None:
    with pytest.raises(ValueError, match="at least one"):
        tracking_bars_figure(nothing)  # type: ignore[arg-type]


def test_nothing_cannot_be_drawn_over_time() -> None:
    with pytest.raises(ValueError, match="at least one"):
        tracking_time_figure([])


def test_long_lines_are_thinned_and_keep_their_ends() -> None:
    time = np.arange(10 * MOST_POINTS, dtype=np.float64)
    some, other = thinned(time, 2.0 * time)
    assert len(some) == MOST_POINTS
    assert (some[0], some[-1]) == (time[0], time[-1])
    np.testing.assert_array_equal(other, 2.0 * some)


def test_drawing_leaves_the_settings_of_the_user_alone() -> None:
    before = dict(matplotlib.rcParams)
    png(tracking_time_figure(runs()))
    assert dict(matplotlib.rcParams) == before
