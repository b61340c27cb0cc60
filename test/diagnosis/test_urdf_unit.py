"""An effort that is no torque in N·m, seen with the masses of a URDF."""

from dataclasses import replace

import numpy as np
import pytest
from mechanism_examples import pendulum_urdf
from pendulum import motion

from lagrangian_ff.diagnosis.preflight.urdf_unit import urdf_unit_checks
from lagrangian_ff.kernels.rigid import Robot, robot_of

pytest.importorskip("pinocchio", reason="Pinocchio, the extra urdf, is not installed")


@pytest.fixture(params=[(2.0, 1.0), (2.6, 0.75)], ids=["right", "wrong"])
def robot(request: pytest.FixtureRequest) -> Robot:
    """Return the pendulum, with its own masses and with masses that are off by a quarter."""
    return robot_of(pendulum_urdf(*request.param), "pendulum.urdf")


def test_newton_metres_are_no_fault(robot: Robot) -> None:
    assert urdf_unit_checks(motion(noise=0.02), robot) == []


@pytest.mark.parametrize("unit", [1.0 / 6.0, 1000.0])
def test_another_unit(robot: Robot, unit: float) -> None:
    whole = motion(noise=0.02)
    (check,) = urdf_unit_checks(replace(whole, tau=unit * whole.tau), robot)
    assert "seems not to be in N·m" in check.finding
    assert "calibrate" in check.advice
    for factor in check.values.values():
        assert factor == pytest.approx(unit, rel=0.5)


def test_a_load_or_an_effort_without_gravity_is_no_unit(robot: Robot) -> None:
    whole = motion(noise=0.02)
    q = whole.q
    tip = 9.81 * 0.4 * np.cos(q[:, 0] + q[:, 1])
    load = 4.0 * np.stack([9.81 * 0.5 * np.cos(q[:, 0]) + tip, tip], axis=1)
    assert urdf_unit_checks(replace(whole, tau=whole.tau + load), robot) == []
    told = {"effort": "without-gravity"}
    assert urdf_unit_checks(replace(whole, tau=whole.tau / 6.0, conditioning=told), robot) == []
