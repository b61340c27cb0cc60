"""Each row of the fault table, injected for real while another process watches the torque."""

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from fault_injections import INJECT, NAMESPACES
from fault_rows import ROWS, Row, Torque
from fault_world import GUARD, LIMIT, PERIODS, RATE, TIMES, Shot, World, held
from node_harness import configured, open_bench

SLACK = 0.5  # s, for a machine under load
ATTEMPTS = 3


@pytest.fixture(scope="module")
def world(ros_environment: dict[str, str], tmp_path_factory: Any) -> Iterator[World]:
    folder: Path = tmp_path_factory.mktemp("faults")
    with open_bench(folder, kills=True) as bench:
        world = World(bench, folder, [f"/{name}" for name in NAMESPACES])
        try:
            yield world
        finally:
            world.close()


@pytest.fixture(scope="module")
def measured() -> Iterator[dict[str, float]]:
    """Collect what each row took and print it."""
    found: dict[str, float] = {}
    yield found
    print("\n" + "\n".join(f"{key:40} {value:6.3f}" for key, value in found.items()))


def test_every_parameter_of_the_installed_file_is_declared(world: World) -> None:
    world.usual()
    assert configured("watchdog") <= world.bench.parameters("/watchdog")


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.key)
def test_row(world: World, measured: dict[str, float], row: Row) -> None:
    """A fault that the machine stood still at is injected again."""
    for attempt in range(ATTEMPTS):
        begin = time.monotonic()
        try:
            inject(world, measured, row)
        except AssertionError:
            if attempt == ATTEMPTS - 1 or not world.pause(begin):
                raise
        else:
            return


def inject(world: World, measured: dict[str, float], row: Row) -> None:
    world.usual()
    world.said.clear()
    with contextlib.closing(INJECT[row.key](world)) as shots:
        for shot in shots:
            took = f"{row.key} [s]"
            measured[took] = max(check(world, row, shot), measured.get(took, 0.0))
            if not shot.later:
                world.until(lambda: world.spoke(row.says), f"/diagnostics: {row.says}")
    world.until(lambda: world.spoke(row.says), f"/diagnostics: {row.says}")
    if not shot.restarts:
        measured[f"{row.key}: largest step / limit"] = check_steps(world, shot)


def check(world: World, row: Row, shot: Shot) -> float:
    """Check what the torque does after the shot and return the time it takes, s."""
    topic, at = shot.topic, shot.at
    if row.torque is Torque.ZERO:
        world.until(lambda: not world.tau(topic).any(), "zero torque")
        world.bench.spin(0.1)
        found = world.records(topic, at)
        flowing = found[found[:, 1:].any(axis=1)]
        took = float(flowing[-1, 0] - at) if len(flowing) else 0.0
        assert not world.tau(topic).any()
        assert took <= row.seconds(TIMES) + SLACK
        return took
    if shot.tau is not None:
        world.until_tau(topic, shot.tau)
        found = world.records(topic, at)
        there = np.abs(found[:, 1] - shot.tau) < 0.02 * shot.tau
        took = float(found[np.argmax(there), 0] - at)
        assert took <= row.at_most + SLACK or not row.at_most
        return took
    world.bench.spin(0.5)
    world.look()
    found = world.records(topic, at)
    if row.torque is Torque.STOPS:
        before = world.records(topic)
        assert before[-1, 1:].all()
        assert before[-1, 0] < at + 0.3
        return max(0.0, float(before[-1, 0] - at))
    if row.torque is Torque.NEVER:
        assert not found[:, 1:].any()
        return 0.0
    assert row.torque is Torque.GOES_ON
    assert len(found) > 50
    np.testing.assert_allclose(found[:, 1:], held(), rtol=0.02)
    # The watchdog sees a stall, too.
    np.testing.assert_allclose(world.records(GUARD, at)[:, 1:], held(), rtol=0.02)
    return 0.0


def check_steps(world: World, shot: Shot) -> float:
    """Check that no message since shortly before the shot moves a torque farther than it may.

    Returns:
        The largest step as a share of the torque limit.
    """
    world.look()
    found = world.records(shot.topic, shot.at - 0.3)
    steps = np.abs(np.diff(found[:, 1:], axis=0)).max(initial=0.0)
    assert steps <= RATE * PERIODS / shot.rate + 1e-9
    return float(steps / LIMIT)


def test_no_command_was_over_its_limit_or_not_finite(world: World) -> None:
    """For all messages of all rows."""
    found = world.all_torques()
    assert len(found) > 10_000
    assert world.sizes == {2}
    assert (np.abs(found) <= LIMIT).all()  # NaN is not
    print(f"\n{len(found)} torques of each joint watched")


def test_every_row_is_injected() -> None:
    assert list(INJECT) == [row.key for row in ROWS]
