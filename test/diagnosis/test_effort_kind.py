"""What the torques show of what the effort holds: gravity, friction, or not surely either."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pendulum import friction_torque, motion, rigid_torque

from lagrangian_ff.diagnosis.preflight.effort_kind import effort_kind, kind_checks
from lagrangian_ff.kernels import States
from lagrangian_ff.recording import Conditioning, Motion, condition, load

EFFORTS = ("total", "without-gravity", "without-friction")


def pendulum(seed: int, effort: str, *, gravity: float = 1.0, friction: float = 1.0) -> Motion:
    """Return a double pendulum, read as `effort`, with 2 % of noise and shares of its torques."""
    whole = motion(seed=seed, noise=0.02)
    x = States.of(whole.q, whole.qd, whole.qdd)
    less = (1.0 - gravity) * rigid_torque(x.at_rest()) + (1.0 - friction) * friction_torque(x)
    return replace(whole, tau=whole.tau - less, conditioning=Conditioning(effort=effort).record())


def said(motion: Motion) -> str:
    return " / ".join(check.finding for check in kind_checks(motion))


@pytest.mark.parametrize("seed", [0, 1])
def test_torque_that_holds_all_is_read_as_it_is(seed: int) -> None:
    whole = pendulum(seed, "total")
    assert said(whole) == ""
    found = effort_kind(whole)
    assert found is not None
    assert found.gravity > 100.0
    assert all(share.low > 0.05 for share in found.friction)


@pytest.mark.parametrize("seed", [0, 1])
def test_gravity_that_the_driver_removed(seed: int) -> None:
    without = pendulum(seed, "total", gravity=0.0)
    (check,) = kind_checks(without)
    assert "--effort without-gravity" in check.advice
    assert "or no joint works against it" in check.finding
    assert check.values["half gravity, log BF"] < -5.0
    assert not check.serious
    told = replace(without, conditioning=Conditioning(effort="without-gravity").record())
    assert said(told) == ""


def test_gravity_in_an_effort_that_is_said_to_have_none() -> None:
    (check,) = kind_checks(pendulum(0, "without-gravity"))
    assert check.serious
    assert "--effort total" in check.advice


def test_gravity_that_the_driver_removed_in_part() -> None:
    (check,) = kind_checks(pendulum(0, "without-gravity", gravity=0.1))
    assert "some gravity is left" in check.finding
    assert 0.02 < check.values["gravity, share"] < 0.15
    assert not check.serious


@pytest.mark.parametrize("seed", [0, 1])
def test_friction_that_the_drive_compensates(seed: int) -> None:
    without = pendulum(seed, "total", friction=0.0)
    (check,) = kind_checks(without)
    assert "--effort without-friction" in check.advice
    assert "sensed behind the gear" in check.finding
    told = replace(without, conditioning=Conditioning(effort="without-friction").record())
    assert said(told) == ""


def test_friction_that_is_left_over() -> None:
    (check,) = kind_checks(pendulum(0, "without-friction", friction=0.5))
    assert "left over" in check.finding
    assert "auto+fri" in check.advice
    shares: Mapping[str, float] = check.values
    assert 0.05 < shares["shoulder, low"] < shares["shoulder"] < shares["shoulder, high"]


@pytest.mark.parametrize("sign", [(-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)])
@pytest.mark.parametrize("seed", [0, 1])
def test_friction_that_drives_has_the_wrong_sign(seed: int, sign: tuple[float, float]) -> None:
    whole = pendulum(seed, "total")
    (check,) = kind_checks(replace(whole, tau=whole.tau * sign))
    assert check.check == "effort sign"
    assert check.serious
    turned = [joint for joint, one in zip(whole.joints, sign, strict=True) if one < 0.0]
    assert check.joint == (turned[0] if len(turned) == 1 else None)
    assert check.remedy is not None
    assert check.remedy.option in check.advice
    mended = check.remedy.applied(Conditioning())
    assert mended.effort_scale == dict.fromkeys(turned, -1.0)


def test_a_drive_that_gives_more_than_it_loses_has_its_sign() -> None:
    much = replace(
        pendulum(0, "total", friction=-0.5),
        conditioning=Conditioning(effort="without-friction").record(),
    )
    assert "sign" not in said(much)


@pytest.mark.parametrize(
    ("effort", "shares", "read"),
    [("total", {"gravity": 0.0}, "without-gravity"), ("without-gravity", {}, "total"),
     ("total", {"friction": 0.0}, "without-friction")],
)  # fmt: skip
def test_the_remedy_is_what_the_advice_says(
    effort: str, shares: dict[str, float], read: str
) -> None:
    (check,) = kind_checks(pendulum(0, effort, **shares))
    assert check.remedy is not None
    assert check.remedy.option in check.advice
    assert check.remedy.applied(Conditioning(effort=effort)).effort == read


def test_too_little_motion_shows_nothing() -> None:
    short = pendulum(0, "total", gravity=0.0).take(slice(0, 300))
    assert effort_kind(short) is None
    assert effort_kind(replace(short, tau=np.zeros_like(short.tau))) is None


@pytest.mark.parametrize(
    "file", ["kuka_lwr4/measurements_1.npz", "kuka_lwr4/measurements_3.npz",
             "ur10/ur10_exciting_trajectory/ur10_exciting_trajectory.db3"]
)  # fmt: skip
def test_measured_arms_hold_all(shared_data: Path, file: str) -> None:
    recording = load(shared_data / file)
    assert said(condition(recording)) == ""
    (check,) = kind_checks(condition(recording, Conditioning(effort="without-gravity")))
    assert check.serious
