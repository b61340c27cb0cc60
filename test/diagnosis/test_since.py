"""Changes since the model was identified are found, and only those."""

from collections.abc import Iterator

import numpy as np
import pytest
import two_rods
from whitened_examples import SHORT, quickly

from lagrangian_ff.diagnosis.since import MASSES, changed_since
from lagrangian_ff.diagnosis.thresholds import Thresholds, using
from lagrangian_ff.identification import Model, Settings, identify


@pytest.fixture(autouse=True, scope="module")
def _small() -> Iterator[None]:
    with quickly(1000, SHORT):
        yield


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
    assert (name, by.unit, by.bounded) == ("F_c", "N·m", False)
    assert by.value == pytest.approx(0.5, rel=0.2)


def test_a_load_that_was_attached_is_told_from_friction(model: Model) -> None:
    found = changed_since(model, two_rods.motion(2, 30.0, load_since=-1.0))
    assert found[0].what == MASSES
    assert set(found[0].joints) == {"shoulder", "elbow"}
    assert not [one for one in found[1:] if one.what in ("viscous", "coulomb")]


def test_the_threshold_of_a_change_decides(model: Model) -> None:
    with using(Thresholds(change_floor=1e9)):
        found = changed_since(model, two_rods.motion(2, 30.0, load_since=-1.0), steps=1)
    assert MASSES not in [one.what for one in found]


def test_an_arm_as_it_was_has_not_changed(model: Model) -> None:
    assert changed_since(model, two_rods.motion(3, 30.0)) == ()
