"""Choosing kernels and their numbers: by the evidence's slopes, and by blocks left out."""

from dataclasses import replace
from operator import attrgetter

import numpy as np
import pendulum
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from lagrangian_ff.effects import EFFECTS, Inputs
from lagrangian_ff.effects.formula import formula_effect
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.choosing.choose import STRONG, choose, choose_robustly
from lagrangian_ff.identification.choosing.evidence import (
    Logarithms,
    derivatives,
    maximise_evidence,
    solvable,
)
from lagrangian_ff.identification.choosing.gains import likeliest_gains
from lagrangian_ff.identification.choosing.left_out import validation_score
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.samples import Samples, evenly
from lagrangian_ff.identification.settings import Settings
from lagrangian_ff.identification.solving.posterior import Posterior, exact
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.identification.spec import Spec, parse
from lagrangian_ff.kernels import KERNELS, DifferentiableKernel, States

Floats = NDArray[np.float64]

CHAIN = parse("chain+fri")
DIFFERENTIABLE = sorted(n for n, k in KERNELS.items() if issubclass(k, DifferentiableKernel))


def training(samples: int, seed: int = 0) -> Samples:
    motion = pendulum.motion(24.0, noise=0.02, seed=seed)
    few = motion.take(evenly(len(motion), samples))
    x = Inputs.of(States.of(few.q, few.qd, few.qdd), few.time, few.segment)
    return Samples(x, few.tau, few.blocks(3.0) % 4)


def doubting(data: Samples) -> Samples:
    weight = np.random.default_rng(2).uniform(0.05, 1.0, data.tau.shape)
    return replace(data, weight=weight)


def holding(data: Samples) -> Samples:
    """Return the same samples of a motion in which the last joint stands still half of the time."""
    motion = pendulum.motion(24.0, noise=0.02)
    states = [motion.q.copy(), motion.qd.copy(), motion.qdd.copy()]
    half = len(motion) // 2
    for one, held in zip(states, (motion.q[half, -1], 0.0, 0.0), strict=True):
        one[half:, -1] = held
    whole = Inputs.of(States.of(*states), motion.time, motion.segment)
    x = whole.take(evenly(len(motion), len(data)))
    assert 0.4 < x.rest[:, -1].mean() < 0.6
    return replace(data, x=x)


def common(data: Samples) -> Scaling:
    return Scaling.of(data.tau, per_joint=False)


def started(data: Samples, spec: Spec = CHAIN) -> Problem:
    return Problem.started(spec, data, common(data))


def step_widths(problem: Problem) -> Floats:
    """Return (N,) rad/s, v0 of the Coulomb terms."""
    return np.array([t.shape["v0"] for t in problem.basis.terms if t.effect.name == "coulomb"])


def best(problem: Problem, steps: int) -> Posterior[System]:
    return maximise_evidence(solvable(problem), steps, Logarithms(problem).prior, enough=0.5)


CHANGES = {"one Lagrangian": None, "another from then on": (6.0, np.inf, 0.3)}


SEEN = {"sure": lambda data: data, "in doubt": doubting, "one joint held": holding}


@pytest.mark.parametrize("seen", SEEN)
@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("name", DIFFERENTIABLE)
def test_derivatives_are_those_of_finite_differences(name: str, change: str, seen: str) -> None:
    """They are those by the kernel's numbers, the noise and the effects' shapes."""
    data = SEEN[seen](training(20))
    problem = replace(started(data, parse(f"{name}+fri")), change=CHANGES[change])
    logarithms = Logarithms(problem)
    middle = logarithms.of(problem)

    def evidence(point: Floats) -> float:
        return exact(logarithms.at(point)).log_evidence

    found = derivatives(exact(problem))
    step = 1e-4
    expected = [
        (evidence(middle + e) - evidence(middle - e)) / (2 * step)
        for e in step * np.eye(len(middle))
    ]
    assert len(expected) == len(middle) == len(found.gradient)
    np.testing.assert_allclose(found.gradient, expected, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(found.curvature, found.curvature.T, atol=1e-10)
    assert np.linalg.eigvalsh(found.curvature).min() > -1e-6


def test_the_derivative_by_a_place_that_is_negative_is_that_of_finite_differences() -> None:
    bump = formula_effect("bump", "A*sign(qd)*exp(-((q-c)/w)^2)", {"c": (-1.0, 1.0), "w": (0.1, 1)})
    plain = started(training(20))
    terms = (*plain.basis.terms, Term(bump, 0, {"c": -0.3, "w": 0.4}))
    problem = plain.having(kernel=plain.kernel, noise=plain.noise, basis=Basis(terms))
    logarithms = Logarithms(problem)
    middle, step = logarithms.of(problem), 1e-4
    assert logarithms.at(middle).basis.terms[-1].shape == pytest.approx({"c": -0.3, "w": 0.4})
    low, high = logarithms.ends
    assert logarithms.at(low).basis.terms[-1].shape["c"] == pytest.approx(-1.0)
    assert logarithms.at(high).basis.terms[-1].shape["c"] == pytest.approx(1.0)
    up, down = (
        exact(logarithms.at(middle + by * np.eye(len(middle))[-2])).log_evidence
        for by in (step, -step)
    )
    found = derivatives(exact(problem)).gradient[-2]
    assert abs(found) > 1e-3
    assert found == pytest.approx((up - down) / (2.0 * step), rel=1e-3)


def test_steps_raise_the_evidence_by_more_than_the_prior_takes() -> None:
    problem = started(training(40))
    logarithms = Logarithms(problem)
    before = exact(problem).log_evidence
    densities = [before + logarithms.prior.log_density(logarithms.of(problem))]
    for steps in (1, 3, 9):
        found = best(problem, steps)
        again = exact(found.problem).log_evidence
        assert found.log_evidence == pytest.approx(again, abs=1e-6)
        at = logarithms.of(found.problem)
        densities.append(found.log_evidence + logarithms.prior.log_density(at))
    assert (np.diff(densities) >= -1e-9).all()
    assert densities[-1] > before + 20.0


def test_a_number_the_motion_does_not_show_stays_where_it_began() -> None:
    """The rotor of a joint that never moves has no torque."""
    data = training(40)
    zero = np.zeros(40)
    x = replace(
        data.x,
        q=np.column_stack([data.x.q[:, 0], zero + 0.3]),
        qd=np.column_stack([data.x.qd[:, 0], zero]),
        qdd=np.column_stack([data.x.qdd[:, 0], zero]),
    )
    still = Samples(x, data.tau, data.fold)
    problem = started(still)
    top = best(problem, 8).problem
    before, after = (one.kernel.hyperparameters["rotor"] for one in (problem, top))
    assert after[1] == pytest.approx(before[1], rel=1e-12)
    assert after[0] != pytest.approx(before[0], rel=1e-6)


def test_a_shape_stays_within_its_range() -> None:
    """Friction that reverses slowly asks for a step as wide as that of no dry friction."""
    data = training(40)
    smooth = replace(data, tau=data.tau + 5.0 * np.tanh(data.x.qd / 1.5))
    widths = step_widths(best(started(smooth), 12).problem)
    (shape,) = EFFECTS["coulomb"].shapes
    assert (widths <= shape.high * (1.0 + 1e-12)).all()
    assert widths.max() == pytest.approx(shape.high)


def test_a_start_with_too_little_noise_gets_more() -> None:
    data = training(30)
    twice = np.repeat(np.arange(15), 2)
    hardly = started(data.take(twice)).noisier(1e-17)
    found = best(hardly, 4)
    assert np.isfinite(found.log_evidence)
    assert (found.problem.noise > hardly.noise).all()


def test_a_joint_at_the_least_noise_does_not_hold_up_the_others() -> None:
    problem = solvable(started(training(120)))
    prior = Logarithms(problem).prior
    usual = maximise_evidence(problem, 30, prior, least_noise=1e-7)
    silent = problem.having(noise=problem.noise * np.array([1.0, 1e-12]))
    found = maximise_evidence(silent, 30, prior, least_noise=1e-7)
    assert found.log_evidence > usual.log_evidence - 1.0
    variance = found.problem.kernel.variance(found.problem.samples.states).mean()
    assert (found.problem.noise >= 0.999e-7 * variance).all()


def test_a_motion_no_start_has_a_factor_for_is_refused_in_words() -> None:
    data = training(30)
    wild = replace(data, x=replace(data.x, qdd=1e170 * data.x.qdd))
    scaling = common(data)
    with pytest.raises(ModelError, match=r"chain\+fri has no Cholesky factor .* impossible"):
        choose(CHAIN, wild, [scaling], Settings())


@pytest.mark.parametrize("criterion", ["validation", "evidence"])
def test_auto_takes_the_kernel_that_does_better(criterion: str) -> None:
    data = training(60)
    scaling = common(data)
    spec = parse("auto+fri")
    found = choose(spec, data, [scaling], Settings(selection=criterion))
    assert {one.kernel for one in found.tried} == {"chain", "chain_rbf"}
    best = min(found.tried, key=attrgetter(criterion))
    assert found.spec.kernel.name == best.kernel
    assert found.spec.basic == f"{best.kernel}+fri"
    again = choose(spec, data, [scaling], Settings(selection=criterion))
    assert again.tried == found.tried
    np.testing.assert_array_equal(again.problem.noise, found.problem.noise)


def typical_error(problem: Problem, data: Samples) -> float:
    """Return the geometric mean of the errors of each joint on each fold left out."""
    found = exact(problem.of(data))
    errors = [validation_score(found, [group]) for group in data.groups()]
    return float(np.exp(np.mean(np.log(errors))))


def with_gains(data: Samples, gains: Floats) -> Samples:
    return replace(data, tau=data.tau * gains)


def test_effort_in_a_unit_of_each_joints_own_is_seen() -> None:
    """Two joints share a Lagrangian in one unit only; with the wrong one each is learned apart."""
    data = training(60)
    for gains, unit in ((np.ones(2), "common"), (np.array([1.0, 10.0]), "joint")):
        given = with_gains(data, gains)
        scalings = [common(given), Scaling.of(given.tau, per_joint=True)]
        found = choose(CHAIN, given, scalings, Settings())
        assert ("common" if np.ptp(found.problem.unit) == 0.0 else "joint") == unit


def test_gains_of_drives_are_found_where_they_are() -> None:
    """In the unit of an unknown gain of 1.5 the torques derive from one Lagrangian."""
    data = training(60)
    for gain in (1.0, 1.5):
        gains = likeliest_gains(best(started(with_gains(data, np.array([1.0, gain]))), 30).problem)
        assert (gains.nats > STRONG) == (gain != 1.0)
    given = with_gains(training(240), np.array([1.0, 1.5]))
    scalings = [common(given), Scaling.of(given.tau, per_joint=True)]
    unit = choose(CHAIN, given, scalings, Settings()).problem.unit
    assert unit[1] / unit[0] == pytest.approx(1.5, rel=0.15)


def test_a_freer_kernel_is_not_taken_for_an_arm_of_rigid_bodies() -> None:
    """Where two kernels do alike, the one that knows more physics does better beyond."""
    for seed in range(3):
        data = training(240, seed)
        assert (
            choose(parse("auto+fri"), data, [common(data)], Settings()).spec.kernel.name == "chain"
        )


def test_a_joint_of_noise_does_not_decide_alone() -> None:
    """Where one joint's effort is nearly all noise, the other's is predicted as well as without."""
    data = training(120)
    tau = data.tau.copy()
    random = np.random.default_rng(4)
    tau[:, 1] += 20.0 * data.tau[:, 1].std() * random.normal(size=len(tau))
    scaling = common(data)

    def error(given: Samples) -> float:
        problem = choose(CHAIN, given, [scaling], Settings()).problem
        left = exact(problem.of(given)).left_out(given.groups())
        return float(np.sqrt(np.mean(left[:, 0] ** 2)))

    assert error(replace(data, tau=tau)) < 2.0 * error(data)


def shared_errors(seed: int, seconds: float, noise: float, length: float) -> Samples:
    """Return 250 samples that share their errors: noise, of the spread, for `length` s."""
    motion = pendulum.motion(seconds, seed=seed)
    kept = np.exp(-0.01 / length)
    white = np.random.default_rng(seed).normal(size=(len(motion) + 500, 2))
    error = lfilter([np.sqrt(1.0 - kept**2)], [1.0, -kept], white, axis=0)[500:]
    few = replace(motion, tau=motion.tau + noise * motion.tau.std(axis=0) * error)
    few = few.take(evenly(len(motion), 250))
    x = Inputs.of(States.of(few.q, few.qd, few.qdd), few.time, few.segment)
    return Samples(x, few.tau, few.blocks(3.0) % 4)


def test_last_steps_that_lead_astray_are_not_followed() -> None:
    data = shared_errors(1, 24.0, 0.1, 0.3)
    found = choose(CHAIN, data, [common(data)], Settings())
    _, before, last = (one.validation or np.inf for one in found.tried)
    assert last > before
    assert typical_error(found.problem, data.thinned(240)) < 0.98 * last


def test_after_steps_that_lead_astray_there_are_no_further_ones() -> None:
    data = shared_errors(0, 12.0, 0.6, 1.0)
    found = choose(CHAIN, data, [common(data)], Settings())
    first, second = (one.validation or np.inf for one in found.tried)
    assert second > first


def test_a_robust_choice_weighs_down_outliers() -> None:
    data = training(80)
    wrong = np.zeros(data.tau.shape, dtype=bool)
    wrong[::17, 0] = wrong[5::19, 1] = True
    tau = data.tau + 6.0 * wrong * data.tau.std(axis=0)
    chosen, weight = choose_robustly(
        CHAIN,
        replace(data, tau=tau),
        lambda some, known: [Scaling.of(some, False, known)],
        Settings(),
    )
    assert (weight[wrong] < 0.2).all()
    assert np.mean(weight[~wrong] < 0.5) < 0.06
    posterior = exact(chosen.problem.of(data).weighted(np.where(wrong, 1e-6, 1.0)))
    assert np.sqrt(np.mean(posterior.residual[~wrong] ** 2)) < 0.03 * data.tau.std()


def test_the_coulomb_step_follows_all_samples_not_only_those_of_the_evidence() -> None:
    data = training(1200, seed=1)
    scaling = common(data)
    found = choose(CHAIN, data, [scaling], Settings(selection="evidence")).problem
    np.testing.assert_allclose(step_widths(found), pendulum.WIDTH, rtol=0.03)
