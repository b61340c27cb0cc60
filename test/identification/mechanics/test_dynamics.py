"""Quantities of a learned Lagrangian: identities of mechanics, and a known pendulum."""

from collections.abc import Callable

import numpy as np
import pendulum
import pytest
from numpy.typing import NDArray
from pendulum_models import fitted

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Dynamics, Model
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.identification.mechanics.dynamics import acceleration
from lagrangian_ff.kernels import KERNELS, LagrangianKernel, States

Floats = NDArray[np.float64]

EVERY = [name for name, kernel in KERNELS.items() if issubclass(kernel, LagrangianKernel)]
QUADRATIC = ["chain", "chain_rbf", "energy", "energy_rbf"]
KEPT = (
    Term(EFFECTS["rotor_inertia"], 1, {}),
    Term(EFFECTS["spring"], 0, {}),
    Term(EFFECTS["counterbalance"], 1, {"r": 0.4, "q0": 1.0}),
    Term(EFFECTS["ripple"], 0, {"order": 3.0}),
)


@pytest.fixture(scope="module", params=EVERY)
def model(request: pytest.FixtureRequest) -> Model:
    """Return a model of each Lagrangian kernel, with friction and effects that keep energy."""
    return fitted(f"{request.param}+fri", further=KEPT, samples=60, noise=1e-2).model


@pytest.fixture(scope="module")
def chain() -> Model:
    """Return a good model of the pendulum."""
    return fitted("chain+fri").model


@pytest.fixture(scope="module")
def unseen() -> States:
    """Return states along the motion the models learn from, between those they have seen."""
    return pendulum.states(20.0, 7.0, seed=0)[1]


def rate(f: Callable[[Floats], Floats], at: Floats, along: Floats) -> Floats:
    """Return the derivative of f along a direction, by differences of fourth order."""
    h = 1e-3
    near = f(at + h * along) - f(at - h * along)
    far = f(at + 2 * h * along) - f(at - 2 * h * along)
    return np.asarray((8.0 * near - far) / (12.0 * h))


def conservative_torque(model: Model, x: States) -> Floats:
    """Return the prediction less friction and constant torques."""
    terms = model.terms(x.q, x.qd, x.qdd)
    kept = {term.effect.name for term in KEPT}
    return terms.total - sum(
        (part for name, part in terms.effects.items() if name not in kept), np.zeros_like(x.q)
    )


def test_mass_matrix_is_symmetric(model: Model, unseen: States) -> None:
    mass = model.dynamics.mass_matrix(unseen.q, unseen.qd)
    scale = np.abs(mass).max()
    np.testing.assert_allclose(mass, mass.transpose(0, 2, 1), atol=1e-9 * scale)


def test_the_parts_add_up_to_the_torque(model: Model, unseen: States) -> None:
    x, dynamics = unseen, model.dynamics
    inertia = np.einsum("inm,im->in", dynamics.mass_matrix(x.q, x.qd), x.qdd)
    whole = inertia + dynamics.velocity_torque(x.q, x.qd) + dynamics.gravity(x.q)
    expected = conservative_torque(model, x)
    np.testing.assert_allclose(whole, expected, atol=1e-8 * np.abs(expected).max())


def test_the_torque_is_that_of_the_lagrangian(model: Model, unseen: States) -> None:
    """It is d/dt ∂L/∂qd − ∂L/∂q, differentiated numerically."""
    x, dynamics = unseen.take(slice(0, 20)), model.dynamics
    h, eye = 1e-3, np.eye(2)

    def momentum(q: Floats, qd: Floats) -> Floats:
        parts = [rate(lambda v: dynamics.lagrangian(q, v), qd, e + 0 * qd) for e in eye]
        return np.stack(parts, axis=1)

    along = (momentum(x.q + s * h * x.qd, x.qd + s * h * x.qdd) for s in (1.0, -1.0))
    change = np.subtract(*along) / (2.0 * h)
    slope = [rate(lambda q: dynamics.lagrangian(q, x.qd), x.q, e + 0 * x.q) for e in eye]
    expected = conservative_torque(model, x)
    found = change - np.stack(slope, axis=1)
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())


def test_gravity_is_the_slope_of_potential_energy(model: Model, unseen: States) -> None:
    dynamics, q = model.dynamics, unseen.q
    for joint, along in enumerate(np.eye(2)):
        slope = rate(dynamics.potential_energy, q, along + 0.0 * q)
        gravity = dynamics.gravity(q)
        np.testing.assert_allclose(slope, gravity[:, joint], atol=1e-6 * np.abs(gravity).max())


def test_energy_is_kinetic_and_potential(model: Model, unseen: States) -> None:
    dynamics, (q, qd) = model.dynamics, (unseen.q, unseen.qd)
    both = dynamics.kinetic_energy(q, qd) + dynamics.potential_energy(q)
    np.testing.assert_allclose(dynamics.energy(q, qd), both, atol=1e-9 * np.abs(both).max())
    np.testing.assert_allclose(dynamics.kinetic_energy(q, 0.0 * qd), 0.0, atol=1e-9)


def test_power_is_the_rate_of_energy_along_a_motion(model: Model) -> None:
    """Both are integrated over two seconds, with the work of friction."""
    time, x = pendulum.states(2.0, 500.0, seed=0)
    friction = model.predict(x.q, x.qd, x.qdd) - conservative_torque(model, x)
    power = np.sum((model.predict(x.q, x.qd, x.qdd) - friction) * x.qd, axis=1)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(time))])
    energy = model.dynamics.energy(x.q, x.qd)
    np.testing.assert_allclose(energy - energy[0], work, atol=2e-4 * np.ptp(energy))


def test_forward_dynamics_inverts_inverse_dynamics(model: Model, unseen: States) -> None:
    x = unseen.take(slice(0, 30))
    mass = model.dynamics.mass_matrix(x.q, x.qd)
    good = np.flatnonzero(np.linalg.eigvalsh(mass)[:, 0] > 0.0)
    assert len(good) > 3
    x = x.take(good)
    tau = model.predict(x.q, x.qd, x.qdd)
    found = model.dynamics.forward(x.q, x.qd, tau)
    np.testing.assert_allclose(found, x.qdd, atol=1e-5 * np.abs(x.qdd).max())


@pytest.mark.parametrize("name", QUADRATIC)
def test_quadratic_kernels_have_a_coriolis_matrix(name: str, unseen: States) -> None:
    dynamics = fitted(f"{name}+fri", further=KEPT, samples=60, noise=1e-2).model.dynamics
    q, qd = unseen.q, unseen.qd
    coriolis = dynamics.coriolis_matrix(q, qd)
    torque = dynamics.velocity_torque(q, qd)
    scale = np.abs(torque).max()
    np.testing.assert_allclose(np.einsum("inm,im->in", coriolis, qd), torque, atol=1e-8 * scale)
    # The mass matrix' own rate of change, by differences, less 2 C.
    change = rate(dynamics.mass_matrix, q, qd)
    skew = change - 2.0 * coriolis
    np.testing.assert_allclose(skew, -skew.transpose(0, 2, 1), atol=1e-6 * np.abs(change).max())
    moving = 0.5 * np.einsum("in,inm,im->i", qd, dynamics.mass_matrix(q), qd)
    np.testing.assert_allclose(
        dynamics.kinetic_energy(q, qd), moving, atol=1e-9 * np.abs(moving).max()
    )


def test_it_is_the_pendulums_own(chain: Model, unseen: States) -> None:
    x, dynamics = unseen, chain.dynamics
    true = pendulum.mass_matrix(x.q)
    assert np.abs(dynamics.mass_matrix(x.q) - true).max() < 0.02 * np.abs(true).max()
    kinetic = 0.5 * np.einsum("in,inm,im->i", x.qd, true, x.qd)
    error = dynamics.kinetic_energy(x.q, x.qd) - kinetic
    assert error.std() < 0.02 * kinetic.std()
    moving = States.of(x.q, x.qd, 0.0 * x.qdd)
    rest = States.of(x.q, 0.0 * x.qd, 0.0 * x.qdd)
    coriolis = pendulum.rigid_torque(moving) - pendulum.rigid_torque(rest)
    error = dynamics.velocity_torque(x.q, x.qd) - coriolis
    assert error.std() < 0.05 * coriolis.std()
    qdd = dynamics.forward(x.q, x.qd, pendulum.rigid_torque(x) + pendulum.friction_torque(x))
    assert ((qdd - x.qdd).std(axis=0) < 0.05 * x.qdd.std(axis=0)).all()


def test_potential_energy_is_the_pendulums_up_to_a_constant(chain: Model, unseen: States) -> None:
    q = unseen.q
    true = 9.81 * np.sin(q[:, 0]) + 9.81 * 0.2 * np.sin(q.sum(axis=1))
    # A part of gravity may stand in the constant torques, which have a potential c·q of their own.
    constant = chain.basis.constant(2, chain.coefficients) - pendulum.OFFSET
    error = chain.dynamics.potential_energy(q) + q @ constant - true
    assert error.std() < 0.02 * true.std()


def test_effects_that_keep_energy_are_the_arms(unseen: States) -> None:
    """A rotor that the kernel does not know is in the mass matrix all the same."""
    found = fitted("vrbfs+fri", further=KEPT[:1], samples=60)
    dynamics, q = found.model.dynamics, unseen.q
    places = {t.effect.name: p for t, p in found.model.basis.slices()}
    rotor = found.model.coefficients[places["rotor_inertia"]][0]
    zero, eye = 0.0 * q, np.eye(2)
    kernel = np.stack(
        [
            found.model.lagrangian_torque(States.of(q, zero, zero + e))
            - found.model.lagrangian_torque(States.of(q, zero, zero))
            for e in eye
        ],
        axis=2,
    )
    expected = kernel + np.diag([0.0, rotor])
    np.testing.assert_allclose(dynamics.mass_matrix(q), expected, atol=1e-9)


def test_one_state_is_as_in_a_batch(chain: Model, unseen: States) -> None:
    dynamics, (q, qd) = chain.dynamics, (unseen.q, unseen.qd)
    tau = chain.predict(q, qd, unseen.qdd)
    for many, one in (
        (dynamics.mass_matrix(q), dynamics.mass_matrix(q[3])),
        (dynamics.coriolis_matrix(q, qd), dynamics.coriolis_matrix(q[3], qd[3])),
        (dynamics.gravity(q), dynamics.gravity(q[3])),
        (dynamics.energy(q, qd), dynamics.energy(q[3], qd[3])),
        (dynamics.lagrangian(q, qd), dynamics.lagrangian(q[3], qd[3])),
        (dynamics.forward(q, qd, tau), dynamics.forward(q[3], qd[3], tau[3])),
    ):
        assert np.shape(one) == np.shape(many)[1:]
        np.testing.assert_allclose(one, many[3], atol=1e-7)


def test_torques_that_follow_the_load_are_inverted_too(chain: Model, unseen: States) -> None:
    """Friction in proportion to the load makes torque bend over acceleration."""
    x = unseen

    def torque(x: States) -> Floats:
        rigid = chain.predict(x.q, x.qd, x.qdd)
        return np.asarray(rigid + 0.3 * np.abs(rigid) * np.tanh(x.qd / 0.1))

    found = acceleration(torque, x, torque(x))
    np.testing.assert_allclose(found, x.qdd, atol=1e-5 * np.abs(x.qdd).max())


@pytest.mark.parametrize("name", ["srbfs+fri", "rbf+fri", "motor+fri", "fri"])
def test_joints_learned_apart_are_refused(name: str) -> None:
    found = fitted(name, samples=30)
    with pytest.raises(ModelError, match=r"learned apart.*identify with auto"):
        _ = found.model.dynamics


def test_joints_in_units_of_their_own_are_refused() -> None:
    found = fitted("chain+fri", samples=30, per_joint=True)
    with pytest.raises(ModelError, match=r"divided by its own spread.*--scale common"):
        Dynamics(found.model)


def test_what_is_not_defined_is_refused() -> None:
    dynamics = fitted("vrbfs+fri", samples=30).model.dynamics
    q = np.zeros((2, 2))
    with pytest.raises(ModelError, match=r"vrbfs has no Coriolis matrix.*velocity_torque"):
        dynamics.coriolis_matrix(q, q)
    with pytest.raises(ModelError, match="2 joints"):
        dynamics.gravity(np.zeros((2, 3)))
    with pytest.raises(ModelError, match="one shape"):
        dynamics.forward(q, q, np.zeros(2))


def test_no_acceleration_is_made_up_where_mass_is_not_positive() -> None:
    def torque(x: States) -> Floats:
        return np.asarray(x.qdd * np.where(x.q > 1.0, -1.0, 1.0))

    x = States.of([[0.0, 0.0], [0.0, 2.0]], np.zeros((2, 2)), np.zeros((2, 2)))
    with pytest.raises(ModelError, match=r"not positive definite at 1 of 2 states.* sample 1"):
        acceleration(torque, x, np.ones((2, 2)))
    found = acceleration(torque, x.take(slice(0, 1)), np.ones((1, 2)))
    np.testing.assert_allclose(found, 1.0)


def test_a_model_on_inducing_points_has_the_same_quantities() -> None:
    model = fitted("chain+fri", landmarks=40).model
    x = pendulum.states(20.0, 7.0, seed=0)[1]
    expected = pendulum.mass_matrix(x.q)
    np.testing.assert_allclose(
        model.dynamics.mass_matrix(x.q), expected, atol=0.02 * expected.max()
    )
    torque = model.predict(x.q, x.qd, x.qdd)
    np.testing.assert_allclose(model.dynamics.forward(x.q, x.qd, torque), x.qdd, atol=1e-6)
