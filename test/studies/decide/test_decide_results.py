"""The study of experiments that decide: its arms, its rig, and how it counts."""

from typing import Any

import numpy as np
import pytest

pytest.importorskip("pybullet")

from lagrangian_ff.arm import HOME, JOINTS, Trajectory
from lagrangian_ff.arm.hidden import HIDDEN
from lagrangian_ff.diagnosis.excite import excite
from lagrangian_ff.investigation import Ended, StoppedError
from lagrangian_ff.studies.decide.cases import NEVER, cases
from lagrangian_ff.studies.decide.results import DecideResults
from lagrangian_ff.studies.decide.rig import Clearance, SimulatedRig, arm_limits
from lagrangian_ff.studies.hidden.verdicts import Judgement, Outcome


def judged(outcome: Outcome, *false: str) -> dict[str, Any]:
    return Judgement(outcome, false, ()).record()


def motion(number: int, before: Outcome, designed: Outcome, nats: tuple[float, float]) -> Any:
    return {
        "case": f"motion-{number}",
        "group": "motion",
        "before": judged(before),
        "designed": {
            "seconds": 30.0,
            "judgement": judged(designed),
            "nats": nats[0],
            "visible": 0.05 * (1 + number),
        },
        "template": {"seconds": 30.0, "judgement": judged(Outcome.NOTHING), "nats": nats[1]},
        "expected": 40.0,
    }


def moved(number: int, group: str, outcome: Outcome, when: float | None, *false: str) -> Any:
    return {
        "case": f"{group}-{number}",
        "group": group,
        "judgement": judged(outcome, *false),
        "moved": 120.0,
        "when": when,
        "left": 0,
        "error": [0.3, 0.2],
        "story": {"ended": Ended.NOTHING_LEFT.value},
    }


def test_only_what_the_usual_motion_left_open_is_counted() -> None:
    lines = [motion(k, Outcome.NOTHING, Outcome.RIGHT, (60.0, 10.0)) for k in range(9)]
    lines += [motion(9, Outcome.CLASS, Outcome.CLASS, (30.0, 30.0))]
    lines[9]["designed"]["attainable"] = 25.0
    lines += [motion(10, Outcome.RIGHT, Outcome.NOTHING, (0.0, 0.0))]
    found = DecideResults.of(lines)
    assert (len(found.opened), found.decided) == (10, 1)
    assert found.findings is not None
    assert found.findings["designed"].figures == {"named": 0.9, "wrong": 0.0}
    assert found.findings["designed"].holds
    assert found.findings["within reach"].figures == {"seen": 10, "named": 9}
    assert found.findings["ratio"].figures["median"] == pytest.approx(6.0)
    assert any("6.0 times" in line for line in found.table())
    # Visible parts of 0.05 to 0.5: one is below 0.1, four up to 0.3; the last is one of a class.
    shares = next(line for line in found.table() if "designed one" in line and " of " in line)
    assert " ".join(shares.split()[3:]) == "1 of 1 4 of 4 4 of 5"


def test_an_arm_that_cannot_have_its_effect_so_large_does_not_count() -> None:
    lines = [moved(k, "five", Outcome.NOTHING, None) for k in range(6)]
    for line, size in zip(lines, (0.05, 0.049, 0.03, 0.05, 0.05, 0.01), strict=True):
        line |= {"hidden": ["elasticity", "joint_4", 0.05], "size": size}
    found = DecideResults.of(lines)
    assert list(found.small) == ["five-5"]
    assert len(found.investigated["five"]) == 5
    assert any("left out" in line for line in found.table())


def test_a_wrong_name_or_a_missed_effect_is_no_success() -> None:
    lines = [moved(k, "five", Outcome.RIGHT, 60.0) for k in range(4)]
    lines += [moved(4, "five", Outcome.WRONG, None, "ripple on joint_1")]
    lines += [moved(k, "clean", Outcome.NOTHING, None) for k in range(5)]
    found = DecideResults.of(lines)
    assert found.findings is not None
    assert not found.findings["five"].holds
    assert found.findings["five"].figures["share"] == pytest.approx(0.8)
    assert found.findings["five"].figures["too little"] == 1
    assert found.findings["clean"].holds
    assert found.findings["limits"].holds
    assert "two" not in found.findings
    assert found.figure() is not None
    # An arm that moved for all of its time, or all but a few seconds, did not end early.
    for late in ({"story": {"ended": Ended.BUDGET.value}}, {"moved": 237.0}):
        later = DecideResults.of([*lines[:-1], {**lines[-1], **late}]).findings
        assert later is not None
        assert not later["clean"].holds
        assert later["clean"].figures == {"wrong": 0, "early": 4}


def test_the_arms_of_the_study_stay_the_same_and_hide_what_motion_can_show() -> None:
    every = cases(0)
    assert every == cases(0)
    assert len({one.name for one in every}) == len(every)
    for one in every:
        assert (one.hidden is None) == (one.group in ("clean", "sooner"))
        if one.hidden is not None:
            assert one.hidden.effect in HIDDEN
            assert one.hidden.effect not in NEVER
            assert one.hidden.joint in JOINTS


def test_the_rig_does_a_motion_counts_what_leaves_its_limits_and_refuses_a_collision() -> None:
    case, limits = next(one for one in cases(0) if one.group == "clean"), arm_limits()
    rig, start = SimulatedRig(case.nuisances, None, case.seed, limits), np.array(HOME)
    path = excite("exciting", JOINTS, limits.around(start, 0.2), start=start, duration=5.0)
    assert Clearance()(path.q) == ""
    recording = rig.run(path, None, lambda share, words: None)
    assert recording.joints == JOINTS
    assert rig.left == 0
    faster = path._replace(time=0.4 * path.time, qd=path.qd / 0.4, qdd=path.qdd / 0.16)
    if np.any(np.abs(faster.qd) > limits.qd_max):
        rig.run(faster, None, lambda share, words: None)
        assert rig.left > 0
    folded = path._replace(q=path.q + np.array([0.0, 1.9, 0.0, 0.0, 0.0, 0.0]))
    assert Clearance()(folded.q) != ""
    with pytest.raises(StoppedError):
        rig.run(folded, None, lambda share, words: None)


def test_the_rig_knows_the_torque_that_it_hides() -> None:
    case = next(one for one in cases(0) if one.hidden and one.hidden.effect == "quadratic_drag")
    assert case.hidden is not None
    limits, start, joint = arm_limits(), np.array(HOME), JOINTS.index(case.hidden.joint)
    hiding, clean = (
        SimulatedRig(case.nuisances, hidden, case.seed, limits) for hidden in (case.hidden, None)
    )
    path = excite("exciting", JOINTS, limits.around(start, 0.2), start=start, duration=5.0)
    hiding.size_along(Trajectory(path.time, path.q, path.qd, path.qdd, JOINTS))
    for rig in (hiding, clean):
        rig.run(path, None, lambda share, words: None)
    (done,), (other,) = hiding.done, clean.done
    efforts = [
        np.interp(done.elapsed, one.time - one.time[0], one.effort[:, joint])
        for one in (done.recording, other.recording)
    ]
    assert np.corrcoef(efforts[0] - efforts[1], done.truth[:, joint])[0, 1] > 0.9
    np.testing.assert_array_equal(other.truth, 0.0)
