"""The judge of a diagnosis, case by case."""

from dataclasses import replace

import pytest
from diagnosis_examples import doubt, finding

from lagrangian_ff.diagnosis import Finding
from lagrangian_ff.studies.hidden.verdicts import Outcome, Truth, judge


def found(effect: str, *joints: str, like: tuple[str, ...] = ()) -> Finding:
    """Return a finding without a cause of its own, confirmed if nothing is like it."""
    return finding(effect, joints=joints, cause=None, rivals=like)


RIPPLE = Truth(("ripple",), ("joint_2",))
DRAG = Truth(("quadratic_drag",), ("joint_4",))
STRANGE = Truth((), ("joint_2",))
RIGHT = found("ripple", "joint_2")
CLASS = found("gear_mesh", "joint_2", like=("ripple",))
ELSEWHERE = found("ripple", "joint_3")
EITHER = found("ripple", "joint_2", like=("gear_mesh",))
OR_ELSE = found("drift", "joint_2", like=("offset",))
OTHER = found("stribeck", "joint_2")
HINT = finding("ripple", "joint_2", doubt=doubt())


@pytest.mark.parametrize(
    ("truths", "findings", "outcome"),
    [
        ([RIPPLE], [RIGHT], "right"),
        ([RIPPLE], [CLASS], "class"),
        ([RIPPLE], [CLASS, RIGHT], "right"),
        ([RIPPLE], [RIGHT, CLASS], "right"),
        ([RIPPLE], [EITHER], "class"),
        ([RIPPLE], [EITHER, RIGHT], "right"),
        ([RIPPLE], [OR_ELSE], "wrong"),
        ([], [OR_ELSE], "wrong"),
        ([STRANGE], [EITHER], "wrong"),
        ([RIPPLE], [ELSEWHERE], "wrong"),
        ([RIPPLE], [OTHER], "wrong"),
        ([RIPPLE], [OTHER, RIGHT], "right"),
        ([RIPPLE], [HINT], "nothing"),
        ([RIPPLE], [], "nothing"),
        ([], [], "nothing"),
        ([], [HINT], "nothing"),
        ([], [RIGHT], "wrong"),
        ([STRANGE], [], "nothing"),
        ([STRANGE], [RIGHT], "wrong"),
        ([STRANGE], [HINT], "nothing"),
        ([RIPPLE, DRAG], [RIGHT, found("quadratic_drag", "joint_4")], "right"),
        ([RIPPLE, DRAG], [CLASS, found("quadratic_drag", "joint_4")], "class"),
        ([RIPPLE, DRAG], [RIGHT], "part"),
        ([RIPPLE, DRAG], [RIGHT, OTHER], "wrong"),
        ([RIPPLE, DRAG], [], "nothing"),
    ],
)
def test_outcomes(truths: list[Truth], findings: list[Finding], outcome: str) -> None:
    assert judge(truths, findings).outcome.value == outcome


def test_false_claims_are_named_even_beside_a_right_one() -> None:
    judged = judge([RIPPLE], [RIGHT, OTHER])
    assert judged.outcome is Outcome.RIGHT
    assert judged.false == ("stribeck on joint_2",)
    assert judge([], [OR_ELSE]).false == ("drift or offset on joint_2",)


def test_a_suggested_truth_is_listed_unless_it_is_also_claimed() -> None:
    assert judge([RIPPLE, DRAG], [HINT]).suggested == (0,)
    assert judge([RIPPLE], [HINT, RIGHT]).suggested == ()
    assert judge([RIPPLE], [OTHER, HINT]).suggested == (0,)


def test_an_effect_of_several_joints_may_be_found_on_any() -> None:
    payload = Truth(("payload",), ("joint_1", "joint_2", "joint_3"))
    assert judge([payload], [found("payload", "joint_3")]).outcome is Outcome.RIGHT
    assert judge([payload], [found("payload", "joint_2", "joint_6")]).outcome is Outcome.RIGHT
    assert judge([payload], [found("payload", "joint_6")]).outcome is Outcome.WRONG


def test_what_is_felt_elsewhere_counts_where_its_cause_is() -> None:
    """A soft gear shakes its neighbours: naming it there is right, blaming theirs is not."""
    truth = [Truth(("elasticity",), ("joint_2",))]
    felt = finding("elasticity", "joint_3", cause="joint_2")
    assert judge(truth, [felt]).outcome is Outcome.RIGHT
    assert judge(truth, [replace(felt, cause="joint_3")]).outcome is Outcome.WRONG
