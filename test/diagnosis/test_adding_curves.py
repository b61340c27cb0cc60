"""What no effect explains is named by its coordinate, and taken in as a curve."""

import numpy as np
import pytest
import two_rods
from diagnosed_rods import diagnosed
from whitened_examples import few_torques

from lagrangian_ff.diagnosis import (
    Diagnosis,
    add,
    apply,
    diagnose,
    diagnosis_record,
    with_consequences,
)
from lagrangian_ff.diagnosis.sentences import curve_command
from lagrangian_ff.errors import EffectError

_small = few_torques(1200)


@pytest.fixture(scope="module")
def sore() -> Diagnosis:
    """Return the diagnosis of an arm with friction that no catalogue has."""
    return with_consequences(diagnosed(two_rods.sore_spot))


def test_what_no_effect_explains_is_named_by_its_coordinate(sore: Diagnosis) -> None:
    assert not sore.confirmed
    rest = {one.coordinate: one for one in sore.unexplained if one.joint == "shoulder"}
    one = rest["position, changing sign with direction"]
    assert curve_command(one, "m.npz") == (
        "lagrangian_ff add m.npz curve --joint shoulder --over position --friction --output NEW.npz"
    )


def test_what_no_effect_explains_is_taken_in_as_a_curve_if_asked(sore: Diagnosis) -> None:
    assert apply(sore) is sore.model
    (_, made), *_ = sore.curves
    assert made.whole_after < 0.6 * made.whole_before
    record = diagnosis_record(sore)["unexplained"][0]
    assert record["lowers_error"] is True
    assert (record["effect"], record["over"]) == ("curve_friction_position", ["position"])
    larger = apply(sore, curves=True)
    step = larger.steps[-1]
    assert (step["added"], step["verdict"]) == (
        "curve_friction_position on shoulder",
        "unexplained",
    )
    again = diagnose(larger, sore.motion, sore.held_out)
    assert not again.found
    assert all(one.joint != "shoulder" for one in again.unexplained)


def test_a_curve_by_hand_is_the_same_as_by_its_command(sore: Diagnosis) -> None:
    by_hand = add(sore.model, "curve", "shoulder", over=("position",), friction=True)
    (made,) = (one for one, _ in sore.curves[:1])
    assert made.consequence is not None
    np.testing.assert_allclose(by_hand.coefficients, made.consequence.model.coefficients)
    with pytest.raises(EffectError, match="only a curve is over"):
        add(sore.model, "stribeck", "shoulder", over=("position",))
