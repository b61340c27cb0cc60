"""When the monitor warns, and the share of torques outside the intervals of the model."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from fake_model import RANGE
from small_model import Floats, motion_at, save_small_model, torque_of

from lagrangian_ff.identification import Model, Score
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.watching.health import FEWEST, PAUSE, Coverage, Health, Limits
from lagrangian_ff.nodes.watching.live import Judged
from lagrangian_ff.nodes.watching.states import State

LIMITS = Limits(window=5.0, still=0.01, margin=0.05, warn=2.0, error=4.0)
JOINTS = ("joint_1", "joint_3")
SCORE = Score(("joint_1", "joint_3"), np.array([1.0, 0.5]), np.array([0.1, 0.1]))


def judged(
    seconds: float, error: tuple[float, float], speed: float = 1.0, q: float = 0.0
) -> Judged:
    tau = np.array(error)
    where = np.full(2, q)
    state = State(round(seconds * 1e9), 1, False, where, np.full(2, speed), np.zeros(2), tau)
    return Judged(state, np.zeros(2))


def status(*given: Judged, score: Score = SCORE) -> Status:
    health = Health(JOINTS, score, RANGE)
    for each in given:
        health.add(each, LIMITS)
    return health.status(LIMITS, {"more": 1})


def run(error: tuple[float, float], count: int = 100, **more: float) -> list[Judged]:
    return [judged(0.05 * k, error, **more) for k in range(count)]


@pytest.mark.parametrize(
    ("error", "level", "message"),
    [
        ((1.2, 0.5), Level.OK, "as when identified: at most 1.2 times the error of then (joint_1)"),
        ((1.0, 1.55), Level.WARN, "residual of joint_3 is 3.1 times what it was when identified"),
        ((2.5, 2.5), Level.ERROR, "residual of joint_3 is 5.0 times what it was when identified; "
         "residual of joint_1 is 2.5 times what it was when identified"),
    ],
)  # fmt: skip
def test_the_status_names_the_worst(error: tuple[float, float], level: Level, message: str) -> None:
    found = status(*run(error))
    assert (found.level, found.message) == (level, message)
    assert found.values["more"] == 1


def test_only_the_last_seconds_count() -> None:
    bad = run((9.0, 9.0), 100)
    good = [judged(5.0 + 0.05 * k, (1.0, 0.5)) for k in range(110)]
    assert status(*bad).level is Level.ERROR
    assert status(*bad, *good).level is Level.OK


def test_a_joint_at_rest_is_not_judged() -> None:
    found = status(*run((9.0, 9.0), speed=0.001))
    assert found.level is Level.OK
    assert "no joint moves enough" in found.message
    assert found.values["joint_1"] == "hardly moves: not judged"
    assert status(*run((9.0, 9.0), FEWEST - 1)).level is Level.OK


def test_outside_the_identified_range_the_model_is_not_blamed() -> None:
    found = status(*run((9.0, 9.0), q=3.0))
    assert found.level is Level.WARN
    assert "100% of the last 5 s lie outside the range the model was identified on" in found.message
    half = [judged(0.05 * k, (9.0 * (k % 2), 0.4), q=3.0 * (k % 2)) for k in range(100)]
    found = status(*half)
    assert found.level is Level.WARN
    assert "50% of the last" in found.message


def test_a_clock_set_back_forgets() -> None:
    found = status(*run((9.0, 9.0)), *[judged(-50.0 + 0.05 * k, (1.0, 0.5)) for k in range(50)])
    assert found.level is Level.OK


@pytest.mark.parametrize("error", [0.0, float("nan")])
def test_a_record_without_an_error_leaves_a_thousandth_of_the_torque(error: float) -> None:
    score = Score(JOINTS[:1], np.array([error]), np.array([error]))
    # The largest torque identified is 50 N·m.
    assert status(*run((0.06, 0.06)), score=score).level is Level.OK
    assert status(*run((0.15, 0.0)), score=score).level is Level.WARN


def test_nothing_seen_is_stale() -> None:
    assert status().level is Level.STALE
    health = Health(JOINTS, SCORE, RANGE)
    health.add(judged(0.0, (1.0, 1.0)), LIMITS)
    health.forget()
    assert health.status(LIMITS, {}).level is Level.STALE


LIMITS = Limits(window=5.0, still=0.01, margin=0.05, warn=2.0, error=4.0)
KEY = "outside the 90 % interval"


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    """Return a small model."""
    return save_small_model(tmp_path_factory.mktemp("cover") / "model.npz")


def watch(
    cover: Coverage, model: Model, begin: float, wrong: float = 0.0, still: bool = False
) -> None:
    """Show it 6 s of motion at 100 Hz, joint b wrong by `wrong` N·m, or joint b at rest."""
    time = np.arange(begin, begin + 6.0, 0.01)
    q, qd, qdd = motion_at(time)
    tau = torque_of(q, qd, qdd)
    predicted = model.predict(q, qd, qdd)
    tau[:, 1] = predicted[:, 1] + wrong
    if still:
        qd[:, 1] = 0.0
    for k, at in enumerate(time):
        state = State(round(at * 1e9), 1, False, q[k], qd[k], qdd[k], tau[k])
        cover.add(Judged(state, predicted[k]), LIMITS)


def test_what_the_model_cannot_have_meant_is_counted(model: Model) -> None:
    cover = Coverage(model)
    watch(cover, model, 0.0)
    values = cover.values()
    assert values[f"{KEY} b"] == "0%"
    assert float(values[f"{KEY} a"].rstrip("%")) <= 40.0
    watch(cover, model, 6.0, wrong=5.0)
    assert cover.values()[f"{KEY} b"] == "100%", "only the last seconds count"
    watch(cover, model, 3.0)
    assert cover.values()[f"{KEY} b"] == "0%", "a clock set back forgets"
    cover.forget()
    assert cover.values() == {}


def test_a_joint_at_rest_has_no_share(model: Model) -> None:
    cover = Coverage(model)
    watch(cover, model, 0.0, wrong=5.0, still=True)
    assert list(cover.values()) == [f"{KEY} a"]


@dataclass
class Counting:
    """Intervals of 1 N·m to each side that count how often they are asked for."""

    model: Model
    asked: int = 0

    @property
    def joints(self) -> tuple[str, ...]:
        return self.model.joints

    @property
    def quick_uncertainty(self) -> "Counting":
        return self

    def reach(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        self.asked += 1
        return np.ones(2)


def test_the_model_is_asked_now_and_then(model: Model) -> None:
    counting = Counting(model)
    watch(Coverage(counting), model, 0.0)  # type: ignore[arg-type]
    assert 1 < counting.asked <= 6.0 / PAUSE + 1


def test_models_without_a_calibration_have_no_share(model: Model) -> None:
    assert Coverage.of(replace(model, record={})) is None
