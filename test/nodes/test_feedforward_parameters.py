"""Parameters of the feedforward over DDS: misspelt, set too late, and of what is not installed."""

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy")

from feedforward_bench import Feedforward
from node_harness import Bench, open_bench
from small_model import save_small_model


@pytest.fixture(scope="module")
def folder(tmp_path_factory: Any) -> Path:
    path: Path = tmp_path_factory.mktemp("parameters")
    save_small_model(path / "model.npz")
    return path


@pytest.fixture(scope="module")
def bench(ros_environment: dict[str, str], folder: Path) -> Iterator[Bench]:
    with open_bench(folder) as bench:
        yield bench


@pytest.fixture(scope="module")
def node(bench: Bench, folder: Path) -> Feedforward:
    return Feedforward(bench, folder)


def test_parameters_that_were_read_are_not_set_without_effect(node: Feedforward) -> None:
    for name, value in (("rate", 100.0), ("effects_file", "mine.py")):
        answer = node.bench.set_parameter("feedforward", name, value)
        assert not answer.successful
        assert "deactivate" in answer.reason
    assert node.bench.set_parameter("feedforward", "point_error", 0.02).successful


def test_silence_is_one_reason_however_long(node: Feedforward) -> None:
    node.bench.until(node.set_point, "torque of set-points")
    node.until_silent("no set-points")
    node.bench.until(lambda: "faded" in node.bench.values("feedforward: stream"), "the count")
    before = int(node.bench.values("feedforward: stream")["faded"])
    node.bench.spin(2.5)
    assert int(node.bench.values("feedforward: stream")["faded"]) == before


@pytest.mark.parametrize("name", ["scale.shouldr", "limits.a.effort_rat", "terms.grav"])
def test_a_misspelt_parameter_is_not_taken_for_none(bench: Bench, folder: Path, name: str) -> None:
    process = bench.start(
        "feedforward",
        namespace="misspelt",
        params={"model_file": str(folder / "model.npz"), name: 0.2},
    )
    bench.until(lambda: f"there is no parameter {name}" in process.output, "a reason")
    assert bench.state("misspelt/feedforward") == "unconfigured"
    process.end()


@pytest.mark.skipif(find_spec("control_msgs") is not None, reason="control_msgs is installed")
def test_without_control_msgs_it_says_what_to_install_and_takes_references(
    bench: Bench, folder: Path
) -> None:
    node = Feedforward(bench, folder, namespace="plain", controller="arm_controller")
    status = "plain/feedforward: controller"
    said = bench.until(lambda: bench.statuses.get(status), "its state").message
    assert "ros-jazzy-control-msgs" in said
    node.hold()
