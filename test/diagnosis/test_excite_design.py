"""Designed motions: they keep every limit, gain more than templates, and what they promise."""

from dataclasses import replace

import numpy as np
import pytest
import two_rods
from design_examples import (
    QUESTIONS,
    SECONDS,
    SIZE,
    STUCK,
    TINY,
    assumed,
    designed,
    keeper,
    rods,
    swing,
    usual,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from whitened_examples import SHORT, few_torques

from lagrangian_ff.diagnosis.excite import (
    Between,
    Design,
    Effort,
    Everything,
    Expected,
    For,
    Limits,
    Parameters,
    Question,
    Reference,
    Suspect,
    design,
    excite,
    limits_of,
    outcomes,
    seen_pose,
)
from lagrangian_ff.diagnosis.excite.climbing import Way
from lagrangian_ff.diagnosis.excite.design import joints_of
from lagrangian_ff.diagnosis.excite.keeping import jerk_of
from lagrangian_ff.diagnosis.excite.objective import Objective, nats_of
from lagrangian_ff.diagnosis.excite.outcome import design_record
from lagrangian_ff.diagnosis.excite.questions import cases_of
from lagrangian_ff.diagnosis.excite.splines import AT_REST, Splines
from lagrangian_ff.diagnosis.search.bayes_factor import bayes_factors
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.whitening import fit
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.effects.formula import Range, formula_effect
from lagrangian_ff.errors import ModelError
from lagrangian_ff.progress import silent
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]


_small = few_torques(1000, SHORT)


# The limits.


@settings(max_examples=15)
@given(st.integers(0, 1000), st.floats(0.3, 3.0), st.floats(0.05, 1.0))
def test_every_limit_is_kept(seed: int, pace: float, share: float) -> None:
    """By slowing down, whatever the control points; else there is no motion."""
    known = limits_of(rods())
    assert known.jerk_max is not None
    limits = replace(known, qd_max=pace * known.qd_max, jerk_max=share * known.jerk_max)
    splines = Splines(6.0, 35)
    control = np.tile(seen_pose(rods(), None, limits), (35, 1))
    inner = slice(AT_REST, 35 - AT_REST)
    draw = np.random.default_rng(seed)
    control[inner] += 0.3 * draw.uniform(-1.0, 1.0, control[inner].shape) * limits.width
    control = np.clip(control, limits.q_low, limits.q_high)
    kept = keeper(limits).kept(splines, control)
    if kept is None:
        return
    made, slack = kept.reference(control), 1.0 + 1e-6
    assert np.all((made.q >= limits.q_low - 1e-9) & (made.q <= limits.q_high + 1e-9))
    assert np.all(np.abs(made.qd) <= slack * limits.qd_max)
    assert np.all(np.abs(made.qdd) <= slack * limits.qdd_max)
    assert np.all(np.abs(jerk_of(made)) <= slack * share * known.jerk_max)
    torque = rods().predict(made.q, made.qd, made.qdd, time=made.time)
    assert np.all(np.abs(torque) <= slack * keeper(limits).tau_max)


def assert_sound(found: Design, limits: Limits) -> None:
    """Within limits, and from rest to rest at one pose."""
    made = found.reference
    assert set(found.used) == {"position", "speed", "acceleration", "jerk", "torque"}
    assert all(np.all(share <= 1.0 + 1e-6) for share in found.used.values())
    assert np.all((made.q >= limits.q_low - 1e-9) & (made.q <= limits.q_high + 1e-9))
    for end in (0, -1):
        np.testing.assert_allclose(made.q[end], made.q[0], atol=1e-9)
        np.testing.assert_allclose(made.qd[end], 0.0, atol=1e-9)
        np.testing.assert_allclose(made.qdd[end], 0.0, atol=1e-9)


def test_a_design_is_sound_and_lasts_as_asked() -> None:
    assert_sound(designed(), limits_of(rods()))
    assert designed().finished
    assert not designed().beyond
    assert designed().reference.time[-1] == pytest.approx(SECONDS, rel=0.15)


def test_narrow_limits_are_kept() -> None:
    limits = limits_of(rods())
    assert limits.tau_max is not None
    narrow = replace(limits, qd_max=0.5 * limits.qd_max, tau_max=0.9 * limits.tau_max)
    found = design(
        rods(), For(STUCK), narrow, seconds=SECONDS, assumed=assumed(), effort=TINY, seed=2
    )
    assert_sound(found, narrow)
    assert np.all(np.abs(found.reference.qd) <= narrow.qd_max * (1.0 + 1e-6))


def test_what_is_in_the_way_is_not_touched() -> None:
    start = seen_pose(rods(), "elbow", limits_of(rods()))
    wall = float(start[1] + 0.15)

    def clear(path: Floats) -> str:
        return "the elbow and a wall" if path[:, 1].max() > wall else ""

    found = design(rods(), For(STUCK), seconds=SECONDS, clear=clear, assumed=assumed(), effort=TINY)
    assert found.reference.q[:, 1].max() <= wall + 1e-3
    assert np.ptp(found.reference.q[:, 1]) > 0.02
    with pytest.raises(ModelError, match="begin where the elbow and a wall touch"):
        design(
            rods(), For(STUCK), start=start + np.array([0.0, 0.3]), seconds=SECONDS, clear=clear,
            assumed=assumed(), effort=TINY,
        )  # fmt: skip


# The gain.


def test_a_design_beats_its_template() -> None:
    groups = cases_of(For(STUCK), assumed(), SIZE)
    template_nats = nats_of(assumed(), groups, usual(), SIZE)
    longer = designed().reference.time[-1] / usual().time[-1]
    assert designed().nats > 2.0 * longer * template_nats


def test_what_was_expected_comes_out() -> None:
    """The rods do the motion with an elbow that sticks, and the search sees as much as promised."""
    made = designed().reference
    true = Candidate(EFFECTS["stribeck"], 1, {"v_s": 0.15})
    size = 0.2 * SIZE  # a larger one is no longer taken for noise
    force = float(assumed().coefficients(true, size)[0])
    tau = two_rods.rods(made.q, made.qd, made.qdd)
    tau += np.array([2.0, 0.4]) * made.qd + np.array([3.0, 0.8]) * np.tanh(made.qd / two_rods.WIDTH)
    tau += force / 0.6 * two_rods.stick(made.time, made.q, made.qd, made.qdd)
    tau += two_rods.NOISE * np.random.default_rng(5).normal(size=tau.shape)
    segment = np.zeros(len(tau), dtype=np.int64)
    recorded = Motion(two_rods.JOINTS, *made, tau, segment)
    whitened = fit(recorded, rods().inputs_of(recorded), rods().basis)
    (score,) = bayes_factors(whitened, [true])
    promised = next(one for one in assumed().gains(made, size, [true]) if one.effect == "stribeck")
    assert promised.nats > 20.0
    assert score.log_bf == pytest.approx(promised.nats, rel=0.5)
    assert score.size == pytest.approx(promised.torque, rel=0.4)


def test_every_effect_has_its_prediction() -> None:
    found = {(one.effect, one.joint) for one in designed().expected}
    for joint in two_rods.JOINTS:
        assert {("stribeck", joint), ("ripple", joint), ("delay", joint)} <= found
        assert ("coulomb", joint) not in found
    assert all(one.nats >= 0.0 and one.size == SIZE for one in designed().expected)


def test_a_larger_effect_gains_more() -> None:
    true = [Candidate(EFFECTS["stribeck"], 1, {"v_s": 0.15})]
    small, large = (assumed().gains(swing(), size, true)[0] for size in (0.05, 0.1))
    assert large.torque == pytest.approx(2.0 * small.torque)
    assert large.signal == pytest.approx(4.0 * small.signal)
    assert small.nats < large.nats < 4.0 * small.nats
    assert small.of_torque(large.torque) == pytest.approx(large.nats)


@pytest.mark.parametrize("question", [*QUESTIONS[1:], Everything(), Parameters()])
def test_every_question_has_its_motion(question: Question) -> None:
    found = design(rods(), question, seconds=SECONDS, assumed=assumed(), effort=TINY)
    assert_sound(found, limits_of(rods()))
    assert found.nats > 0.0
    assert found.question == question
    assert set(joints_of(question, rods())) <= set(found.joints)


def test_two_formulas_that_no_catalogue_holds_have_their_motion() -> None:
    forms = ("A*sign(qd)*exp(-((q-c)/w)^2)", "A*sign(qd)*abs(load)*exp(-((q-c)/w)^2)")
    ends: dict[str, Range] = {"c": (-1.0, 1.0, 5, "even"), "w": (0.1, 1.0, 5)}
    suspects = (
        Suspect(name, "elbow", {"c": 0.1, "w": 0.3}, formula_effect(name, form, ends))
        for name, form in zip(("tight", "loaded"), forms, strict=True)
    )
    question = Between(*suspects)
    found = design(rods(), question, seconds=SECONDS, assumed=assumed(), effort=TINY)
    assert_sound(found, limits_of(rods()))
    assert found.nats > 0.0


def test_a_motion_for_the_parameters_tells_more_of_them_than_exciting() -> None:
    """Of the five base parameters of two rods, in less time."""
    limits = limits_of(rods())
    start = seen_pose(rods(), None, limits)
    template = excite("exciting", rods().joints, limits, start=start, duration=SECONDS)
    found = design(
        rods(), Parameters(), start=start, seconds=SECONDS, assumed=assumed(), effort=TINY
    )
    assert found.reference.time[-1] < 1.1 * template.time[-1]
    assert log_det(found.reference) > log_det(template)


def log_det(made: Reference) -> float:
    """Return the log determinant of the information about the base parameters of two rods."""
    (a, b), (v, w), (f, g) = (one.T for one in made[1:])
    c, s, none = np.cos(b), np.sin(b), np.zeros(len(a))
    weight = 9.81 * np.cos(a + b)
    shoulder = [
        f,
        f + g,
        none,
        0.5 * (2.0 * c * f + c * g - s * (2.0 * v * w + w**2)) + weight,
        9.81 * np.cos(a),
    ]
    elbow = [none, f + g, g, 0.5 * (c * f + s * v**2) + weight, none]
    noise = two_rods.NOISE[:, None]
    both = np.hstack([np.array(shoulder) / noise[0], np.array(elbow) / noise[1]])
    return float(np.linalg.slogdet(both @ both.T)[1])


def test_the_joint_in_question_is_also_moved_alone() -> None:
    """From the templates that hold the other, which stays where it is."""
    limits = limits_of(rods())
    pose = seen_pose(rods(), "elbow", limits)
    splines = Splines(SECONDS, 45)
    index = np.arange(0, len(splines.time), 8)
    objective = Objective(assumed(), cases_of(For(STUCK), assumed(), SIZE), splines, SIZE, index)
    both = Way(objective, keeper(), pose, replace(TINY, first=6, starts=2), (0, 1))
    found = both.starts(["elbow"], 0, silent)
    assert both.alone([0, 1], found) is None
    made = both.alone([1], found)
    assert made is not None
    way, starts = made
    assert 0 < len(starts) < len(found)
    *_, best = way.uphill(starts, 0)
    assert best.value > starts[0].value
    kept = way.kept(best)
    assert kept is not None
    assert not np.ptp(kept[1][:, 0])
    assert np.ptp(kept[1][:, 1]) > 0.1
    little = replace(best, control=pose + 0.01 * (best.control - pose))
    small = way.kept(little)
    assert small is not None
    assert np.ptp(small[1][:, 1]) > 0
    assert both.kept(little) is None  # joints that hardly move are held, and none is left


def test_the_seed_decides() -> None:
    least = Effort(rows=120, starts=1, first=1, rounds=((1, 30.0),))

    def one(seed: int) -> Floats:
        return design(
            rods(), For(STUCK), seconds=SECONDS, assumed=assumed(), effort=least, seed=seed
        ).reference.q

    first = one(3)
    np.testing.assert_array_equal(first, one(3))
    other = one(4)
    assert first.shape != other.shape or not np.allclose(first, other)


def test_an_interrupted_search_gives_the_best_so_far() -> None:
    def stop(share: float, label: str) -> None:
        if label.startswith("climbing") and share > 0.4:
            raise KeyboardInterrupt

    found = design(
        rods(), For(STUCK), seconds=SECONDS, assumed=assumed(), effort=TINY, progress=stop
    )
    assert not found.finished
    assert_sound(found, limits_of(rods()))


@pytest.mark.parametrize(
    ("question", "words"),
    [
        (For(Suspect("stribek", "elbow")), "no effect 'stribek'"),
        (For(Suspect("stribeck", "wrist")), "no joint wrist"),
        (For(Suspect("coulomb", "elbow")), "has coulomb@elbow already"),
        (For(Suspect("rotor_inertia", "elbow")), "no motion shows rotor_inertia@elbow"),
        (For(Suspect("stribeck", "elbow", {"vs": 1.0})), "no shape vs; it has v_s"),
        (Between(STUCK, Suspect("contact", "elbow")), "it is an event"),
    ],
)
def test_questions_that_no_motion_answers(question: Question, words: str) -> None:
    with pytest.raises(ModelError, match=words):
        design(rods(), question, assumed=assumed(), effort=TINY)


@pytest.mark.parametrize(
    ("seconds", "size", "words"),
    [(1.0, 0.05, "1 s: expected 8 to 60"), (20.0, 0.0, "size of 0"), (20.0, 2.0, "size of 2")],
)
def test_values_that_cannot_be(seconds: float, size: float, words: str) -> None:
    with pytest.raises(ModelError, match=words):
        design(rods(), For(STUCK), seconds=seconds, size=size, assumed=assumed())


# What came of it.


def test_what_came_of_a_design_is_said_beside_the_promise() -> None:
    record = design_record(
        replace(designed(), expected=(Expected("stribeck", "elbow", SIZE, 0.2, 100.0, 1e6, 100.0),))
    )
    finding = {"effect": "stribeck", "joints": ["elbow"], "size": 0.1, "evidence_gain": 30.0}
    other = {**finding, "effect": "ripple"}
    (found,) = outcomes(record, {"findings": [finding, other]})
    assert (found.effect, found.joint, found.gained) == ("stribeck", "elbow", 30.0)
    assert found.ratio == pytest.approx(0.5)
    assert found.promised == pytest.approx(25.0, rel=0.01)
    with pytest.raises(ValueError, match="not the JSON of a design"):
        outcomes({}, {"findings": []})
