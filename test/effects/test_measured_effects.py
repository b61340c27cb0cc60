"""Effects known from measured arms and servos, compared with the equations of their states."""

from dataclasses import replace

import numpy as np
import pytest
from effect_examples import motion
from numpy.typing import NDArray

from lagrangian_ff.effects import EFFECTS, Inputs
from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]


@pytest.fixture(scope="module")
def x() -> Inputs:
    """Return a motion of three joints."""
    return motion(30.0)


def fitted(x: Inputs, true: Floats, *terms: tuple[str, dict[str, float]]) -> tuple[Floats, float]:
    """Return the parameters of some effects that fit a torque, and the rms of what they leave."""
    columns = np.hstack([EFFECTS[name].columns(x, 1, shape) for name, shape in terms])
    found = np.asarray(np.linalg.lstsq(columns, true, rcond=None)[0], dtype=np.float64)
    return found, float(np.sqrt(np.mean((columns @ found - true) ** 2)))


def test_a_gear_that_both_sides_press_has_two_weights(x: Inputs) -> None:
    """The motor has to overcome the friction that its own torque causes: solved by bisection."""
    dry, viscous, of_motor, of_load, at_rest, creep = 1.5, 0.8, 0.12, 0.07, 0.1, 0.2
    sign = np.tanh(x.qd[:, 1] / x.sign_speed[1])
    load, speed = x.load[:, 1], x.qd[:, 1]

    def missing(motor: Floats) -> Floats:
        pressed = of_motor * np.abs(motor) + of_load * np.abs(load)
        bump = at_rest * np.abs(load) * np.exp(-((speed / creep) ** 2))
        return motor - load - viscous * speed - sign * (dry + pressed + bump)

    low, high = np.full_like(load, -500.0), np.full_like(load, 500.0)
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = missing(middle) > 0.0
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    motor = 0.5 * (low + high)
    seen = replace(x, torque=np.stack([motor] * 3, axis=1))
    found, left = fitted(
        seen, motor - load, ("coulomb", {"v0": 0.05}), ("viscous", {}), ("load_friction", {}),
        ("directional_friction", {}), ("load_stribeck", {"v_s": creep}),
    )  # fmt: skip
    np.testing.assert_allclose(found, (dry, viscous, of_motor + of_load, of_motor, at_rest), 1e-6)
    assert left < 1e-6


def test_the_panda_s_friction_is_a_step_and_its_uneven_part(x: Inputs) -> None:
    """Gaz and others 2019: p1 / (1 + exp(-p2 (qd + p3))) - const, of joints 1 to 4."""
    for p1, p2, p3 in ((0.55, 5.1, 0.040), (0.87, 9.1, 0.026), (0.64, 10.1, -0.046)):
        true = p1 / (1.0 + np.exp(-p2 * (x.qd[:, 1] + p3))) - p1 / (1.0 + np.exp(-p2 * p3))
        width = 2.0 / p2
        even = ("coulomb", {"v0": width})
        (step, uneven), left = fitted(x, true, even, ("asymmetric_step", {"w": width}))
        _, without = fitted(x, true, even)
        assert step == pytest.approx(p1 / 2.0, rel=0.1)
        assert uneven == pytest.approx(-step * p3 / width, rel=0.2)
        assert left < 0.35 * without


def small_strokes() -> Inputs:
    """Return reversals of 0.5 to 50 mrad of three joints, in steps of a millisecond."""
    time = np.arange(0.0, 12.0, 1e-3)
    size = 0.05 * np.exp(-np.abs(time - 6.0) / 1.3) + 5e-4
    q = (size * np.sin(6.0 * time))[:, None] * np.ones(3)
    qd = np.gradient(q, time, axis=0)
    x = Inputs.of(States.of(q, qd, np.zeros_like(q)), time=time)
    return replace(x, sign_speed=np.full(3, 1e-3))


@pytest.mark.parametrize("spread", [1.0, 30.0])
def test_presliding_is_what_many_contacts_do(spread: float) -> None:
    """Generalised Maxwell slip: ten massless blocks on springs, each with its own breakaway force.

    A block moves as soon as its spring pulls with that force; widths lie within a factor `spread`.
    """
    x = small_strokes()
    widths = 2e-3 * np.geomspace(1.0 / np.sqrt(spread), np.sqrt(spread), 10)
    block, true = np.full(10, -1.0) * widths, np.empty(len(x))  # they slide already, forwards
    for k, q in enumerate(x.q[:, 1]):
        spring = q - block
        over = np.abs(spread_of := spring / widths) > 1.0
        block = np.where(over, q - np.sign(spread_of) * widths, block)
        true[k] = np.sum((q - block) / widths) / 10.0
    several, one = (
        min(
            fitted(x, true, ("coulomb", {"v0": 1e-3}), ("hysteresis", {"w": w}))[1]
            if whole
            else single(x, true, w)
            for w in np.geomspace(2e-4, 4e-3 if whole else 3e-2, 25).tolist()
        )
        for whole in (True, False)
    )
    assert several < 0.05
    assert spread == 1.0 or several < 0.4 * one


def single(x: Inputs, true: Floats, width: float) -> float:
    """Return the rms that one contact of a width leaves, besides Coulomb friction."""
    first = EFFECTS["hysteresis"].columns(x, 1, {"w": width})[:, :1]
    columns = np.hstack([first, EFFECTS["coulomb"].columns(x, 1, {"v0": 1e-3})])
    found, *_ = np.linalg.lstsq(columns, true, rcond=None)
    return float(np.sqrt(np.mean((columns @ found - true) ** 2)))


@pytest.mark.parametrize("degrees", [0.3, 1.0, 2.0])
def test_a_servo_s_backlash(degrees: float, x: Inputs) -> None:
    """A motor that swings a link of 0.02 kg·m² about its weight, through teeth with play.

    The teeth are stiff springs with critical damping, integrated in steps of 50 µs.
    """
    mass, play, fine = 0.02, np.deg2rad(degrees), 5e-5
    stiffness = 2e3
    loss = 2.0 * np.sqrt(stiffness * mass)
    t = np.arange(0.0, 10.0, fine)
    motor, turns = np.sin(3.0 * t), 3.0 * np.cos(3.0 * t)
    weight = 0.6 * np.sin(motor)
    link, speed, carried = float(motor[0]), float(turns[0]), np.zeros_like(t)
    for i, (at, going, pull) in enumerate(
        zip(motor.tolist(), turns.tolist(), weight.tolist(), strict=True)
    ):
        apart = at - link
        push = 0.0
        if abs(apart) > 0.5 * play:
            squeezed = apart - np.copysign(0.5 * play, apart)
            push = stiffness * squeezed + loss * (going - speed)
            push = push if push * squeezed > 0.0 else 0.0
        carried[i] = push
        speed += fine * (push - pull) / mass
        link += fine * speed
    every = round(0.01 / fine)
    time = t[::every]
    true = carried.reshape(-1, every).mean(axis=1)
    load = (-9.0 * mass * motor + weight).reshape(-1, every).mean(axis=1)
    still = np.zeros((len(time), 3))
    seen = Inputs.of(States.of(still, still, still), time, load=np.stack([load] * 3, axis=1))
    smooth = np.hanning(15) / np.hanning(15).sum()
    best = max(
        float(np.corrcoef(np.convolve(c, smooth, "same")[100:-10],
                          np.convolve(true - load, smooth, "same")[100:-10])[0, 1])
        for shape in EFFECTS["backlash"].candidates(seen, 0)[:9]
        for c in [EFFECTS["backlash"].columns(seen, 0, shape)[:, 0]]
    )  # fmt: skip
    assert best > 0.7
