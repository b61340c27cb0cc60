"""Compare, diagnose and add by service, on a small model that the node loads and a motion that is
published with its own stamps, faster than it was."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy")

from node_harness import LATCHED, Bench, Process, heard, open_bench
from sensor_msgs.msg import JointState
from small_model import JOINTS, recorded_bag, save_small_model
from std_msgs.msg import String
from std_srvs.srv import Trigger

from lagrangian_ff.identification import Model
from lagrangian_ff.nodes.common.topics import stamp
from lagrangian_ff.recording import load

PUBLISHED = 3000  # samples of 10 ms


@pytest.fixture(scope="module")
def folder(tmp_path_factory: Any) -> Path:
    path: Path = tmp_path_factory.mktemp("services")
    save_small_model(path / "model.npz")
    recorded_bag(path / "measured", drag=0.9)
    return path


@pytest.fixture(scope="module")
def bench(ros_environment: dict[str, str], folder: Path) -> Iterator[Bench]:
    with open_bench(folder) as bench:
        yield bench


@pytest.fixture(scope="module")
def identify(bench: Bench, folder: Path) -> Process:
    names = {"output_directory": str(folder / "out"), "model_file": str(folder / "model.npz")}
    return bench.start("identify", params={**names, **heard("/joint_states")})


def ask(bench: Bench, action: str) -> tuple[bool, str]:
    response = bench.call(Trigger, f"identify/{action}")
    return response.success, response.message


def record(bench: Bench, folder: Path, samples: int) -> None:
    measured = load(folder / "measured")
    publisher = bench.publisher(JointState, "joint_states")
    assert ask(bench, "start")[0]
    for row in range(samples):
        message = JointState(
            name=list(JOINTS),
            position=measured.position[row].tolist(),
            effort=measured.effort[row].tolist(),
        )
        message.header.stamp = stamp(1_700_000_000_000_000_000 + row * 10_000_000)
        publisher.publish(message)
        if row % 50 == 0:
            bench.spin(0.01)
    bench.until(lambda: bench.values("identify: input").get("samples") == str(samples), "samples")
    success, message = ask(bench, "stop")
    assert success, message
    bench.node.destroy_publisher(publisher)


def test_compare_with_a_loaded_model(bench: Bench, identify: Process, folder: Path) -> None:
    record(bench, folder, PUBLISHED)
    success, message = ask(bench, "compare")
    assert success
    assert message.startswith("started to compare model.npz with recording_")
    success, message = ask(bench, "diagnose")
    assert not success
    assert "comparing: wait for the end" in message
    values = bench.until(
        lambda: bench.values("identify: comparison")
        if "JSON" in bench.values("identify: comparison") else None, "the comparison"
    )  # fmt: skip
    written = json.loads(Path(values["JSON"]).read_text())
    assert written["joints"]["b"]["rmse"] > 2.0 * written["joints"]["a"]["rmse"]
    assert Path(values["page"]).parent == folder / "out"
    assert "where 1" in values
    assert bench.statuses["identify: comparison"].message in identify.output
    # Who comes late gets it all the same.
    reports = bench.collect(String, "identify/report", LATCHED)
    bench.until(lambda: reports, "the report")
    assert json.loads(reports[-1][1].data) == written


def test_add_what_a_person_asks_for(bench: Bench, identify: Process, folder: Path) -> None:
    success, message = ask(bench, "add")
    assert not success
    assert "call ~/diagnose first" in message
    assert bench.set_parameter("identify", "add.effect", "quadratic_drag").successful
    assert bench.set_parameter("identify", "add.joint", "c").successful
    assert ask(bench, "add")[0]
    bench.until(lambda: "the model has no joint 'c'" in identify.output, "the reason")
    assert bench.set_parameter("identify", "add.joint", "b").successful
    success, message = ask(bench, "add")
    assert "started to add quadratic_drag on b to model.npz" in message
    bench.until(
        lambda: "added quadratic_drag on b" in getattr(
            bench.statuses.get("identify: addition"), "message", ""
        ), "the larger model",
    )  # fmt: skip
    new = folder / "model_quadratic_drag_b.npz"
    assert bench.values("identify: identification")["model file"] == str(new)
    assert [step["added"] for step in Model.load(new).steps][1:] == ["quadratic_drag on b"]
    success, message = ask(bench, "save")
    assert success, message
    assert Model.load(folder / "model.npz").name == Model.load(new).name


def test_a_diagnosis_that_is_impossible_is_reported(
    bench: Bench, identify: Process, folder: Path
) -> None:
    assert ask(bench, "clear")[0]
    record(bench, folder, 400)
    success, message = ask(bench, "diagnose")
    assert success
    assert "its last third is held back" in message
    bench.until(lambda: "~/diagnose failed: " in identify.output, "the reason")

    def failed() -> Any:
        status = bench.statuses.get("identify: diagnosis")
        return status if status is not None and status.level == b"\x02" else None

    assert "of motion to judge by" in bench.until(failed, "its status").message
    assert "Traceback" not in identify.output
