"""Models of robots with the bodies of a URDF."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pendulum
import pytest
from mechanism_examples import pendulum_urdf

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Identification, Model, Settings, extend, identify
from lagrangian_ff.kernels import KERNELS, States
from lagrangian_ff.kernels.rigid import Robot, robot_of
from lagrangian_ff.recording import Conditioning

pytest.importorskip("pinocchio", reason="Pinocchio, the extra urdf, is not installed")

SETTINGS = Settings(samples=100, evaluations=20, train=0.2)


def identified(robot: Robot | None, settings: Settings = SETTINGS) -> Identification:
    """Return a model of the first fifth of a recording with 1 % of noise."""
    return identify(pendulum.motion(40.0, noise=0.01), settings, mechanism=robot)


@pytest.fixture(scope="module")
def wrong() -> Robot:
    """Return the pendulum with one rod too heavy and one too light by 20 %."""
    return robot_of(pendulum_urdf(2.0 * 1.2, 1.0 * 0.8), "wrong.urdf")


@pytest.fixture(scope="module")
def found(wrong: Robot) -> Identification:
    return identified(wrong)


def error(found: Identification) -> float:
    """Return the error in N·m against torques without noise, on motion not learned from."""
    data = pendulum.motion(40.0)
    predicted = found.model.predict(data.q, data.qd, data.qdd)
    return float(np.sqrt(np.mean((predicted - data.tau)[len(data) // 5 :] ** 2)))


def test_wrong_masses_and_rotors_are_learned_from_little_data(found: Identification) -> None:
    blind = error(identified(None, replace(SETTINGS, model="vrbfs+fri")))
    assert error(found) < 0.1 * blind
    assert error(found) < 0.02 * pendulum.motion(40.0).tau.std()


@pytest.mark.parametrize("name", ["chain", "rbfs", "none"])
def test_every_sort_of_kernel_corrects(name: str, wrong: Robot) -> None:
    assert name in KERNELS
    some = identified(wrong, replace(SETTINGS, model=f"{name}+fri", samples=60, evaluations=6))
    assert error(some) < 0.1 * pendulum.motion(40.0).tau.std()
    assert some.model.name == f"{name}+fri"


@pytest.mark.parametrize("name", ["auto", "rbfs", "none"])
def test_a_known_robot_is_learned_on_inducing_points(
    name: str, wrong: Robot, tmp_path: Path
) -> None:
    settings = replace(SETTINGS, model=f"{name}+fri", evaluations=6, landmarks=30)
    some = identified(wrong, settings)
    assert (some.record["samples"], some.record["landmarks"]) == (800, 30)
    assert error(some) < 0.1 * pendulum.motion(40.0).tau.std()
    some.model.save(tmp_path / "model.npz")
    again, data = Model.load(tmp_path / "model.npz"), pendulum.motion(3.0, seed=4)
    x = data.q, data.qd, data.qdd
    np.testing.assert_array_equal(again.predict(*x), some.model.predict(*x))
    low, high = again.uncertainty.interval(*x)
    assert (low < high).all()


def test_contacts_do_not_drag_a_known_robot(wrong: Robot) -> None:
    data = pendulum.motion(40.0, noise=0.01)
    tau = data.tau.copy()
    for first in range(100, 800, 100):
        tau[first : first + 15, 1] += 10.0
    settings = replace(SETTINGS, model="vrbfs+fri", loss="huber")
    found = identify(replace(data, tau=tau), settings, mechanism=wrong)
    assert error(found) < 0.02 * data.tau.std()
    squares = replace(settings, loss="square")
    assert error(identify(replace(data, tau=tau), squares, mechanism=wrong)) > 2.0 * error(found)


def test_what_neither_bodies_nor_friction_hold_is_left_to_the_kernel(wrong: Robot) -> None:
    data = pendulum.motion(40.0, noise=0.01)
    spring = 3.0 * np.sin(2.0 * data.q)
    sprung = replace(data, tau=data.tau + spring)
    settings = replace(SETTINGS, train=0.7)
    rigid = identify(sprung, replace(settings, model="none+fri"), mechanism=wrong).record
    both = identify(sprung, replace(settings, model="vrbfs+fri"), mechanism=wrong).record
    assert float(str(both["rmse"])) < 0.2 * float(str(rigid["rmse"]))


def test_the_record_has_the_known_mechanism(found: Identification) -> None:
    record = json.loads(json.dumps(found.record, allow_nan=False))
    assert record["mechanism"] == {
        "kind": "urdf", "name": "pendulum", "mass": pytest.approx(3.2), "prismatic": [],
        "still": [],
    }  # fmt: skip
    assert record["scale"] == "common"
    assert {"bodies", "deviation", "armature", "correction", "inertia"} <= set(
        record["hyperparameters"]
    )


def test_the_file_needs_neither_the_urdf_nor_pinocchio(
    found: Identification, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found.model.save(tmp_path / "model.npz")
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    again = Model.load(tmp_path / "model.npz")
    data = pendulum.motion(3.0, seed=4)
    states = data.q, data.qd, data.qdd
    np.testing.assert_array_equal(again.predict(*states), found.model.predict(*states))
    assert again.kernel.mechanism is not None
    assert again.kernel.mechanism.record() == found.record["mechanism"]


def test_an_effect_is_added_without_forgetting_the_robot(found: Identification) -> None:
    larger = extend(found.model, EFFECTS["quadratic_drag"], "elbow")
    assert larger.record["mechanism"] == found.record["mechanism"]
    assert error(larger) < 2.0 * error(found)


def test_terms_are_those_of_the_bodies(found: Identification) -> None:
    data = pendulum.motion(5.0, seed=3)
    terms = found.model.terms(data.q, data.qd, data.qdd)
    still = np.zeros_like(data.q)
    columns = [
        found.model.terms(data.q, still, np.broadcast_to(one, still.shape)).inertia
        for one in np.eye(2)
    ]
    mass = pendulum.mass_matrix(data.q)
    np.testing.assert_allclose(np.stack(columns, axis=2), mass, atol=0.05 * mass.max())
    np.testing.assert_allclose(
        terms.total, found.model.predict(data.q, data.qd, data.qdd), atol=1e-9
    )


def test_joints_that_the_urdf_does_not_have_are_refused(wrong: Robot) -> None:
    data = replace(pendulum.motion(10.0), joints=("shoulder", "wrist"))
    with pytest.raises(ModelError, match="no wrist; recorded: shoulder, wrist; movable in the URDF"
                       ": shoulder, elbow"):  # fmt: skip
        identify(data, SETTINGS, mechanism=wrong)


def test_one_unit_for_all_joints_is_asked_for(wrong: Robot) -> None:
    with pytest.raises(ModelError, match="scale is 'joint', but"):
        identified(wrong, replace(SETTINGS, scale="joint"))


def test_bodies_have_no_weight_where_the_effort_holds_no_gravity(wrong: Robot) -> None:
    whole = pendulum.motion(20.0, noise=0.01)
    x = States.of(whole.q, whole.qd, whole.qdd)
    light = replace(
        whole,
        tau=whole.tau - pendulum.rigid_torque(x.at_rest()),
        conditioning=Conditioning(effort="without-gravity").record(),
    )
    few = replace(SETTINGS, model="chain+fri", samples=60, train=0.7)
    some = identify(light, few, mechanism=wrong)
    assert some.model.identified.score.mean_nmse < 0.01
    found = some.model.terms(x.q, 0.0 * x.q, 0.0 * x.q)
    assert np.abs(found.gravity).max() < 1e-9
