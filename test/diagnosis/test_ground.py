"""The ground: what is left is white, of the size of the noise, and blind to what is known."""

from collections.abc import Iterator

import numpy as np
import pytest
import two_rods
from ground_examples import friction, ground_of, inputs, quickly
from numpy.typing import NDArray
from sines import sines

from lagrangian_ff.diagnosis.ground import Ground, lay, tune
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.recording.motion import Motion


@pytest.fixture(autouse=True, scope="module")
def _small() -> Iterator[None]:
    with quickly(1600):
        yield


WIDE = friction(0.05)
"""Its Coulomb step is too wide."""


@pytest.fixture(scope="module")
def ground() -> Ground:
    """Return the ground of a motion in which nothing is hidden."""
    return ground_of(two_rods.motion(1), WIDE)


def test_what_is_left_is_white_and_of_the_size_of_the_noise(ground: Ground) -> None:
    left = ground.residual.reshape(-1, 2)
    np.testing.assert_allclose(np.mean(left**2, axis=0), 1.0, atol=0.15)
    following = np.mean(left[1:] * left[:-1], axis=0) / np.mean(left**2, axis=0)
    assert np.abs(following).max() < 0.15
    assert ground.seen.window > 1
    averaged = two_rods.NOISE / np.sqrt(ground.seen.window)
    np.testing.assert_allclose(ground.noise, averaged, rtol=0.25)


def test_the_width_of_the_coulomb_step_is_found(ground: Ground) -> None:
    np.testing.assert_allclose(ground.basis.sign_speed(2), two_rods.WIDTH, rtol=0.15)


def test_what_the_model_has_leaves_nothing(ground: Ground) -> None:
    for term in ground.basis.terms:
        white = ground.whiten(term.columns(ground.seen), term.joint)
        left = ground.project(white)
        assert np.linalg.norm(left) < 1e-6 * np.linalg.norm(white)


@pytest.fixture
def many(ground: Ground) -> NDArray[np.float64]:
    """Return so many columns that they are whitened together."""
    return np.sin(np.linspace(0.1, 9.0, 100) * ground.seen.q[:, :1])


@pytest.mark.parametrize("joint", [0, 1])
def test_many_columns_are_whitened_as_each_alone(
    ground: Ground, many: NDArray[np.float64], joint: int
) -> None:
    together = ground.whiten(many, joint)
    ground.forget()
    alone = np.hstack([ground.whiten(many[:, [n]], joint) for n in range(many.shape[1])])
    np.testing.assert_allclose(together, alone, atol=1e-9 * np.abs(alone).max())


def test_single_precision_is_exact_enough_to_choose_by(
    ground: Ground, many: NDArray[np.float64]
) -> None:
    exact = ground.whiten(many, 0)
    coarse = ground.whiten(many, 0, coarse=True)
    assert coarse.dtype == np.float32
    np.testing.assert_allclose(coarse, exact, atol=1e-3 * np.abs(exact).max())


def test_the_same_prior_is_laid_again_alike(ground: Ground) -> None:
    basis = Basis(ground.basis.terms[:-1])
    again = ground.relaid(basis=basis)
    anew = lay(
        ground.motion, ground.index, ground.block, ground.inputs, ground.prior, basis,
        seen=ground.seen,
    )  # fmt: skip
    np.testing.assert_allclose(again.residual, anew.residual, atol=1e-9)
    assert again.system.log_evidence == pytest.approx(anew.system.log_evidence)


def test_the_load_is_predicted_without_its_own_block(ground: Ground) -> None:
    """Spoiling the torque of one block does not change the load seen there."""
    spoilt = ground.motion.tau.copy()
    rows = ground.index[ground.block == 5]
    spoilt[rows] += 50.0
    motion = Motion(**{**ground.motion.__dict__, "tau": spoilt})
    other, same = (
        lay(of, ground.index, ground.block, ground.inputs, ground.prior, ground.basis)
        for of in (motion, ground.motion)
    )
    inside = ground.block == 5
    scale = np.abs(ground.motion.tau).max()
    total, before = (one.unseen_inputs().torque[inside] for one in (other, same))
    np.testing.assert_allclose(total, before, atol=1e-6 * scale)


def test_the_load_is_that_of_the_rods(ground: Ground) -> None:
    motion = two_rods.motion(2)
    load = ground.inputs_of(motion).load
    rotors = motion.qdd * np.array([0.3, 0.05])
    true = two_rods.rods(motion.q, motion.qd, motion.qdd) - rotors
    error = load - true
    # Which part of the inertia is the rotor's, motion hardly tells: gravity is most of the load.
    assert (error.std(axis=0) / true.std(axis=0)).max() < 0.25


def test_a_wrong_unit_of_effort_on_one_joint_is_found() -> None:
    motion = two_rods.motion(3)
    scaled = Motion(**{**motion.__dict__, "tau": motion.tau * np.array([1.0, 2.0])})
    gain = ground_of(scaled, WIDE).prior.gain
    assert gain[1] / gain[0] == pytest.approx(2.0, rel=0.15)


def test_noise_is_not_taken_for_dynamics_where_one_joint_hides_an_effect() -> None:
    """Few torques of six joints are fitted without any noise, and all is blamed on that joint."""
    rng = np.random.default_rng(1)
    t = np.arange(0.0, 60.0, 0.01)
    q, qd, qdd = sines(rng, t, 6, (0.4, 4.0))
    weight = 3.0 * np.cos(np.cumsum(q, axis=1))
    tau = 2.0 * qdd + np.cumsum(weight[:, ::-1], axis=1)[:, ::-1]
    tau[:, 1] += 1.2 * np.cos(7.0 * q[:, 1])
    tau += 0.2 * rng.normal(size=tau.shape)
    names = tuple(f"joint_{n + 1}" for n in range(6))
    motion = Motion(names, t, q, qd, qdd, tau, np.zeros(len(t), dtype=np.int64), "six joints")
    found = ground_of(motion, Basis(()))
    noise = 0.2 / np.sqrt(found.seen.window)
    others = np.delete(found.noise, 1)
    assert np.all((others > noise / 3.0) & (others < 3.0 * noise))
    # The hidden effect counts as noise of its own joint, and no more than that.
    assert noise < found.noise[1] < 1.2


def test_a_ground_that_knows_of_a_sliding_joint_is_the_likelier_one() -> None:
    """A mass that slides on a beam in the vertical plane, 1 to 5 m from its axis."""
    rng = np.random.default_rng(2)
    t = np.arange(0.0, 40.0, 0.01)
    q, qd, qdd = (part * np.array([1.0, 2.0]) for part in sines(rng, t, 2, (0.4, 4.0)))
    q = q + np.array([0.3, 3.0])
    reach, weight = q[:, 1], 9.81 * 2.0
    first = (1.0 + 2.0 * reach**2) * qdd[:, 0] + 4.0 * reach * qd[:, 1] * qd[:, 0]
    second = 2.0 * qdd[:, 1] - 2.0 * reach * qd[:, 0] ** 2
    tau = np.stack(
        [first + weight * reach * np.cos(q[:, 0]), second + weight * np.sin(q[:, 0])], axis=1
    )
    tau += 0.3 * rng.normal(size=tau.shape)
    segment = np.zeros(len(t), dtype=np.int64)
    motion = Motion(("turn", "reach"), t, q, qd, qdd, tau, segment, "telescope")
    told, untold = (
        tune(motion, inputs(motion), Basis(()), sliding=sliding).system.log_evidence
        for sliding in (np.array([0.0, 1.0]), None)
    )
    assert told > untold + 100.0
