"""Single false samples are found and left out; what an arm really does is not."""

from dataclasses import replace

import numpy as np
import pytest
from recording_examples import SHARED, swinging

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording import Recording, condition, inspect, load

BASE = swinging(4000)
"""Three joints that swing for 8 s at 500 Hz."""


def noisy(seed: int = 0) -> Recording:
    generator = np.random.default_rng(seed)
    return replace(
        BASE,
        position=BASE.position + generator.normal(scale=1e-5, size=BASE.position.shape),
        effort=BASE.effort + generator.normal(scale=0.1, size=BASE.effort.shape),
    )


def with_value(
    recording: Recording, quantity: str, rows: slice, joint: int, value: float
) -> Recording:
    table = getattr(recording, quantity).copy()
    table[rows, joint] = value
    return replace(recording, **{quantity: table})


@pytest.mark.parametrize("value", [2000.0, -400.0, 1e200, 1.7e308])
def test_a_false_effort_is_told_and_changes_nothing(value: float) -> None:
    spoilt = with_value(noisy(), "effort", slice(1500, 1501), 1, value)
    (found,) = inspect(spoilt).outliers
    assert (found.joint, found.quantity, found.sample, found.value) == (
        "elbow",
        "effort",
        1500,
        value,
    )
    assert found.time == pytest.approx(3.0)
    assert any("elbow: effort of" in line and "sample 1501 at 3.000 s" in line
               for line in inspect(spoilt).lines())  # fmt: skip
    motion, clean = condition(spoilt), condition(noisy())
    assert any("elbow: effort of" in note and note.endswith("left out") for note in motion.notes)
    assert not any("no effort in" in note for note in motion.notes)
    assert np.allclose(motion.tau, clean.tau, atol=0.1)


@pytest.mark.parametrize("quantity", ["position", "velocity"])
@pytest.mark.parametrize("samples", [1, 2])
def test_false_positions_and_velocities_are_left_out(quantity: str, samples: int) -> None:
    spoilt = with_value(noisy(), quantity, slice(800, 800 + samples), 2, 17.0)
    found = inspect(spoilt).outliers
    assert [(one.quantity, one.sample) for one in found] == [
        (quantity, 800 + k) for k in range(samples)
    ]
    assert np.allclose(condition(spoilt).qdd, condition(noisy()).qdd, atol=0.5)


def test_several_near_each_other_are_all_found() -> None:
    effort = noisy().effort.copy()
    for row in (1000, 1004, 1010, 3998, 0):
        effort[row, 0] = 900.0
    found = inspect(replace(noisy(), effort=effort)).outliers
    assert {one.sample for one in found} == {0, 1000, 1004, 1010, 3998}


def contact(width: float) -> Floats:
    """A blow that a drive's low-pass of 1 ms has rounded, in N·m."""
    since = np.maximum(BASE.time - 3.0, 0.0)
    return 60.0 * (np.exp(-since / width) - np.exp(-since / 1e-3))


def kicked() -> Recording:
    """A torque of one sample that moves the joint."""
    effort, position = noisy().effort.copy(), noisy().position.copy()
    effort[1500, 0] -= 12.0
    position[:, 0] -= 0.3 * np.maximum(BASE.time - 3.0, 0.0) * np.exp(-(BASE.time - 3.0))
    return replace(noisy(), effort=effort, position=position)


def genuine() -> dict[str, Recording]:
    base = noisy()
    square = np.where(np.sin(7.0 * BASE.time) > 0.0, 40.0, -40.0)
    stick = 30.0 * ((BASE.time * 12.0) % 1.0)
    lost = np.delete(np.arange(4000), slice(2000, 2060))
    rng = np.random.default_rng(1)
    late = np.argsort(np.arange(4000) + 3.0 * (rng.random(4000) < 0.01), kind="stable")
    held = np.repeat(base.effort[::4], 4, axis=0)
    return {
        "clean": BASE,
        "a short contact": replace(base, effort=base.effort + contact(4e-3)[:, None]),
        "a long contact": replace(base, effort=base.effort + contact(0.1)[:, None]),
        "hard reversals": replace(base, effort=base.effort + square[:, None]),
        "stick and slip": replace(base, effort=base.effort + stick[:, None]),
        "lost samples": taken(base, lost),
        "samples out of order": taken(base, late),
        "effort at a lower rate": replace(base, effort=held),
        "a coarse encoder": replace(base, position=np.round(base.position, 3)),
        "a coarse effort": replace(base, effort=np.round(base.effort)),
        "heavy noise": replace(base, effort=base.effort + rng.laplace(size=base.effort.shape)),
        "spikes all the time": replace(
            base, effort=base.effort + 50.0 * (rng.random(base.effort.shape) < 0.02)
        ),
        "a kick that moves the arm": kicked(),
    }


def taken(recording: Recording, rows: Ints) -> Recording:
    position, velocity, effort = (
        recording.tables[name][rows] for name in ("position", "velocity", "effort")
    )
    return Recording(recording.joints, recording.time[rows], position, velocity, effort)


@pytest.mark.parametrize("name", genuine())
def test_what_an_arm_does_is_no_outlier(name: str) -> None:
    assert inspect(genuine()[name]).outliers == ()


@pytest.mark.parametrize(
    "relative",
    ["ur10/ur10_exciting_trajectory/ur10_exciting_trajectory.db3", "kuka_lwr4/measurements_1.npz"],
)
def test_measured_arms_have_none(relative: str) -> None:
    path = SHARED / relative
    if not path.exists():
        pytest.skip(f"the measured recording {relative} is not at hand")
    assert inspect(load(path)).outliers == ()


def test_clipping_is_seen_beside_an_outlier() -> None:
    clipped = replace(BASE, effort=np.clip(BASE.effort, -8.0, 8.0))
    spoilt = with_value(clipped, "effort", slice(700, 701), 1, 2000.0)
    seen, expected = inspect(spoilt).clipping, inspect(clipped).clipping
    assert [one.value for one in seen] == [one.value for one in expected] != []


def test_wild_efforts_in_a_row_are_refused_with_their_place() -> None:
    spoilt = with_value(noisy(), "effort", slice(1500, 1505), 1, 1e200)
    with pytest.raises(
        RecordingError, match=r"5 effort values beyond 1e\+09, first 1e\+200 of elbow"
    ):
        condition(spoilt)


def test_constant_effort_of_every_joint_is_refused() -> None:
    with pytest.raises(RecordingError, match="the effort of every joint is constant"):
        condition(replace(BASE, effort=np.full_like(BASE.effort, 3.0)))
