"""Designed motions: their information is the search's own, they keep every limit, and they gain."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import two_rods
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from whitened_examples import SHORT, quickly

from lagrangian_ff.diagnosis.excite import (
    Assumed,
    Between,
    Design,
    Effort,
    Everything,
    Expected,
    For,
    Limits,
    Question,
    Reference,
    Suspect,
    design,
    excite,
    limits_of,
    outcomes,
    seen_pose,
)
from lagrangian_ff.diagnosis.excite.design import joints_of
from lagrangian_ff.diagnosis.excite.keeping import Keeper, jerk_of
from lagrangian_ff.diagnosis.excite.objective import Objective, judge, nats_of
from lagrangian_ff.diagnosis.excite.outcome import design_record
from lagrangian_ff.diagnosis.excite.questions import Case, cases_of
from lagrangian_ff.diagnosis.excite.splines import AT_REST, Splines
from lagrangian_ff.diagnosis.excite.starts import template
from lagrangian_ff.diagnosis.search.bayes_factor import bayes_factors, expected
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.diagnosis.whitening import fit
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.identification.problem import Nuisance
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

SECONDS, SIZE = 8.0, 0.05
STUCK = Suspect("stribeck", "elbow", {"v_s": 0.15})
TINY = Effort(rows=160, starts=1, first=4, rounds=((4, 30.0), (4, 1e3)))


@pytest.fixture(autouse=True, scope="module")
def _small() -> Iterator[None]:
    with quickly(1000, SHORT):
        yield


@cache
def rods() -> Model:
    """Return a model of the two rods, with plain friction."""
    few = Settings(train=1.0, samples=100, evaluations=12)
    return identify(two_rods.motion(1, 30.0), few).model


@cache
def assumed() -> Assumed:
    """Return what the search assumes of them."""
    return Assumed.of(rods())


@cache
def designed() -> Design:
    """Return the motion that shows whether the elbow sticks."""
    small = Effort(rows=300, starts=1, first=10, rounds=((15, 30.0), (10, 1e3), (5, 1e4)))
    return design(rods(), For(STUCK), seconds=SECONDS, assumed=assumed(), effort=small)


@cache
def usual() -> Reference:
    """Return the template for the same, over about as soon."""
    limits = limits_of(rods())
    start = seen_pose(rods(), "elbow", limits)
    return template("slow sweep", rods().joints, limits, "elbow", start, SECONDS)


def swing() -> Reference:
    """Return a motion of both joints."""
    return excite("exciting", rods().joints, limits_of(rods()), duration=SECONDS)


def keeper(limits: Limits | None = None) -> Keeper:
    return Keeper(rods(), limits or limits_of(rods()), np.zeros(2))


# The information.


@pytest.mark.parametrize("name", ["stribeck", "quadratic_drag", "ripple", "hysteresis", "coupled"])
def test_a_signal_is_the_searchs_own_information(name: str) -> None:
    """Of a motion that was not made yet, with the code that judges one that was."""
    whitened = assumed().whitened(swing())
    true = Candidate(EFFECTS[name], 1, EFFECTS[name].candidates(assumed().base.x, 1)[0])
    (score,) = bayes_factors(whitened, [true])
    prior = expected(true.columns(whitened.x), float(whitened.spread[1]))
    ratio = assumed().coefficients(true, SIZE) / prior
    (judged,) = judge(whitened, [Case(true, (None,))], assumed(), SIZE)
    own = 0.5 * np.mean(np.diag(score.information) * ratio**2)
    assert judged.signals[0] == pytest.approx(own / assumed().inflation[true.key], rel=1e-6)


def test_a_rival_takes_what_it_can_imitate() -> None:
    """As much as the search would give it, were it in the model."""
    whitened = assumed().whitened(swing())
    true, rival = (
        Candidate(EFFECTS["stribeck"], 1, {"v_s": 0.15}),
        Candidate(EFFECTS["quadratic_drag"], 1),
    )
    beside = Nuisance(1, rival.columns(whitened.x))
    (alone,), (left,) = (
        bayes_factors(one, [true])
        for one in (whitened, whitened.explaining(whitened.basis, (beside,)))
    )
    (judged,) = judge(whitened, [Case(true, (None, rival))], assumed(), SIZE)
    # The search scales by the residual; nothing was measured here.
    scale = whitened.explaining(whitened.basis, (beside,)).amplitude ** 2
    share = scale * float(left.information[0, 0] / alone.information[0, 0])
    assert share < 1.0
    assert judged.signals[1] / judged.signals[0] == pytest.approx(share, rel=1e-6)


@pytest.mark.parametrize("name", ["stribeck", "ripple", "hysteresis"])
def test_nothing_tells_an_effect_from_itself(name: str) -> None:
    whitened = assumed().whitened(swing())
    true = Candidate(EFFECTS[name], 1, EFFECTS[name].candidates(assumed().base.x, 1)[1])
    (judged,) = judge(whitened, [Case(true, (None, true))], assumed(), SIZE)
    assert judged.signals[1] < 1e-9 * judged.signals[0]


def test_the_noise_counts_by_time_and_not_by_samples() -> None:
    """Looking twice as often at the same motion says nothing new."""
    motion = assumed().motion_of(swing())
    inputs = rods().inputs_of(motion)
    true = Candidate(EFFECTS["stribeck"], 1, {"v_s": 0.15})
    gains = []
    for every in (4, 2):
        index = np.arange(0, len(motion), every)
        whitened = assumed().whitened_at(motion, index, inputs, inputs.take(index))
        gains.append(float(judge(whitened, [Case(true, (None,))], assumed(), SIZE)[0].signals[0]))
    assert gains[0] == pytest.approx(gains[1], rel=0.1)


QUESTIONS = [
    For(STUCK),
    For(Suspect("ripple", "elbow")),
    Between(Suspect("stribeck", "elbow"), Suspect("power_law", "elbow")),
]


@pytest.mark.parametrize("question", QUESTIONS)
def test_the_slope_is_that_of_the_value(question: Question) -> None:
    splines = Splines(6.0, 24)
    index = np.arange(3, len(splines.time), 11)
    groups = cases_of(question, assumed(), SIZE)
    # Without rivals that remember: theirs is the slope by their own joint only.
    groups = [
        [
            Case(one.true, tuple(r for r in one.rivals if r is None or not r.effect.remembers))
            for one in group
        ]
        for group in groups
    ]
    objective = Objective(assumed(), groups, splines, SIZE, index, dynamics=True)
    pose = seen_pose(rods(), "elbow", limits_of(rods()))
    draw = np.random.default_rng(0)
    control, way = np.tile(pose, (24, 1)), np.zeros((24, 2))
    inner = slice(AT_REST, 24 - AT_REST)
    control[inner] += draw.normal(0.0, 0.2, control[inner].shape)
    way[inner] = draw.normal(size=way[inner].shape)
    look = objective.look(control)
    step = 1e-6
    up, down = (objective.look(control + s * step * way, slope=False).value for s in (1.0, -1.0))
    along = float(np.sum(objective.slope(look, control) * way))
    assert along == pytest.approx((up - down) / (2 * step), rel=0.02, abs=1e-3)


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
    force = float(assumed().coefficients(true, SIZE)[0])
    tau = two_rods.rods(made.q, made.qd, made.qdd)
    tau += np.array([2.0, 0.4]) * made.qd + np.array([3.0, 0.8]) * np.tanh(made.qd / two_rods.WIDTH)
    tau += force / 0.6 * two_rods.stick(made.time, made.q, made.qd, made.qdd)
    tau += two_rods.NOISE * np.random.default_rng(5).normal(size=tau.shape)
    segment = np.zeros(len(tau), dtype=np.int64)
    recorded = Motion(two_rods.JOINTS, *made, tau, segment)
    whitened = fit(recorded, rods().inputs_of(recorded), rods().basis)
    (score,) = bayes_factors(whitened, [true])
    promised = next(one for one in assumed().gains(made, SIZE, [true]) if one.effect == "stribeck")
    assert promised.nats > 20.0
    assert score.log_bf == pytest.approx(promised.nats, rel=0.6)
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


@pytest.mark.parametrize("question", [*QUESTIONS[1:], Everything()])
def test_every_question_has_its_motion(question: Question) -> None:
    found = design(rods(), question, seconds=SECONDS, assumed=assumed(), effort=TINY)
    assert_sound(found, limits_of(rods()))
    assert found.nats > 0.0
    assert found.question == question
    assert set(joints_of(question, rods())) <= set(found.joints)


def test_the_seed_decides() -> None:
    def one(seed: int) -> Floats:
        return design(
            rods(), For(STUCK), seconds=SECONDS, assumed=assumed(), effort=TINY, seed=seed
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
