"""The share of torques that the model did not think possible, of the last seconds."""

from dataclasses import replace

import numpy as np
import pytest
from small_model import Floats, motion_at, save_small_model, torque_of

from lagrangian_ff.identification import Model
from lagrangian_ff.identification.certainty.uncertainty import Uncertainty
from lagrangian_ff.nodes.watching.cover import PAUSE, Cover
from lagrangian_ff.nodes.watching.health import Limits
from lagrangian_ff.nodes.watching.live import Judged
from lagrangian_ff.nodes.watching.states import State

LIMITS = Limits(window=5.0, still=0.01, margin=0.05, warn=2.0, error=4.0)
KEY = "outside the 90 % interval"


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    """Return a small model."""
    return save_small_model(tmp_path_factory.mktemp("cover") / "model.npz")


def watch(
    cover: Cover, model: Model, begin: float, wrong: float = 0.0, still: bool = False
) -> None:
    """Show it 6 s of motion at 100 Hz, joint b wrong by so many N·m, or joint b at rest."""
    time = np.arange(begin, begin + 6.0, 0.01)
    q, qd, qdd = motion_at(time)
    tau = torque_of(q, qd, qdd)
    predicted = model.predict(q, qd, qdd)
    tau[:, 1] = predicted[:, 1] + wrong
    if still:
        qd[:, 1] = 0.0
    for k, at in enumerate(time):
        state = State(round(at * 1e9), 1, q[k], qd[k], qdd[k], tau[k])
        cover.add(Judged(state, predicted[k]), LIMITS)


def test_what_the_model_cannot_have_meant_is_counted(model: Model) -> None:
    cover = Cover(model)
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


def test_a_joint_at_rest_is_not_judged(model: Model) -> None:
    cover = Cover(model)
    watch(cover, model, 0.0, wrong=5.0, still=True)
    assert list(cover.values()) == [f"{KEY} a"]


def test_it_is_asked_now_and_then(model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    cover, asked = Cover(model), []

    def counted(self: Uncertainty, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        asked.append(q)
        return np.ones(2)

    monkeypatch.setattr(Uncertainty, "reach", counted)
    watch(cover, model, 0.0)
    assert len(asked) <= 6.0 / PAUSE + 1


def test_models_of_before_tell_none(model: Model) -> None:
    assert Cover.of(replace(model, record={})) is None
