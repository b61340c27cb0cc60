"""Predictions in the order of time are those of the whole motion, memory included."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from small_model import motion_at, save_small_model

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Model, extend
from lagrangian_ff.nodes.watching.live import BEHIND, Judged, LivePrediction
from lagrangian_ff.nodes.watching.states import State

Floats = NDArray[np.float64]


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    return save_small_model(tmp_path_factory.mktemp("live") / "model.npz")


def states(count: int, segment: int = 1) -> list[State]:
    time = np.linspace(2.0 * segment, 2.0 * segment + 0.01 * (count - 1), count)
    q, qd, qdd = motion_at(time)
    at = np.round(time * 1e9).astype(int).tolist()
    return [State(at[k], segment, False, q[k], qd[k], qdd[k], np.zeros(2)) for k in range(count)]


def batches(whole: list[State], size: int) -> Iterator[list[State]]:
    for first in range(0, len(whole), size):
        yield whole[first : first + size]


def predicted(judged: list[Judged]) -> Floats:
    return np.stack([each.predicted for each in judged])


def of_motion(model: Model, whole: list[State]) -> Floats:
    q, qd, qdd = (np.stack([getattr(s, name) for s in whole]) for name in ("q", "qd", "qdd"))
    time = np.array([s.at / 1e9 for s in whole])
    return model.predict(q, qd, qdd, time=time, segment=np.array([s.segment for s in whole]))


@pytest.mark.parametrize("size", [1, 3, 40])
def test_without_memory_each_state_is_predicted_at_once(model: Model, size: int) -> None:
    whole = states(40)
    live = LivePrediction(model)
    judged = [each for batch in batches(whole, size) for each in live.take(batch)]
    assert [each.state for each in judged] == whole
    np.testing.assert_allclose(predicted(judged), of_motion(model, whole), rtol=1e-9)
    np.testing.assert_allclose(judged[3].residual, -judged[3].predicted)
    assert live.take([]) == []


@pytest.mark.parametrize("size", [1, 7])
@pytest.mark.parametrize(
    ("effect", "shape"), [("hysteresis", {"w": 3e-3}), ("delay", {}), ("stribeck", {"v_s": 0.1})]
)
def test_with_memory_the_motion_so_far_is_seen(
    model: Model, effect: str, shape: dict[str, float], size: int
) -> None:
    larger = extend(model, EFFECTS[effect], "b", shape).model
    # The fitted coefficient is next to nothing, for nothing is missing.
    fitted = larger.coefficients[:-1]
    bare, larger = (replace(larger, coefficients=np.append(fitted, last)) for last in (0.0, 5.0))
    whole = states(150)
    without = of_motion(bare, whole)
    live = LivePrediction(larger)
    judged = [each for batch in batches(whole, size) for each in live.take(batch)]
    assert live.waits == (0 if effect == "stribeck" else BEHIND)
    assert len(judged) == len(whole) - live.waits
    expected = of_motion(larger, whole)[: len(judged)]
    np.testing.assert_allclose(predicted(judged), expected, rtol=1e-6, atol=1e-6)
    assert np.abs(expected - without[: len(judged)]).max() > 0.5


def test_what_waited_at_an_interruption_is_left_out(model: Model) -> None:
    larger = extend(model, EFFECTS["delay"], "b", {}).model
    live = LivePrediction(larger)
    judged = [each for batch in (states(20, 1), states(20, 2)) for each in live.take(batch)]
    assert [each.state.segment for each in judged] == [1] * 18 + [2] * 18
