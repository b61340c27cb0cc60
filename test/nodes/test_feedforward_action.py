"""Goals of FollowJointTrajectory through the feedforward to a controller with the rules of JTC."""

import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from built_interfaces import follow_joint_trajectory
from builtin_interfaces.msg import Duration
from feedforward_bench import planned, tracked
from node_harness import SETTLED, Bench, open_bench
from rclpy.action import ActionClient
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from lagrangian_ff.arm import HOME, JOINTS, Trajectory, exciting_trajectory, simulate
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.recording import condition

CONTROLLER = "joint_trajectory_controller"
STATUS = "feedforward: controller"
EVERY = 0.25  # s between the points of a sparse plan


@pytest.fixture(scope="module")
def action(ros_environment: dict[str, str]) -> Iterator[Any]:
    """Yield the type of the action, for this process and for those that it starts."""
    with follow_joint_trajectory() as kind:
        yield kind


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("goals")
    recording = simulate(exciting_trajectory(5, seed=0, duration=40.0)).recording
    found = identify(condition(recording), Settings(train=1.0, samples=500))
    found.model.save(path / "model.npz")
    return path


@pytest.fixture(scope="module")
def bench(action: Any, folder: Path) -> Iterator[Bench]:
    with open_bench(folder) as bench:
        yield bench


class Robot:
    """A controller, a feedforward before it, and a client, each by its own name."""

    def __init__(
        self, bench: Bench, action: Any, folder: Path, name: str,
        controller: dict[str, Any] | None = None, **feedforward: Any,
    ) -> None:  # fmt: skip
        self.bench, self.action = bench, action
        self.status = f"{name}/{STATUS}"
        self.controller = bench.start(
            "stand_in_controller", namespace=name, params=controller or {}
        )
        self.node = bench.start(
            "feedforward",
            namespace=name,
            params={
                "model_file": str(folder / "model.npz"),
                "controller": CONTROLLER,
                "out_of_range": "allow",
                "joint_state_timeout": 0.0,
                **feedforward,
            },
        )
        topic = f"/{name}/feedforward/follow_joint_trajectory"
        self.client = ActionClient(bench.node, action, topic)
        bench.until(self.client.server_is_ready, "the action of the feedforward")
        bench.spin(SETTLED)
        bench.until(lambda: self.said, "the state of the controller")
        bench.until(lambda: "no action" not in self.said, "the controller")
        self.feedback: list[Any] = []

    @property
    def said(self) -> str:
        status = self.bench.statuses.get(self.status)
        return "" if status is None else str(status.message)

    def send(self, trajectory: JointTrajectory) -> Any:
        """Send a goal and return its handle when it is answered."""
        self.feedback = []
        goal = self.action.Goal(trajectory=trajectory)
        future = self.client.send_goal_async(
            goal, feedback_callback=lambda message: self.feedback.append(message.feedback)
        )
        self.bench.until(future.done, "the answer to a goal")
        return future.result()

    def result(self, handle: Any) -> Any:
        future = handle.get_result_async()
        self.bench.until(future.done, "the result of a goal")
        return future.result()

    def run(self, trajectory: JointTrajectory) -> tuple[float, int]:
        """Follow a trajectory from its start; return the rms error, mrad, and the points sent."""
        q = list(trajectory.points[0].positions)
        assert self.result(self.send(move(q, 3.0))).status == GoalStatus.STATUS_SUCCEEDED
        before = self.count
        handle = self.send(trajectory)
        found = self.result(handle)
        assert found.status == GoalStatus.STATUS_SUCCEEDED
        assert found.result.error_string == "Goal successfully reached!"
        self.bench.until(lambda: self.count > before, "the count of goals")
        sent = int(self.bench.values(self.status)["points sent"])
        return tracked(self.controller), sent

    @property
    def count(self) -> int:
        return int(self.bench.values(self.status).get("goals", "0"))


def move(q: list[float], seconds: float) -> JointTrajectory:
    """Return one point to go to; the controller goes there from where it stands."""
    point = JointTrajectoryPoint(positions=q)
    point.time_from_start = Duration(sec=int(seconds), nanosec=round((seconds % 1) * 1e9))
    return JointTrajectory(joint_names=list(JOINTS), points=[point])


def move_between(start: Any, goal: Any) -> Trajectory:
    q = np.array([start, goal])
    return Trajectory(np.array([0.0, 1.0]), q, np.zeros_like(q), np.zeros_like(q))


@pytest.fixture(scope="module")
def robot(bench: Bench, action: Any, folder: Path) -> Robot:
    return Robot(bench, action, folder, "effort")


def test_sparse_plans_are_tracked_like_dense_ones(
    robot: Robot, bench: Bench, action: Any, folder: Path
) -> None:
    bench.until(lambda: "effort is filled" in robot.said, "a controller that takes effort")
    path = exciting_trajectory(5, seed=3, duration=8.0)
    sparse = planned(path, EVERY, JOINTS)
    proxied, sent = robot.run(sparse)
    dense, most = robot.run(planned(path, 0.004, JOINTS))
    assert bench.set_parameter("effort/feedforward", "point_error", 1.0).successful
    alone, given = robot.run(sparse)
    assert bench.set_parameter("effort/feedforward", "point_error", 0.01).successful
    print(
        f"\ntracking, rms mrad: {alone:.2f} with the {given} points of the plan, "
        f"{proxied:.2f} with {sent}, {dense:.2f} with {most}"
    )
    assert proxied < 1.05 * dense
    assert alone > 1.25 * dense
    assert sent < most


def test_cancelling_reaches_the_controller(robot: Robot) -> None:
    handle = robot.send(move([q + 0.1 for q in HOME], 20.0))
    assert handle.accepted
    robot.bench.until(lambda: robot.feedback, "feedback")
    future = handle.cancel_goal_async()
    robot.bench.until(future.done, "the answer to cancelling")
    assert future.result().return_code == CancelGoal.Response.ERROR_NONE
    found = robot.result(handle)
    assert found.status == GoalStatus.STATUS_CANCELED
    assert found.result.error_string == "Trajectory canceled"


def test_a_new_goal_preempts_and_both_clients_hear_of_it(robot: Robot) -> None:
    old = robot.send(move([q + 0.1 for q in HOME], 20.0))
    new = robot.send(move(list(HOME), 1.0))
    first, second = robot.result(old), robot.result(new)
    assert first.status == GoalStatus.STATUS_ABORTED
    assert "new incoming action" in first.result.error_string
    assert second.status == GoalStatus.STATUS_SUCCEEDED


def test_a_goal_that_the_controller_rejects_is_rejected(robot: Robot) -> None:
    wrong = move([0.0] * 6, 1.0)
    wrong.joint_names[0] = "elbow"
    assert not robot.send(wrong).accepted


def test_a_goal_without_torque_passes_as_it_is(robot: Robot) -> None:
    assert robot.bench.set_parameter("effort/feedforward", "out_of_range", "refuse").successful
    far = planned(exciting_trajectory(5, seed=3, duration=8.0), EVERY, JOINTS)
    for point in far.points:
        point.positions = [q + 40.0 for q in point.positions]
    handle = robot.send(far)
    assert handle.accepted
    cancelled = handle.cancel_goal_async()
    robot.bench.until(cancelled.done, "the answer to cancelling")
    robot.bench.until(
        lambda: (
            "outside the identified range"
            in robot.bench.values(robot.status)["last goal without effort"]
        ),
        "the reason",
    )
    assert robot.bench.set_parameter("effort/feedforward", "out_of_range", "allow").successful


@pytest.mark.parametrize(
    ("name", "controller", "said"),
    [
        ("position", {"command_interfaces": ["position"]}, "command_interfaces to [position, ef"),
        (
            "none",
            {"command_interfaces": ["position"], "offered": ["position", "velocity"]},
            "the hardware offers no effort command interface for joint_1",
        ),
        ("scaled", {"gains.joint_2.ff_velocity_scale": 1.0}, "gains.joint_2.ff_velocity_scale"),
    ],
)
def test_it_says_what_to_configure(
    bench: Bench, action: Any, folder: Path, name: str, controller: dict[str, Any], said: str
) -> None:
    robot = Robot(bench, action, folder, name, controller)
    bench.until(lambda: said in robot.said, said)
    handle = robot.send(planned(exciting_trajectory(5, seed=3, duration=8.0), EVERY, JOINTS))
    assert handle.accepted
    handle.cancel_goal_async()


def test_a_controller_that_rejects_effort_gets_goals_without(
    bench: Bench, action: Any, folder: Path
) -> None:
    robot = Robot(bench, action, folder, "old", {"old": True})
    path = planned(exciting_trajectory(5, seed=3, duration=8.0), EVERY, JOINTS)
    handle = robot.send(path)
    assert handle.accepted
    bench.until(lambda: "rejects effort" in robot.said, "a word")
    handle.cancel_goal_async()


def test_a_path_violation_comes_back_as_it_is(bench: Bench, action: Any, folder: Path) -> None:
    robot = Robot(bench, action, folder, "strict", {"path_tolerance": 1e-5})
    found = robot.result(robot.send(move([q + 0.5 for q in HOME], 1.0)))
    assert found.status == GoalStatus.STATUS_ABORTED
    assert found.result.error_code == action.Result.PATH_TOLERANCE_VIOLATED


def test_goals_end_when_the_controller_goes(bench: Bench, action: Any, folder: Path) -> None:
    robot = Robot(bench, action, folder, "going")
    handle = robot.send(move([q + 0.1 for q in HOME], 20.0))
    assert handle.accepted
    robot.controller.end()
    found = robot.result(handle)
    assert found.status == GoalStatus.STATUS_ABORTED
    assert "gone" in found.result.error_string
    bench.until(lambda: "no action" in robot.said, "a word that the controller is missing")
    assert not robot.send(move(list(HOME), 1.0)).accepted


def test_a_node_that_ends_cancels_what_nobody_can_reach_any_more(
    bench: Bench, action: Any, folder: Path
) -> None:
    robot = Robot(bench, action, folder, "ending")
    assert robot.send(move([q + 0.1 for q in HOME], 20.0)).accepted
    robot.controller.signal(signal.SIGSTOP)  # a busy machine: it reads when the node has ended
    robot.node.signal(signal.SIGTERM)
    time.sleep(0.4)
    robot.controller.signal(signal.SIGCONT)
    assert robot.node.wait() == 0
    bench.until(lambda: "goal canceled" in robot.controller.output, "the cancelled goal")


def test_torque_is_not_streamed_where_nobody_controls_the_position(
    bench: Bench, action: Any, folder: Path
) -> None:
    group = {"type": "effort_controllers/JointGroupEffortController"}
    robot = Robot(bench, action, folder, "alone", group)
    commands = bench.collect(Float64MultiArray, "alone/feedforward/commands")
    send = bench.publisher(JointTrajectory, "alone/feedforward/reference")
    send.publish(planned(move_between(HOME, HOME), 0.1, JOINTS))
    stream = "alone/feedforward: stream"
    bench.until(
        lambda: "nobody controls its position" in bench.statuses[stream].message, "the refusal"
    )
    assert commands
    assert not any(any(message.data) for _, message in commands)
    assert bench.set_parameter("alone/feedforward", "without_position_loop", True).successful
    bench.until(lambda: any(commands[-1][1].data), "the torque that was allowed")
    robot.controller.end()
