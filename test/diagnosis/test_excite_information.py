"""The information of a motion that was not made yet is the search's own, and so is its slope."""

import numpy as np
import pytest
from design_examples import QUESTIONS, SECONDS, SIZE, assumed, rods, swing
from whitened_examples import SHORT, few_torques

from lagrangian_ff.diagnosis.excite import Parameters, Question, Reference, limits_of, seen_pose
from lagrangian_ff.diagnosis.excite.objective import Objective, judge
from lagrangian_ff.diagnosis.excite.questions import Case, cases_of
from lagrangian_ff.diagnosis.excite.splines import AT_REST, Splines
from lagrangian_ff.diagnosis.search.bayes_factor import bayes_factors, expected
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification.problem import Nuisance

_small = few_torques(1000, SHORT)


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


def creeping() -> Reference:
    """Return a motion in which the elbow hardly goes faster than its friction turns over."""
    time = np.arange(0.0, SECONDS, 0.01)
    swings, rate = np.sin(2.0 * time), np.cos(2.0 * time)
    most = 1.5 * rods().basis.sign_speed(2)[1]
    pose = seen_pose(rods(), "elbow", limits_of(rods()))
    q, qd, qdd = np.tile(pose, (len(time), 1)), np.zeros((len(time), 2)), np.zeros((len(time), 2))
    q[:, 1] += 0.5 * most * swings
    qd[:, 1], qdd[:, 1] = most * rate, -2.0 * most * swings
    return Reference(time, q, qd, qdd)


@pytest.mark.parametrize(("speed", "least", "most"), [(0.01, 0.0, 0.05), (0.15, 0.5, 1.0)])
def test_what_a_bend_shows_in_creeping_counts_for_little(
    speed: float, least: float, most: float
) -> None:
    """With friction unknown at creeping speed, only a bend at higher speed can be seen."""
    made = creeping() if speed < 0.1 else swing()
    case = Case(Candidate(EFFECTS["stribeck"], 1, {"v_s": speed}), (None,))
    signals = [
        float(judge(one.whitened(made), [case], one, SIZE)[0].signals[0])
        for one in (assumed(), assumed().unsure_of_creep([1]))
    ]
    assert least * signals[0] <= signals[1] <= most * signals[0], signals


@pytest.mark.parametrize("question", [*QUESTIONS, Parameters()])
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
    unsure = assumed().unsure_of_creep([0, 1])
    objective = Objective(unsure, groups, splines, SIZE, index, dynamics=True)
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
