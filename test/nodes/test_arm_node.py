"""The arm node over DDS: exact stamps, refusals in words, feedforward from every source."""

import math
import signal
from collections.abc import Iterator
from functools import partial
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("pybullet")

from builtin_interfaces.msg import Duration
from node_harness import (
    BEST_EFFORT,
    LATCHED,
    RELIABLE,
    Bench,
    Process,
    configured,
    heard,
    open_bench,
)
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from lagrangian_ff.arm import HOME, JOINTS

PERIOD = 2_000_000


@pytest.fixture(scope="module")
def bench(ros_environment: dict[str, str], tmp_path_factory: Any) -> Iterator[Bench]:
    folder: Path = tmp_path_factory.mktemp("arm")
    with open_bench(folder) as bench:
        yield bench


@pytest.fixture(autouse=True)
def dropped(bench: Bench) -> Iterator[None]:
    """Let each test collect for itself."""
    yield
    bench.drop()


@pytest.fixture(scope="module")
def arm(bench: Bench) -> Process:
    return bench.start("arm")


def stamp(message: JointState) -> int:
    return int(message.header.stamp.sec) * 10**9 + int(message.header.stamp.nanosec)


def trajectory(q: list[list[float]], time: list[float], **changes: Any) -> JointTrajectory:
    names = changes.get("names", list(JOINTS))
    message = JointTrajectory(joint_names=names)
    for row, at in zip(q, time, strict=True):
        point = JointTrajectoryPoint(positions=row)
        point.time_from_start = Duration(sec=int(at), nanosec=round((at % 1) * 1e9))
        if "effort" in changes:
            point.effort = changes["effort"]
        message.points.append(point)
    return message


def said(process: Process, text: str) -> bool:
    return text in process.output


def newest(queue: Any) -> JointState:
    return queue[-1][1]


def test_every_parameter_of_the_installed_file_is_declared(bench: Bench, arm: Process) -> None:
    assert configured("arm") <= bench.parameters("arm")


def test_joint_states_come_on_an_exact_grid_with_their_reference(
    bench: Bench, arm: Process
) -> None:
    states = bench.collect(JointState, "joint_states")
    references = bench.collect(JointState, "arm/reference_state")
    description = bench.collect(String, "robot_description", LATCHED)
    bench.until(lambda: len(states) > 500 and len(references) > 500 and description, "a second")
    stamps = np.array([stamp(message) for _, message in states])
    assert set(np.diff(stamps)) == {PERIOD}
    assert set(stamps) & {stamp(message) for _, message in references}
    assert list(newest(states).name) == list(JOINTS)
    assert "<robot" in description[0][1].data


def test_it_follows_a_trajectory_in_any_joint_order_and_shows_feedforward(
    bench: Bench, arm: Process
) -> None:
    references = bench.collect(JointState, "arm/reference_state")
    states = bench.collect(JointState, "joint_states")
    send = bench.publisher(JointTrajectory, "arm/joint_trajectory")
    start = np.array(HOME)
    goal = start + 0.2
    send.publish(trajectory([list(start[::-1]), list(goal[::-1])], [0.0, 0.8], names=JOINTS[::-1]))
    bench.until(lambda: references and np.allclose(newest(references).position, goal), "the goal")
    bench.until(lambda: np.abs(newest(states).position - goal).max() < 0.1, "the arm near it")
    commands = bench.publisher(Float64MultiArray, "arm/commands")
    tau = [0.0, 1.0, 2.0, 0.5, 0.25, 0.125]

    def pushed() -> bool:
        commands.publish(Float64MultiArray(data=tau))
        return np.allclose(newest(references).effort, tau)

    bench.until(pushed, "the commanded torque")
    bench.until(lambda: not any(newest(references).effort), "zero after the timeout")


def test_sources_can_be_changed_at_run_time_to_listed_ones_only(bench: Bench, arm: Process) -> None:
    references = bench.collect(JointState, "arm/reference_state")
    assert bench.set_parameter("arm", "feedforward_source", "true").successful
    bench.until(lambda: references and abs(newest(references).effort[1]) > 1.0, "true torque")
    assert bench.set_parameter("arm", "feedforward_source", "trajectory").successful
    bench.until(lambda: not any(newest(references).effort), "no effort in the reference")
    send = bench.publisher(JointTrajectory, "arm/joint_trajectory")
    here = list(newest(references).position)
    effort = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
    send.publish(trajectory([here, here], [0.0, 0.2], effort=effort))
    bench.until(lambda: np.allclose(newest(references).effort, effort), "effort of the trajectory")
    refused = bench.set_parameter("arm", "feedforward_source", "magic")
    assert not refused.successful
    assert "none, stream, trajectory, true" in refused.reason
    assert bench.set_parameter("arm", "feedforward_source", "stream").successful


@pytest.fixture(scope="module")
def clocked(bench: Bench) -> Process:
    """Start an arm that has its own time and waits for its commands."""
    own = {"publish_clock": True, "wait_for_command": 2.0}
    params = {**own, **heard("/clocked/arm/commands")}
    return bench.start("arm", namespace="clocked", params=params)


def test_an_arm_with_its_own_clock_publishes_it_and_stops_at_its_end(
    bench: Bench, clocked: Process
) -> None:
    states = bench.collect(JointState, "clocked/joint_states")
    clock = bench.collect(Clock, "/clock", BEST_EFFORT)
    bench.until(lambda: len(states) > 100 and clock, "joint states and the clock")
    last = clock[-1][1].clock
    at = int(last.sec) * 10**9 + int(last.nanosec)
    bench.until(lambda: stamp(newest(states)) >= at, "the joint state of that moment")
    assert at in {stamp(message) for _, message in states}
    assert bench.set_parameter("clocked/arm", "clock_speed", 0.0).successful
    bench.until_quiet(states, "joint states while the clock stands")
    stood = stamp(newest(states))
    assert bench.set_parameter("clocked/arm", "clock_speed", 2.0).successful
    bench.until(lambda: stamp(newest(states)) > stood + 10**8, "the clock going on")
    assert {PERIOD} == set(np.diff([stamp(message) for _, message in states]))
    until = stamp(newest(states)) + 3 * 10**9
    assert bench.set_parameter("clocked/arm", "clock_until", until / 1e9).successful
    bench.until(lambda: stamp(newest(states)) >= until, "the time at which it stands still")
    bench.until_quiet(states, "joint states at that time")
    assert stamp(newest(states)) - until < PERIOD
    assert bench.set_parameter("clocked/arm", "clock_until", 0.0).successful


def test_each_joint_state_is_answered_before_the_next_tick(bench: Bench, clocked: Process) -> None:
    states = bench.collect(JointState, "clocked/joint_states")
    references = bench.collect(JointState, "clocked/arm/reference_state")
    commands = bench.publisher(Float64MultiArray, "clocked/arm/commands", RELIABLE)
    bench.until(lambda: states and references, "joint states")
    answers: dict[int, float] = {}

    def answered() -> bool:
        """Answer slowly, with another torque for each joint state."""
        at = stamp(newest(states))
        if at not in answers:
            answers[at] = 0.001 * len(answers)
            commands.publish(Float64MultiArray(data=[answers[at]] * 6))
        return len(answers) > 60

    bench.until(answered, "sixty ticks")
    last = max(answers)
    bench.until(lambda: stamp(newest(references)) > last, "the tick after the last answer")
    effort = {stamp(message): message.effort[0] for _, message in references}
    for at in sorted(answers)[21:]:
        assert effort[at + PERIOD] == answers[at]
    # Nobody answers any more: it goes on all the same, and without torque.
    bench.until(lambda: stamp(newest(references)) > last + 5 * 10**8, "the arm going on")
    assert not any(newest(references).effort)
    bench.until(partial(said, clocked, "no command came within 2 s"), "a word about it")
    assert bench.set_parameter("clocked/arm", "clock_speed", 0.0).successful


def test_what_cannot_be_followed_is_refused_in_words_and_survived(
    bench: Bench, arm: Process
) -> None:
    references = bench.collect(JointState, "arm/reference_state")
    send = bench.publisher(JointTrajectory, "arm/joint_trajectory")
    bench.until(lambda: references, "a reference")
    here = np.array(newest(references).position)
    far = here + np.array([0.0, 0.0, 0.4, 0.0, 0.0, 0.0])
    outside = here + np.array([0.0, 9.0, 0.0, 0.0, 0.0, 0.0])
    nan = here.copy()
    nan[4] = math.nan
    for message, expected in (
        (trajectory([list(far), list(here)], [0.0, 1.0]), "joint_3 would jump by 0.4000 rad"),
        (trajectory([list(here), list(outside)], [0.0, 9.0]), "position of joint_2"),
        (trajectory([list(here), list(nan)], [0.0, 1.0]), "position of joint_5 in point 1 is nan"),
        (trajectory([[]], [0.0], names=[]), "moves no joints"),
    ):
        send.publish(message)
        # Warnings come once a second at most; the next message must not be gathered into it.
        bench.until(partial(said, arm, expected), expected)
    bench.until(
        lambda: "moves no joints" in bench.values("arm: plant").get("last refusal", ""),
        "the reason",
    )
    np.testing.assert_allclose(newest(references).position, here, atol=1e-9)
    commands = bench.publisher(Float64MultiArray, "arm/commands")
    wrong = [Float64MultiArray(data=data) for data in ([], [1.0], [math.nan] * 6, [math.inf] * 6)]
    bad = cycle([b"\x00\x01\x00\x00junk", *wrong])

    def counted() -> bool:
        commands.publish(next(bad))
        return int(bench.values("arm: plant").get("bad command", "0")) > 4

    bench.until(counted, "bad commands counted")
    assert not any(newest(references).effort)
    assert arm.alive


def test_it_ends_cleanly_whatever_signals_come(bench: Bench, arm: Process) -> None:
    endings = {"a": [signal.SIGTERM], "b": [signal.SIGINT], "c": [signal.SIGINT] * 2}
    processes = {name: bench.start("arm", namespace=name) for name in endings}
    states = {name: bench.collect(JointState, f"/{name}/joint_states") for name in endings}
    for name, signals in endings.items():
        bench.until(partial(len, states[name]), f"joint states of {name}")
        for number in signals:
            processes[name].signal(number)
    for process in processes.values():
        assert process.wait() == 0
        assert "Traceback" not in process.output
    assert arm.alive


def test_impossible_parameters_end_it_with_a_sentence(bench: Bench) -> None:
    mistakes: list[tuple[dict[str, Any], str]] = [
        ({"feedforward_source": "magic"}, "expected one of none, stream"),
        ({"command_timeout": -1.0}, "command_timeout"),
        ({"initial_position": [0.0, 99.0, 0.0, 0.0, 0.0, 0.0]}, "start position of joint_2"),
    ]
    processes = [bench.start("arm", namespace="wrong", params=params) for params, _ in mistakes]
    for process, (_, expected) in zip(processes, mistakes, strict=True):
        assert process.wait() == 2
        assert expected in process.output
        assert "Traceback" not in process.output


def test_set_points_of_one_point_are_followed(bench: Bench, arm: Process) -> None:
    send = bench.publisher(JointTrajectory, "arm/joint_trajectory")
    states = bench.collect(JointState, "arm/reference_state")
    bench.until(lambda: states, "the reference")
    wanted = [q + 0.01 for q in states[-1][1].position]
    send.publish(trajectory([wanted], [0.0]))
    bench.until(
        lambda: np.allclose(newest(states).position, wanted, atol=1e-9),
        "the set-point as reference",
    )


def test_what_is_hidden_in_it_is_asked_for_by_name(bench: Bench) -> None:
    wrong = bench.start("arm", namespace="wrong", params={"hidden": ["stick@joint_1:0.1"]})
    assert wrong.wait() == 2
    assert "no effect 'stick'" in wrong.output
    odd = bench.start("arm", namespace="odd", params={"hidden": ["spring@joint_2:0.3"]})
    bench.start("arm", namespace="plain")
    names = ("odd/", "plain/")
    states = {name: bench.collect(JointState, f"{name}joint_states") for name in names}
    goal = np.array(HOME) + 0.4
    for name in states:
        send = bench.publisher(JointTrajectory, f"{name}arm/joint_trajectory")
        send.publish(trajectory([list(HOME), list(goal)], [0.0, 1.0]))

    def moving(name: str) -> list[float]:
        # At rest the effort is anywhere within static friction.
        return [m.effort[1] for _, m in list(states[name]) if m.velocity[1] > 0.1]

    bench.until(lambda: all(len(moving(name)) > 100 for name in names), "both arms moving")
    effort = [np.mean(moving(name)) for name in names]
    assert abs(effort[0] - effort[1]) > 0.5
    odd.end()
