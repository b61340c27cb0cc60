"""Lists of names as people say them."""

import pytest

from lagrangian_ff.words import listed, sentence, spoken, which

ARM = ("base", "elbow", "wrist", "hand")


@pytest.mark.parametrize(
    ("names", "said"), [([], ""), (["a"], "a"), (["a", "b"], "a and b"), ("abc", "a, b and c")]
)
def test_names_are_listed(names: list[str], said: str) -> None:
    """As in a sentence."""
    assert listed(names) == said


@pytest.mark.parametrize(
    ("joints", "said"),
    [
        (ARM, "every joint"),
        (ARM[::-1], "every joint"),
        (ARM[1:], "every joint but base"),
        (ARM[2:], "wrist, hand"),
        (["elbow"], "elbow"),
    ],
)
def test_joints_of_an_arm_are_named_briefly(joints: list[str], said: str) -> None:
    """All of them are not counted up."""
    assert which(joints, ARM) == said


def test_two_joints_are_named_even_if_they_are_all() -> None:
    """As short as the phrase, and clearer; the same where the arm is not known."""
    assert which(["a", "b"], ["a", "b"]) == "a, b"
    assert which(["a", "b", "c"], []) == "a, b, c"


def test_an_effect_is_spoken_and_its_joint_keeps_its_name() -> None:
    """Underscores are of names in code."""
    assert spoken("torque_ripple on joint_2") == "torque ripple on joint_2"


def test_a_sentence_begins_and_ends_as_one() -> None:
    """The name of a joint stays as it is."""
    assert sentence("go slower") == "Go slower."
    assert sentence("joint_2 is noisy!") == "joint_2 is noisy!"
