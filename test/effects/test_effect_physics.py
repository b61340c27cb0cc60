"""What effects must obey: power, symmetry, memory, and who is made of whom."""

from dataclasses import replace

import numpy as np
import pytest
from effect_examples import motion, shape_of, shapes_of
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.signal import bilinear, lfilter

from lagrangian_ff.effects import EFFECTS, Inputs
from lagrangian_ff.effects.memory import stop, swinging
from lagrangian_ff.errors import EffectError
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]

DISSIPATES = (
    "viscous", "coulomb", "asymmetric_viscous", "stribeck", "power_law", "quadratic_drag",
    "load_friction", "load_viscous", "load_stribeck", "warm_up",
)  # fmt: skip
"""All friction but: asymmetric_coulomb (split within the smoothed step), position_friction (more
here, less there), asymmetric_step, directional_friction and temperature_friction (more one way,
under one load or below T0, less otherwise) and hysteresis (gives back what it stored)."""
OTHERS = {
    "asymmetric_coulomb", "asymmetric_step", "directional_friction", "hysteresis",
    "position_friction", "temperature_friction",
}  # fmt: skip

SAME_BOTH_WAYS = ("offset", "ripple", "gear_mesh", "spring", "counterbalance", "torque_gain")


@pytest.fixture(scope="module")
def x() -> Inputs:
    """Return a motion of three joints."""
    return motion()


def reversed_in_time(x: Inputs) -> Inputs:
    """Return the same postures and loads, moved through the other way."""
    return replace(x, qd=-x.qd)


@pytest.mark.parametrize("name", DISSIPATES)
def test_friction_takes_energy_out(name: str, x: Inputs) -> None:
    effect = EFFECTS[name]
    power = effect.columns(x, 0, shape_of(effect)) * x.qd[:, [0]]
    assert power.min() >= 0.0
    assert power.max() > 0.0


def test_every_friction_is_judged() -> None:
    friction = {name for name, effect in EFFECTS.items() if effect.kind == "friction"}
    assert friction == {*DISSIPATES, *OTHERS}


@pytest.mark.parametrize(
    "name",
    sorted({*DISSIPATES, "position_friction", "directional_friction"} - {"asymmetric_viscous"}),
)
def test_friction_turns_with_the_direction_of_motion(name: str, x: Inputs) -> None:
    effect = EFFECTS[name]
    shape = shape_of(effect)
    there, back = effect.columns(x, 1, shape), effect.columns(reversed_in_time(x), 1, shape)
    np.testing.assert_allclose(back, -there, atol=1e-15)


@pytest.mark.parametrize("name", SAME_BOTH_WAYS)
def test_what_is_no_friction_is_the_same_both_ways(name: str, x: Inputs) -> None:
    effect = EFFECTS[name]
    shape = shape_of(effect)
    there, back = effect.columns(x, 1, shape), effect.columns(reversed_in_time(x), 1, shape)
    np.testing.assert_array_equal(back, there)


def test_asymmetric_coulomb_is_coulomb_and_offset(x: Inputs) -> None:
    ours = EFFECTS["asymmetric_coulomb"].columns(x, 1, {})
    theirs = np.hstack(
        [
            EFFECTS["coulomb"].columns(x, 1, {"v0": float(x.sign_speed[1])}),
            EFFECTS["offset"].columns(x, 1, {}),
        ]
    )
    left = theirs - ours @ np.linalg.lstsq(ours, theirs, rcond=None)[0]
    np.testing.assert_allclose(left, 0.0, atol=1e-12)


def test_asymmetric_viscous_holds_viscous(x: Inputs) -> None:
    ours = EFFECTS["asymmetric_viscous"].columns(x, 2, {})
    np.testing.assert_array_equal(ours.sum(axis=1), x.qd[:, 2])


def test_a_warm_gear_has_settled(x: Inputs) -> None:
    late = replace(x, time=x.time + 1e5)
    columns = EFFECTS["warm_up"].columns(late, 0, {"T": 60.0})
    np.testing.assert_allclose(columns, 0.0, atol=1e-12)


@pytest.mark.parametrize(("order", "turn"), [(2.0, np.pi), (7.0, 2 * np.pi / 7)])
def test_ripple_repeats(order: float, turn: float, x: Inputs) -> None:
    effect = EFFECTS["ripple"]
    moved = replace(x, q=x.q + turn)
    there, again = (effect.columns(z, 0, {"order": order}) for z in (x, moved))
    np.testing.assert_allclose(again, there, atol=1e-12)


def naive_stop(q: Floats, start: float, width: float) -> Floats:
    """Return q minus the position of a slider that is pulled along with play."""
    slider = q[0] - start * width
    out = []
    for position in q:
        slider = min(max(slider, position - width), position + width)
        out.append((position - slider) / width)
    return np.array(out)


@given(
    steps=st.lists(st.floats(-5e-3, 5e-3), min_size=1, max_size=60),
    start=st.floats(-1.0, 1.0),
    width=st.floats(3e-4, 3e-2),
)
def test_stop_operator_is_a_slider_with_play(
    steps: list[float], start: float, width: float
) -> None:
    q = np.cumsum(steps)
    segment = np.zeros(q.size, dtype=np.int64)
    found = stop(q, segment, np.full(q.size, start), width)
    np.testing.assert_allclose(found, naive_stop(q, start, width), atol=1e-9)


def test_stop_operator_begins_again_in_every_stretch() -> None:
    q = np.array([0.0, 1.0, 2.0, 0.0, 0.5])
    segment = np.array([0, 0, 0, 1, 1])
    start = np.array([0.0, 9.0, 9.0, -0.5, 9.0])
    np.testing.assert_allclose(stop(q, segment, start, 1.0), [0.0, 1.0, 1.0, -0.5, 0.0])


def test_hysteresis_lives_within_the_distance_after_a_reversal() -> None:
    """Beyond twice the width it has slid, and nothing is left; before, it lags behind."""
    time = np.linspace(0.0, 2.0, 2001)
    q = 0.1 * np.abs(1.0 - time)[:, None]
    qd = np.where(time < 1.0, -0.1, 0.1)[:, None]
    x = Inputs.of(States.of(q, qd, np.zeros_like(q)), time=time, sign_speed=np.array([1e-4]))
    column = EFFECTS["hysteresis"].columns(x, 0, {"w": 5e-3})
    column = column @ (1.0, 0.0, 0.0)
    travelled = q[:, 0]
    after = time > 1.0
    np.testing.assert_allclose(column[~after][:-1], 0.0, atol=1e-9)
    np.testing.assert_allclose(column[after & (travelled > 0.0101)], 0.0, atol=1e-9)
    within = after & (travelled < 0.0099) & (travelled > 1e-4)
    assert (column[within] < 0.0).all()


def test_a_closed_loop_of_presliding_takes_energy_out() -> None:
    time = np.linspace(0.0, 4.0 * np.pi, 4001)
    q = 0.01 * np.sin(time)[:, None]
    qd = 0.01 * np.cos(time)[:, None]
    x = Inputs.of(States.of(q, qd, -q), time=time)
    settled = x.sign(0)
    torque = EFFECTS["hysteresis"].columns(x, 0, {"w": 2e-3}) @ (0.5, 0.3, 0.2) + settled
    second = time >= 2.0 * np.pi
    assert torque[second][1:] @ np.diff(q[second, 0]) > 0.0


def test_backlash_lets_the_load_go_and_gives_its_momentum_back(x: Inputs) -> None:
    load = np.where(x.time < 3.0, -4.0, 4.0)[:, None] * np.ones(3)
    reversing = replace(x, load=load)
    column = EFFECTS["backlash"].columns(reversing, 0, {"of": 0, "P": 0.08})[:, 0]
    # Across the gap at load / P: 1 = 4 t² / (2 P), t = 0.2 s.
    gap = (x.time > 3.01) & (x.time < 3.19)
    np.testing.assert_allclose(column[gap], -4.0, atol=1e-9)
    assert column[(x.time > 3.2) & (x.time < 3.25)].max() > 4.0
    assert np.abs(column[x.time < 2.98]).max() == pytest.approx(0.0, abs=1e-12)
    assert np.abs(column[x.time > 3.5]).max() < 1e-3
    assert abs(column.sum()) < 4.0  # the jump itself lies somewhere between two samples


def test_backlash_agrees_with_two_masses_and_a_dead_zone(x: Inputs) -> None:
    """The motor swings; the link, pulled by a constant force of its own, follows through the play.

    Teeth of high stiffness and critical damping are integrated in small steps.
    """
    mass, play, stiffness = 1.5, 0.02, 4e5
    loss = 2.0 * np.sqrt(stiffness * mass)
    fine = 1e-4
    t = np.arange(0.0, x.time[-1] + fine, fine)
    motor, turns = 0.3 * np.sin(2.0 * t), 0.6 * np.cos(2.0 * t)
    link, speed, carried = motor[0] + 0.5 * play, turns[0], np.zeros_like(t)
    for i in range(len(t)):
        apart = motor[i] - link
        squeezed = np.sign(apart) * max(abs(apart) - 0.5 * play, 0.0)
        push = stiffness * squeezed + (loss * (turns[i] - speed) if squeezed else 0.0)
        carried[i] = push if push * squeezed > 0.0 else 0.0
        speed += fine * carried[i] / mass
        link += fine * speed
    load = (-1.2 * mass * np.sin(2.0 * x.time))[:, None] * np.ones(3)
    shape = {"of": 0, "P": mass * play}
    column = EFFECTS["backlash"].columns(replace(x, load=load), 0, shape)[:, 0]
    width = round(np.median(np.diff(x.time)) / fine)
    true = np.convolve(carried, np.full(width, 1.0 / width), "same")[::width][: len(x)]
    settled = x.time > 1.0
    both = np.stack([column, true - load[:, 0]], axis=1)
    around = gaussian_filter1d(both, 6.0, axis=0, mode="nearest", truncate=3.0)[settled]
    assert np.asarray(np.corrcoef(around.T))[0, 1] > 0.8


def test_delay_is_torque_of_a_moment_before(x: Inputs) -> None:
    """To first order: the torque of a motion whose torque came 2 ms late."""
    late = 0.002
    torque = np.sin(3.0 * x.time)[:, None] * np.ones(3)
    column = EFFECTS["delay"].columns(replace(x, torque=torque), 1, {})[:, 0]
    true = np.sin(3.0 * (x.time - late)) - np.sin(3.0 * x.time)
    np.testing.assert_allclose(late * column[1:-1], true[1:-1], atol=1e-4)


def test_elasticity_is_a_mass_behind_a_spring(x: Inputs) -> None:
    """The motor moves as waves; what the spring carries of them is exact, resonance and all."""
    mass, stiffness, damping = 2.0, 1500.0, 0.08
    w0 = np.sqrt(stiffness / mass)
    orders = np.array([3.0, 9.0, 20.0, 40.0])
    s = 1j * orders
    passed = (2 * damping * w0 * s + w0**2) / (s**2 + 2 * damping * w0 * s + w0**2)
    # (M s² q) of the motor's waves, and that behind the spring.
    waves = np.exp(1j * np.outer(x.time, orders)) * -mass * orders**2
    load, true = waves.sum(axis=1).imag, (waves @ passed).imag
    moving = replace(x, load=np.stack([load] * 3, axis=1))
    shape = {"of": 1, "f": w0 / (2 * np.pi), "z": damping}
    column = EFFECTS["elasticity"].columns(moving, 1, shape)[:, 0]
    settled = x.time > 4.0  # what swings freely from the start has died out
    error = (column - (true - load))[settled]
    assert np.sqrt(np.mean(error**2)) < 0.05 * np.sqrt(np.mean((true - load)[settled] ** 2))


def test_elasticity_lets_what_is_slow_pass(x: Inputs) -> None:
    slow = replace(x, load=5.0 + np.sin(0.2 * x.time)[:, None] * np.ones(3))
    column = EFFECTS["elasticity"].columns(slow, 1, {"of": 1, "f": 5.0, "z": 0.1})[:, 0]
    assert np.abs(column[x.time > 2.0]).max() < 1e-3


def test_a_resonance_is_scipys_filter() -> None:
    values = 3.0 + np.cumsum(np.random.default_rng(0).normal(size=500))
    step, w, damping = 0.004, 2.0 * np.pi * 5.0, 0.1
    continuous = [2.0 * damping * w, w * w], [1.0, 2.0 * damping * w, w * w]
    numerator, denominator = bilinear(*continuous, fs=1.0 / step)
    expected = values[0] + lfilter(numerator, denominator, values - values[0])
    np.testing.assert_allclose(swinging(values, step, w, damping), expected, rtol=1e-10)


@pytest.mark.parametrize("name", ["elasticity", "backlash"])
def test_a_gear_that_gives_way_shakes_other_joints_as_its_own(name: str, x: Inputs) -> None:
    effect = EFFECTS[name]
    shape = {**effect.candidates(x, 2)[0]}
    assert shape["of"] == 2.0
    np.testing.assert_array_equal(effect.columns(x, 0, shape), effect.columns(x, 2, shape))
    assert effect.cause(0, shape) == 2
    assert {round(one["of"]) for one in effect.candidates(x, 0)} == {0, 1, 2}
    with pytest.raises(EffectError, match=f"'{name}': there is no joint 7; expected 0 to 2"):
        effect.columns(x, 0, {**shape, "of": 7.0})


def test_inertia_missing_in_the_load_is_made_up_for(x: Inputs) -> None:
    """Two parameters span what the gear carries, however much of qdd the load lacks."""
    shape = {"of": 1.0, "f": 4.0, "z": 0.1}
    right = replace(x, load=x.load + 3.0 * x.qdd)
    true = EFFECTS["elasticity"].columns(right, 1, shape)[:, 0]
    columns = EFFECTS["elasticity"].columns(x, 1, shape)
    np.testing.assert_allclose(columns @ (1.0, 3.0), true, atol=1e-9)


def test_saturation_gives_the_limit(x: Inputs) -> None:
    column = EFFECTS["saturation"].columns(x, 0, {"L": 10.0})[:, 0]
    np.testing.assert_allclose(x.torque[:, 0] + column, np.clip(x.torque[:, 0], -10.0, 10.0))


def test_a_payload_is_there_from_its_moment_on(x: Inputs) -> None:
    columns = EFFECTS["payload"].columns(x, 0, {"t0": 4.0})
    assert not columns[x.time < 4.0].any()
    assert columns[x.time >= 4.0].any(axis=0).all()


def test_a_contact_ends(x: Inputs) -> None:
    column = EFFECTS["contact"].columns(x, 0, {"t0": 4.0, "length": 2.0})[:, 0]
    np.testing.assert_array_equal(column, ((x.time >= 4.0) & (x.time < 6.0)).astype(float))


@pytest.mark.parametrize("name", ["payload", "contact"])
def test_events_need_time(name: str, x: Inputs) -> None:
    assert EFFECTS[name].candidates(x, 0)
    assert not EFFECTS[name].candidates(replace(x, time=np.full(len(x), np.inf)), 0)


def test_coupled_joints_stick_where_their_speeds_cancel(x: Inputs) -> None:
    together = replace(x, qd=np.stack([x.qd[:, 0], -x.qd[:, 0], x.qd[:, 2]], axis=1))
    effect = EFFECTS["coupled"]
    np.testing.assert_array_equal(effect.columns(together, 0, {"partner": 1, "ratio": 1}), 0.0)
    assert effect.columns(together, 0, {"partner": 1, "ratio": -1}).any()
    assert {s["partner"] for s in effect.candidates(x, 1)} == {0.0, 2.0}


def test_a_partner_that_is_not_there_is_named(x: Inputs) -> None:
    with pytest.raises(EffectError, match="joint 7 is no partner"):
        EFFECTS["coupled"].columns(x, 0, {"partner": 7, "ratio": 1})


def test_eccentricity_is_what_a_bent_coordinate_leaves() -> None:
    """One joint of inertia J in a field of gravity, seen through an encoder off its centre.

    In the reported angle Q = q + e cos(q + f) its Lagrangian gives torque · dq/dQ; the effect
    makes of it, to first order in e, the torque itself.
    """
    e, phase = 1e-3, 0.7
    q = np.linspace(-3.0, 3.0, 200)
    torque = 1.5 * np.sin(2.0 * q) + 3.0 * np.cos(q)
    seen = q + e * np.cos(q + phase)
    load = (torque / (1.0 - e * np.sin(q + phase)))[:, None]
    still = np.zeros_like(load)
    x = Inputs.of(States.of(seen[:, None], still, still), load=load)
    parameters = np.array([-e * np.sin(phase), -e * np.cos(phase)])
    found = load[:, 0] + EFFECTS["eccentricity"].columns(x, 0, {}) @ parameters
    np.testing.assert_allclose(found, torque, atol=1e-5)


def test_a_counterbalance_is_the_rate_of_its_length() -> None:
    """Torque is force times d length / dq, with the length from the law of cosines."""
    q, r, q0 = np.linspace(0.0, 6.0, 5001), 0.4, 1.1
    length = np.sqrt(1.0 + r**2 - 2.0 * r * np.cos(q - q0))
    still = np.zeros((q.size, 1))
    x = Inputs.of(States.of(q[:, None], still, still))
    column = EFFECTS["counterbalance"].columns(x, 0, {"r": r, "q0": q0})[:, 0]
    np.testing.assert_allclose(r * column[1:-1], np.gradient(length, q)[1:-1], atol=1e-5)


@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_a_gap_in_the_recording_is_not_bridged(name: str, x: Inputs) -> None:
    """Two stretches in one recording give what each gives alone."""
    effect = EFFECTS[name]
    shape = shapes_of(effect, x, 0)[0]
    half = len(x) // 2
    parts = (np.arange(half), np.arange(half, len(x)))
    torn = replace(x, segment=(np.arange(len(x)) >= half).astype(np.int64))
    alone = [effect.columns(replace(torn.take(part), whole=None), 0, shape) for part in parts]
    np.testing.assert_allclose(effect.columns(torn, 0, shape), np.vstack(alone), atol=1e-12)


def test_samples_may_be_means_of_their_neighbours(x: Inputs) -> None:
    """Of the motion and of columns alike, never across a segment."""
    torn = replace(x, segment=(np.arange(len(x)) >= 400).astype(np.int64))
    index = np.array([0, 10, 398, 402, 700])
    some = torn.take(index, 7)
    np.testing.assert_allclose(some.qd[1], x.qd[7:14].mean(axis=0))
    np.testing.assert_allclose(some.qd[2], x.qd[395:400].mean(axis=0))
    np.testing.assert_allclose(some.qd[3], x.qd[400:406].mean(axis=0))
    np.testing.assert_allclose(some.qd[0], x.qd[:4].mean(axis=0))
    fewer = some.take(np.array([1, 4]))
    np.testing.assert_allclose(fewer.q, some.q[[1, 4]])
    columns = Term(EFFECTS["coulomb"], 1, {"v0": 0.05}).columns(fewer)
    every = EFFECTS["coulomb"].columns(torn, 1, {"v0": 0.05})
    np.testing.assert_allclose(columns[0], every[7:14].mean(axis=0))


def test_what_follows_the_load_asks_which_inertia_is_the_rotors(x: Inputs) -> None:
    """Only where that matters; without a shape the load is taken as it is."""
    gravity_free = replace(x, load=1.0 * x.qdd, rotor=np.array([3.0, 0.0, 0.02]))
    effect = EFFECTS["load_friction"]
    tried = [shape["Jr"] for shape in effect.candidates(gravity_free, 0)]
    assert tried == pytest.approx([3.0, 1e-6, 1.0, 2.0])
    all_link = replace(gravity_free, rotor=np.zeros(3))
    assert [shape["Jr"] for shape in effect.candidates(all_link, 0)] == pytest.approx(
        [1e-6, 0.25, 0.5, 0.75]
    )
    heavy = replace(gravity_free, load=gravity_free.load + 100.0)
    assert [shape["Jr"] for shape in effect.candidates(heavy, 0)] == [3.0]
    column = effect.columns(gravity_free, 0, {"Jr": 1.0})[:, 0]
    np.testing.assert_allclose(column, np.abs(3.0 * x.qdd[:, 0]) * x.sign(0))
    as_it_is = effect.columns(gravity_free, 0, {})[:, 0]
    np.testing.assert_allclose(as_it_is, np.abs(x.qdd[:, 0]) * x.sign(0))
    assert {shape["Jr"] for shape in EFFECTS["gear_mesh"].candidates(gravity_free, 0)} == set(tried)
