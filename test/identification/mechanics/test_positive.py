"""A mass matrix kept positive definite: that it is, and that nothing else is given up for it."""

from pathlib import Path
from typing import Any

import numpy as np
import pendulum
import pytest
from pendulum_models import fitted

from lagrangian_ff.effects import EFFECTS, Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Identification, Model, Settings, extend, identify
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.identification.mechanics.positive import FLOOR, keep_positive
from lagrangian_ff.kernels import KERNELS, LagrangianKernel, States

LAGRANGIAN = [name for name, kernel in KERNELS.items() if issubclass(kernel, LagrangianKernel)]
ROTOR = (Term(EFFECTS["rotor_inertia"], 1, {}),)
NOISY = pendulum.motion(20.0, 50.0, noise=1.0, seed=3)
"""A motion with as much noise as torque, which hardly determines a mass matrix."""


def found(name: str, positive: bool, landmarks: int | None = None) -> Identification:
    """Return a fit of 40 samples of the noisy motion, or of all on inducing points."""
    how: dict[str, Any] = {"samples": 40, "positive": positive, "landmarks": landmarks}
    return fitted(f"{name}+fri", NOISY, further=ROTOR, noise=1e-2, **how)


def least(model: Model) -> float:
    """Return the least eigenvalue on the whole training motion."""
    x = model.data.take(model.trained)
    return float(np.linalg.eigvalsh(model.dynamics.mass_matrix(x.q, x.qd)).min())


@pytest.mark.parametrize("name", LAGRANGIAN)
def test_it_is_positive_definite_all_along(name: str) -> None:
    free, kept = found(name, False), found(name, True)
    assert least(free.model) < 0.0
    assert least(kept.model) > 0.0
    record = kept.record["mass_matrix"]
    assert isinstance(record, dict)
    assert record["share"] == 0.0
    # It is a fit still: the noise is as large as the torque, so that little of it may be missed.
    errors = [
        np.mean((one.model.predict(NOISY.q, NOISY.qd, NOISY.qdd) - NOISY.tau) ** 2)
        for one in (free, kept)
    ]
    assert errors[1] < 1.1 * errors[0]


@pytest.mark.parametrize("name", LAGRANGIAN)
def test_it_is_the_nearest_one(name: str) -> None:
    """Only the minimiser of a convex cost satisfies the Karush-Kuhn-Tucker conditions.

    Residuals are the weights times the noise, and every constraint that pushes, pushes upwards and
    is reached exactly.
    """
    free = found(name, False).posterior
    states, count = free.states, len(free.states)
    held = keep_positive(free, states)
    kernel, unit = free.problem.kernel, float(free.problem.unit[0])
    ((_, _, system),) = free.systems
    target = system.target.reshape(count, 2)
    design = free.problem.basis.design(Inputs.of(states)) / unit
    left = target - kernel.apply(states, held.states, held.weights) - design @ held.coefficients
    noise = free.problem.rows((0, 1)).noise.reshape(count, 2)
    np.testing.assert_allclose(left, noise * held.weights[:count], atol=1e-6 * abs(target).max())

    added = slice(count, count + (len(held.states) - count) // 2)
    moved, push = held.states.take(added), held.weights[added]
    assert len(moved) > 0
    multiplier = np.sum(push * moved.qdd, axis=1) / np.sum(moved.qdd**2, axis=1)
    assert (multiplier > 0.0).all()
    np.testing.assert_allclose(push, multiplier[:, None] * moved.qdd)
    rest = States.of(moved.q, moved.qd, 0.0 * moved.q)
    np.testing.assert_array_equal(held.states.take(slice(added.stop, None)).qdd, rest.qdd)
    np.testing.assert_array_equal(held.weights[added.stop :], -push)

    up, down = (kernel.apply(x, held.states, held.weights) for x in (moved, rest))
    pull = up - down
    rotor = free.problem.basis.slices()[-1][1]
    pull[:, 1] += moved.qdd[:, 1] * held.coefficients[rotor][0] / unit
    reached = np.sum(pull * moved.qdd, axis=1)
    np.testing.assert_allclose(reached, FLOOR, rtol=1e-4)
    # The basis is free: what pushes it is balanced by the residuals.
    force = np.einsum("inb,in->b", design, held.weights[:count])
    force[rotor] += np.sum(multiplier * moved.qdd[:, 1] ** 2) / unit
    np.testing.assert_allclose(force, 0.0, atol=1e-6 * np.abs(held.weights).max())


def test_models_on_inducing_points_are_kept_positive_as_well(tmp_path: Path) -> None:
    free, kept = (found("vrbfs", positive, landmarks=20) for positive in (False, True))
    assert least(free.model) < 0.0
    assert least(kept.model) > 0.0
    kept.model.save(tmp_path / "model.npz")
    again = Model.load(tmp_path / "model.npz")
    assert (len(again.index), len(again.seen)) == (20, 800)
    assert least(again) == pytest.approx(least(kept.model))
    assert least(extend(again, EFFECTS["spring"], "elbow").model) > 0.0


def test_a_good_model_stays_as_it_is() -> None:
    free, kept = (fitted("chain+fri", positive=positive) for positive in (False, True))
    np.testing.assert_array_equal(free.model.weights, kept.model.weights)
    np.testing.assert_array_equal(free.model.coefficients, kept.model.coefficients)


def test_forward_dynamics_can_be_asked_for_then() -> None:
    free, kept = (found("vrbfs", positive).model for positive in (False, True))
    x = kept.data.take(kept.trained)
    with pytest.raises(ModelError, match=r"not positive definite.*--positive"):
        free.dynamics.forward(x.q, x.qd, x.tau)
    qdd = kept.dynamics.forward(x.q, x.qd, x.tau)
    np.testing.assert_allclose(kept.predict(x.q, x.qd, qdd), x.tau, atol=1e-6 * abs(x.tau).max())


def test_a_model_file_keeps_it(tmp_path: Path) -> None:
    model = found("vrbfs", True).model
    model.save(tmp_path / "model.npz")
    again, x = Model.load(tmp_path / "model.npz"), NOISY
    assert len(again.centres) > len(again.index)
    expected = model.predict(x.q, x.qd, x.qdd)
    np.testing.assert_allclose(again.predict(x.q, x.qd, x.qdd), expected, rtol=1e-12)
    assert np.isfinite(again.uncertainty.variance(x.q[:3], x.qd[:3], x.qdd[:3])).all()


def test_an_effect_that_is_added_does_not_undo_it() -> None:
    larger = extend(found("chain", True).model, EFFECTS["spring"], "elbow").model
    assert least(larger) > 0.0


def test_identify_has_it_as_a_setting() -> None:
    settings = Settings("chain+fri", samples=60, train=0.8, evaluations=5, positive=True)
    model = identify(NOISY, settings).model
    assert model.record["scale"] == "common"
    assert least(model) > 0.0


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (Settings(positive=True, scale="joint"), "scale is 'joint', expected common or auto"),
        (Settings("srbfs+fri", positive=True), "joints of srbfs are learned apart"),
        (Settings("fri", positive=True), "joints of none are learned apart"),
    ],
)
def test_where_there_is_no_mass_matrix_it_is_refused(settings: Settings, said: str) -> None:
    with pytest.raises(ModelError, match=said):
        identify(NOISY, settings)
