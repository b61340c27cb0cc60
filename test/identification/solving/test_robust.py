"""Huber's loss: the minimiser, what it must not depend on, and what outliers do to a model."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pendulum
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from problems import problem_of
from scipy.optimize import minimize

from lagrangian_ff.diagnosis import diagnose, verdict, with_consequences
from lagrangian_ff.diagnosis.thresholds import Effort, using
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Identification, Model, Settings, extend, identify
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.solving.posterior import exact, exact_solver
from lagrangian_ff.identification.solving.robust import at_sight, huber
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

FEW = Settings("chain+fri", samples=120, evaluations=12, loss="huber")


def spoiled(motion: Motion, kind: str, share: float = 0.05, train: float = 2.0 / 3.0) -> Motion:
    """Return a motion in whose training part this share of the torques is grossly wrong."""
    rng = np.random.default_rng(7)
    last = round(train * len(motion))
    length = 1 if kind == "single" else round(0.2 / (motion.time[1] - motion.time[0]))
    tau = motion.tau.copy()
    for joint, spread in enumerate(motion.tau.std(axis=0)):
        count = round(share * last / length)
        for first in length * rng.choice(last // length, count, replace=False):
            size = rng.choice([-1.0, 1.0]) * rng.uniform(2.0, 10.0) * spread
            tau[first : first + length, joint] += size
    return replace(motion, tau=tau)


def few(samples: int, kind: str = "single") -> Motion:
    motion = pendulum.motion(12.0, noise=0.02)
    return spoiled(motion.take(evenly(len(motion), samples)), kind, 0.1, 1.0)


@pytest.mark.parametrize("name", ["vrbfs+fri", "chain+fri", "srbfs+fri", "rbf", "fri"])
def test_no_torque_pulls_harder_than_the_loss_allows(name: str) -> None:
    """At the minimum the noise times a is the derivative of the loss, the residual cut at δ."""
    given = problem_of(few(50), name)
    found = huber(exact_solver(given), enough=1e-8)
    posterior = found.posterior
    noise = given.variances
    pull = noise * posterior.weights * given.unit
    cut = np.clip(posterior.residual, -found.threshold, found.threshold)
    np.testing.assert_allclose(pull / found.threshold, cut / found.threshold, atol=1e-7)
    assert (np.abs(posterior.residual) > 3.0 * found.threshold).any()


def test_it_is_the_minimum_that_a_general_method_finds() -> None:
    given = problem_of(few(16))
    found = huber(exact_solver(given), enough=1e-9)
    rows, gram = given.rows((0, 1)), given.gram((0, 1))
    design, target = rows.design(), rows.target
    gram = np.tril(gram) + np.tril(gram, -1).T
    noise = np.tile(given.variances, 16)
    limit = np.tile(found.threshold / given.unit, 16)
    size = len(target)

    def cost(point: Floats) -> tuple[float, Floats]:
        a, b = point[:size], point[size:]
        residual = target - gram @ a - design @ b
        cut = np.clip(residual, -limit, limit)
        loss = np.sum(cut * (residual - 0.5 * cut) / noise) + 0.5 * a @ gram @ a
        pull = cut / noise
        return float(loss), np.concatenate([gram @ (a - pull), -design.T @ pull])

    weights, coefficients = found.posterior.weights.ravel(), found.posterior.coefficients
    ours = cost(np.concatenate([weights, coefficients]))
    assert np.abs(ours[1]).max() < 1e-5
    elsewhere = minimize(
        cost, np.zeros(size + len(coefficients)), jac=True, method="BFGS",
        options={"gtol": 1e-8, "maxiter": 5000},
    )  # fmt: skip
    assert ours[0] <= elsewhere.fun * (1.0 + 1e-9)


@settings(max_examples=10)
@given(seed=st.integers(0, 999), name=st.sampled_from(["vrbfs+fri", "chain+fri", "srbfs+fri"]))
def test_the_order_of_the_samples_does_not_matter(seed: int, name: str) -> None:
    motion = few(30)
    order = np.random.default_rng(seed).permutation(len(motion))
    one = huber(exact_solver(problem_of(motion, name)), enough=1e-8)
    other = huber(exact_solver(problem_of(motion.take(order), name)), enough=1e-8)
    np.testing.assert_allclose(other.threshold, one.threshold, rtol=1e-5)
    ours, theirs = (found.posterior.problem.samples.weights for found in (other, one))
    np.testing.assert_allclose(ours, theirs[order], atol=1e-5)
    scale = np.abs(one.posterior.coefficients).max()
    np.testing.assert_allclose(
        other.posterior.coefficients, one.posterior.coefficients, atol=1e-5 * scale
    )


@settings(max_examples=10)
@given(unit=st.floats(1e-3, 1e3))
def test_the_unit_of_torque_does_not_matter(unit: float) -> None:
    motion = few(30)
    one = huber(exact_solver(problem_of(motion)))
    other = huber(exact_solver(problem_of(replace(motion, tau=unit * motion.tau))))
    ours, theirs = (found.posterior.problem.samples.weights for found in (other, one))
    np.testing.assert_allclose(ours, theirs, atol=1e-6)


@settings(max_examples=10)
@given(threshold=st.floats(1e3, 1e9), name=st.sampled_from(["vrbfs+fri", "chain+fri", "rbf"]))
def test_with_a_huge_threshold_it_is_least_squares(threshold: float, name: str) -> None:
    given = problem_of(few(30), name)
    found = huber(exact_solver(given), threshold=np.full(2, threshold)).posterior
    least = exact(given)
    assert (found.problem.samples.weights == 1.0).all()
    np.testing.assert_array_equal(found.weights, least.weights)
    np.testing.assert_array_equal(found.coefficients, least.coefficients)


@given(size=st.floats(10.0, 1e6))
@settings(max_examples=10)
def test_an_outlier_that_grows_changes_nothing_more(size: float) -> None:
    """Beyond the threshold its pull stays the same."""
    given = problem_of(few(30))
    threshold = huber(exact_solver(given)).threshold
    fits = []
    for factor in (1.0, size):
        wrong = given.samples.tau.copy()
        wrong[7, 0] = 100.0 * factor * given.unit[0]
        spoilt = exact_solver(given.of(replace(given.samples, tau=wrong)))
        fits.append(huber(spoilt, threshold=threshold, enough=1e-6).posterior.weights)
    np.testing.assert_allclose(fits[1], fits[0], atol=1e-3 * np.abs(fits[0]).max())


def test_torques_without_noise_weigh_one_or_hardly_less() -> None:
    """A joint that stands still has residuals of zero, and no threshold of zero."""
    motion = few(30)
    tau = motion.tau.copy()
    tau[:, 1] = 0.0
    found = huber(exact_solver(problem_of(replace(motion, tau=tau))))
    assert np.isfinite(found.posterior.weights).all()
    assert (found.threshold > 0.0).all()
    assert (at_sight(tau)[:, 1] == 1.0).all()


@pytest.fixture(scope="module")
def clean() -> Motion:
    """Return forty seconds of the pendulum with 2 % of noise."""
    return pendulum.motion(40.0, noise=0.02)


@pytest.fixture(scope="module")
def touched(clean: Motion) -> Identification:
    """Return a model of a motion with contacts, which chooses its kernel too."""
    return identify(spoiled(clean, "contact"), replace(FEW, model="auto+fri"))


@pytest.fixture(scope="module")
def square(clean: Motion) -> Identification:
    """Return a model of the motion without contacts by least squares."""
    return identify(clean, replace(FEW, loss="square"))


def held_out_error(found: Identification) -> float:
    return float(str(found.record["rmse"]))


@pytest.mark.parametrize(("name", "kind"), [("vrbfs+fri", "single"), ("chain+fri", "contact")])
def test_a_twentieth_of_gross_outliers_hardly_changes_the_error(
    clean: Motion, name: str, kind: str
) -> None:
    usual = Settings(name, samples=160, scale="common", evaluations=25)
    robust = replace(usual, loss="huber")
    before = held_out_error(identify(clean, usual))
    wrong = spoiled(clean, kind)
    assert held_out_error(identify(wrong, robust)) < 1.1 * before
    assert held_out_error(identify(wrong, usual)) > 3.0 * before


@pytest.mark.parametrize("positive", [False, True])
def test_outliers_hardly_change_a_model_on_inducing_points(clean: Motion, positive: bool) -> None:
    usual = Settings("vrbfs+fri", samples=240, scale="common", landmarks=60, positive=positive)
    before = held_out_error(identify(clean, usual))
    wrong = spoiled(clean, "contact")
    found = identify(wrong, replace(usual, loss="huber"))
    assert held_out_error(found) < 1.1 * before
    assert held_out_error(identify(wrong, usual)) > 3.0 * before
    weight = found.model.irls_weight
    assert weight is not None
    assert weight.shape == found.training.tau.shape
    gross = np.abs(wrong.tau - clean.tau)[found.model.seen] > 1.0
    assert (weight[gross] < 0.5).mean() > 0.99
    assert (weight[~gross] < 0.5).mean() < 0.05


def test_without_outliers_the_model_is_as_good(clean: Motion, square: Identification) -> None:
    assert held_out_error(identify(clean, FEW)) < 1.1 * held_out_error(square)


def test_the_record_has_the_outliers(touched: Identification) -> None:
    outliers = touched.record["outliers"]
    assert isinstance(outliers, dict)
    weight = touched.model.irls_weight
    assert weight is not None
    assert outliers["share"] == np.mean(weight < 0.5)
    assert 0.03 < outliers["share"] < 0.12
    longest = outliers["longest"]
    assert 0.1 < longest["seconds"] < 1.0
    column = pendulum.JOINTS.index(longest["joint"])
    first = np.searchsorted(touched.training.time, longest["begin"])
    assert weight[first, column] < 0.5
    assert f"{longest['seconds']:.2f} s of {longest['joint']}" in outliers["words"]
    assert f"{outliers['share']:.1%} of the torques" in outliers["words"]
    validation = touched.record["validation"]
    assert isinstance(validation, dict)
    assert outliers["rmse_of_others"] < 0.2 * validation["rmse"]


def test_outliers_held_out_move_the_rmse_and_not_the_median_beside_it(clean: Motion) -> None:
    found = identify(spoiled(clean, "contact", train=1.0), FEW)
    outliers, errors = found.record["outliers"], found.record["joints"]
    assert isinstance(outliers, dict)
    assert isinstance(errors, dict)
    untouched = clean.take(np.flatnonzero(~found.model.trained))
    missed = np.median(np.abs(untouched.tau - found.predicted), axis=0)
    for joint, without in zip(pendulum.JOINTS, missed, strict=True):
        half = outliers["joints"][joint]["held_out_median"]
        assert half == pytest.approx(without, rel=0.2)
        assert errors[joint]["rmse"] > 5.0 * half


def test_a_contact_is_no_torque_the_model_knows(clean: Motion, touched: Identification) -> None:
    largest = np.abs(clean.tau).max(axis=0)
    assert (touched.model.range.tau_max <= 1.1 * largest).all()
    assert (touched.model.range.tau_max > 0.8 * largest).all()


def test_intervals_are_not_widened_by_outliers(
    touched: Identification, square: Identification
) -> None:
    for one, other in zip(effects(touched), effects(square), strict=True):
        (robust,), (usual,) = one["parameters"].values(), other["parameters"].values()
        assert robust["high"] - robust["low"] < 4.0 * (usual["high"] - usual["low"])


def effects(found: Identification) -> list[dict[str, dict[str, dict[str, float]]]]:
    entries = found.record["effects"]
    assert isinstance(entries, list)
    return entries


@pytest.mark.parametrize("landmarks", [0, 60])
def test_uncertainty_is_that_of_torques_without_contacts(clean: Motion, landmarks: int) -> None:
    settings = replace(FEW, samples=200, landmarks=landmarks)
    robust = identify(spoiled(clean, "contact"), settings)
    square = identify(clean, replace(settings, loss="square"))
    x = clean.take(np.flatnonzero(~square.model.trained)[::20])
    one, other = (
        np.sqrt(m.uncertainty.variance(x.q, x.qd, x.qdd)).mean(axis=0)
        for m in (robust.model, square.model)
    )
    assert (one < 2.0 * other).all()
    shares = []
    for found in (robust, square):
        low, high = found.model.uncertainty.interval(x.q, x.qd, x.qdd)
        shares.append(((low <= x.tau) & (x.tau <= high)).mean())
    assert min(shares) > 0.85
    assert shares[0] == pytest.approx(shares[1], abs=0.04)


@pytest.mark.parametrize("landmarks", [0, 60])
def test_a_saved_model_refits_to_the_same(
    clean: Motion, touched: Identification, landmarks: int, tmp_path: Path
) -> None:
    if landmarks:
        touched = identify(spoiled(clean, "contact"), replace(FEW, landmarks=landmarks))
    path = tmp_path / "model.npz"
    touched.model.save(path)
    again = Model.load(path)
    np.testing.assert_array_equal(again.irls_weight, touched.model.irls_weight)
    stribeck = EFFECTS["stribeck"]
    here = extend(touched.model, stribeck, "elbow")
    there = extend(again, stribeck, "elbow")
    np.testing.assert_array_equal(there.model.weights, here.model.weights)
    assert here.record["settings"] == touched.record["settings"]
    assert held_out_error(here) < 1.1 * held_out_error(touched)


def test_a_model_of_the_square_loss_keeps_no_weights(clean: Motion) -> None:
    found = identify(clean, Settings(samples=40, evaluations=4))
    assert found.model.irls_weight is None
    assert "outliers" not in found.record


def test_a_robust_model_can_be_diagnosed(touched: Identification) -> None:
    known = {name: EFFECTS[name] for name in ("stribeck", "quadratic_drag")}
    motion = pendulum.motion(20.0, seed=3)
    with using(effort=Effort(rows=400)):
        found = diagnose(touched.model, motion, effects=known, steps=1)
    assert found.model is touched.model
    assert verdict(with_consequences(found))
