"""The feedforward node over DDS: in time, within its limits, and silent when it must be."""

import math
import re
import signal
import textwrap
import threading
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from feedforward_bench import Feedforward, reference
from node_harness import Bench, configured, open_bench
from sensor_msgs.msg import JointState
from small_model import save_small_model
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.diagnosis import add
from lagrangian_ff.effects import EFFECTS, load_effects
from lagrangian_ff.identification import Model
from lagrangian_ff.nodes.common.topics import points
from lagrangian_ff.nodes.streaming.reference import read_reference


@pytest.fixture(scope="module")
def folder(tmp_path_factory: Any) -> Path:
    path: Path = tmp_path_factory.mktemp("feedforward")
    return path


@pytest.fixture(scope="module")
def model(folder: Path) -> Model:
    return save_small_model(folder / "model.npz")


@pytest.fixture(scope="module")
def bench(ros_environment: dict[str, str], folder: Path, model: Model) -> Iterator[Bench]:
    with open_bench(folder) as bench:
        yield bench


@pytest.fixture(scope="module")
def node(bench: Bench, folder: Path) -> Feedforward:
    return Feedforward(bench, folder, joints=["b", "a"])


def nanoseconds(header: Any) -> int:
    return int(header.stamp.sec) * 10**9 + int(header.stamp.nanosec)


def test_every_parameter_of_the_installed_file_is_declared(node: Feedforward) -> None:
    assert configured("feedforward") <= node.bench.parameters("feedforward")


def test_a_reference_is_annotated_and_streamed_in_time(node: Feedforward, model: Model) -> None:
    time = list(np.linspace(0.0, 1.5, 16))
    swing = 0.3 * np.sin(np.pi * np.array(time) / 1.5) ** 2
    sent = reference(time, np.column_stack([swing, 0 * swing, -swing]), names=("b", "x", "a"))
    before = node.bench.node.get_clock().now().nanoseconds
    node.send.publish(sent)
    _, message = node.bench.until(lambda: node.annotated and node.annotated[-1], "annotation")
    complete = read_reference(points(sent), model.joints)
    expected = model.predict(complete.q, complete.qd, complete.qdd)
    effort = np.array([point.effort for point in message.points])
    np.testing.assert_allclose(effort[:, [2, 0]], expected, atol=1e-6)
    assert not effort[:, 1].any()
    start = nanoseconds(message.header)
    assert start > before

    node.bench.until(
        lambda: node.stamped and nanoseconds(node.stamped[-1][1].header) > start + 1.6e9, "the end"
    )
    assert "accelerations by a spline" in node.process.output
    streamed = [m for _, m in node.stamped if 0 <= nanoseconds(m.header) - start <= 1_500_000_000]
    assert len(streamed) > 50
    elapsed = np.array([nanoseconds(m.header) - start for m in streamed]) / 1e9
    tau = np.array([m.effort for m in streamed])
    q, qd, qdd = complete.sample(elapsed)
    expected = model.predict(q, qd, qdd)
    # Between the samples of the plan the torque is interpolated.
    assert np.abs(tau - expected).max() < 0.02 * np.abs(expected).max()
    assert list(streamed[0].name) == list(model.joints)
    for _, command in node.commands:
        assert len(command.data) == 2
        assert np.isfinite(command.data).all()
    rest = model.predict(complete.q[-1], np.zeros(2), np.zeros(2))
    np.testing.assert_allclose(node.tau, rest[::-1], atol=1e-6)


def test_terms_and_scale_are_switched_at_run_time(node: Feedforward) -> None:
    node.hold()
    assert node.bench.set_parameter("feedforward", "terms.gravity", False).successful
    node.bench.until(lambda: abs(node.tau[0]) < 2.0, "no gravity")
    assert node.bench.set_parameter("feedforward", "terms.gravity", True).successful
    assert node.bench.set_parameter("feedforward", "scale.a", 0.0).successful
    node.bench.until(lambda: node.tau[1] == 0.0 and node.tau[0] > 4.0, "joint a scaled to nothing")
    assert not node.bench.set_parameter("feedforward", "scale.a", 1.5).successful
    assert node.bench.set_parameter("feedforward", "scale.a", 1.0).successful


def test_disabling_fades_and_enabling_brings_back(node: Feedforward) -> None:
    node.hold()
    response = node.bench.call(SetBool, "feedforward/enable", SetBool.Request(data=False))
    assert response.success
    node.until_silent("disabled")
    node.bench.call(SetBool, "feedforward/enable", SetBool.Request(data=True))
    node.until_sending("enabled")


def test_silence_of_set_points_and_of_joint_states_fades(node: Feedforward) -> None:
    node.bench.until(node.set_point, "torque of set-points")
    node.bench.until(
        lambda: int(node.bench.values("feedforward: stream").get("references followed", "0")) > 1,
        "set-points counted",
    )
    node.bench.until(node.set_point, "torque of set-points again")
    node.until_silent("no set-points")
    node.bench.until(lambda: "no set-point for" in node.process.output, "a warning")
    node.hold()
    assert node.bench.set_parameter("feedforward", "joint_state_timeout", 0.3).successful
    node.until_silent("no joint states")
    states = node.bench.publisher(JointState, "joint_states")
    alive = JointState(name=["c", "b", "a"], position=[0.0, 0.0, 0.0])

    def live() -> bool:
        states.publish(alive)
        return any(node.tau)

    node.bench.until(live, "torque with joint states")
    for bad in (
        JointState(), JointState(name=["a", "b"], position=[math.nan, 0.0]),
        JointState(name=["a"], position=[0.0]), b"junk", JointState(name=["a", "b"]),
    ):  # fmt: skip
        states.publish(bad)
        node.bench.spin(0.05)
    node.until_silent("only bad joint states")
    alive.position = [0.0, 2.0, 2.0]
    node.bench.until(
        lambda: (states.publish(alive), "rad from its reference" in node.process.output)[1],
        "a joint astray",
    )
    alive.position = [0.0, 0.0, 0.0]
    states.publish(alive)
    assert node.bench.set_parameter("feedforward", "joint_state_timeout", 0.0).successful


def test_bad_references_are_refused_and_survived(node: Feedforward) -> None:
    node.hold()
    held = node.tau
    annotated = len(node.annotated)
    nan = [[0.0, 0.0], [0.1, math.nan]]
    flood = [
        reference([0.0, 1.0], [[0.0], [0.1]], names=("wheel",)),
        reference([0.0, 1.0], nan),
        reference([1.0, 0.5], [[0.0, 0.0], [0.1, 0.1]]),
        reference([], []),
        JointTrajectory(),
    ]
    for _ in range(40):
        for message in flood:
            node.send.publish(message)
        node.bench.spin(0.005)
    node.bench.until(
        lambda: int(node.bench.values("feedforward: stream").get("refused reference", "0")) > 20,
        "refusals counted",
    )
    node.bench.until(lambda: "refused a reference: " in node.process.output, "a warning")
    warned = [float(at) for at in re.findall(r"\[WARN\] \[([\d.]+)\]", node.process.output)]
    assert len(warned) <= warned[-1] - warned[0] + 2, "at most one warning a second"
    assert len(node.annotated) == annotated
    assert node.tau == pytest.approx(held, rel=0.02)
    assert node.process.alive


@pytest.mark.parametrize("policy", ["refuse", "fade"])
def test_outside_the_identified_range_there_is_no_torque(node: Feedforward, policy: str) -> None:
    assert node.bench.set_parameter("feedforward", "out_of_range", policy).successful
    annotated = len(node.annotated)
    node.send.publish(reference([0.0, 2.0], [[0.4, 0.4], [9.0, 9.0]]))
    if policy == "refuse":
        node.bench.until(
            lambda: "outside the identified range: " in node.process.output, "a refusal"
        )
        assert len(node.annotated) == annotated
    else:
        _, message = node.bench.until(
            lambda: len(node.annotated) > annotated and node.annotated[-1], "annotation"
        )
        assert not any(message.points[-1].effort)
        node.until_silent("outside the range")
        node.bench.until(lambda: "the torque fades to zero there" in node.process.output, "a word")


def test_deactivating_and_activating(node: Feedforward) -> None:
    node.hold()
    assert node.bench.transition("feedforward", "deactivate")
    node.until_silent("deactivated")
    node.bench.until_quiet(node.commands, "zeros")
    count = len(node.commands)
    node.send.publish(reference([0.0, 0.1], [[0.4, 0.4], [0.4, 0.4]]))
    node.bench.until(lambda: "ignored a reference: not active" in node.process.output, "a word")
    node.bench.until_quiet(node.commands, "commands while inactive")
    assert len(node.commands) == count
    assert node.bench.transition("feedforward", "activate")
    node.bench.until(lambda: len(node.commands) > count, "commands again")
    assert not any(node.tau)
    node.hold()
    assert node.bench.transition("feedforward", "deactivate")
    assert node.bench.transition("feedforward", "cleanup")
    assert node.bench.transition("feedforward", "configure")
    assert node.bench.transition("feedforward", "activate")
    node.hold()


def test_deactivating_fades_though_set_points_go_on(node: Feedforward) -> None:
    node.bench.until(node.set_point, "torque of set-points")
    stop = threading.Event()

    def go_on() -> None:
        while not stop.wait(0.01):
            node.send.publish(reference([0.0], [[0.2, 0.2]]))

    sender = threading.Thread(target=go_on)
    sender.start()
    try:
        begin = len(node.commands)
        assert node.bench.transition("feedforward", "deactivate")
        node.until_silent("deactivated")
    finally:
        stop.set()
        sender.join()
    torques = np.array([message.data[0] for _, message in list(node.commands)[begin - 1 :]])
    # From full to zero in 0.2 s at 500 Hz; a stall may make some ticks of 0.02 s.
    assert np.abs(np.diff(torques)).max() < 0.25 * torques.max()
    assert node.bench.transition("feedforward", "activate")
    node.hold()


def test_diagnostics_tell_the_rate_and_the_model(node: Feedforward) -> None:
    def rate() -> float:
        return float(node.bench.values("feedforward: stream").get("publish rate [Hz]", "0"))

    node.bench.until(lambda: rate() > 100.0, "a publish rate")
    values = node.bench.values("feedforward: model")
    assert values["model"] == "chain+fri"
    assert "held-out error a" in values
    node.hold()
    known = node.bench.until(
        lambda: float(node.bench.values("feedforward: certainty").get("doubt a", "0")),
        "how sure it is of what it holds",
    )
    assert 0.0 < known < 1.0
    assert (
        "of the largest torque or better" in node.bench.statuses["feedforward: certainty"].message
    )


def test_without_a_model_it_waits_unconfigured_for_one(bench: Bench, folder: Path) -> None:
    process = bench.start(
        "feedforward", namespace="lost", params={"model_file": str(folder / "missing.npz")}
    )
    bench.until(lambda: "cannot be configured" in process.output, "a reason")
    assert "missing.npz" in process.output
    assert bench.state("/lost/feedforward") == "unconfigured"
    assert not bench.transition("/lost/feedforward", "configure")
    name = str(folder / "model.npz")
    assert bench.set_parameter("/lost/feedforward", "model_file", name).successful
    assert bench.transition("/lost/feedforward", "configure")
    commands: deque[Any] = bench.collect(Float64MultiArray, "/lost/feedforward/commands")
    bench.until_quiet(commands, "commands before it is active")
    assert not commands
    process.signal(signal.SIGINT)
    assert process.wait() == 0


def test_a_model_with_an_effect_of_the_users_own_is_loaded_with_its_file(
    bench: Bench, folder: Path, model: Model
) -> None:
    text = """
        from lagrangian_ff.effects import Effect, Parameter

        class Sway(Effect):
            name = "sway"
            formula = "F cos(3 q)"
            parameters = (Parameter("F", "N·m", "of a cable"),)

            def columns(self, x, joint, shape):
                import numpy as np
                return np.cos(3.0 * x.q[:, [joint]])
        """
    (folder / "sway.py").write_text(textwrap.dedent(text), encoding="utf-8")
    known = dict(EFFECTS)
    load_effects(folder / "sway.py")
    try:
        add(model, "sway", joint="a").save(folder / "swaying.npz")
    finally:
        EFFECTS.clear()
        EFFECTS.update(known)
    params = {"model_file": str(folder / "swaying.npz")}
    process = bench.start("feedforward", namespace="swaying", params=params)
    bench.until(lambda: "cannot be configured" in process.output, "a reason")
    assert "sway" in process.output
    name = str(folder / "sway.py")
    assert bench.set_parameter("/swaying/feedforward", "effects_file", name).successful
    assert bench.transition("/swaying/feedforward", "configure")
    process.signal(signal.SIGINT)
    assert process.wait() == 0


def test_the_last_command_is_zero_in_each_namespace_whatever_signal_ends_it(
    bench: Bench, folder: Path, node: Feedforward
) -> None:
    other = Feedforward(bench, folder, "left")
    node.until_sending("held from before")
    assert not any(other.tau)
    other.hold()
    for ended, signals in ((other, [signal.SIGINT] * 2), (node, [signal.SIGTERM])):
        for number in signals:
            ended.process.signal(number)
        assert ended.process.wait() == 0
        ended.until_silent("it has ended")
        assert "Traceback" not in ended.process.output
        gone_down = [abs(m.data[0]) for _, m in ended.commands][-50:]
        assert np.abs(np.diff(gone_down)).max() < 4.0, "torque fell in one step"
