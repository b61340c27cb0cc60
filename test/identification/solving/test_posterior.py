"""The fit of every kernel, against refitting and against what must not matter."""

from dataclasses import replace

import numpy as np
import pendulum
import pytest
from problems import problem_of

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.problem import Scaling
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.solving.posterior import Posterior, exact
from lagrangian_ff.kernels import KERNELS, States
from lagrangian_ff.recording.motion import Motion

EVERY = sorted(KERNELS)


def thin(motion: Motion, samples: int) -> Motion:
    return motion.take(evenly(len(motion), samples))


def posterior_of(motion: Motion, name: str, scaling: Scaling | None = None) -> Posterior:
    return exact(problem_of(motion, name, scaling))


def predict(model: Posterior, motion: Motion) -> np.ndarray:
    x = States.of(motion.q, motion.qd, motion.qdd)
    problem = model.problem
    kernel = problem.kernel.apply(x, model.states, model.weights) * problem.unit
    return kernel + sum(problem.basis.torque(Inputs.of(x), model.coefficients).values())


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("per_joint", [True, False])
def test_left_out_residuals_are_those_of_refitting(name: str, per_joint: bool) -> None:
    motion = thin(pendulum.motion(12.0, noise=0.02), 60)
    problem = problem_of(motion, f"{name}+fri", Scaling.of(motion.tau, per_joint))
    whole = exact(problem)
    group = np.arange(20, 35)
    residual, changed = whole.left_out([group]), whole.changed([group])
    rest = np.setdiff1d(np.arange(60), group)
    without = exact(problem.take(rest))
    expected = motion.tau[group] - predict(without, motion.take(group))
    np.testing.assert_allclose(residual[group], expected, atol=1e-6 * motion.tau.std())
    assert np.isnan(residual[rest]).all()
    np.testing.assert_allclose(changed[0], without.coefficients, atol=1e-6)


@pytest.mark.parametrize("name", ["vrbfs+fri", "srbfs+fri", "rbf+fri", "motor+fri"])
def test_the_unit_of_torque_does_not_matter(name: str) -> None:
    motion = thin(pendulum.motion(12.0), 80)
    in_mnm = replace(motion, tau=1000.0 * motion.tau)
    one, other = posterior_of(motion, name), posterior_of(in_mnm, name)
    np.testing.assert_allclose(predict(other, motion), 1000.0 * predict(one, motion), rtol=1e-6)


@pytest.mark.parametrize("name", ["vrbfs+fri", "srbfs+fri", "pol+fri"])
def test_the_order_of_joints_does_not_matter(name: str) -> None:
    motion = thin(pendulum.motion(12.0), 80)
    turned = motion.select(("elbow", "shoulder"))
    one, other = (
        predict(posterior_of(motion, name), motion),
        predict(posterior_of(turned, name), turned),
    )
    np.testing.assert_allclose(other[:, ::-1], one, atol=1e-7 * abs(one).max())


def test_a_strong_joint_does_not_drown_a_weak_one() -> None:
    """A joint with a thousandth of the torque is learned as well as before."""
    motion = thin(pendulum.motion(20.0), 150)
    weak = replace(motion, tau=motion.tau * np.array([1.0, 1e-3]))
    test = pendulum.motion(20.0, seed=0)
    one = predict(posterior_of(motion, "vrbfs+fri"), test)[:, 1]
    other = predict(posterior_of(weak, "vrbfs+fri"), test)[:, 1]
    np.testing.assert_allclose(1e3 * other, one, atol=1e-6 * abs(one).max())


def test_with_one_unit_the_mass_matrix_is_symmetric() -> None:
    motion = thin(pendulum.motion(20.0), 120)
    model = posterior_of(motion, "vrbfs+fri", Scaling.of(motion.tau, per_joint=False))
    point = motion.take(slice(30, 31))
    columns = []
    for joint in range(2):
        qdd = point.qdd.copy()
        qdd[:, joint] += 1.0
        moved = replace(point, qdd=qdd)
        columns.append((predict(model, moved) - predict(model, point))[0])
    assert columns[0][1] == pytest.approx(columns[1][0], rel=1e-8)


def test_known_friction_is_recovered() -> None:
    motion = thin(pendulum.motion(30.0), 400)
    model = posterior_of(motion, "vrbfs+fri", Scaling.of(motion.tau, per_joint=False))
    found = {
        (t.effect.name, t.joint): model.coefficients[p][0] for t, p in model.problem.basis.slices()
    }
    for joint in range(2):
        assert found["viscous", joint] == pytest.approx(pendulum.VISCOUS[joint], rel=0.03)
        assert found["coulomb", joint] == pytest.approx(pendulum.COULOMB[joint], rel=0.03)


@pytest.mark.parametrize("name", ["srbfs+fri", "rbf+fri"])
def test_a_joint_that_is_learned_apart_can_be_had_alone(name: str) -> None:
    motion = thin(pendulum.motion(12.0), 80)
    problem = problem_of(motion, name)
    whole, alone = exact(problem), exact(problem, only=1)
    ((joints, _, system),) = alone.systems
    assert joints == (1,)
    np.testing.assert_array_equal(system.weights, whole.systems[1][2].weights)
    group = [np.arange(20, 35)]
    left, every = (one.left_out(group) for one in (alone, whole))
    np.testing.assert_array_equal(left[:, 1], every[:, 1])
    assert np.isnan(left[:, 0]).all()
