"""How each fault of the table is injected, and undone."""

import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Generator
from typing import Any

import numpy as np
from fault_world import GUARD, LIMIT, MAIN, PERIODS, TIMES, Q, Robot, Shot, World, held, reference
from lifecycle_msgs.srv import ChangeState
from node_harness import Process
from sensor_msgs.msg import JointState
from small_model import save_small_model
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory

ENDINGS = (
    [signal.SIGINT], [signal.SIGTERM], [signal.SIGHUP], [signal.SIGQUIT],
    [signal.SIGINT] * 2, [signal.SIGTERM] * 2,
)  # fmt: skip
NAMESPACES = ("simulated", "lost", "poor", "late", "left", *(f"end{k}" for k in range(6)))


Injection = Generator[Shot, None, None]
INJECT: dict[str, Callable[[World], Injection]] = {}


def injects(function: Callable[[World], Injection]) -> Callable[[World], Injection]:
    """Register the function that injects the row of its name, yields a shot, and undoes it."""
    INJECT[function.__name__] = function
    return function


def refused(name: str, *args: Any, **named: Any) -> None:
    """Register a row of a reference that is refused."""

    def inject(world: World) -> Injection:
        world.robot.references.publish(reference(*args, **named))
        yield Shot()

    inject.__name__ = name
    injects(inject)


@injects
def stops(world: World) -> Injection:
    world.stream()
    world.robot.setpoint = None
    yield Shot()


@injects
def jumps(world: World) -> Injection:
    world.stream(0.0)
    world.robot.position = 0.2
    world.robot.setpoint = (0.6, 0.0)
    yield Shot(tau=held(0.6))


@injects
def jumps_far(world: World) -> Injection:
    world.stream(0.0)
    world.robot.setpoint = (0.7, 0.0)
    yield Shot()


refused("nan", [0.0, 1.0], [[Q, Q], [Q, math.nan]])
refused("infinite", [0.0, 1.0], [[Q, Q], [Q, math.inf]])
refused("sizes", [0.0, 1.0], [[Q, Q], [Q, Q, Q]])
refused("names", [0.0, 1.0], [[Q, Q], [Q, Q]], names=("a", "c"))
refused("unsorted", [0.0, 1.0, 0.5], [[Q, Q]] * 3)
refused("empty", [], [])


@injects
def past(world: World) -> Injection:
    message = reference([0.0, 1.0], [[Q, Q]] * 2)
    message.header.stamp.sec = 1
    world.robot.references.publish(message)
    yield Shot()


@injects
def junk(world: World) -> Injection:
    for data in (b"junk", b"\x00\x01\x00\x00" + b"\xff" * 40, b"\x00\x01\x00\x00" + b"\x01" * 99):
        world.robot.references.publish(data)
    yield Shot()


refused("many", np.arange(100_000) / 1000.0, np.full((100_000, 2), Q))


@injects
def sparse(world: World) -> Injection:
    world.robot.references.publish(reference([0.0, 2.0], [[Q, Q], [0.6, 0.6]]))
    yield Shot(tau=held(0.6))


@injects
def outside(world: World) -> Injection:
    world.stream()
    world.robot.position, world.robot.setpoint = 2.0, (2.0, 0.0)
    yield Shot()


@injects
def limit(world: World) -> Injection:
    world.stream(0.0)
    world.robot.setpoint = (0.0, 5.0)
    yield Shot(tau=LIMIT)


def states(name: str, make: Callable[[Robot, int], list[JointState]]) -> None:
    """Register a row of other joint states than the healthy ones."""

    def inject(world: World) -> Injection:
        world.robot.make = lambda now: make(world.robot, now)
        yield Shot()

    inject.__name__ = name
    injects(inject)


def with_nan(robot: Robot, now: int) -> list[JointState]:
    message = robot.state(now)
    message.position = [Q, math.nan]
    return [message]


states("silent", lambda robot, now: [])


@injects
def stale(world: World) -> Injection:
    old = world.bench.node.get_clock().now().nanoseconds
    world.robot.make = lambda now: [world.robot.state(old)]
    yield Shot()


states("two_publishers", lambda robot, now: [robot.state(now), robot.state(now - 4_000_000)])
states("other_arm", lambda robot, now: [robot.state(now, "xy")])
states("part", lambda robot, now: [robot.state(now, "a")])
states("nan_states", with_nan)
states("astray", lambda robot, now: [robot.state(now, shift=1.0)])
states("hour_off", lambda robot, now: [robot.state(now + 3600 * 10**9)])
states("set_back", lambda robot, now: [robot.state(now - 60 * 10**9)])


SIMULATED: list[Process] = []


@injects
def no_clock(world: World) -> Injection:
    SIMULATED.append(world.start("simulated", use_sim_time=True))
    yield Shot("/simulated/feedforward/commands")


@injects
def clock_back(world: World) -> Injection:
    world.robot.simulated = 100 * 10**9
    world.settle("/simulated/feedforward/commands")
    world.hold("/simulated")
    world.robot.simulated = 10 * 10**9
    yield Shot("/simulated/feedforward/commands", rate=150.0)  # simulated time steps by 10 ms


@injects
def clock_stands(world: World) -> Injection:
    world.hold("/simulated")
    world.robot.speed = 0
    yield Shot("/simulated/feedforward/commands", rate=150.0)
    world.robot.simulated = None
    SIMULATED.pop().kill()


@injects
def missing(world: World) -> Injection:
    lost = world.start("lost", model_file=str(world.folder / "missing.npz"))
    yield Shot("/lost/feedforward/commands")
    lost.end()


@injects
def broken(world: World) -> Injection:
    file = world.folder / "broken.npz"
    file.write_bytes(world.sound[:3000])
    lost = world.start("lost", model_file=str(file))
    yield Shot("/lost/feedforward/commands")
    lost.end()


@injects
def truncated(world: World) -> Injection:
    world.model.write_bytes(world.sound[:3000])
    yield Shot()


@injects
def other_joints(world: World) -> Injection:
    save_small_model(world.model, ("a", "c"))
    yield Shot()


@injects
def removed(world: World) -> Injection:
    world.model.unlink()
    yield Shot()


@injects
def replaced(world: World) -> Injection:
    begin = time.monotonic()
    save_small_model(world.model, factor=1.2)
    yield Shot(tau=1.2 * held())
    world.model.write_bytes(world.sound)
    world.until_tau(MAIN, held())
    steps = np.abs(np.diff(world.records(MAIN, begin)[:, 1:], axis=0)).max()
    bump = 0.2 * held() * 0.002 * PERIODS / TIMES["ramp_time"]
    assert steps <= 1.1 * bump


@injects
def bad_parameter(world: World) -> Injection:
    result = world.bench.set_parameter("/feedforward", "scale.a", 7.0)
    assert not result.successful
    assert result.reason
    yield Shot()


@injects
def bad_start(world: World) -> Injection:
    lost = world.start("lost", rate=-5.0)
    assert lost.wait() == 2
    assert "rate" in lost.output
    assert "Traceback" not in lost.output
    yield Shot("/lost/feedforward/commands")


@injects
def not_allowed(world: World) -> Injection:
    for number in (1, 2, 3, 5, 99):
        request = ChangeState.Request()
        request.transition.id = number
        answer = world.bench.call(ChangeState, "/feedforward/change_state", request)
        assert not answer.success
    assert "possible now: deactivate (4), shutdown (7)" in world.main.output
    yield Shot()


@injects
def disabled(world: World) -> Injection:
    call = world.bench.call
    call(SetBool, "/feedforward/enable", SetBool.Request(data=True))  # the first call takes longer
    shot = Shot()
    world.bench.call(SetBool, "/feedforward/enable", SetBool.Request(data=False))
    yield shot
    world.bench.call(SetBool, "/feedforward/enable", SetBool.Request(data=True))


@injects
def deactivated(world: World) -> Injection:
    world.bench.state("/feedforward")
    shot = Shot()
    assert world.bench.transition("/feedforward", "deactivate")
    yield shot
    assert world.bench.transition("/feedforward", "activate")


@injects
def starved(world: World) -> Injection:
    poor = world.start("poor", joint_state_timeout=0.0)
    world.settle("/poor/feedforward/commands")
    world.hold("/poor")
    send = world.bench.publisher(JointTrajectory, "/poor/feedforward/reference")
    for thread in world.threads(poor):
        os.setpriority(os.PRIO_PROCESS, thread, 19)
    shot = Shot("/poor/feedforward/commands", tau=held(0.6))
    send.publish(reference([0.0, 2.0], [[Q, Q], [0.6, 0.6]]))
    # Linux shares time between sessions first: in one session all weigh as much as the node.
    hog = [sys.executable, "-c", "while True: pass"]
    count = 4 * (os.cpu_count() or 1)
    hogs = [subprocess.Popen(hog, start_new_session=True) for _ in range(count)]
    try:
        world.bench.spin(2.5)  # a whole second lies within it, of those that diagnostics count
    finally:
        for one in hogs:
            one.kill()
            one.wait()
    yield shot
    poor.end()


@injects
def stopped(world: World) -> Injection:
    world.main.signal(signal.SIGSTOP)
    try:
        yield Shot(later=True)
    finally:
        world.main.signal(signal.SIGCONT)
    world.until_tau(MAIN, held())


@injects
def stopped_guarded(world: World) -> Injection:
    world.main.signal(signal.SIGSTOP)
    try:
        yield Shot(GUARD)
    finally:
        world.main.signal(signal.SIGCONT)
    world.until_tau(GUARD, held())


@injects
def killed(world: World) -> Injection:
    world.main.kill()
    yield Shot()


@injects
def killed_guarded(world: World) -> Injection:
    world.main.kill()
    yield Shot(GUARD)


@injects
def restarted(world: World) -> Injection:
    world.main.kill()
    message = reference([0.0, 8.0], [[Q, Q], [0.6, 0.6]])
    message.header.stamp = world.bench.node.get_clock().now().to_msg()
    assert world.main.alive
    assert not world.tau(MAIN).any()
    shot = Shot(tau=held(0.6), restarts=True)
    world.send(message, MAIN, held(0.6))
    yield shot


@injects
def late(world: World) -> Injection:
    world.robot.references.publish(reference([0.0, 0.1], [[Q, Q]] * 2))
    late = world.start("late")
    world.settle("/late/feedforward/commands")
    yield Shot("/late/feedforward/commands")
    late.end()


@injects
def second(world: World) -> Injection:
    other = world.start(autostart=False)
    yield Shot()
    other.end()


@injects
def neighbour(world: World) -> Injection:
    left = world.start("left", joint_state_timeout=0.0)
    world.settle("/left/feedforward/commands")
    world.hold("/left")
    left.kill()
    yield Shot()


@injects
def ended(world: World) -> Injection:
    topics = [f"/end{k}/feedforward/commands" for k in range(len(ENDINGS))]
    nodes = [
        world.start(f"end{k}", rate=100.0, joint_state_timeout=0.0) for k in range(len(ENDINGS))
    ]
    for k, topic in enumerate(topics):
        world.settle(topic)
        world.hold(f"/end{k}")
    for node, topic, signals in zip(nodes, topics, ENDINGS, strict=True):
        shot = Shot(topic, rate=100.0)
        for number in signals:
            node.signal(number)
        assert node.wait() == 0
        assert "Traceback" not in node.output
        yield shot


@injects
def guard_ended(world: World) -> Injection:
    guard, shot = world.guard, Shot(GUARD)
    guard.signal(signal.SIGINT)
    guard.signal(signal.SIGINT)
    assert guard.wait() == 0
    assert "Traceback" not in guard.output
    yield shot


@injects
def guard_killed(world: World) -> Injection:
    world.guard.kill()
    yield Shot(GUARD)
