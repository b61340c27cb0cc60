"""Unseen motion is predicted with the friction of the searched motion."""

import numpy as np
import pytest
import two_rods
from two_rods import Floats
from whitened_examples import few_torques, friction, inputs, whitened_of

from lagrangian_ff.arrays import Ints
from lagrangian_ff.diagnosis import Diagnosis, diagnose
from lagrangian_ff.diagnosis.search.carried import DRIFTS, Carried
from lagrangian_ff.diagnosis.whitening import Whitened, whiten
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.recording.motion import Motion

FEW = Settings(train=1.0, samples=120, evaluations=20, model="chain+fri")
DRAG = 0.3  # N·m·s²/rad²


_small = few_torques(800)


def elbow(drag: float = 0.0, thicker: float = 0.0, drier: float = 0.0) -> two_rods.Hidden:
    """Drag of the elbow, and N·m·s/rad and N·m by which its friction differs from the usual."""

    def torque(t: Floats, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        v = qd[:, 1]
        whole = drag * v * np.abs(v) + thicker * v + drier * np.tanh(v / two_rods.WIDTH)
        return np.stack([np.zeros_like(v), whole], axis=1)

    return torque


def found(first: two_rods.Hidden, second: two_rods.Hidden, seconds: float) -> Diagnosis:
    """Return the diagnosis of 40 s, confirmed on some seconds, among effects over speed."""
    model = identify(two_rods.motion(1), FEW).model
    names = ("quadratic_drag", "stribeck", "asymmetric_viscous")
    return diagnose(
        model,
        two_rods.motion(1, hidden=first),
        two_rods.motion(2, seconds, hidden=second),
        {name: EFFECTS[name] for name in names},
        steps=2,
    )


def like(searched: Whitened, motion: Motion, index: Ints) -> Whitened:
    """Return samples of another motion, whitened as the searched one."""
    return whiten(motion, index, searched.seconds, inputs(motion), searched.problem)


def carried_of(searched: Whitened, unseen: Whitened) -> Carried:
    """Return what a motion says of plain friction for another."""
    carried = Carried.of(searched, friction().terms, unseen)
    assert carried is not None
    return carried


def names(done: Diagnosis) -> list[tuple[str, str]]:
    """Return what is confirmed, and where."""
    return [(one.effect.name, one.joint) for one in done.confirmed]


@pytest.mark.parametrize("other", [(0.0, 0.0), (0.1, -0.1), (-0.1, 0.2)])
def test_drag_is_confirmed_where_friction_has_changed(other: tuple[float, float]) -> None:
    done = found(elbow(DRAG), elbow(DRAG, *other), 30.0)
    assert names(done) == [("quadratic_drag", "elbow")]


@pytest.mark.parametrize("other", [(0.0, 0.0), (0.1, -0.1), (-0.1, 0.2), (0.3, 0.0)])
def test_drag_of_the_first_motion_alone_is_not_confirmed(other: tuple[float, float]) -> None:
    for seconds in (3.0, 30.0):
        assert names(found(elbow(DRAG), elbow(0.0, *other), seconds)) == []


def test_a_few_seconds_confirm_what_friction_would_take_up() -> None:
    done = found(elbow(DRAG / 3), elbow(DRAG / 3), 3.0)
    assert names(done) == [("quadratic_drag", "elbow")]


def test_it_is_the_bayes_factor_of_the_unseen_motion_given_the_searched_one() -> None:
    """As from the dense covariance of both motions, with a nearly flat prior of the friction."""
    searched = whitened_of(two_rods.motion(1, 30.0))
    motion = two_rods.motion(2, 10.0)
    unseen = like(searched, motion, searched.index[:80])
    carried = carried_of(searched, unseen)
    np.testing.assert_array_equal(carried.drift, 0.0)

    rng = np.random.default_rng(0)
    torques = [0.1 * rng.normal(size=(len(one.x), 1)) for one in (searched, unseen)]
    on = np.array([[0.0, 1.0]])
    there, here = (
        one.shared(t, on)[:, 0] for one, t in zip((searched, unseen), torques, strict=True)
    )
    z = carried.white(here, there)
    gained = float(z @ (carried.residual + 0.5 * z))

    rubs = [0, 1, 3, 4]  # viscous and Coulomb; offsets and shapes may differ
    whites, designs, rests = [], [], []
    for one in (searched, unseen):
        white = one.system.white_design / one.amplitude
        q, _ = np.linalg.qr(np.delete(white, rubs, axis=1))
        outside = np.eye(len(white)) - q @ q.T
        whites.append(outside @ one.system.white_target / one.amplitude)
        designs.append(outside @ white[:, rubs])
        rests.append(outside)
    wide = np.diag(1e4 / np.sum(designs[0] ** 2, axis=0))

    def log_evidence(target: Floats, design: Floats) -> float:
        whole = np.eye(len(target)) + design @ wide @ design.T
        return -0.5 * float(target @ np.linalg.solve(whole, target))

    def of_both(less: tuple[Floats, Floats]) -> float:
        targets = [y - rest @ z for y, rest, z in zip(whites, rests, less, strict=True)]
        return log_evidence(np.concatenate(targets), np.vstack(designs)) - log_evidence(
            targets[0], designs[0]
        )

    none = np.zeros_like(there), np.zeros_like(here)
    # The findings are in the searched motion already: what is asked is what is lost without one.
    gone = -there, -here
    assert of_both(none) - of_both(gone) == pytest.approx(gained, rel=1e-3)


def test_the_largest_drift_forgets_the_searched_motion() -> None:
    assert DRIFTS[0] == 0.0
    assert list(DRIFTS) == sorted(DRIFTS)

    def other_gears(t: Floats, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        return np.asarray(40.0 * qd + 30.0 * np.tanh(qd / two_rods.WIDTH) + 50.0)

    searched = whitened_of(two_rods.motion(1, 30.0))
    motion = two_rods.motion(2, 10.0, hidden=other_gears)
    unseen = like(searched, motion, searched.index[:80])
    carried = carried_of(searched, unseen)
    np.testing.assert_array_equal(carried.drift, DRIFTS[-1])
    torque = unseen.shared(unseen.x.q[:, [0]] ** 2, np.array([[0.0, 1.0]]))[:, 0]
    z = carried.white(torque, np.zeros(searched.residual.shape))
    alone = unseen.project(torque[:, None])[:, 0]
    assert float(z @ z) == pytest.approx(float(alone @ alone), rel=0.02)


def test_a_joint_that_turns_one_way_does_not_tell_dry_friction_from_an_offset() -> None:
    """Both are constant torques, up to rounding."""
    searched = whitened_of(two_rods.motion(1, 30.0))
    motion = two_rods.motion(2, 10.0)
    onward = np.flatnonzero(motion.qd[:, 1] > 20 * two_rods.WIDTH)[::4]
    unseen = like(searched, motion, onward)
    carried = carried_of(searched, unseen)
    assert np.isfinite(carried.drift).all()
    on = np.array([[0.0, 1.0]])
    here, there = (
        one.shared(one.x.qd[:, [1]] * np.abs(one.x.qd[:, [1]]), on)[:, 0]
        for one in (unseen, searched)
    )
    z, alone = carried.white(here, there), unseen.project(here[:, None])[:, 0]
    assert 0.1 * float(alone @ alone) < float(z @ z) < 10.0 * float(here @ here)


def test_a_model_without_friction_has_nothing_to_carry() -> None:
    plain = Settings(train=1.0, samples=120, evaluations=20, model="chain")
    model = identify(two_rods.motion(1), plain).model
    first, second = (two_rods.motion(seed, 20.0) for seed in (1, 2))
    sought = {name: EFFECTS[name] for name in ("viscous", "coulomb")}
    done = diagnose(model, first, second, sought, steps=4)
    assert {one.effect.name for one in done.confirmed} == set(sought)
