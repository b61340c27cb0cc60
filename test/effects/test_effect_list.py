"""What every effect of the shared list must be."""

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from effect_examples import JOINTS, motion, shape_of, shapes_of
from numpy.typing import NDArray

from lagrangian_ff.effects import (
    EFFECTS,
    GROUPS,
    KINDS,
    MOTIONS,
    PARTS,
    Effect,
    Inputs,
    checked_columns,
    checked_energies,
    look_alikes,
)
from lagrangian_ff.errors import EffectError
from lagrangian_ff.kernels import States

COORDINATES = {
    "velocity", "position", "acceleration", "load", "time", "direction", "since_reversal", "order",
}  # fmt: skip
# Rates of change and smoothing are centred: the last samples of a motion know what comes next.
LOOKAHEAD = {"hysteresis": 0, "delay": 1, "elasticity": 0, "backlash": 1}


@pytest.fixture(params=sorted(EFFECTS))
def effect(request: pytest.FixtureRequest) -> Effect:
    """Return each effect."""
    return EFFECTS[request.param]


@pytest.fixture(scope="module")
def moving() -> Inputs:
    """Return a motion of three joints."""
    return motion()


@pytest.fixture
def states() -> Inputs:
    """Return states of three joints without time, rest among them."""
    rng = np.random.default_rng(0)
    q, qd, qdd = rng.normal(size=(3, 20, JOINTS))
    qd[0] = 0.0
    return Inputs.of(States.of(q, qd, qdd))


def test_it_explains_itself(effect: Effect) -> None:
    words = (
        effect.name, effect.formula, effect.source, effect.meaning, effect.shows_as,
        effect.next_motion,
    )  # fmt: skip
    assert all(words)
    assert effect.source != "user"
    assert effect.kind in KINDS
    assert effect.part in PARTS
    assert effect.coordinate in COORDINATES
    assert effect.motion in MOTIONS
    assert effect.uses <= {"load", "torque"}
    assert effect.parameters
    assert all(p.name and p.unit and p.meaning for p in effect.parameters)
    assert all(s.name and s.unit and s.meaning for s in effect.shapes)
    assert all(s.low <= s.start <= s.high for s in effect.shapes)


def test_its_formula_has_every_number_by_its_name(effect: Effect) -> None:
    named = set(re.findall(r"[A-Za-z_]\w*", effect.formula))
    assert {p.name for p in effect.parameters} | {s.name for s in effect.shapes} <= named


def test_its_look_alikes_are_stated_once_and_hold_both_ways(effect: Effect) -> None:
    for other, difference in effect.look_alikes.items():
        assert other in EFFECTS
        assert other != effect.name
        assert difference
        assert effect.name not in EFFECTS[other].look_alikes
    for other, difference in look_alikes(effect).items():
        assert look_alikes(EFFECTS[other])[effect.name] == difference


def test_it_goes_with_gravity_if_it_is_there_at_rest(effect: Effect, moving: Inputs) -> None:
    """With equal parameters: unequal Coulomb friction holds an offset."""
    still = np.zeros_like(moving.q)
    resting = replace(
        moving, q=still + 0.3, qd=still, qdd=still, load=still + 5.0, torque=still + 5.0
    )
    shapes = effect.candidates(resting, 1) or [shape_of(effect)]
    columns = [effect.columns(resting, 1, shape) for shape in shapes]
    torque = [float(np.abs(one.sum(axis=1)).max()) > 1e-9 for one in columns]
    follows_limit = effect.name == "saturation"  # its limits come from a torque that varies
    assert any(torque) or follows_limit if effect.part == "gravity" else not any(torque)


def test_friction_takes_energy(effect: Effect, moving: Inputs) -> None:
    """At each moment, on the shaft that it acts on, but for what remembers."""
    if effect.part != "friction" or effect.remembers or effect.name == "directional_friction":
        return
    for shape in shapes_of(effect, moving, 1):
        power = effect.columns(moving, 1, shape).sum(axis=1) * effect.speed(moving, 1, shape)
        # The others brake together with the joint's other friction only.
        assert not effect.signs(moving, 1, shape) or (power >= 0.0).all()


def test_there_is_one_finite_column_a_parameter(effect: Effect, moving: Inputs) -> None:
    for joint in range(JOINTS):
        for shape in shapes_of(effect, moving, joint):
            columns = checked_columns(effect, moving, joint, shape)
            assert columns.shape == (len(moving), len(effect.parameters))


def test_it_adds_something_to_a_motion(effect: Effect, moving: Inputs) -> None:
    shapes = shapes_of(effect, moving, 1)
    assert shapes
    assert all(effect.columns(moving, 1, shape).any(axis=0).all() for shape in shapes)


def test_states_without_time_are_settled_and_finite(effect: Effect, states: Inputs) -> None:
    together = checked_columns(effect, states, 1, shape_of(effect))
    for i in range(3):
        alone = effect.columns(states.take(np.array([i])), 1, shape_of(effect))
        np.testing.assert_allclose(alone[0], together[i], atol=1e-12)


def test_the_search_stays_in_the_range(effect: Effect, moving: Inputs) -> None:
    for shape in effect.candidates(moving, 0):
        for s in effect.shapes:
            assert s.low <= shape[s.name] <= s.high
        assert set(shape) == {s.name for s in effect.shapes}


def test_a_sample_does_not_depend_on_which_others_are_there(effect: Effect, moving: Inputs) -> None:
    """Only what remembers may look at other samples, and it looks back, or a moment ahead."""
    shape = shapes_of(effect, moving, 1)[-1]
    whole = effect.columns(moving, 1, shape)
    if not effect.remembers:
        some = np.arange(0, len(moving), 7)
        np.testing.assert_array_equal(effect.columns(moving.take(some), 1, shape), whole[some])
    first = len(moving) // 2
    start = effect.columns(cut(moving, first), 1, shape)
    kept = first - LOOKAHEAD.get(effect.name, 0)
    np.testing.assert_allclose(start[:kept], whole[:kept], atol=1e-12)


def test_it_knows_what_it_uses(effect: Effect, moving: Inputs) -> None:
    shape = shapes_of(effect, moving, 1)[-1]
    before = effect.columns(moving, 1, shape)
    for name in ("load", "torque"):
        changed = replace(moving, **{name: 1.3 * getattr(moving, name) + 1.0})
        same = np.array_equal(effect.columns(changed, 1, shape), before)
        assert same == (name not in effect.uses)


def test_it_knows_whether_it_remembers(effect: Effect, moving: Inputs) -> None:
    """Samples in a stretch of their own have no past."""
    alone = replace(moving, segment=np.arange(len(moving)))
    shape = shapes_of(effect, moving, 1)[-1]
    same = np.array_equal(effect.columns(alone, 1, shape), effect.columns(moving, 1, shape))
    assert same != effect.remembers


def test_what_keeps_energy_takes_power_as_its_energy_rises(effect: Effect, moving: Inputs) -> None:
    for shape in shapes_of(effect, moving, 1):
        found = effect.energies(moving, 1, shape)
        if found is None:
            continue
        assert not effect.remembers
        assert not effect.uses
        kinetic, potential = found
        assert kinetic.shape == potential.shape == (len(moving), len(effect.parameters))
        h = 1e-5
        later, earlier = (
            energy(
                effect,
                replace(moving, q=moving.q + t * moving.qd, qd=moving.qd + t * moving.qdd),
                shape,
            )
            for t in (h, -h)
        )
        power = effect.columns(moving, 1, shape) * moving.qd[:, [1]]
        rate = (later - earlier) / (2.0 * h)
        np.testing.assert_allclose(power, rate, atol=1e-5 * np.abs(power).max())
        # At rest only potential energy is left, and twice the speed has four times the other.
        slow = effect.energies(replace(moving, qd=0.5 * moving.qd), 1, shape)
        assert slow is not None
        np.testing.assert_allclose(4.0 * slow[0], kinetic, atol=1e-12)
        np.testing.assert_array_equal(slow[1], potential)


def energy(effect: Effect, x: Inputs, shape: dict[str, float]) -> NDArray[np.float64]:
    """Kinetic and potential energy together, of the second joint."""
    found = effect.energies(x, 1, shape)
    assert found is not None
    return found[0] + found[1]


def test_energies_of_another_shape_are_refused(moving: Inputs) -> None:
    class Lopsided(type(EFFECTS["spring"])):  # type: ignore[misc]
        name = "lopsided"

        def energies(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> tuple[Any, ...]:
            return x.q[:, joint], x.q[:, [joint]]

    with pytest.raises(
        EffectError, match=r"'lopsided': energies\(\) gave shapes.*expected kinetic and potential"
    ):
        checked_energies(Lopsided(), moving, 0, {})


def test_friction_keeps_no_energy(moving: Inputs) -> None:
    kept = {
        name
        for name, effect in EFFECTS.items()
        if effect.energies(moving, 0, shape_of(effect)) is not None
    }
    assert kept == {"rotor_inertia", "spring", "counterbalance", "ripple"}
    assert not any(EFFECTS[name].part == "friction" for name in kept)


def test_the_engine_finds_one_effect_of_each_kind_that_it_asks_for() -> None:
    events = [effect.arm_event for effect in EFFECTS.values() if effect.arm_event]
    assert sorted(events) == ["lasting", "passing"]
    for effect in EFFECTS.values():
        assert effect.sign_width in {"", *shape_of(effect)}
        assert not effect.plain or effect.part == "friction"
        assert not effect.constant or effect.part == "gravity"
    assert any(effect.plain for effect in EFFECTS.values())


def test_groups_are_made_of_effects() -> None:
    assert all(name in EFFECTS for names in GROUPS.values() for name in names)
    assert not set(GROUPS) & set(EFFECTS)


def test_friction_basis_is_the_papers_kernel(states: Inputs) -> None:
    """Φ Φᵀ equals (51), with the velocity in both tanh as the text of the paper says."""
    width = 0.05
    columns = np.hstack([EFFECTS[name].columns(states, 2, {"v0": width}) for name in GROUPS["fri"]])
    v = states.qd[:, 2]
    step = np.tanh(v / width)
    np.testing.assert_allclose(columns @ columns.T, np.outer(v, v) + np.outer(step, step) + 1.0)


def cut(x: Inputs, count: int) -> Inputs:
    """Return the beginning of a motion as if the recording had ended there."""
    names = ("q", "qd", "qdd", "time", "segment", "load", "torque", "temperature")
    return replace(x, **{name: getattr(x, name)[:count] for name in names})


def test_its_shape_is_told_in_words() -> None:
    joints = ("base", "elbow", "wrist")
    gear = EFFECTS["elasticity"].shape_words({"of": 1.0, "f": 3.33333, "z": 0.1}, joints)
    assert gear == {"of": "elbow", "f": "3.33", "z": "0.1"}
    assert EFFECTS["ripple"].shape_words({"order": 18.0}, joints) == {"order": "18"}


def test_joints_may_stand_in_for_samples_where_it_says_so(effect: Effect) -> None:
    if not effect.side_by_side:
        return
    q, qd, qdd = np.random.default_rng(0).normal(size=(3, JOINTS))
    together = Inputs.of(States.of(q[:, None], qd[:, None], qdd[:, None]))
    one = Inputs.of(States.of(q, qd, qdd))
    shapes = {s.name: np.geomspace(s.low, s.high, JOINTS) for s in effect.shapes}
    columns: dict[str, Any] = {name: values[:, None] for name, values in shapes.items()}
    found = effect.columns(together, 0, columns)
    for joint in range(JOINTS):
        shape = {name: float(values[joint]) for name, values in shapes.items()}
        np.testing.assert_allclose(found[joint], effect.columns(one, joint, shape)[0])
