"""Where the load is a guess, what follows it is not ruled out by a guess that is wrong."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import two_rods
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.ground import Ground, tune, tuning
from lagrangian_ff.diagnosis.search.candidates import Candidate, named
from lagrangian_ff.diagnosis.search.gain import scores
from lagrangian_ff.diagnosis.search.guess import hidden_by_guess
from lagrangian_ff.effects import EFFECTS, Inputs
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]


@pytest.fixture(autouse=True, scope="module")
def _small() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tuning, "ROWS", 1000)
        yield


def flat() -> Ground:
    """Rods that lie flat, with a wave that grows with the load: all of it is inertia."""
    motion = two_rods.motion(1, 40.0)
    still = np.zeros_like(motion.q)
    weight = two_rods.rods(motion.q, still, still)
    rotors = motion.qdd * np.array([3.0, 0.05])  # kg·m², of the shoulder most
    load = two_rods.rods(motion.q, motion.qd, motion.qdd) - weight
    tau = motion.tau - weight + rotors
    tau[:, 0] += 0.8 * np.abs(load[:, 0]) * np.cos(8.0 * motion.q[:, 0])
    return ground_of(replace(motion, tau=tau))


def wave(t: Floats, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """As high whatever the load."""
    return np.stack([2.0 * np.cos(8.0 * q[:, 0]), np.zeros(len(t))], axis=1)


def ground_of(motion: two_rods.Motion) -> Ground:
    friction = [
        Term(EFFECTS[name], joint, {"v0": two_rods.WIDTH} if name == "coulomb" else {})
        for name in ("viscous", "coulomb", "offset")
        for joint in (0, 1)
    ]
    x = Inputs.of(States.of(motion.q, motion.qd, motion.qdd), motion.time, motion.segment)
    return tune(motion, x, Basis(tuple(friction)))


def best(ground: Ground, effect: str) -> Candidate:
    found = scores(ground, named(ground.seen, ground.basis, [0], {effect: EFFECTS[effect]}))
    return max(found, key=lambda score: score.gain).candidate


def test_under_gravity_the_load_is_known() -> None:
    ground = ground_of(two_rods.motion(1, 30.0, wave))
    assert not ground.unsure_load.any()
    assert hidden_by_guess(ground, best(ground, "ripple")) == ()


def test_a_wheel_has_no_load_that_could_be_told_from_its_rotor() -> None:
    """A pendulum has: its weight."""
    motion = two_rods.motion(1, 30.0)
    tau = np.stack(
        [3.0 * motion.qdd[:, 0], motion.qdd[:, 1] + 5.0 * np.cos(motion.q[:, 1])], axis=1
    )
    tau += two_rods.NOISE * np.random.default_rng(0).normal(size=tau.shape)
    ground = ground_of(replace(motion, tau=tau))
    assert ground.unsure_load.tolist() == [True, False]


def test_a_wave_that_grows_with_an_unknown_load_may_be_either() -> None:
    ground = flat()
    assert hidden_by_guess(ground, best(ground, "ripple")) == ("gear_mesh",)
    assert hidden_by_guess(ground, best(ground, "gear_mesh")) == ()

    assert hidden_by_guess(ground, best(ground, "stribeck")) == ()  # nothing of the kind
