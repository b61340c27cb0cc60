"""The picture of what an effect looks like."""

import numpy as np
import pytest

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.report.effect_picture import HEIGHTS, JOINT, motion, signature_figure


@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_every_effect_is_drawn_with_its_numbers(name: str) -> None:
    effect = EFFECTS[name]
    figure = signature_figure(effect)
    words = [text.get_text() for text in figure.texts]
    words += [axes.get_title(loc="left") for axes in figure.axes]
    said = " ".join(words).replace("\n", " ")
    assert name in said
    assert effect.formula in said
    assert all(f"{p.name} = " in said for p in effect.parameters)
    assert all(f"{s.name} = " in said for s in effect.shapes)
    largest = max(
        np.nanmax(np.abs(np.asarray(line.get_ydata(), dtype=np.float64)))
        for line in figure.axes[0].get_lines()
    )
    assert 0.5 * HEIGHTS[0] < largest <= 1.05 * sum(HEIGHTS)


def test_the_motion_is_one() -> None:
    """Its velocity and acceleration are the derivatives of its position; it creeps and reverses."""
    x = motion()
    np.testing.assert_allclose(x.qd[1:-1], np.gradient(x.q, x.time, axis=0)[1:-1], atol=2e-3)
    np.testing.assert_allclose(x.qdd[1:-1], np.gradient(x.qd, x.time, axis=0)[1:-1], atol=1e-2)
    speed = np.abs(x.qd[:, JOINT])
    assert np.median(speed[x.time < 5.0]) < 0.5 < 2.0 < speed.max()
    assert np.count_nonzero(np.diff(np.sign(x.qd[:, JOINT]))) > 5
    assert 5.0 < np.ptp(x.q[:, JOINT]) < 2.0 * np.pi


def test_the_spectrum_shows_the_order_that_a_search_starts_at() -> None:
    ripple = EFFECTS["ripple"]
    figure = signature_figure(ripple)
    left = next(axes for axes in figure.axes if axes.get_xlabel().startswith("order"))
    heights = [patch.get_height() for patch in left.patches]  # type: ignore[attr-defined]
    assert np.argmax(heights) + 1 == ripple.shapes[0].start
