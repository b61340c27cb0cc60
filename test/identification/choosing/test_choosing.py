"""Choosing kernels and their numbers: by the evidence's slopes, and by blocks left out."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pendulum
import pytest
from numpy.typing import NDArray

from lagrangian_ff.effects import EFFECTS, Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.choice import Choice, Scaling
from lagrangian_ff.identification.choosing import choose as choosing
from lagrangian_ff.identification.choosing.choose import choose_all
from lagrangian_ff.identification.choosing.evidence import _Path, climb, slopes_of
from lagrangian_ff.identification.choosing.robustly import choose_robustly
from lagrangian_ff.identification.choosing.search import starting_choice
from lagrangian_ff.identification.choosing.training import TrainingSet
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.solving.equations import fit
from lagrangian_ff.identification.spec import Spec, parse
from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]

CHAIN = parse("chain+fri")


def training(samples: int, seed: int = 0) -> TrainingSet:
    motion = pendulum.motion(24.0, noise=0.02, seed=seed)
    few = motion.take(evenly(len(motion), samples))
    x = Inputs.of(States.of(few.q, few.qd, few.qdd), few.time, few.segment)
    return TrainingSet(x, few.tau, few.blocks(3.0) % 4)


def doubting(data: TrainingSet) -> TrainingSet:
    trust = np.random.default_rng(2).uniform(0.05, 1.0, data.tau.shape)
    return replace(data, trust=trust)


def started(data: TrainingSet, spec: Spec = CHAIN) -> tuple[Choice, Scaling]:
    return starting_choice(spec, data.states), Scaling.of(data.tau, per_joint=False)


@pytest.mark.parametrize("doubt", [False, True])
def test_slopes_by_numbers_noise_and_shapes_are_those_of_finite_differences(doubt: bool) -> None:
    data = training(20)
    data = doubting(data) if doubt else data
    choice, scaling = started(data)
    path = _Path(CHAIN, choice)
    middle = path.middle

    def height(point: Floats) -> float:
        return fit(CHAIN, path.at(point), data.x, data.tau, scaling, data.trust).log_evidence

    found = slopes_of(fit(CHAIN, choice, data.x, data.tau, scaling, data.trust), data)
    step = 1e-4
    expected = [
        (height(middle + e) - height(middle - e)) / (2 * step) for e in step * np.eye(len(middle))
    ]
    assert len(expected) == len(middle) == len(found.slope)
    np.testing.assert_allclose(found.slope, expected, rtol=1e-4, atol=1e-4)
    assert np.linalg.eigvalsh(found.information).min() > -1e-6


def test_a_climb_raises_the_evidence_by_more_than_the_prior_takes() -> None:
    data = training(40)
    choice, scaling = started(data)
    before = fit(CHAIN, choice, data.x, data.tau, scaling).log_evidence
    path = _Path(CHAIN, choice)
    heights = [before + path.belief.height(path.middle)]
    for steps in (1, 3, 9):
        top, evidence = climb(CHAIN, choice, data, scaling, [(40, steps)])
        again = fit(CHAIN, top, data.x, data.tau, scaling).log_evidence
        assert evidence == pytest.approx(again, abs=1e-6)
        belief = _Path(CHAIN, choice).belief
        heights.append(evidence + belief.height(_Path(CHAIN, top).middle))
    assert (np.diff(heights) >= -1e-9).all()
    assert heights[-1] > before + 20.0


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
    still = TrainingSet(x, data.tau, data.fold)
    choice, scaling = started(still)
    top, _ = climb(CHAIN, choice, still, scaling, [(40, 8)])
    before, after = (c.kernel.hyperparameters["rotor"] for c in (choice, top))
    assert after[1] == pytest.approx(before[1], rel=1e-12)
    assert after[0] != pytest.approx(before[0], rel=1e-6)


def test_a_shape_stays_within_its_range() -> None:
    """Friction that reverses slowly asks for a step as wide as that of no dry friction."""
    data = training(40)
    smooth = replace(data, tau=data.tau + 5.0 * np.tanh(data.x.qd / 1.5))
    choice, scaling = started(smooth)
    top, _ = climb(CHAIN, choice, smooth, scaling, [(40, 12)])
    (shape,) = EFFECTS["coulomb"].shapes
    assert (top.shapes["coulomb"]["v0"] <= shape.high * (1.0 + 1e-12)).all()
    assert top.shapes["coulomb"]["v0"].max() == pytest.approx(shape.high)


def test_a_start_with_too_little_noise_gets_more() -> None:
    data = training(30)
    twice = np.repeat(np.arange(15), 2)
    doubled = TrainingSet(data.x.take(twice), data.tau[twice], data.fold[twice])
    choice, scaling = started(doubled)
    hardly = replace(choice, noise=choice.noise * 1e-17)
    top, evidence = climb(CHAIN, hardly, doubled, scaling, [(30, 4)])
    assert np.isfinite(evidence)
    assert (top.noise > hardly.noise).all()


def test_a_motion_no_start_has_a_factor_for_is_refused_in_words() -> None:
    data = training(30)
    wild = replace(data, x=replace(data.x, qdd=1e170 * data.x.qdd))
    _, scaling = started(data)
    with pytest.raises(ModelError, match=r"chain\+fri has no Cholesky factor .* impossible"):
        choose_all(CHAIN, wild, [scaling])


@pytest.mark.parametrize("criterion", ["validation", "evidence"])
def test_auto_takes_the_kernel_that_does_better(criterion: str) -> None:
    data = training(60)
    _, scaling = started(data)
    spec = parse("auto+fri")
    found = choose_all(spec, data, [scaling], criterion)
    assert {str(one["kernel"]) for one in found.tried} == {"chain", "chain_rbf"}
    best = min(found.tried, key=lambda one: float(str(one[criterion])))
    assert found.spec.kernel.name == best["kernel"]
    assert found.spec.basic == f"{best['kernel']}+fri"
    again = choose_all(spec, data, [scaling], criterion)
    assert again.tried == found.tried
    np.testing.assert_array_equal(again.choice.noise, found.choice.noise)


def astray(after: int, climbs: list[Choice]) -> Callable[..., tuple[Choice, float]]:
    """A climb that ends in much noise once there have been some; it notes where each one led."""

    def climbed(*given: Any, **named: Any) -> tuple[Choice, float]:
        top, evidence = climb(*given, **named)
        if len(climbs) >= after:
            top = replace(top, noise=1e6 * top.noise)
        climbs.append(top)
        return top, evidence

    return climbed


def test_a_last_climb_that_leads_astray_is_not_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where samples lie so close that they share their errors."""
    data = training(250)
    _, scaling = started(data)
    climbs: list[Choice] = []
    monkeypatch.setattr(choosing, "climb", astray(2, climbs))
    found = choose_all(CHAIN, data, [scaling])
    _, before, last = (float(str(one["validation"])) for one in found.tried)
    assert last > before
    assert (found.choice.noise < 1e-3 * climbs[-1].noise).all()


def test_after_a_climb_that_leads_astray_there_is_no_further_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    data = training(60)
    _, scaling = started(data)
    climbs: list[Choice] = []
    monkeypatch.setattr(choosing, "climb", astray(1, climbs))
    found = choose_all(CHAIN, data, [scaling])
    assert len(climbs) == len(found.tried) == 2


def test_a_robust_choice_knows_whom_not_to_trust() -> None:
    data = training(80)
    wrong = np.zeros(data.tau.shape, dtype=bool)
    wrong[::17, 0] = wrong[5::19, 1] = True
    tau = data.tau + 6.0 * wrong * data.tau.std(axis=0)
    chosen, trust = choose_robustly(
        CHAIN, replace(data, tau=tau), lambda some, known: [Scaling.of(some, False, known)]
    )
    assert (trust[wrong] < 0.2).all()
    assert np.mean(trust[~wrong] < 0.5) < 0.06
    choice = chosen.choice
    fitted = fit(CHAIN, choice, data.x, data.tau, chosen.scaling, np.where(wrong, 1e-6, 1.0))
    assert np.sqrt(np.mean(fitted.residual[~wrong] ** 2)) < 0.03 * data.tau.std()


def test_friction_turns_round_as_all_samples_say_not_only_those_climbed_with() -> None:
    data = training(1200, seed=1)
    _, scaling = started(data)
    found = choose_all(CHAIN, data, [scaling], "evidence").choice
    np.testing.assert_allclose(found.shapes["coulomb"]["v0"], pendulum.WIDTH, rtol=0.03)


def test_a_choice_takes_the_shapes_of_a_basis_and_keeps_the_rest() -> None:
    data = training(20)
    choice, _ = started(data)
    v0 = [choice.shapes["coulomb"]["v0"][0], 0.07]
    basis = replace(choice, shapes={"coulomb": {"v0": np.array(v0)}}).basis(CHAIN, 2)
    found = choice.shaped_as(basis)
    assert found.shapes["coulomb"]["v0"].tolist() == v0
    assert found.kernel is choice.kernel
    assert found.basis(CHAIN, 2).terms == basis.terms
