"""From a motion to a judged model."""

import json
from dataclasses import replace

import numpy as np
import pendulum
import pytest
from numpy.typing import NDArray

from lagrangian_ff.errors import ModelError, RecordingError
from lagrangian_ff.identification import Identification, Settings, identify
from lagrangian_ff.kernels import States
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

FEW = Settings(samples=120, evaluations=25, train=0.5)


@pytest.fixture(scope="module")
def found() -> Identification:
    """Return a model of the pendulum with 2 % of noise."""
    return identify(pendulum.motion(40.0, noise=0.02), FEW)


def test_unseen_motion_is_predicted(found: Identification) -> None:
    fresh = pendulum.motion(20.0, seed=0)
    error = fresh.tau - found.model.predict(fresh.q, fresh.qd, fresh.qdd)
    assert (error.std(axis=0) / fresh.tau.std(axis=0)).max() < 0.03
    assert float(str(found.record["nmse"])) < 0.01


def test_intervals_hold_the_true_friction(found: Identification) -> None:
    truth = {"viscous": pendulum.VISCOUS, "coulomb": pendulum.COULOMB}
    entries = found.record["effects"]
    assert isinstance(entries, list)
    inside = []
    for entry in entries:
        if entry["effect"] in truth:
            (numbers,) = entry["parameters"].values()
            true = truth[entry["effect"]][pendulum.JOINTS.index(entry["joint"])]
            inside.append(numbers["low"] <= true <= numbers["high"])
            assert numbers["high"] - numbers["low"] < 0.5 * true
    assert len(inside) == 4
    assert sum(inside) >= 3


def test_terms_add_up_and_mean_what_they_say(found: Identification) -> None:
    _, x = pendulum.states(10.0, 50.0, seed=0)
    terms = found.model.terms(x.q, x.qd, x.qdd)
    whole = found.model.predict(x.q, x.qd, x.qdd)
    np.testing.assert_allclose(terms.total, whole, atol=1e-9)
    rest = States.of(x.q, 0 * x.q, 0 * x.q)
    # A constant torque belongs to gravity as well as to the offset: compare without means.
    gravity, true = terms.gravity, pendulum.rigid_torque(rest)
    error = (gravity - gravity.mean(axis=0)) - (true - true.mean(axis=0))
    assert (error.std(axis=0) / true.std(axis=0)).max() < 0.1
    inertia = pendulum.rigid_torque(States.of(x.q, 0 * x.q, x.qdd)) - true
    assert ((terms.inertia - inertia).std(axis=0) / inertia.std(axis=0)).max() < 0.15
    assert set(terms.effects) == {"viscous", "coulomb", "offset"}


def test_one_state_is_predicted_as_in_a_batch(found: Identification) -> None:
    _, x = pendulum.states(1.0, 20.0, seed=2)
    batch = found.model.predict(x.q, x.qd, x.qdd)
    single = found.model.predict(x.q[3], x.qd[3], x.qdd[3])
    assert single.shape == (2,)
    np.testing.assert_allclose(single, batch[3], atol=1e-12)
    assert found.model.terms(x.q[3], x.qd[3], x.qdd[3]).friction.shape == (2,)


def test_states_of_another_arm_are_refused(found: Identification) -> None:
    with pytest.raises(ModelError, match="2 joints"):
        found.model.predict(np.zeros((4, 3)), np.zeros((4, 3)), np.zeros((4, 3)))


def test_the_record_is_json_and_complete(found: Identification) -> None:
    record = json.loads(json.dumps(found.record, allow_nan=False))
    assert record["model"] == "chain+fri"
    assert set(record["joints"]) == set(pendulum.JOINTS)
    assert record["samples"] == 120
    numbers = {"inertia", "link", "potential", "wave", "swing", "rotor", "prismatic"}
    assert numbers | {"gamma", "coulomb.v0"} == set(record["hyperparameters"])
    assert record["training_seconds"] == pytest.approx(20.0, abs=0.1)
    assert len(record["effects"]) == 6
    assert record["effects"][0]["parameters"]["B"]["unit"] == "N·m·s/rad"


def test_the_error_is_of_motion_the_model_has_not_seen() -> None:
    """A corrupted second half changes the judged error and nothing of the model."""
    motion = pendulum.motion(30.0)
    spoiled = motion.tau.copy()
    spoiled[len(motion) // 2 + 5 :] += 50.0
    settings = Settings(samples=60, evaluations=8, train=0.5)
    clean = identify(motion, settings)
    dirty = identify(replace(motion, tau=spoiled), settings)
    np.testing.assert_array_equal(clean.model.weights, dirty.model.weights)
    assert float(str(dirty.record["rmse"])) > float(str(clean.record["rmse"])) + 40.0


def test_results_are_reproducible() -> None:
    motion, settings = pendulum.motion(20.0), Settings(samples=60, evaluations=10)
    first, second = identify(motion, settings), identify(motion, settings)
    np.testing.assert_array_equal(first.model.weights, second.model.weights)
    np.testing.assert_array_equal(first.model.coefficients, second.model.coefficients)


def test_all_of_the_motion_is_judged_in_blocks_left_out() -> None:
    settings = Settings(samples=120, evaluations=10, train=1.0)
    found = identify(pendulum.motion(20.0, noise=0.02), settings)
    assert "left out" in str(found.record["judged_on"])
    assert found.record["validation"] is not None
    again = found.model.predict(found.held_out.q, found.held_out.qd, found.held_out.qdd)
    seen = np.sqrt(np.mean((again - found.held_out.tau) ** 2))
    assert float(str(found.record["rmse"])) > seen


def test_several_recordings_are_split_each() -> None:
    motions = [pendulum.motion(15.0, seed=1), pendulum.motion(15.0, seed=2)]
    found = identify(motions, Settings(samples=80, evaluations=10, train=0.5))
    assert found.record["training_seconds"] == pytest.approx(15.0, abs=0.1)
    assert len(np.unique(found.training.segment)) == 2


@pytest.mark.parametrize("name", ["vrbfs+fri", "srbfs+fri", "rbfs+fri", "motor+fri", "fri", "pol"])
@pytest.mark.parametrize("selection", ["validation", "evidence"])
def test_every_way_of_choosing_works_on_every_shape_of_kernel(name: str, selection: str) -> None:
    settings = Settings(name, samples=50, evaluations=8, selection=selection, train=1.0)
    found = identify(pendulum.motion(12.0, noise=0.02), settings)
    assert 0.0 < float(str(found.record["nmse"])) < 1.5


def test_choosing_hyperparameters_lowers_what_it_judges_by() -> None:
    motion = pendulum.motion(30.0, noise=0.02)
    errors = []
    for evaluations in (1, 60):
        record = identify(motion, Settings(samples=120, evaluations=evaluations)).record
        validation = record["validation"]
        assert isinstance(validation, dict)
        errors.append(validation["nmse"])
    assert errors[1] < errors[0]


def test_the_lagrangian_helps_and_so_does_friction() -> None:
    motion = pendulum.motion(40.0, noise=0.01)
    error = {
        name: float(str(identify(motion, Settings(name, samples=150)).record["nmse"]))
        for name in ("vrbfs+fri", "vrbfs", "motor+fri", "rbfs+fri")
    }
    assert error["vrbfs+fri"] < error["rbfs+fri"]
    assert error["vrbfs+fri"] < 0.1 * error["vrbfs"]
    assert error["vrbfs+fri"] < 0.1 * error["motor+fri"]


def test_the_scale_follows_whether_the_joints_share_one_lagrangian() -> None:
    """A joint whose torque is in another unit than its neighbour's breaks the common Lagrangian."""
    motion = pendulum.motion(30.0, noise=0.01)
    agreed = identify(motion, Settings(samples=120))
    assert agreed.record["scale"] == "common"
    by_force = identify(motion, Settings(samples=120, scale="joint"))
    assert float(str(agreed.record["nmse"])) < float(str(by_force.record["nmse"]))


def holding(joint: int, seconds: float, seed: int) -> Motion:
    """Return a motion in which one joint stands still, its torque anywhere within its friction."""
    motion = pendulum.motion(seconds, seed=seed, noise=0.02)
    q, qd, qdd = motion.q.copy(), motion.qd.copy(), motion.qdd.copy()
    q[:, joint], qd[:, joint], qdd[:, joint] = q[0, joint], 0.0, 0.0
    x = States.of(q, qd, qdd)
    tau = pendulum.rigid_torque(x) + pendulum.friction_torque(x)
    tau[:, joint] += 0.8 * pendulum.COULOMB[joint]
    tau += 0.02 * motion.tau.std(axis=0) * np.random.default_rng(seed).normal(size=tau.shape)
    return replace(motion, q=q, qd=qd, qdd=qdd, tau=tau)


@pytest.mark.parametrize("joint", [0, 1])
def test_motion_in_which_a_joint_is_held_costs_the_others_nothing(joint: int) -> None:
    """Recordings in which one joint is held must not raise the error on other motion."""
    whole = pendulum.motion(20.0, noise=0.02, seed=1)
    unseen = pendulum.motion(20.0, noise=0.02, seed=5)
    settings = Settings("chain+fri", train=1.0)

    def error(*learned: Motion) -> Floats:
        model = identify(list(learned), settings).model
        left = unseen.tau - model.predict(unseen.q, unseen.qd, unseen.qdd)
        return np.asarray(left.std(axis=0))

    held = [holding(joint, 20.0, seed) for seed in (2, 3, 4)]
    assert (error(whole, *held) < 1.05 * error(whole)).all()


@pytest.mark.parametrize("landmarks", [0, 40])
def test_a_joint_that_stands_still_is_survived(landmarks: int) -> None:
    motion = pendulum.motion(20.0)
    q, zero = motion.q.copy(), np.zeros(len(motion))
    q[:, 1] = 0.3
    still = np.column_stack([motion.qd[:, 0], zero])
    calm = np.column_stack([motion.qdd[:, 0], zero])
    tau = np.column_stack([motion.tau[:, 0], zero])
    settings = replace(FEW, landmarks=landmarks)
    found = identify(replace(motion, q=q, qd=still, qdd=calm, tau=tau), settings)
    assert np.isfinite(found.predicted).all()
    assert np.isfinite(found.model.coefficients).all()


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (Settings(train=0.0), "train is 0"),
        (Settings(train=1.5), "train is 1.5"),
        (Settings(samples=3), "samples is 3"),
        (Settings(landmarks=-1), "landmarks is -1"),
        (Settings(block_seconds=-1.0), "block_seconds"),
        (Settings(folds=1), "folds is 1"),
        (Settings(scale="none"), "scale is 'none'"),
        (Settings(selection="luck"), "selection is 'luck'"),
        (Settings(loss="absolute"), "loss is 'absolute', expected square, huber"),
        (Settings(block_seconds=float("nan")), "block_seconds is nan"),
        (Settings(train=float("nan")), "train is nan"),
        (Settings(samples=100.5), "samples is 100.5, expected a whole number"),  # type: ignore[arg-type]
        (Settings(evaluations=0), "evaluations is 0"),
        (Settings(model="magic"), "'magic' is neither"),
    ],
)
def test_settings_that_cannot_work_are_refused(settings: Settings, said: str) -> None:
    with pytest.raises(ModelError, match=said):
        identify(pendulum.motion(20.0), settings)


def test_less_than_a_block_is_refused() -> None:
    with pytest.raises(RecordingError, match=r"pendulum: 1\.99 s of training motion"):
        identify(pendulum.motion(3.0))


@pytest.mark.parametrize("selection", ["validation", "evidence"])
def test_one_block_cannot_be_judged_on(selection: str) -> None:
    with pytest.raises(ModelError, match="needs at least two of them, got one"):
        identify(pendulum.motion(3.1), Settings(train=1.0, block_seconds=3.09, selection=selection))
