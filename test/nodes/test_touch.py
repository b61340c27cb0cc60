"""The alarm: touches are noticed within a tenth of a second, and usual motion raises none."""

import copy
from collections.abc import Container, Iterator

import numpy as np
import pytest
from small_model import JOINTS, Floats, motion_at, torque_of

from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateView
from lagrangian_ff.nodes.common.models import conditioning_for
from lagrangian_ff.nodes.common.status import Level
from lagrangian_ff.nodes.watching.chance import LEARNING
from lagrangian_ff.nodes.watching.live import LivePrediction
from lagrangian_ff.nodes.watching.states import LiveStates
from lagrangian_ff.nodes.watching.touch import Touch, TouchAlarm
from lagrangian_ff.recording import Recording, condition

RATE = 100.0  # Hz of messages and states
NOISE = 0.05  # N·m


@pytest.fixture(scope="module")
def model() -> Model:
    """Return a model that learned from a minute with the noise that it will meet."""
    time = np.arange(6000) / RATE
    q, qd, qdd = motion_at(time)
    noise = NOISE * np.random.default_rng(0).normal(size=q.shape)
    position = q + 1e-6 * np.random.default_rng(1).normal(size=q.shape)
    recording = Recording(JOINTS, time, position, qd, torque_of(q, qd, qdd) + noise)
    return identify(condition(recording), Settings(train=1.0, samples=300, evaluations=5)).model


class Stream:
    """A model that watches the motion it was learned from, through the node's own path."""

    def __init__(self, model: Model) -> None:
        self.states = LiveStates(model.joints, conditioning_for(model, {}, {}), RATE)
        self.prediction, self.alarm = LivePrediction(model), TouchAlarm(model, 1.0 / RATE)

    def take(
        self, begin: float, seconds: float, added: Floats, lost: Container[int] = ()
    ) -> Iterator[tuple[float, Touch]]:
        """Yield touches with the stamp (s) of the message that showed them."""
        time = begin + np.arange(round(seconds * RATE)) / RATE
        q, qd, qdd = motion_at(time)
        random = np.random.default_rng(round(begin))
        tau = torque_of(q, qd, qdd) + NOISE * random.normal(size=q.shape) + added
        for k, now in enumerate(time):
            if k in lost:
                continue
            at = round(now * 1e9)
            view = JointStateView(at, JOINTS, q[k], qd[k], tau[k])
            state = self.states.take(view, at)
            for judged in self.prediction.take([state] if state else []):
                touch = self.alarm.add(judged, 0.25)
                if touch is not None:
                    yield float(now), touch


def quiet(seconds: float) -> Floats:
    return np.zeros((round(seconds * RATE), len(JOINTS)))


SECONDS = LEARNING + 60.0
BEGUN = 1000.0 + SECONDS


@pytest.fixture(scope="module")
def learned(model: Model) -> tuple[Stream, list[tuple[float, Touch]]]:
    """Return a stream that has seen a minute more than it learns from, and what it raised."""
    stream = Stream(model)
    assert "learning what is usual" in stream.alarm.status().message
    return stream, list(stream.take(1000.0, SECONDS, quiet(SECONDS)))


@pytest.fixture
def stream(model: Model, learned: tuple[Stream, list[tuple[float, Touch]]]) -> Stream:
    return copy.deepcopy(learned[0], {id(model): model})


def test_usual_motion_raises_no_alarm(learned: tuple[Stream, list[tuple[float, Touch]]]) -> None:
    stream, found = learned
    assert found == []
    assert stream.alarm.status().message == "no touch so far"


def test_a_tenth_of_the_torque_is_noticed_within_a_tenth_of_a_second(
    model: Model, stream: Stream
) -> None:
    added, begins = quiet(30.0), 3.0 + 5.0 * np.arange(5)
    size = 0.1 * np.sqrt(np.mean(model.data.tau[:, 1] ** 2))
    for begin in begins:
        added[round(begin * RATE) : round((begin + 0.5) * RATE), 1] = size
    found = list(stream.take(BEGUN, 30.0, added))
    for begin in BEGUN + begins:
        when, touch = next(each for each in found if begin <= each[0] < begin + 1.0)
        assert when - begin < 0.1 - 0.02  # the node looks every 10 ms, and DDS takes some
        assert touch.joint == "b"
        assert touch.torque > 0.0
        assert abs(touch.at / 1e9 - begin) < 0.06
    assert len(found) <= 2 * len(begins)  # it is noticed when it begins, and may be when it ends


def test_the_status_shows_a_touch_for_some_seconds(stream: Stream) -> None:
    added = quiet(10.0)
    added[200:250] = 20.0
    shown = [stream.alarm.status() for _ in stream.take(BEGUN, 10.0, added)]
    assert shown[0].level is Level.WARN
    assert "N·m beyond what the motion takes" in shown[0].message
    later = stream.alarm.status()
    assert later.level is Level.OK
    assert later.message.startswith("no touch for")


def test_outside_the_known_range_nothing_is_judged(stream: Stream) -> None:
    judged = stream.alarm.judged
    for k in range(200):
        at, far = round((BEGUN + k / RATE) * 1e9), np.full(2, 9.0)
        state = stream.states.take(JointStateView(at, JOINTS, far, 0.0 * far, 99.0 * far), at)
        for one in stream.prediction.take([state] if state else []):
            assert stream.alarm.add(one, 0.25) is None or one.state.q[0] < 3.0
    assert stream.alarm.judged - judged < 0.5


def test_a_straight_line_over_a_hole_is_not_judged(model: Model, stream: Stream) -> None:
    judged = stream.alarm.judged
    added = quiet(10.0)
    added[500:520] = 20.0
    assert list(stream.take(BEGUN, 10.0, added, lost=range(300, 600, 10))) == []
    assert 6.0 < stream.alarm.judged - judged < 8.0
