"""Changes since the model was identified are found, and only those."""

from dataclasses import replace

import numpy as np
import pytest
import two_rods
from whitened_examples import SHORT, few_torques

from lagrangian_ff.diagnosis import diagnose, verdict
from lagrangian_ff.diagnosis.competing import MASSES
from lagrangian_ff.diagnosis.misfit import misfit_of
from lagrangian_ff.diagnosis.since import changed_if_misfit, changed_since
from lagrangian_ff.diagnosis.thresholds import Thresholds, using
from lagrangian_ff.identification import Model, Settings, identify

_small = few_torques(1000, SHORT)


@pytest.fixture(scope="module")
def model() -> Model:
    """Return a model of the rods as they were."""
    return identify(
        two_rods.motion(1, 30.0), Settings(train=1.0, samples=100, evaluations=12)
    ).model


def worn(
    t: two_rods.Floats, q: two_rods.Floats, qd: two_rods.Floats, qdd: two_rods.Floats
) -> two_rods.Floats:
    """Half a newton metre more dry friction in the elbow."""
    return np.stack([np.zeros(len(t)), 0.5 * np.tanh(qd[:, 1] / two_rods.WIDTH)], axis=1)


def test_friction_that_grew_is_named_with_how_much(model: Model) -> None:
    found = changed_since(model, two_rods.motion(2, 30.0, worn))
    assert [(one.what, one.joints) for one in found] == [("coulomb", ("elbow",))]
    ((name, by),) = found[0].parameters.items()
    assert (name, by.unit) == ("F_c", "N·m")
    assert by.low < 0.5 < by.high
    assert by.high - by.low < 0.2
    before, after = found[0].error_before, found[0].error_after
    assert before is not None
    assert after is not None
    assert after < 0.5 * before


def test_a_load_that_was_attached_is_told_from_friction(model: Model) -> None:
    found = changed_since(model, two_rods.motion(2, 30.0, load_since=-1.0))
    assert found[0].what == MASSES
    assert set(found[0].joints) == {"shoulder", "elbow"}
    assert not [one for one in found[1:] if one.what in ("viscous", "coulomb")]


def test_a_drive_whose_gain_changed_is_one_finding(model: Model) -> None:
    """It scales friction and offset of its joint too."""
    new = two_rods.motion(2, 30.0)
    (found,) = changed_since(model, replace(new, tau=new.tau * [1.15, 1.0]))
    assert (found.what, found.joints) == ("torque_gain", ("shoulder",))
    gain = found.parameters["g"]
    assert gain.low < 0.15 < gain.high
    assert gain.high - gain.low < 0.02


def test_an_effort_in_another_unit_is_one_finding(model: Model) -> None:
    new = two_rods.motion(2, 30.0)
    (found,) = changed_since(model, replace(new, tau=0.8 * new.tau))
    assert (found.what, set(found.joints)) == ("torque_gain", {"shoulder", "elbow"})
    assert found.parameters["g"].value == pytest.approx(-0.2, abs=0.01)


def test_coulomb_and_viscous_friction_of_a_joint_are_one_finding(model: Model) -> None:
    new = two_rods.motion(2, 30.0)
    qd = new.qd[:, 1]
    more = np.stack([0.0 * qd, 0.5 * np.tanh(qd / two_rods.WIDTH) + 0.3 * qd], axis=1)
    (found,) = changed_since(model, replace(new, tau=new.tau + more))
    assert (found.what, found.joints) == ("coulomb and viscous", ("elbow",))
    assert found.parameters["B"].value == pytest.approx(0.3, rel=0.2)


def test_only_a_model_that_errs_more_than_it_promised_asks(model: Model) -> None:
    same, loaded = two_rods.motion(3, 30.0), two_rods.motion(2, 30.0, load_since=-1.0)
    assert changed_if_misfit(model, same) is None
    assert not misfit_of(model, same).larger
    found = misfit_of(model, loaded)
    assert set(found.larger) == {0, 1}
    assert found.here[1] > 3.0 * found.own[1]


def test_what_the_model_contradicts_is_not_called_noise(model: Model) -> None:
    """Without the question what changed, the verdict still says how large the error is."""
    loaded, more = (two_rods.motion(seed, 30.0, load_since=-1.0) for seed in (2, 4))
    found = diagnose(model, loaded, more, steps=1)
    assert not found.confirmed
    said = verdict(found)
    assert said.startswith("The arm is not as the model knows it")
    assert "noise" not in said
    changed = changed_since(model, loaded, steps=1)
    assert verdict(found, changed).startswith("The arm changed since the model was identified")
    assert "other masses" in verdict(found, changed)


def test_the_threshold_of_a_change_decides(model: Model) -> None:
    with using(Thresholds(change_floor=1e9)):
        found = changed_since(model, two_rods.motion(2, 30.0, load_since=-1.0), steps=1)
    assert MASSES not in [one.what for one in found]


def test_an_arm_as_it_was_has_not_changed(model: Model) -> None:
    assert changed_since(model, two_rods.motion(3, 30.0)) == ()
