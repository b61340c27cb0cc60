"""Loops that are closed, against a five-bar whose equations of motion have multipliers."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.kernels import CoupledKernel, Energy, Family, States
from lagrangian_ff.kernels.constrained import FiveBar
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

BASE, CRANKS, FOREARMS = 0.3, (0.25, 0.3), (0.45, 0.4)
LENGTH = np.array([CRANKS[0], FOREARMS[0], CRANKS[1], FOREARMS[1]])
MASS = np.array([1.2, 0.7, 1.0, 0.9])
LINKAGE = FiveBar(BASE, CRANKS, FOREARMS)


def motion(seconds: float, rate: float, seed: int = 0) -> tuple[Floats, States]:
    """Cranks that swing about an open posture, each with three sines."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1.0 / rate)
    q, qd, qdd = np.zeros((3, len(t), 2))
    q += [2.1, 0.9]
    for _ in range(3):
        omega, phase, size = rng.uniform(1, 5, 2), rng.uniform(0, 6, 2), rng.uniform(0.1, 0.2, 2)
        angle = omega * t[:, None] + phase
        q += size * np.sin(angle)
        qd += size * omega * np.cos(angle)
        qdd -= size * omega**2 * np.sin(angle)
    return t, States.of(q, qd, qdd)


def torque_with_multipliers(x: States) -> Floats:
    """(M, 2) N·m at the cranks, of four uniform rods in absolute angles and a pin at the hand.

    M θ̈ + c + w = (τ1, 0, τ2, 0) + Aᵀ λ with A θ̇ = 0: four equations for τ and λ. The forearms'
    angles are found by Newton's method, their rates from the constraint.
    """
    out = np.empty((len(x), 2))
    forearms = np.array([0.9, 2.2])
    for n in range(len(x)):
        theta = np.array([x.q[n, 0], forearms[0], x.q[n, 1], forearms[1]])
        for _ in range(50):
            c, s = LENGTH * np.cos(theta), LENGTH * np.sin(theta)
            gap = np.array([c[0] + c[1] - BASE - c[2] - c[3], s[0] + s[1] - s[2] - s[3]])
            a = np.array([[-s[0], -s[1], s[2], s[3]], [c[0], c[1], -c[2], -c[3]]])
            theta[[1, 3]] -= np.linalg.solve(a[:, [1, 3]], gap)
        assert np.abs(gap).max() < 1e-12
        forearms = theta[[1, 3]]
        rate, change = np.zeros((2, 4))
        rate[[0, 2]], change[[0, 2]] = x.qd[n], x.qdd[n]
        rate[[1, 3]] = -np.linalg.solve(a[:, [1, 3]], a[:, [0, 2]] @ rate[[0, 2]])
        bend = np.array([[-c[0], -c[1], c[2], c[3]], [-s[0], -s[1], s[2], s[3]]]) @ rate**2
        change[[1, 3]] = -np.linalg.solve(a[:, [1, 3]], a[:, [0, 2]] @ change[[0, 2]] + bend)
        force = np.zeros(4)
        for crank, rod in ((0, 1), (2, 3)):
            l1, l2, m1, m2 = LENGTH[crank], LENGTH[rod], MASS[crank], MASS[rod]
            between = theta[crank] - theta[rod]
            both = 0.5 * m2 * l1 * l2
            force[crank] += (m1 / 3 + m2) * l1**2 * change[crank]
            force[crank] += both * (
                np.cos(between) * change[rod] + np.sin(between) * rate[rod] ** 2
            )
            force[rod] += m2 / 3 * l2**2 * change[rod]
            force[rod] += both * (
                np.cos(between) * change[crank] - np.sin(between) * rate[crank] ** 2
            )
            force[crank] += 9.81 * (0.5 * m1 + m2) * c[crank]
            force[rod] += 9.81 * 0.5 * m2 * c[rod]
        driven = np.zeros((4, 2))
        driven[0, 0] = driven[2, 1] = 1.0
        out[n] = np.linalg.solve(np.hstack([driven, a.T]), force)[:2]
    return out


def recorded(seconds: float = 20.0) -> Motion:
    t, x = motion(seconds, 50.0)
    return Motion(
        joints=LINKAGE.joints, time=t, q=x.q, qd=x.qd, qdd=x.qdd, tau=torque_with_multipliers(x),
        segment=np.zeros(len(t), dtype=np.int64), source="five-bar",
    )  # fmt: skip


def test_the_tree_follows_the_cranks() -> None:
    t, x = motion(2.0, 2000.0)
    tree, g = LINKAGE.tree(x)
    step = t[1] - t[0]
    rate = (tree.q[2:] - tree.q[:-2]) / (2 * step)
    np.testing.assert_allclose(rate, tree.qd[1:-1], atol=1e-5 * np.abs(rate).max())
    change = (tree.q[2:] - 2 * tree.q[1:-1] + tree.q[:-2]) / step**2
    np.testing.assert_allclose(change, tree.qdd[1:-1], atol=1e-4 * np.abs(change).max())
    # Both arms end in the hand, and move it alike.
    angle = np.cumsum(tree.q.reshape(-1, 2, 2), axis=2)
    ends = np.sum(LENGTH.reshape(2, 2) * np.exp(1j * angle), axis=2) + np.array([0.0, BASE])
    np.testing.assert_allclose(ends[:, 0], ends[:, 1], atol=1e-12)
    assert g.shape == (len(t), 4, 2)


def error_of(family: Family) -> float:
    """Error on unseen motion after learning 20 s, relative to the torque's spread."""
    (_, u), (_, x) = motion(20.0, 10.0, 0), motion(10.0, 10.0, 1)
    kernel, learned, true = family.start(u), torque_with_multipliers(u), torque_with_multipliers(x)
    assert isinstance(kernel, CoupledKernel)
    gram = kernel.cross(u, u)
    gram += 1e-13 * np.trace(gram) / len(gram) * np.eye(len(gram))
    weights = np.asarray(np.linalg.solve(gram, learned.ravel()).reshape(learned.shape), np.float64)
    return float(((kernel.apply(x, u, weights) - true).std(axis=0) / true.std(axis=0)).max())


def test_the_closed_mechanism_is_in_the_space_of_its_tree() -> None:
    assert error_of(LINKAGE.around(Energy)) < 1e-5
    assert error_of(Energy) > 1e-3


def test_a_model_is_identified_of_the_closed_mechanism() -> None:
    data, settings = recorded(), Settings("vrbfs", samples=100, evaluations=20, train=0.7)
    found = identify(data, settings, mechanism=LINKAGE)
    error = found.held_out.tau - found.predicted
    assert (error.std(axis=0) / data.tau.std(axis=0)).max() < 0.02
    assert found.record["mechanism"] == {"kind": "linkage", "name": "five-bar"}


def test_a_model_file_needs_the_code_of_its_linkage(tmp_path: Path) -> None:
    settings = Settings("svrbfs", samples=30, evaluations=4, train=1.0)
    model = identify(recorded(8.0), settings, mechanism=LINKAGE).model
    model.save(tmp_path / "model.npz")
    with pytest.raises(ModelError, match="linkage five-bar, whose code is not in the file"):
        Model.load(tmp_path / "model.npz")
    again = Model.load(tmp_path / "model.npz", linkage=LINKAGE)
    _, x = motion(1.0, 20.0, seed=1)
    states = x.q, x.qd, x.qdd
    np.testing.assert_array_equal(again.predict(*states), model.predict(*states))


def test_other_joints_are_refused() -> None:
    with pytest.raises(ModelError, match="recorded are right, left, expected are left, right"):
        LINKAGE.of_joints(("right", "left"), "bag")


def test_a_posture_out_of_reach_is_told() -> None:
    x = States.of([[np.pi, 0.0]], [[0.0, 0.0]], [[0.0, 0.0]])
    with pytest.raises(ModelError, match=r"not finite at sample 0: .* cannot be closed"):
        FiveBar(1.0, CRANKS, FOREARMS).tree(x)


def test_a_jacobian_of_another_shape_is_told() -> None:
    class Wrong(FiveBar):
        def jacobian(self, q: Floats) -> Floats:
            return np.zeros((len(q), 2))

    _, x = motion(1.0, 10.0)
    with pytest.raises(ModelError, match=r"jacobian\(\) gave shape \(10, 2\), expected \(10, T, 2"):
        Wrong(BASE, CRANKS, FOREARMS).tree(x)
