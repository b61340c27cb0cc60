"""A new service of the identify node is one class and one line in the list of jobs."""

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

import rclpy
from node_harness import Bench, heard, open_bench
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from toy_job import Count

from lagrangian_ff.nodes.common.topics import stamp
from lagrangian_ff.nodes.identify import IdentifyNode
from lagrangian_ff.nodes.recorder.jobs import JOBS, Job

WITH_TOY: tuple[type[Job], ...] = (*JOBS, Count)
SAMPLES = 50


@pytest.fixture
def bench(
    ros_environment: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Bench]:
    """Yield a bench beside an identify node with the toy job, in this process."""
    # The process that does the job finds the toy as this one does.
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent), prepend=":")
    with open_bench(tmp_path) as bench:
        context = Context()
        params = {"output_directory": tmp_path, **heard("/joint_states")}
        given = [text for name, value in params.items() for text in ("-p", f"{name}:={value}")]
        rclpy.init(args=["--ros-args", *given], context=context)
        node = IdentifyNode(WITH_TOY, context=context)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        thread = threading.Thread(target=executor.spin, daemon=True)
        thread.start()
        yield bench
        executor.shutdown()
        thread.join(timeout=10.0)
        node.close()
        node.destroy_node()
        context.try_shutdown()


def ask(bench: Bench, action: str) -> tuple[bool, str]:
    response = bench.call(Trigger, f"identify/{action}")
    return response.success, response.message


def test_a_toy_job_is_served(bench: Bench, tmp_path: Path) -> None:
    success, message = ask(bench, "count")
    assert not success
    assert "nothing recorded: call ~/start" in message
    assert ask(bench, "start")[0]
    publisher = bench.publisher(JointState, "joint_states")
    for number in range(SAMPLES):
        state = JointState(name=["a"], position=[0.1 * number], effort=[1.0])
        state.header.stamp = stamp(1_700_000_000_000_000_000 + number * 10_000_000)
        publisher.publish(state)
    bench.until(lambda: bench.values("identify: input").get("samples") == str(SAMPLES), "samples")
    assert ask(bench, "stop")[0]
    assert ask(bench, "count") == (True, "started to count 1 recordings")
    bench.until(lambda: bench.values("identify: size").get("label") == "waiting", "its progress")
    assert bench.statuses["identify: size"].message == "counting: waiting"
    assert bench.values("identify: size")["progress"] == "0.5"
    assert bench.statuses["identify: identification"].message == "no model yet"
    success, message = ask(bench, "compare")
    assert not success
    assert "counting: wait for the end" in message
    (tmp_path / "go").touch()
    count = bench.until(lambda: bench.values("identify: size").get("samples"), "the count")
    assert count == str(SAMPLES)
    assert bench.statuses["identify: size"].message == f"{SAMPLES} samples"
