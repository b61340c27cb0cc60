"""What drives where nature brakes is not confirmed, however well it explains the torque."""

import numpy as np
import pytest
import two_rods
from whitened_examples import few_torques, whitened_of

from lagrangian_ff.diagnosis import Diagnosis, diagnose
from lagrangian_ff.diagnosis.confidence import Reason
from lagrangian_ff.diagnosis.search.bayes_factor import bayes_factors
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.search.signs import unnatural
from lagrangian_ff.effects import EFFECTS, Effect, Parameter, Shape
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.problem import Nuisance

FEW = Settings(train=1.0, samples=120, evaluations=20, model="chain+fri")
OWN = 0.8  # N·m, Coulomb friction of the elbow without what is hidden


_small = few_torques(800)


def found(hidden: two_rods.Hidden, *names: str, steps: int = 1) -> Diagnosis:
    """Return the diagnosis of a hidden torque among a few effects."""
    model = identify(two_rods.motion(1), FEW).model
    first, second = (two_rods.motion(seed, hidden=hidden) for seed in (1, 2))
    return diagnose(model, first, second, {name: EFFECTS[name] for name in names}, steps=steps)


def on_elbow(torque: two_rods.Floats) -> two_rods.Floats:
    """Return (M, 2) N·m of a torque (M,) of the elbow."""
    return np.stack([np.zeros_like(torque), torque], axis=1)


def swinging(size: float) -> two_rods.Hidden:
    """Dry friction of the elbow that rises and falls with its angle, by `size` N·m."""
    return lambda t, q, qd, qdd: on_elbow(
        size * np.sin(q[:, 1]) * np.tanh(qd[:, 1] / two_rods.WIDTH)
    )


@pytest.mark.parametrize("stiffness", [3.0, -3.0])
def test_a_spring_pulls_and_does_not_push(stiffness: float) -> None:
    done = found(lambda t, q, qd, qdd: on_elbow(stiffness * q[:, 1]), "spring")
    assert bool(done.findings) == (stiffness > 0.0)
    for one in done.findings:
        assert one.confirmed
        assert one.parameters["k"].low < 3.0 < one.parameters["k"].high


def test_friction_may_swing_as_long_as_it_brakes() -> None:
    done = found(swinging(0.6 * OWN), "position_friction")
    (finding,) = done.confirmed
    assert finding.parameters["b"].value == pytest.approx(0.6 * OWN, rel=0.2)


def test_friction_that_drives_in_a_part_of_the_range_is_doubted() -> None:
    (finding,) = found(swinging(4.0 * OWN), "position_friction").findings
    assert finding.doubt is not None
    assert finding.doubt.reason is Reason.IMPOSSIBLE
    assert "friction would drive the joint" in finding.doubt.words


@pytest.mark.parametrize(("sign", "confirmed"), [(1.0, True), (-1.0, False)])
def test_drag_brakes(sign: float, confirmed: bool) -> None:
    """Although all friction together still takes energy out."""
    done = found(
        lambda t, q, qd, qdd: on_elbow(sign * 0.05 * qd[:, 1] * np.abs(qd[:, 1])), "quadratic_drag"
    )
    assert bool(done.confirmed) is confirmed
    assert bool(done.findings) is confirmed


def test_an_effect_of_ones_own_says_what_is_positive() -> None:
    class Rail(Effect):
        name = "rail"
        formula = "k tanh(10 q)"
        parameters = (Parameter("k", "N·m", "torque of a magnet", positive=True),)
        part = "gravity"

        def columns(self, x, joint, shape):  # type: ignore[no-untyped-def]
            return np.tanh(10.0 * x.q[:, [joint]])

    model = identify(two_rods.motion(1), FEW).model
    for sign in (1.0, -1.0):

        def rail(
            t: two_rods.Floats,
            q: two_rods.Floats,
            qd: two_rods.Floats,
            qdd: two_rods.Floats,
            sign: float = sign,
        ) -> two_rods.Floats:
            return on_elbow(sign * np.tanh(10.0 * q[:, 1]))

        first, second = (two_rods.motion(seed, hidden=rail) for seed in (1, 2))
        done = diagnose(model, first, second, {"rail": Rail()}, steps=1)
        assert bool(done.confirmed) == (sign > 0.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_shape_that_hardly_shows_leaves_the_sign_sure(sign: float) -> None:
    """In a small range a sine is a line: many amplitudes explain it, but none below zero."""

    class Magnet(Effect):
        name = "magnet"
        formula = "k sin(q/w)"
        parameters = (Parameter("k", "N·m", "torque of a magnet", positive=True),)
        shapes = (Shape("w", "rad", "width of its pole", low=3.0, high=12.0, start=6.0),)
        part = "gravity"

        def columns(self, x, joint, shape):  # type: ignore[no-untyped-def]
            return np.sin(x.q[:, [joint]] / shape["w"])

    def magnet(
        t: two_rods.Floats, q: two_rods.Floats, qd: two_rods.Floats, qdd: two_rods.Floats
    ) -> two_rods.Floats:
        return on_elbow(sign * 20.0 * np.sin(q[:, 1] / 6.0))

    model = identify(two_rods.motion(1), FEW).model
    first, second = (two_rods.motion(seed, hidden=magnet) for seed in (1, 2))
    done = diagnose(model, first, second, {"magnet": Magnet()}, steps=1)
    assert [one.confirmed for one in done.findings] == ([True] if sign > 0.0 else [])


def test_two_of_one_shaft_are_judged_by_their_power() -> None:
    """A viscous part too small to measure does not speak against a shared shaft."""

    def shaft(
        t: two_rods.Floats, q: two_rods.Floats, qd: two_rods.Floats, qdd: two_rods.Floats
    ) -> two_rods.Floats:
        torque = 0.8 * np.tanh((qd[:, 0] + qd[:, 1]) / two_rods.WIDTH)
        return np.stack([torque, torque], axis=1)

    (finding,) = found(shaft, "coupled").confirmed
    assert finding.parameters["F"].low > 0.0
    assert finding.parameters["B"].low < 0.1
    reverse = found(lambda *x: -shaft(*x), "coupled")
    assert not reverse.confirmed


def test_friction_that_a_curve_has_taken_over_counts_with_the_rest() -> None:
    """Beside a curve over speed, viscous and Coulomb friction alone have no known power."""
    stuck = Candidate(EFFECTS["stribeck"], 1, {"v_s": 0.15})
    whitened = whitened_of(two_rods.motion(1, 30.0, hidden=two_rods.stick))
    (score,) = bayes_factors(whitened, [stuck])
    v = whitened.x.qd[:, 1]
    basis = Basis((*whitened.basis.terms, stuck.term()))
    curve = np.stack([v + 1e-4 * v**3, np.tanh(v / two_rods.WIDTH), v * np.abs(v)], axis=1)
    both = whitened.explaining(basis, (Nuisance(1, curve),))
    place = [term.effect.name for term in basis.terms].index("viscous", 1)
    assert np.sqrt(both.system.covariance[place, place]) > 1.0
    assert unnatural(both, score) == ""
