"""Every kernel has its own stroke, and every curve its name where it can be read."""

import numpy as np
import pytest
from matplotlib.text import Annotation

from lagrangian_ff.identification.spec import ALTERNATIVES
from lagrangian_ff.kernels import KERNELS
from lagrangian_ff.report.style import png
from lagrangian_ff.studies.curves import OTHER, STROKES, Curve, curves_figure, spread, stroke_of


@pytest.mark.parametrize(
    "places", [[0.1, 0.5, 0.9], [0.5, 0.5, 0.5], [0.1, 0.12, 0.13, 0.3], [0.0, 0.09, 0.18, 0.2]]
)
def test_names_keep_their_order_and_stand_apart(places: list[float]) -> None:
    moved = spread(np.array(places), 0.1)
    assert np.all(np.diff(moved) >= 0.1 - 1e-12)
    # Crowds share the room about their middle: on the whole nothing moves.
    assert moved.mean() == pytest.approx(np.mean(places))


def test_names_with_room_stay_where_they_are() -> None:
    np.testing.assert_allclose(spread(np.array([0.1, 0.3, 0.31, 0.9]), 0.05)[[0, 3]], [0.1, 0.9])


def test_every_curve_is_drawn_and_named_in_its_panel() -> None:
    curves = {"high": Curve([1.0, 2.0], [5.0, 4.0]), "low": Curve([1.0, 2.0], [0.1, 0.2])}
    figure = curves_figure({"both": curves, "none": {}, "one": {"alone": curves["low"]}}, "x", "y")
    both, one = figure.axes
    assert [axes.get_title("left") for axes in (both, one)] == ["both", "one"]
    named = [text for text in both.texts if isinstance(text, Annotation)]
    assert {text.get_text(): tuple(text.xy) for text in named} == {
        "high": (2.0, 4.0),
        "low": (2.0, 0.2),
    }
    assert len(one.lines) == 1
    low, high = both.get_ylim()
    assert low < 0.1
    assert high > 5.0
    assert png(figure).startswith(b"\x89PNG")


def test_nothing_done_is_said() -> None:
    figure = curves_figure({"panel": {}}, "x", "y")
    assert [text.get_text() for text in figure.texts] == ["no case is done"]


def test_every_kernel_is_drawn_in_its_own_way() -> None:
    assert set(STROKES) == {*KERNELS, *ALTERNATIVES} - {"none"}
    assert len({(stroke.colour, stroke.dashes) for stroke in STROKES.values()}) == len(STROKES)
    assert stroke_of("vrbfs+fri") == STROKES["vrbfs"]
    assert stroke_of("none+fri") == OTHER
