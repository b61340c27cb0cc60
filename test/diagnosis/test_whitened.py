"""The whitened residual is white, of the size of the noise, and free of what is known."""

from dataclasses import replace

import numpy as np
import pytest
import two_rods
from numpy.typing import NDArray
from sines import sines
from whitened_examples import few_torques, friction, inputs, quickly, whitened_of

from lagrangian_ff.diagnosis.whitening import Changing, Whitened, fit, whiten
from lagrangian_ff.diagnosis.whitening.hyperparameters import used, with_sign_speeds
from lagrangian_ff.diagnosis.whitening.whitened import AVERAGED, LOAD_SECONDS
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.solving.posterior import exact
from lagrangian_ff.recording.motion import Motion, concatenate

_small = few_torques(1600)


WIDE = friction(0.05)
"""Its Coulomb step is too wide."""
HYSTERESIS = Term(EFFECTS["hysteresis"], 1, {"w": two_rods.BENDS / 9.0})


@pytest.fixture(scope="module")
def whitened() -> Whitened:
    """Return the whitened of a motion in which nothing is hidden."""
    return whitened_of(two_rods.motion(1), WIDE)


def test_what_is_left_is_white_and_of_the_size_of_the_noise(whitened: Whitened) -> None:
    left = whitened.residual.reshape(-1, 2)
    np.testing.assert_allclose(np.mean(left**2, axis=0), 1.0, atol=0.15)
    following = np.mean(left[1:] * left[:-1], axis=0) / np.mean(left**2, axis=0)
    assert np.abs(following).max() < 0.15
    assert whitened.x.window > 1
    averaged = two_rods.NOISE / np.sqrt(whitened.x.window)
    np.testing.assert_allclose(whitened.noise, averaged, rtol=0.25)


def test_what_is_to_be_looked_at_closely_is_looked_at_whole() -> None:
    one = two_rods.motion(1)
    part = one.take(one.elapsed < 15.0)
    before, close = concatenate([part] * 5), replace(part, closely=np.ones(len(part), dtype=bool))
    with quickly(1000):
        index = used(concatenate([before, close]))
        evenly = used(concatenate([before, part]))
        np.testing.assert_array_equal(used(close), used(part))
    assert len(index) == len(evenly) == 500
    near = index[index >= len(before)]
    step = float(np.median(np.diff(part.time)))
    assert np.diff(near).max() * step < 1.5 * AVERAGED
    assert len(near) > 2 * np.sum(evenly >= len(before))
    assert np.all(np.diff(index) > 0)


def test_the_width_of_the_coulomb_step_is_found(whitened: Whitened) -> None:
    np.testing.assert_allclose(whitened.basis.sign_speed(2), two_rods.WIDTH, rtol=0.15)


def test_the_width_of_the_coulomb_step_is_found_beside_hysteresis() -> None:
    """Whose sign has the same width."""
    wide = friction(0.1).terms
    basis = Basis((*wide, HYSTERESIS))
    motion = two_rods.motion(1, hidden=two_rods.presliding)
    found = fit(motion, replace(inputs(motion), sign_speed=basis.sign_speed(2)), basis)
    np.testing.assert_allclose(found.basis.sign_speed(2), two_rods.WIDTH, rtol=0.25)


def test_a_width_that_was_fitted_without_hysteresis_is_fitted_again() -> None:
    without = whitened_of(two_rods.motion(1, hidden=two_rods.presliding), WIDE)
    assert without.basis.sign_speed(2)[1] > 1.5 * two_rods.WIDTH
    beside = without.explaining(Basis((*without.basis.terms, HYSTERESIS)), ())
    found = with_sign_speeds(beside, {1}).basis.sign_speed(2)
    assert found[1] == pytest.approx(two_rods.WIDTH, rel=0.25)
    assert found[0] == without.basis.sign_speed(2)[0]


def test_a_width_that_was_fitted_without_stribeck_friction_leaves_no_trace() -> None:
    """From that width or from the one found, the same is the likeliest."""
    without = whitened_of(two_rods.motion(1, hidden=two_rods.stick))
    assert without.basis.sign_speed(2)[1] < two_rods.WIDTH / 1.5
    stribeck = Term(EFFECTS["stribeck"], 1, {"v_s": 0.15})
    beside = without.explaining(Basis((*without.basis.terms, stribeck)), ())
    found = with_sign_speeds(beside, {1})
    again = with_sign_speeds(found, {1})
    assert found.basis.sign_speed(2)[1] == pytest.approx(two_rods.WIDTH, rel=0.05)
    assert again.basis.sign_speed(2)[1] == pytest.approx(found.basis.sign_speed(2)[1], rel=2e-3)


def test_what_the_model_has_leaves_nothing(whitened: Whitened) -> None:
    for term in whitened.basis.terms:
        white = whitened.whitened(term.columns(whitened.x), term.joint)
        left = whitened.project(white)
        assert np.linalg.norm(left) < 1e-6 * np.linalg.norm(white)


@pytest.fixture
def many(whitened: Whitened) -> NDArray[np.float64]:
    """Return columns, enough of them to be whitened together."""
    return np.sin(np.linspace(0.1, 9.0, 100) * whitened.x.q[:, :1])


@pytest.mark.parametrize("joint", [0, 1])
def test_many_columns_are_whitened_as_each_alone(
    whitened: Whitened, many: NDArray[np.float64], joint: int
) -> None:
    together = whitened.whitened(many, joint)
    whitened.forget()
    alone = np.hstack([whitened.whitened(many[:, [n]], joint) for n in range(many.shape[1])])
    np.testing.assert_allclose(together, alone, atol=1e-9 * np.abs(alone).max())


def test_single_precision_is_exact_enough_to_choose_by(
    whitened: Whitened, many: NDArray[np.float64]
) -> None:
    exact = whitened.whitened(many, 0)
    coarse = whitened.whitened(many, 0, coarse=True)
    assert coarse.dtype == np.float32
    np.testing.assert_allclose(coarse, exact, atol=1e-3 * np.abs(exact).max())


def test_the_same_factor_serves_another_basis(whitened: Whitened) -> None:
    basis = Basis(whitened.basis.terms[:-1])
    again = whitened.explaining(basis, ())
    parts = whitened.motion, whitened.index, whitened.seconds, whitened.inputs
    fresh = whiten(*parts, whitened.problem.having(basis=basis), whitened.x)
    np.testing.assert_allclose(again.residual, fresh.residual, atol=1e-9)
    assert again.system.log_evidence == pytest.approx(fresh.system.log_evidence)


def test_the_load_is_predicted_without_its_own_block(whitened: Whitened) -> None:
    """Spoiling the torque of one block does not change the load seen there."""
    spoilt = whitened.motion.tau.copy()
    block = whitened.motion.blocks(LOAD_SECONDS)[whitened.index]
    rows = whitened.index[block == 5]
    spoilt[rows] += 50.0
    motion = replace(whitened.motion, tau=spoilt)
    other, same = (
        whiten(of, whitened.index, whitened.seconds, whitened.inputs, whitened.problem)
        for of in (motion, whitened.motion)
    )
    inside = block == 5
    scale = np.abs(whitened.motion.tau).max()
    total, before = (one.inputs_left_out().torque[inside] for one in (other, same))
    np.testing.assert_allclose(total, before, atol=1e-6 * scale)


def test_the_load_is_that_of_the_rods(whitened: Whitened) -> None:
    motion = two_rods.motion(2)
    load = whitened.inputs_of(motion).load
    rotors = motion.qdd * np.array([0.3, 0.05])
    true = two_rods.rods(motion.q, motion.qd, motion.qdd) - rotors
    error = load - true
    # Motion hardly separates the rotors' inertia from the load's; gravity is most of the load.
    assert (error.std(axis=0) / true.std(axis=0)).max() < 0.25


def test_a_wrong_unit_of_effort_on_one_joint_is_found() -> None:
    motion = two_rods.motion(3)
    scaled = replace(motion, tau=motion.tau * np.array([1.0, 2.0]))
    unit = whitened_of(scaled, WIDE).problem.unit
    assert unit[1] / unit[0] == pytest.approx(2.0, rel=0.15)


def test_the_units_of_the_model_need_less_evidence_than_others() -> None:
    """Six seconds are too few to find units, but enough to tell right ones from wrong ones."""
    motion = two_rods.motion(3, 6.0)
    scaled = replace(motion, tau=motion.tau * np.array([1.0, 1.3]))

    def ratio(unit: list[float] | None) -> float:
        known = None if unit is None else np.array(unit)
        found = fit(scaled, inputs(scaled), WIDE, unit=known).problem.unit
        return float(found[1] / found[0])

    assert ratio(None) == 1.0
    assert ratio([10.0, 13.0]) == pytest.approx(1.3)
    assert ratio([10.0, 6.0]) == 1.0


def test_noise_is_not_taken_for_dynamics_where_one_joint_hides_an_effect() -> None:
    """Few torques of six joints are fitted without any noise, and all is blamed on that joint."""
    rng = np.random.default_rng(1)
    t = np.arange(0.0, 60.0, 0.01)
    q, qd, qdd = sines(rng, t, 6, (0.4, 4.0))
    weight = 3.0 * np.cos(np.cumsum(q, axis=1))
    tau = 2.0 * qdd + np.cumsum(weight[:, ::-1], axis=1)[:, ::-1]
    tau[:, 1] += 1.2 * np.cos(7.0 * q[:, 1])
    tau += 0.2 * rng.normal(size=tau.shape)
    names = tuple(f"joint_{n + 1}" for n in range(6))
    motion = Motion(names, t, q, qd, qdd, tau, np.zeros(len(t), dtype=np.int64), "six joints")
    found = whitened_of(motion, Basis(()))
    noise = 0.2 / np.sqrt(found.x.window)
    others = np.delete(found.noise, 1)
    assert np.all((others > noise / 3.0) & (others < 3.0 * noise))
    # The hidden effect counts as noise of that joint only.
    assert noise < found.noise[1] < 1.2


def test_a_problem_that_knows_of_a_sliding_joint_is_the_likelier_one() -> None:
    """A mass that slides on a beam in the vertical plane, 1 to 5 m from its axis."""
    rng = np.random.default_rng(2)
    t = np.arange(0.0, 40.0, 0.01)
    q, qd, qdd = (part * np.array([1.0, 2.0]) for part in sines(rng, t, 2, (0.4, 4.0)))
    q = q + np.array([0.3, 3.0])
    reach, weight = q[:, 1], 9.81 * 2.0
    first = (1.0 + 2.0 * reach**2) * qdd[:, 0] + 4.0 * reach * qd[:, 1] * qd[:, 0]
    second = 2.0 * qdd[:, 1] - 2.0 * reach * qd[:, 0] ** 2
    tau = np.stack(
        [first + weight * reach * np.cos(q[:, 0]), second + weight * np.sin(q[:, 0])], axis=1
    )
    tau += 0.3 * rng.normal(size=tau.shape)
    segment = np.zeros(len(t), dtype=np.int64)
    motion = Motion(("turn", "reach"), t, q, qd, qdd, tau, segment, "telescope")
    known, unknown = (
        fit(motion, inputs(motion), Basis(()), sliding=sliding).system.log_evidence
        for sliding in (np.array([0.0, 1.0]), None)
    )
    assert known > unknown + 100.0


@pytest.mark.parametrize("since", [0.0, 0.3, 0.7])
@pytest.mark.parametrize("until", [0.9, np.inf])
def test_a_change_has_the_evidence_of_the_whole_matrix(
    whitened: Whitened, since: float, until: float
) -> None:
    time = whitened.x.time
    length = float(np.ptp(time))
    change = (float(time[0]) + since * length, float(time[0]) + until * length, 0.2)
    plain, changed = (
        exact(replace(whitened.problem, change=one)).log_evidence for one in (None, change)
    )
    log_bf = Changing.of(whitened, len(whitened.index)).log_bayes_factor(change)
    assert log_bf == pytest.approx(changed - plain, rel=1e-6, abs=1e-6)


def test_a_change_after_the_end_changes_nothing(whitened: Whitened) -> None:
    end = float(whitened.x.time[-1])
    assert Changing.of(whitened, 100).log_bayes_factor((end + 1.0, np.inf, 0.2)) == 0.0
