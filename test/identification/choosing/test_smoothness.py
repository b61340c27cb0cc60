"""The smoothness of curves, their signs, and the models that have them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pendulum
import pendulum_models
import pytest
import scipy
from numpy.typing import NDArray

from lagrangian_ff.effects import EFFECTS, Curve, Over, curve_over
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model, extend
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.pointwise import Pointwise
from lagrangian_ff.identification.solving.posterior import exact
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

DEPTH = 3.0


def bump(x: Floats) -> Floats:
    """A torque that is no effect of the catalogue, odd in x; falling far from 0."""
    return np.asarray(DEPTH * x * np.exp(-((x / 3.0) ** 2)))


def moved(seconds: float = 30.0, seed: int = 0) -> Motion:
    motion = pendulum.motion(seconds, noise=0.02, seed=seed)
    tau = motion.tau.copy()
    tau[:, 1] += bump(motion.qd[:, 1])
    return replace(motion, tau=tau)


@pytest.fixture(scope="module")
def model() -> Model:
    return pendulum_models.fitted("chain+fri", moved()).model


@pytest.fixture(scope="module")
def curved(model: Model) -> Model:
    return extend(model, curve_over([Over("velocity")]), "elbow").model


def error(model: Model, motion: Motion) -> float:
    found = model.predict(motion.q, motion.qd, motion.qdd, time=motion.time)
    return float(np.sqrt(np.mean((motion.tau - found)[:, 1] ** 2)))


def test_a_curve_takes_in_what_no_effect_is(model: Model, curved: Model) -> None:
    unseen = moved(seed=5)
    assert error(curved, unseen) < 0.2 * error(model, unseen)
    assert curved.name == "chain+fri+curve_velocity@elbow"
    assert curved.steps[-1]["added"] == "curve_velocity on elbow"
    curve = curved.basis.terms[-1].effect
    assert isinstance(curve, Curve)
    assert 3 <= curve.heights.shape[1] <= 15


def test_noise_alone_is_no_curve() -> None:
    """Where there is nothing to find, the prior of largest evidence leaves no direction free."""
    clean = pendulum_models.fitted("chain+fri", pendulum.motion(30.0, noise=0.02)).model
    with pytest.raises(ModelError, match="show nothing of a curve over velocity"):
        extend(clean, curve_over([Over("velocity")]), "elbow")


def test_an_odd_curve_is_odd_and_a_monotone_one_never_turns(model: Model) -> None:
    for flags in ({"odd": True}, {"monotone": True}, {"odd": True, "monotone": True}):
        found = extend(model, curve_over([Over("velocity")], **flags), "elbow").model
        (term, place) = found.basis.slices()[-1]
        assert isinstance(term.effect, Curve)
        b = found.coefficients[place]
        (speed,), torque = term.effect.table(b, 201)
        if "odd" in flags:
            np.testing.assert_allclose(speed, -speed[::-1], atol=1e-12)
            np.testing.assert_allclose(torque, -torque[::-1], atol=1e-9 * np.abs(torque).max())
        if "monotone" in flags:
            assert (b > 0.0).all()
            steps = np.diff(torque)
            assert (steps >= -1e-12).all() or (steps <= 1e-12).all()


def test_a_monotone_curve_is_the_bounded_optimum() -> None:
    """Of a wave it has the rises alone, and no steps at or above zero do better."""
    motion = pendulum.motion(30.0, noise=0.02)
    tau = motion.tau.copy()
    tau[:, 1] += 4.0 * np.sin(4.0 * motion.q[:, 1]) * np.tanh(motion.qd[:, 1] / 0.02)
    model = pendulum_models.fitted("chain+fri", replace(motion, tau=tau)).model
    wish = curve_over([Over("position")], friction=True, monotone=True)
    found = extend(model, wish, "elbow")
    (_, part, solution) = found.posterior.systems[0]
    *others, (term, place) = part.slices()
    assert solution.coefficients[place].min() > 0.0
    curve = term.effect
    assert isinstance(curve, Curve)
    count = curve.axes[0].count
    sign = np.sign(np.diff(curve.heights.sum(axis=1)).sum())
    every = sign * (np.tril(np.ones((count, count)))[:, 1:] - 0.5)
    x = found.posterior.problem.samples.x
    size = np.var(
        curve.made(curve.axes, curve.seen, every).columns(x, 1, {}) / x.sign(1)[:, None], 0
    )
    every = every[:, size > 2e-3 * size.max()]  # those at the ends are of a few samples
    assert curve.heights.shape[1] < every.shape[1] - 3
    whole = replace(term, effect=curve.made(curve.axes, curve.seen, every))
    basis = Basis((*(one for one, _ in others), whole))
    system = exact(found.posterior.problem.having(basis=basis)).system
    span, _ = np.linalg.qr(system.white_design[:, : place.start])
    z, w = (one - span @ (span.T @ one) for one in (system.white_design, system.white_target))
    _, left = scipy.optimize.nnls(z[:, place.start :], w)
    nats = 0.5 * (solution.squares - left**2) / solution.amplitude
    assert nats < 0.01


def test_a_model_with_a_curve_is_kept_and_driven_as_any(curved: Model, tmp_path: Path) -> None:
    curved.save(tmp_path / "model.npz")
    same = Model.load(tmp_path / "model.npz")
    motion = moved(5.0, seed=3)
    states = motion.q, motion.qd, motion.qdd
    expected = curved.predict(*states, time=motion.time)
    np.testing.assert_allclose(same.predict(*states, time=motion.time), expected, atol=1e-9)
    terms = same.terms(*states, time=motion.time)
    np.testing.assert_allclose(terms.total, expected, atol=1e-9)
    assert np.abs(terms.effects["curve_velocity"][:, 1]).max() > 0.5
    assert not terms.effects["curve_velocity"][:, 0].any()
    q, qd, qdd = (each[7] for each in states)
    one = Pointwise(same).torque(q, qd, qdd)
    np.testing.assert_allclose(one, curved.predict(q, qd, qdd), atol=1e-9)


def test_where_a_curve_has_not_been_is_said(curved: Model) -> None:
    motion = moved(5.0)
    inside = motion.q, 0.5 * motion.qd, motion.qdd
    assert curved.curves_outside(*inside) == {}
    ((words, share),) = curved.curves_outside(motion.q, 10.0 * motion.qd, motion.qdd).items()
    assert words == "a curve over velocity on elbow"
    assert 0.0 < share <= 1.0


def test_more_can_be_added_beside_a_curve_but_not_the_same_again(curved: Model) -> None:
    more = extend(curved, EFFECTS["ripple"], "shoulder", {"order": 5.0}).model
    assert [t.effect.name for t in more.basis.terms][-2:] == ["curve_velocity", "ripple"]
    with pytest.raises(ModelError, match="already"):
        extend(curved, curve_over([Over("velocity")]), "elbow")


def test_a_curve_over_what_stands_still_is_refused(model: Model) -> None:
    still = replace(model.data, qdd=0.0 * model.data.qdd)
    with pytest.raises(ModelError, match="does not change"):
        extend(replace(model, data=still), curve_over([Over("acceleration")]), "elbow")
