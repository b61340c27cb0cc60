"""Interactive figures: valid for plotly, true to the record, safe inside a page."""

import base64
import gzip
import json
import re
from dataclasses import replace
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest
from diagnosis_examples import changed, consequence, finding, full_run
from hypothesis import given
from hypothesis import strategies as st
from page_examples import JOINTS, SCRIPT, bins, compared, comparison

from lagrangian_ff.diagnosis import Comparison
from lagrangian_ff.diagnosis.compare import Interval
from lagrangian_ff.report.colours import AFTER, BAD, faded
from lagrangian_ff.report.plot import Plot, embed
from lagrangian_ff.report.sections.changed import changes_plot
from lagrangian_ff.report.sections.findings import before_after_plot, partial_residual_plot
from lagrangian_ff.report.sections.history import fall_plot, joints_fall_plot
from lagrangian_ff.report.sections.joints import orders_plot, residual_plot, torque_plot
from lagrangian_ff.report.sections.ranking import ranking_plot
from lagrangian_ff.report.sections.regions import blocks_plot, dependence_plot


def sure() -> Comparison:
    """Torques over time with intervals."""
    found = comparison()
    reach = np.repeat(0.5 + 0.01 * np.arange(60.0)[:, None], 2, axis=1)
    interval = Interval(JOINTS, np.arange(60), reach, np.full(2, 0.9), 6)
    return replace(found, interval=interval)


def plots() -> dict[str, Plot]:
    """One of each."""
    where = compared().where
    return {
        "torque": torque_plot(where.comparison, "elbow"),
        "torque with interval": torque_plot(sure(), "elbow"),
        "residual": residual_plot(bins("elbow", "velocity")),
        "directions": residual_plot(bins("elbow", "direction")),
        "dependence": dependence_plot(where.bins),
        "blocks": blocks_plot(where),
        "orders": orders_plot(where.spectra[0]),
        "partial residual": partial_residual_plot(finding().partial_residual, "stribeck"),
        "before and after": before_after_plot(consequence()),
        "ranking": ranking_plot(full_run().diagnosis),
        "fall": fall_plot(["as it was", "+ stribeck on elbow"], [2.0, 1.0]),
        "changes": changes_plot([changed("payload")], ["shoulder", "elbow"]),
        "joints": joints_fall_plot(["identified", "+ a"], {"elbow": [2.0, 1.0]}),
        "fall from": fall_plot(["question 1", "question 2"], [1.0, 0.9], 1.5),
        "joints from": joints_fall_plot(["question 1"], {"elbow": [1.0]}, {"elbow": 2.0}),
    }


def read(piece: str) -> dict[str, Any]:
    """What the browser reads of an embedded figure."""
    found = re.search(r'<script type="text/plain">(.*?)</script>', piece)
    assert found is not None
    return dict(json.loads(gzip.decompress(base64.b64decode(found[1]))))


@pytest.mark.parametrize("name", plots())
def test_plotly_takes_every_figure(name: str) -> None:
    """plotly checks names and values of everything against its schema."""
    plot = read(embed(plots()[name], name))
    figure = go.Figure(plot)
    assert len(figure.data) == len(plot["data"]) > 0
    assert figure.layout.height == plots()[name].height


def test_the_residual_is_measured_less_predicted_and_broken_at_a_gap() -> None:
    measured, predicted, left = torque_plot(comparison(), "elbow").data
    assert measured["y"].count(None) == predicted["y"].count(None) == left["y"].count(None) == 1
    pairs = zip(measured["y"], predicted["y"], left["y"], strict=True)
    assert all(m is None or r == pytest.approx(m - p) for m, p, r in pairs)


def test_intervals_lie_behind_the_lines_and_are_switched_together() -> None:
    found = sure()
    around, zero, *lines = torque_plot(found, "elbow").data
    assert [one["name"] for one in lines] == ["measured", "predicted", "measured − predicted"]
    assert around["name"] == "90 % interval"
    assert around["showlegend"]
    assert not zero["showlegend"]
    assert around["legendgroup"] == zero["legendgroup"]
    assert (zero["yaxis"], around["fill"]) == ("y2", "toself")
    # Each stretch goes there along the upper end, back along the lower one, and then breaks.
    assert found.interval is not None
    half, predicted, reach = 30, found.predicted[:, 1], found.interval.reach[:, 1]
    upper, lower = (predicted + reach).tolist(), (predicted - reach).tolist()
    first = upper[:half] + lower[:half][::-1]
    second = upper[half:] + lower[half:][::-1]
    assert around["y"] == [*first, None, *second]
    assert around["x"].index(None) == zero["x"].index(None) == 2 * half
    assert max(y for y in zero["y"] if y is not None) == reach[-1]


def test_bins_are_drawn_where_they_are() -> None:
    entry = bins("elbow", "velocity")
    _, curve, bars = residual_plot(entry).data
    assert curve["y"] == entry.mean.tolist()
    edges = [x - 0.5 * w for x, w in zip(bars["x"], bars["width"], strict=True)]
    assert edges == pytest.approx(entry.low)
    assert bars["y"] == pytest.approx(100.0 * entry.share_of_error)


def test_a_coordinate_of_few_values_is_drawn_by_their_words() -> None:
    points, bars = residual_plot(bins("elbow", "direction")).data
    assert points["x"] == bars["x"] == ["backwards", "forwards"]


def test_a_block_that_got_worse_is_not_drawn_as_better() -> None:
    after = before_after_plot(consequence()).data[-1]
    assert after["marker"]["color"] == [AFTER, BAD]


def test_the_strongest_candidate_is_on_top() -> None:
    plot = ranking_plot(full_run().diagnosis)
    assert plot.data[0]["y"][0] == "stribeck on elbow"
    assert plot.layout["yaxis"]["autorange"] == "reversed"


def test_a_spectrums_lines_are_named() -> None:
    notes = orders_plot(compared().where.spectra[0]).layout["annotations"]
    assert [one["text"] for one in notes] == ["20"]


@given(st.floats(allow_nan=True, allow_infinity=True), st.text())
def test_any_number_and_text_goes_through_the_page(value: float, text: str) -> None:
    piece = embed(Plot([{"x": [value], "name": text + SCRIPT}]), "alternative")
    trace = read(piece)["data"][0]
    assert trace["name"] == text + SCRIPT
    if value != value or abs(value) == float("inf"):
        assert trace["x"] == [None]
    else:
        assert trace["x"][0] == pytest.approx(value, rel=1e-4, abs=1e-300)


def test_colours_fade() -> None:
    assert faded("#c2410c", 0.5) == "rgba(194,65,12,0.5)"


def test_a_fall_shows_what_it_is_without_the_effects_that_were_found() -> None:
    plot = fall_plot(["question 1", "question 2"], [1.0, 0.9], 1.5)
    level, fall = plot.data
    assert (list(level["y"]), list(fall["y"])) == ([1.5, 1.5], [1.0, 0.9])
    assert level["name"] == "the last model without what was found: 1.50 N·m"
    assert plot.layout["yaxis"]["range"][1] > 1.5
    assert len(fall_plot(["as it was", "+ a"], [2.0, 1.0]).data) == 1
    shares = joints_fall_plot(["question 1", "question 2"], {"elbow": [1.0, 0.5]}, {"elbow": 2.0})
    assert list(shares.data[0]["y"]) == [50.0, 25.0]
