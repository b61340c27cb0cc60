"""The identify node over DDS: written at once, refusing in words, identifying beside it."""

import math
import re
import signal
from collections.abc import Iterator
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import small_model

pytest.importorskip("rclpy")
pytest.importorskip("pybullet")

from builtin_interfaces.msg import Duration
from node_harness import Bench, Process, configured, heard, open_bench
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from lagrangian_ff.arm import JOINTS, exciting_trajectory
from lagrangian_ff.identification import Model
from lagrangian_ff.recording import load

KNOWN = find_spec("pinocchio") is not None
"""Whether the node can read the description that the arm publishes."""
PARAMETERS = {
    "samples": 60, "train": 0.6, "effort_scale.joint_1": 1.0, "use_robot_description": KNOWN,
    **heard("/joint_states"),
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: Any) -> Path:
    path: Path = tmp_path_factory.mktemp("identify")
    return path


@pytest.fixture(scope="module")
def bench(ros_environment: dict[str, str], folder: Path) -> Iterator[Bench]:
    with open_bench(folder, kills=True) as bench:
        yield bench


@pytest.fixture(scope="module")
def identify(bench: Bench, folder: Path) -> Process:
    directory = str(folder / "out")
    return bench.start("identify", params={**PARAMETERS, "output_directory": directory})


@pytest.fixture(scope="module")
def arm(bench: Bench) -> Process:
    return bench.start("arm", params={"feedforward_source": "true"})


def ask(bench: Bench, action: str, node: str = "identify") -> tuple[bool, str]:
    response = bench.call(Trigger, f"{node}/{action}")
    return response.success, response.message


def samples(bench: Bench, node: str = "identify") -> int:
    """Return the size of the recording; 0 while the node does not record."""
    values = bench.values(f"{node}: input")
    return int(values["samples"]) if values.get("state") == "recording" else 0


def test_every_parameter_of_the_installed_file_is_declared(bench: Bench, identify: Process) -> None:
    assert configured("identify") <= bench.parameters("identify")


def test_each_service_says_what_to_do_first(bench: Bench, identify: Process) -> None:
    for action, expected in (
        ("stop", "call ~/start first"),
        ("identify", "nothing recorded: call ~/start"),
        ("compare", "nothing recorded: call ~/start"),
        ("diagnose", "nothing recorded: call ~/start"),
        ("save", "call ~/identify first"),
        ("add", "no model: call ~/identify first"),
    ):
        success, message = ask(bench, action)
        assert not success
        assert expected in message
    success, message = ask(bench, "start")
    assert success
    assert "nobody publishes there yet" in message
    success, message = ask(bench, "stop")
    assert not success
    assert "no joint states came on /joint_states" in message
    assert ask(bench, "clear")[0]


def test_from_a_motion_of_the_arm_to_a_model_file(
    bench: Bench, identify: Process, arm: Process, folder: Path
) -> None:
    bench.until(lambda: bench.values("identify: input").get("joints"), "joint states")
    assert ask(bench, "start")[0]
    success, message = ask(bench, "start")
    assert not success
    assert "call ~/stop first" in message
    motion = exciting_trajectory(4, seed=1, duration=7.0)
    trajectory = JointTrajectory(joint_names=list(JOINTS))
    for time, q, qd, qdd in zip(motion.time, motion.q, motion.qd, motion.qdd, strict=True):
        point = JointTrajectoryPoint(
            positions=list(q), velocities=list(qd), accelerations=list(qdd)
        )
        point.time_from_start = Duration(sec=int(time), nanosec=round((time % 1) * 1e9))
        trajectory.points.append(point)
    bench.publisher(JointTrajectory, "arm/joint_trajectory").publish(trajectory)
    assert not ask(bench, "identify")[0]
    bench.until(lambda: samples(bench) > 3700, "7 s of joint states")
    success, message = ask(bench, "stop")
    assert success, message
    count, seconds, rate = re.findall(r"recorded (\d+) samples, ([\d.]+) s, ([\d.]+) Hz", message)[
        0
    ]
    assert int(count) > 3700
    assert float(rate) == pytest.approx(500.0, rel=0.02)
    assert float(seconds) == pytest.approx(int(count) / 500.0, rel=0.02)

    success, message = ask(bench, "identify")
    assert success
    assert "started to identify auto+fri" in message
    success, message = ask(bench, "identify")
    assert not success
    assert "wait for the end" in message
    success, message = ask(bench, "start")
    assert success, "it records on while it identifies"
    assert re.search(r"the disk has [\d.]+ GB .* MB/s", message)
    bench.until(lambda: samples(bench) > 500, "a second of joint states")
    success, message = ask(bench, "stop")
    assert success
    assert float(re.findall(r"([\d.]+) Hz", message)[0]) == pytest.approx(500.0, rel=0.02)

    def found() -> dict[str, str]:
        assert "~/identify failed" not in identify.output, identify.output
        values = bench.values("identify: identification")
        return values if "model file" in values else {}

    values = bench.until(found, "the model")
    assert {f"held-out error {joint}" for joint in JOINTS} <= set(values)
    assert "RMSE" in identify.output
    model = Model.load(Path(values["model file"]))
    assert model.joints == JOINTS
    mechanism = model.record.get("mechanism")
    assert (isinstance(mechanism, dict) and mechanism["name"] == "arm6") == KNOWN
    success, message = ask(bench, "save")
    assert success
    saved = folder / "out" / "model.npz"
    assert str(saved) in message
    still = np.zeros((1, 6))
    np.testing.assert_array_equal(
        Model.load(saved).predict(still, still, still), model.predict(still, still, still)
    )
    saved.write_bytes(b"of yesterday")
    success, message = ask(bench, "save")
    assert success
    (kept,) = saved.parent.glob("model_*.npz")
    assert kept.read_bytes() == b"of yesterday"
    assert kept.name in message
    assert ask(bench, "clear")[0]
    assert not ask(bench, "save")[0]
    assert Path(values["model file"]).exists()


def test_an_identification_that_is_impossible_is_reported(
    bench: Bench, identify: Process, arm: Process
) -> None:
    assert ask(bench, "start")[0]
    bench.until(lambda: samples(bench) > 100, "some joint states")
    assert ask(bench, "stop")[0]
    assert ask(bench, "identify")[0]
    bench.until(lambda: "~/identify failed: " in identify.output, "the reason")
    success, message = ask(bench, "save")
    assert not success
    assert "the last identification failed" in message
    assert ask(bench, "identify")[0]
    success, message = ask(bench, "clear")
    assert success
    assert "stopped identifying" in message


def test_a_flood_of_bad_messages_is_counted_and_survived(
    bench: Bench, identify: Process, arm: Process
) -> None:
    assert ask(bench, "start")[0]
    publisher = bench.publisher(JointState, "joint_states")
    bad = [
        b"junk", b"\x00\x01\x00\x00" + b"\xff" * 40,
        JointState(), JointState(name=["a", "a"], position=[0.0, 0.0]),
        JointState(name=["a"], position=[]), JointState(name=["a"], position=[1.0, 2.0]),
        JointState(name=["a"], position=[math.nan]), JointState(name=["a"], effort=[1.0, 2.0]),
    ]  # fmt: skip
    for _ in range(100):
        for message in bad:
            publisher.publish(message)
        bench.spin(0.005)
    bench.until(
        lambda: int(bench.values("identify: input").get("not a joint state", "0")) > 50,
        "bad messages counted",
    )
    before = samples(bench)
    bench.until(lambda: samples(bench) > before + 100, "good messages still recorded")
    ignored = r"\[WARN\] \[([\d.]+)\] \[\w+\]: ignored"
    warned = [float(at) for at in re.findall(ignored, identify.output)]
    assert warned
    assert len(warned) <= warned[-1] - warned[0] + 2, "at most one warning a second"
    success, message = ask(bench, "stop")
    assert success, message
    bag = Path(re.findall(r" to (/\S+)", message)[0])
    assert load(bag, joints=JOINTS).position.shape[1] == 6


def test_recordings_that_exist_are_compared_and_a_wrong_one_is_named(
    bench: Bench, folder: Path
) -> None:
    small_model.save_small_model(folder / "small.npz")
    bag = small_model.recorded_bag(folder / "earlier", drag=0.9)
    params = {
        "output_directory": str(folder / "loaded"), "model_file": str(folder / "small.npz"),
        "recordings": [str(bag)],
    }  # fmt: skip
    process = bench.start("identify", namespace="loaded", params=params)
    node = "loaded/identify"
    loaded = bench.until(lambda: bench.values(f"{node}: recordings").get("recording 1"), "the bag")
    assert "3000 samples in 30.0 s of a, b" in loaded
    assert ask(bench, "compare", node)[0]
    bags = bench.until(lambda: bench.values(f"{node}: comparison").get("recordings"), "its end")
    assert bags == str(bag)
    success, message = ask(bench, "load", node)
    assert not success
    assert "all loaded" in message
    bench.set_parameter(node, "recordings", [str(bag), str(folder / "absent")])
    assert ask(bench, "load", node)[0]
    bench.until(lambda: "~/load failed: " in process.output, "the reason")
    assert "no such file" in process.output
    assert ask(bench, "compare", node)[0], "what was loaded stays"


def test_a_recording_survives_a_kill(bench: Bench, arm: Process, folder: Path) -> None:
    directory = folder / "killed"
    process = bench.start(
        "identify", namespace="second",
        params={"output_directory": str(directory), "bag_prefix": "precious"},
    )  # fmt: skip
    relay = bench.node.create_publisher(JointState, "/second/joint_states", 1000)
    state = JointState(name=["a", "b"], position=[0.0, 0.0], effort=[0.0, 0.0])
    bench.until(relay.get_subscription_count, "the recorder")
    assert ask(bench, "start", "/second/identify")[0]

    def more(wanted: int) -> bool:
        for _ in range(20):
            state.header.stamp = bench.node.get_clock().now().to_msg()
            relay.publish(state)
        return samples(bench, "second/identify") >= wanted

    bench.until(partial(more, 300), "samples on their way")
    seen = samples(bench, "second/identify")
    process.signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    (bag,) = directory.glob("precious_*")
    assert not (bag / "metadata.yaml").exists()
    recording = load(bag)
    assert recording.joints == ("a", "b")
    assert len(recording) >= seen


def test_a_parameter_of_a_joint_that_cannot_be_is_reported_and_survived(
    bench: Bench, folder: Path
) -> None:
    params = {"output_directory": str(folder / "wrong"), "effort_scale.a": 2}  # not 2.0
    bench.start("identify", namespace="wrong", params=params)
    states = bench.publisher(JointState, "wrong/joint_states")
    message = JointState(name=["a"], position=[0.1], effort=[0.2])

    def reported() -> Any:
        states.publish(message)
        status = bench.statuses.get("wrong/identify: housekeeping")
        return status is not None and "effort_scale.a" in status.message

    success, said = ask(bench, "start", "wrong/identify")
    assert success, said
    bench.until(reported, "the parameter is named")
    assert bench.values("wrong/identify: input")
    assert ask(bench, "stop", "wrong/identify")[0]
    success, said = ask(bench, "identify", "wrong/identify")
    assert not success
    assert "effort_scale.a" in said


def test_ctrl_c_twice_ends_the_bag_properly(
    bench: Bench, identify: Process, arm: Process, folder: Path
) -> None:
    bags = set((folder / "out").glob("recording_*"))
    assert ask(bench, "start")[0]
    bench.until(lambda: samples(bench) > 100, "samples")
    identify.signal(signal.SIGINT)
    identify.signal(signal.SIGINT)
    assert identify.wait() == 0
    (bag,) = {path for path in (folder / "out").glob("recording_*") if path.is_dir()} - bags
    assert (bag / "metadata.yaml").exists()
    assert len(load(bag, joints=JOINTS)) > 100
    assert "Traceback" not in identify.output
