"""Shapes that were chosen while an effect was missing are chosen again with it."""

from dataclasses import replace

import numpy as np
import pendulum
import pendulum_models
import pytest

from lagrangian_ff.effects import EFFECTS, Inputs
from lagrangian_ff.identification import Model, extend
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.choosing.shapes import best_shape, fall, refit_shapes
from lagrangian_ff.identification.solving.posterior import Posterior, exact
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.recording.motion import Motion

BUMP, V_S = 0.5, 0.25  # N·m, rad/s
STEEP = 0.006  # rad/s, what makes up for a bump best


def sticking() -> Motion:
    """Return the pendulum with more friction of its elbow at creeping speed."""
    motion = pendulum.motion(30.0, noise=0.005)
    v = motion.qd[:, 1]
    tau = motion.tau.copy()
    tau[:, 1] += BUMP * np.tanh(v / pendulum.WIDTH) * np.exp(-((v / V_S) ** 2))
    return replace(motion, tau=tau)


@pytest.fixture(scope="module")
def model() -> Model:
    """Return a model whose Coulomb friction of the elbow is too steep, as without the bump."""
    model = pendulum_models.fitted("chain+fri", sticking()).model
    basis = with_steps(model.basis, STEEP, (1,))
    return replace(model, prior=replace(model.prior, basis=basis))


def with_steps(basis: Basis, v0: float, joints: tuple[int, ...]) -> Basis:
    """Return the basis with the Coulomb step of some joints as wide as v0."""
    return Basis(
        tuple(
            replace(term, shape={"v0": v0})
            if term.effect.name == "coulomb" and term.joint in joints
            else term
            for term in basis.terms
        )
    )


def fitted_on_subset(model: Model) -> tuple[Posterior[System], Basis, Inputs]:
    """Return a fit to 200 of a model's samples, its basis, and those samples."""
    few = Blueprint.of(model).subset(model.inputs_of(model.data), 200)
    return exact(few), few.basis, few.samples.x


def shapes(basis: Basis) -> dict[tuple[str, int], dict[str, float]]:
    return {(t.effect.name, t.joint): dict(t.shape) for t in basis.terms if t.shape}


def test_of_a_shape_that_is_known_in_part_the_rest_is_searched(model: Model) -> None:
    fitted, _, x = fitted_on_subset(model)
    x = replace(x, load=0.3 * x.qdd)  # all inertia, of which any part may be the rotor's
    samples = replace(fitted.problem.samples, x=x)
    fitted = replace(fitted, problem=fitted.problem.of(samples))
    ripple, mesh = EFFECTS["ripple"], EFFECTS["gear_mesh"]
    assert best_shape(fitted, ripple, 1, {"order": 7.0}) == {"order": 7.0}
    found = best_shape(fitted, mesh, 1, {"order": 7.0})
    tried = [shape for shape in mesh.candidates(x, 1) if shape["order"] == 7.0]
    assert len(tried) > 1
    falls = [fall(fitted, Term(mesh, 1, shape))[0] for shape in tried]
    assert found == tried[int(np.argmax(falls))]


def test_the_steepness_and_the_bump_are_found_together(model: Model) -> None:
    before = shapes(model.basis)
    found = extend(model, EFFECTS["stribeck"], "elbow")
    after = shapes(found.model.basis)
    assert after["coulomb", 1]["v0"] == pytest.approx(pendulum.WIDTH, rel=0.3)
    assert after["stribeck", 1]["v_s"] == pytest.approx(V_S, rel=0.2)
    assert after["coulomb", 0] == before["coulomb", 0]
    effects = found.record["effects"]
    assert isinstance(effects, list)
    (bump,) = (one for one in effects if one["effect"] == "stribeck")
    assert bump["parameters"]["F_s"]["value"] == pytest.approx(BUMP, rel=0.2)


def test_a_shape_that_is_given_is_kept(model: Model) -> None:
    found = extend(model, EFFECTS["stribeck"], "elbow", {"v_s": 0.2})
    after = shapes(found.model.basis)
    assert after["stribeck", 1] == {"v_s": 0.2}
    assert after["coulomb", 1]["v0"] > 2.0 * STEEP


def test_nothing_is_tuned_where_nothing_has_a_shape(model: Model) -> None:
    """Tuning twice changes nothing either: the first result was the best."""
    fitted, basis, _ = fitted_on_subset(model)
    plain = Basis(tuple(Term(EFFECTS[n], 1) for n in ("viscous", "offset")))
    assert refit_shapes(fitted, plain, 1) is plain
    once = refit_shapes(fitted, basis, 1)
    twice = refit_shapes(fitted, once, 1)
    v0 = [shapes(found)["coulomb", 1]["v0"] for found in (once, twice)]
    assert v0[1] == pytest.approx(v0[0], rel=0.03)


@pytest.mark.parametrize("start", [0.3, 0.6])
def test_a_shape_at_or_beyond_the_end_of_its_range_comes_back_into_it(start: float) -> None:
    """Models of other versions have such shapes."""
    smooth = pendulum_models.fitted("chain+fri", pendulum.motion(30.0, noise=0.005)).model
    fitted, basis, _ = fitted_on_subset(smooth)
    found = shapes(refit_shapes(fitted, with_steps(basis, start, (0, 1)), 1))
    assert found["coulomb", 1]["v0"] == pytest.approx(pendulum.WIDTH, rel=0.3)
    assert found["coulomb", 0] == {"v0": start}
