"""Effects get the same inputs from a motion under design as from its recording."""

import numpy as np
import pytest
from design_examples import SECONDS, rods
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.excite.reading import Reading
from lagrangian_ff.diagnosis.excite.splines import AT_REST, Splines
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification.basis import Term

Floats = NDArray[np.float64]

SPLINES = Splines(SECONDS, 43)
INDEX = np.arange(5, len(SPLINES.time), 16)


def control() -> Floats:
    found = np.tile(rods().data.q.mean(axis=0), (SPLINES.count, 1))
    inner = slice(AT_REST, -AT_REST)
    found[inner] += np.random.default_rng(0).normal(0.0, 0.1, found[inner].shape)
    return found


@pytest.mark.parametrize("names", [("stribeck",), ("hysteresis", "load_friction"), ("backlash",)])
def test_effects_read_what_they_read_of_a_recording(names: tuple[str, ...]) -> None:
    model = rods()
    terms = [
        Term(effect, 1, {shape.name: shape.start for shape in effect.shapes})
        for effect in (EFFECTS[name] for name in names)
    ]
    width = model.basis.sign_speed(2)
    x = Reading(model, terms, SPLINES, INDEX, width).of(control())
    q, qd, qdd, _ = (rate @ control() for rate in SPLINES.rates)
    whole = model.inputs(q, qd, qdd, time=SPLINES.time, segment=np.zeros(len(q), dtype=np.int64))
    for term in terms:
        expected = term.columns(whole)[INDEX]
        assert np.ptp(expected) > 0.0
        np.testing.assert_allclose(term.columns(x), expected, rtol=1e-9, atol=1e-12)


def test_the_load_nearby_is_that_of_the_other_motion() -> None:
    model = rods()
    reading = Reading(model, (), SPLINES, INDEX, model.basis.sign_speed(2))
    rates = SPLINES.rates[:3]
    ways = [rate @ control() for rate in rates]
    steps = [1e-4 * rate[:, 11] for rate in rates]
    q, qd, qdd = ways
    load = model.inputs(q, qd, qdd).load
    near = reading.nearby(ways, load, [1])[1]
    moved = [way + np.outer(step, [0.0, 1.0]) for way, step in zip(ways, steps, strict=True)]
    q, qd, qdd = moved
    change = model.inputs(q, qd, qdd).load - near.load
    assert np.abs(change).max() > 0.0
    np.testing.assert_allclose(near.at(steps) - near.load, change, atol=2e-3 * np.abs(change).max())
