"""Drive gains of a double pendulum, in closed form, from motion with and without a load."""

from dataclasses import replace

import numpy as np
import pytest
from mechanism_examples import pendulum_urdf
from numpy.typing import NDArray
from pendulum import motion, rigid_torque

from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.drive_gains import DriveGains, drive_gains
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.rigid import Robot, robot_of
from lagrangian_ff.recording import Conditioning, Motion

pytest.importorskip("pinocchio", reason="Pinocchio, the extra urdf, is not installed")

Floats = NDArray[np.float64]
GAINS = np.array([6.2, -0.8])
UPPER = 0.5  # m


@pytest.fixture(scope="module")
def robot() -> Robot:
    """Return the pendulum's kinematics, with masses that are wrong."""
    return robot_of(pendulum_urdf(7.0, 0.3), "wrong.urdf")


def load_torque(x: States, mass: float, reach: float, heavy: float = 9.81) -> Floats:
    """(M, 2) N·m of a point mass on the lower rod."""
    c, s = np.cos(x.q[:, 1]), np.sin(x.q[:, 1])
    both = reach**2 + UPPER * reach * c
    first = (UPPER**2 + both + UPPER * reach * c) * x.qdd[:, 0] + both * x.qdd[:, 1]
    first -= UPPER * reach * s * (2.0 * x.qd[:, 0] * x.qd[:, 1] + x.qd[:, 1] ** 2)
    second = both * x.qdd[:, 0] + reach**2 * x.qdd[:, 1] + UPPER * reach * s * x.qd[:, 0] ** 2
    tip = heavy * reach * np.cos(x.q[:, 0] + x.q[:, 1])
    first += heavy * UPPER * np.cos(x.q[:, 0]) + tip
    return mass * np.stack([first, second + tip], axis=1)


def recorded(
    seed: int, mass: float = 0.0, reach: float = 0.4, seconds: float = 40.0, gravity: bool = True
) -> Motion:
    """A recording in units of effort, with 1 % of noise."""
    whole = motion(seconds, seed=seed)
    x = States.of(whole.q, whole.qd, whole.qdd)
    tau = whole.tau + load_torque(x, mass, reach, 9.81 if gravity else 0.0)
    if not gravity:
        tau = tau - rigid_torque(x.at_rest())
    noise = 0.01 * tau.std(axis=0) * np.random.default_rng(seed + 50).normal(size=tau.shape)
    kind = Conditioning(effort="total" if gravity else "without-gravity").record()
    return replace(whole, tau=(tau + noise) / GAINS, conditioning=kind, source=f"run_{seed}")


def within(found: DriveGains) -> list[bool]:
    return [
        one.gain.low < gain < one.gain.high for one, gain in zip(found.each, GAINS, strict=True)
    ]


@pytest.mark.parametrize("centre", [None, (0.4, 0.0, 0.0)])
def test_gains_of_any_size_and_sign_without_knowing_the_masses(
    robot: Robot, centre: tuple[float, float, float] | None
) -> None:
    found = drive_gains([recorded(0), recorded(1)], recorded(2, 1.5), robot, 1.5, centre)
    for one, gain in zip(found.each, GAINS, strict=True):
        assert one.known
        assert 0.5 < one.share < 1.0
        assert one.gain.value == pytest.approx(gain, rel=0.02)
        assert one.gain.low < one.gain.value < one.gain.high
    assert found.centre[0] == pytest.approx(0.4, abs=0.01)
    assert found.error == pytest.approx([0.05, 0.02], abs=0.06)


def test_nine_of_ten_intervals_hold_the_gain(robot: Robot) -> None:
    runs = [
        drive_gains(recorded(k, seconds=20.0), recorded(k + 100, 1.0, seconds=20.0), robot, 1.0)
        for k in range(12)
    ]
    held = np.array([within(found) for found in runs])
    assert 0.75 <= held.mean() <= 1.0
    width = [one.gain.high / one.gain.low for found in runs for one in found.each]
    assert np.median(width) < 1.1


def test_the_mass_sets_the_scale(robot: Robot) -> None:
    empty, carrying = recorded(0), recorded(2, 1.5)
    right, double = (drive_gains(empty, carrying, robot, mass) for mass in (1.5, 3.0))
    for one, other in zip(right.each, double.each, strict=True):
        assert other.gain.value == pytest.approx(2.0 * one.gain.value, rel=1e-3)


def test_an_effort_without_gravity_will_do(robot: Robot) -> None:
    empty, carrying = recorded(0, gravity=False), recorded(2, 1.5, gravity=False)
    for one, gain in zip(drive_gains(empty, carrying, robot, 1.5).each, GAINS, strict=True):
        assert one.gain.value == pytest.approx(gain, rel=0.05)


def test_without_a_load_no_gain_is_claimed(robot: Robot) -> None:
    """What is named as loaded carries nothing: any gain would do."""
    found = drive_gains(recorded(0), recorded(2), robot, 1.5)
    assert not any(one.known for one in found.each)


def test_exchanged_recordings_are_refused(robot: Robot) -> None:
    with pytest.raises(ModelError, match="friction would drive every joint"):
        drive_gains(recorded(2, 1.5), recorded(0), robot, 1.5)


def test_a_contact_is_left_out(robot: Robot) -> None:
    carrying = recorded(2, 1.5)
    touched = carrying.tau.copy()
    touched[2000:2100] += 30.0 / GAINS
    found = drive_gains(recorded(0), replace(carrying, tau=touched), robot, 1.5)
    assert [one.gain.value for one in found.each] == pytest.approx(GAINS.tolist(), rel=0.02)
    assert found.left_out == ("run_2 from 20.0 s",)


def test_what_cannot_work_is_refused(robot: Robot) -> None:
    empty, carrying = recorded(0, seconds=20.0), recorded(2, 1.5, seconds=8.0)
    with pytest.raises(ModelError, match=r"4 blocks of 2 s of motion with the load"):
        drive_gains(empty, carrying, robot, 1.5)
    with pytest.raises(ModelError, match="the payload is 0"):
        drive_gains(empty, empty, robot, 0.0)
