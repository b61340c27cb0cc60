"""Uncertainty: against dense formulas, refitting, and motion held out."""

import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pendulum
import pytest
from numpy.typing import NDArray
from pendulum_models import fitted
from scipy.signal import butter, sosfiltfilt

from lagrangian_ff.effects import EFFECTS, Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.identification.certainty.calibration import QUICK
from lagrangian_ff.identification.certainty.uncertainty import quick_factor
from lagrangian_ff.identification.samples import Samples
from lagrangian_ff.identification.solving.posterior import Posterior, exact
from lagrangian_ff.kernels import KERNELS, CoupledKernel, IndependentKernel, States
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

EVERY = sorted(KERNELS)


def wandering(seconds: float, seed: int) -> Motion:
    """Return a pendulum with an error that no model has: slow, a tenth of each torque."""
    motion = pendulum.motion(seconds, seed=0)
    wild = np.random.default_rng(seed).normal(size=motion.tau.shape)
    slow = sosfiltfilt(butter(2, 1.0, fs=100.0, output="sos"), wild, axis=0)
    error = 0.1 * motion.tau.std(axis=0) * slow / slow.std(axis=0)
    return replace(motion, tau=motion.tau + error)


def dense(fit: Posterior, x: Inputs, joint: int) -> tuple[float, float]:
    """Return kernel and basis variance of one torque at one state, in units of s²."""
    joints, basis, system = next(s for s in fit.systems if joint in s[0])
    kernel, states, at = fit.problem.kernel, fit.states, States(x.q, x.qd, x.qdd)
    row, unit = joints.index(joint), fit.problem.unit
    if isinstance(kernel, CoupledKernel):
        gram, cross = kernel.cross(states, states), kernel.cross(at, states)[row]
    else:
        assert isinstance(kernel, IndependentKernel)
        gram, cross = kernel.cross(states, states, joint), kernel.cross(at, states, joint)[0]
    noise = fit.problem.variances[list(joints)]
    inverse = np.linalg.inv(gram + np.diag(np.tile(noise, len(states))))
    design = basis.design(x)[0, joint] / unit[joint]
    left = design - cross @ inverse @ system.design
    information = system.design.T @ inverse @ system.design
    prior = float(kernel.variance(at)[0, joint])
    return prior - cross @ inverse @ cross, left @ np.linalg.pinv(information) @ left


@pytest.mark.parametrize("name", EVERY)
def test_it_is_the_variance_of_gaussian_processes(name: str) -> None:
    found = fitted(f"{name}+fri", samples=40, noise=1e-2).posterior
    x = Inputs.of(pendulum.states(3.0, 1.0, seed=5)[1])
    variance = found.variance(x)
    for sample in range(len(x)):
        for joint in range(2):
            system = next(s for j, _, s in found.systems if joint in j)
            scale = system.amplitude * found.problem.unit[joint] ** 2
            kernel, basis = dense(found, x.take(np.array([sample])), joint)
            prior = variance.prior[sample, joint]
            assert variance.kernel[sample, joint] == pytest.approx(
                scale * kernel, rel=1e-6, abs=1e-9 * prior
            )
            assert variance.basis[sample, joint] == pytest.approx(scale * basis, rel=1e-5)


@pytest.mark.parametrize("name", EVERY)
def test_deviations_of_samples_left_out_are_those_of_a_fit_without_them(name: str) -> None:
    made = fitted(f"{name}+fri", samples=60, noise=1e-2)
    x, tau = Inputs.of(made.posterior.states), made.training.tau
    group, rest = np.arange(20, 30), np.setdiff1d(np.arange(60), np.arange(20, 30))
    weight = np.random.default_rng(3).uniform(0.1, 1.0, tau.shape)
    problem = made.posterior.problem.of(Samples(x, tau, None, weight))
    whole, without = exact(problem), exact(problem.take(rest))
    variance = without.variance(x.take(group))
    expected = variance.kernel + variance.basis + variance.noise
    for joints, _, system in whole.systems:
        other = next(s for j, _, s in without.systems if j == joints)
        expected[:, list(joints)] *= system.amplitude / other.amplitude
    found = whole.left_out_deviation([group])
    np.testing.assert_allclose(found[group] ** 2, expected, rtol=1e-5)
    assert np.isnan(found[rest]).all()


def coverage(
    name: str, motions: list[Motion], thinned: int = 0, landmarks: int | None = None
) -> Floats:
    """Return the mean share of each joint's torques held out that lie inside its interval."""
    shares = []
    for motion in motions:
        found = fitted(name, motion, samples=200, noise=1e-3, in_turn=True, landmarks=landmarks)
        certain = found.model.uncertainty
        if thinned:
            certain = certain.thinned(thinned)
        x = found.held_out.take(slice(None, None, 3))
        low, high = certain.interval(x.q, x.qd, x.qdd)
        shares.append(((low <= x.tau) & (x.tau <= high)).mean(axis=0))
    return np.asarray(np.mean(shares, axis=0))


@pytest.mark.parametrize(
    ("name", "thinned"), [("chain+fri", 0), ("vrbfs+fri", 0), ("srbfs+fri", 0), ("vrbfs+fri", 50)]
)
def test_intervals_hold_nine_of_ten_torques_not_seen(name: str, thinned: int) -> None:
    motions = [pendulum.motion(60.0, 50.0, noise=0.05, seed=seed) for seed in range(4)]
    assert np.abs(coverage(name, motions, thinned) - 0.9).max() < 0.05


@pytest.mark.parametrize("thinned", [0, 50])
def test_they_hold_them_where_errors_are_no_white_noise(thinned: int) -> None:
    motions = [wandering(60.0, seed) for seed in range(4)]
    assert np.abs(coverage("vrbfs+fri", motions, thinned) - 0.9).max() < 0.05


@pytest.mark.parametrize(
    ("name", "thinned"), [("chain+fri", 0), ("srbfs+fri", 0), ("vrbfs+fri", 0), ("vrbfs+fri", 50)]
)
def test_models_on_inducing_points_hold_them_as_well(name: str, thinned: int) -> None:
    """Neighbours have a common error here: 2400 samples count as much as a small subset."""
    motions = [wandering(60.0, seed) for seed in range(3)]
    assert np.abs(coverage(name, motions, thinned, landmarks=40) - 0.9).max() < 0.05


def test_the_record_has_the_factors_on_deviations() -> None:
    found = fitted("vrbfs+fri", wandering(30.0, 1))
    record = found.record["uncertainty"]
    assert isinstance(record, dict)
    assert record["level"] == 0.9
    assert list(record["factor"]) == list(pendulum.JOINTS)
    used = found.model.uncertainty.factor
    np.testing.assert_allclose(list(record["factor"].values()), used, rtol=1e-6)


def test_uncertainty_grows_outside_the_data() -> None:
    some = ("vrbfs+fri", "chain_rbf+fri", "srbf+fri")
    for name, landmarks in itertools.product(some, (None, 40)):
        model = fitted(name, landmarks=landmarks).model
        q = model.data.q[0]
        steps = np.array([0.0, 1.5, 3.0, 6.0])[:, None]
        qd, far = np.tile([1.0, 1.0], (4, 1)), model.range.qd_max * steps
        deviation = np.sqrt(model.uncertainty.variance(np.tile(q, (4, 1)), far, 0.0 * far))
        assert (np.diff(deviation, axis=0) > 0.0).all()
        assert (deviation[-1] > 3.0 * deviation[0]).all()
        unknown = model.uncertainty.unknown(np.tile(q, (4, 1)), far + qd, 0.0 * far)
        assert (np.diff(unknown.max(axis=1)) > 0.0).all()
        assert unknown.min() >= 0.0
        assert unknown.max() <= 1.0


def test_noise_is_a_part_of_it() -> None:
    found = fitted("chain+fri", pendulum.motion(30.0, noise=0.05), noise=1e-3)
    x, certain = found.held_out, found.model.uncertainty
    whole = certain.variance(x.q, x.qd, x.qdd)
    torque = certain.variance(x.q, x.qd, x.qdd, noise=False)
    assert (torque < whole).all()
    # All samples have the same noise, and on known ground it is most of what there is.
    np.testing.assert_allclose(whole - torque, np.tile((whole - torque)[0], (len(x), 1)))
    assert (torque.mean(axis=0) < 0.5 * whole.mean(axis=0)).all()


def test_fewer_samples_have_no_smaller_variance_before_calibration() -> None:
    found = fitted("vrbfs+fri", pendulum.motion(30.0, noise=0.02))
    whole, x = found.model.uncertainty, found.held_out
    few = whole.thinned(40)
    assert len(few.posterior.states) == 40
    at = Inputs.of(States.of(x.q, x.qd, x.qdd))
    one, other = whole.posterior.variance(at), few.posterior.variance(at)
    amplitudes = np.median(other.prior / one.prior)
    left = (other.kernel + other.basis) / amplitudes
    assert (left > (1.0 - 1e-6) * (one.kernel + one.basis)).all()
    with pytest.raises(ModelError, match="expected at least 10"):
        whole.thinned(3)


@pytest.mark.parametrize("more", [{}, {"landmarks": 40}, {"loss": "huber"}])
def test_the_quick_form_is_the_thinned_one_with_its_stored_calibration(
    more: dict[str, Any], tmp_path: Path
) -> None:
    found = fitted("vrbfs+fri", wandering(30.0, 2), samples=QUICK + 20, noise=1e-3, **more)
    found.model.save(tmp_path / "model.npz")
    model, x = Model.load(tmp_path / "model.npz"), found.held_out
    quick = model.quick_uncertainty
    assert "uncertainty" not in vars(model), "the whole system was solved"
    thinned = model.uncertainty.thinned(QUICK)
    of_before = replace(model, record={**model.record, "uncertainty": None})
    expected = thinned.variance(x.q, x.qd, x.qdd)
    for one in (quick, of_before.quick_uncertainty):
        np.testing.assert_allclose(one.variance(x.q, x.qd, x.qdd), expected, rtol=1e-6)
    assert quick_factor(of_before) is None


def test_some_samples_are_evaluated_with_the_past_of_all() -> None:
    presliding = (Term(EFFECTS["hysteresis"], 0, {"w": 0.3}),)
    found = fitted("chain+fri", further=presliding, samples=60)
    x, quick = found.held_out, found.model.quick_uncertainty
    past: dict[str, Any] = {"time": x.time, "segment": x.segment}
    every = quick.reach(x.q, x.qd, x.qdd, **past)
    at = np.arange(5, len(x), 7)
    np.testing.assert_allclose(quick.reach(x.q, x.qd, x.qdd, at=at, **past), every[at], rtol=1e-6)
    alone = x.take(at)
    assert not np.allclose(quick.reach(alone.q, alone.qd, alone.qdd), every[at], rtol=1e-3)


def test_a_single_block_is_too_little_for_calibration() -> None:
    found = fitted("vrbfs+fri", samples=60, block_seconds=60.0, train=1.0)
    assert quick_factor(found.model) is None
    with pytest.raises(ModelError, match="longer recording"):
        _ = found.model.quick_uncertainty


def test_one_state_is_as_in_a_batch() -> None:
    found = fitted("chain+fri", samples=60)
    x, certain = found.held_out, found.model.uncertainty
    for many, one in zip(
        (*certain.interval(x.q, x.qd, x.qdd), certain.unknown(x.q, x.qd, x.qdd)),
        (*certain.interval(x.q[3], x.qd[3], x.qdd[3]), certain.unknown(x.q[3], x.qd[3], x.qdd[3])),
        strict=True,
    ):
        assert one.shape == (2,)
        np.testing.assert_allclose(one, many[3], rtol=1e-6)


def test_effects_that_follow_the_torque_receive_that_of_the_model() -> None:
    rubbing = [Term(EFFECTS["load_friction"], joint, {"Jr": 0.0}) for joint in range(2)]
    found = fitted("chain+fri", further=rubbing, samples=60)
    x, certain = found.held_out, found.model.uncertainty
    variance = certain.variance(x.q, x.qd, x.qdd, time=x.time, segment=x.segment)
    known = certain.posterior.variance(found.model.inputs_of(x)).whole * certain.factor**2
    np.testing.assert_allclose(variance, known, rtol=1e-9)
    still = found.model.inputs_of(x)
    unknown = certain.posterior.variance(replace(still, load=0.0 * still.load)).basis
    assert (np.abs(unknown / certain.posterior.variance(still).basis - 1.0) > 0.01).any()


@pytest.mark.parametrize("landmarks", [None, 40])
def test_a_model_file_has_the_uncertainty_of_the_model(
    landmarks: int | None, tmp_path: Path
) -> None:
    found = fitted("vrbfs+fri", samples=60, landmarks=landmarks)
    found.model.save(tmp_path / "model.npz")
    again, x = Model.load(tmp_path / "model.npz"), found.held_out
    np.testing.assert_allclose(
        again.uncertainty.variance(x.q, x.qd, x.qdd),
        found.model.uncertainty.variance(x.q, x.qd, x.qdd),
        rtol=1e-9,
    )


def test_what_cannot_be_is_refused() -> None:
    certain = fitted("fri", samples=30).model.uncertainty
    q = np.zeros((2, 2))
    with pytest.raises(ModelError, match=r"level is 90.*as in 0\.9"):
        certain.interval(q, q, q, level=90)
    with pytest.raises(ModelError, match="2 joints"):
        certain.variance(np.zeros((2, 3)), np.zeros((2, 3)), np.zeros((2, 3)))
