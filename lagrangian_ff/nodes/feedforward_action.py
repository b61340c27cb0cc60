"""The action FollowJointTrajectory of the feedforward: goals go on to the controller with effort.

    ~/follow_joint_trajectory               server, for MoveIt or anyone
    CONTROLLER/follow_joint_trajectory      client, of joint_trajectory_controller

Answers, feedback, results, cancelling and preemption are those of the controller.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.lifecycle import LifecycleNode
from rclpy.task import Future
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.status import Level, Status, ThrottledWarnings
from lagrangian_ff.nodes.feedforward_controller import ControllerFacts, optional
from lagrangian_ff.nodes.feedforward_references import Filled
from lagrangian_ff.nodes.streaming.plan import reason

ACTION = "follow_joint_trajectory"
MISSING = (
    "control_msgs is not installed, so no goals are taken (sudo apt install "
    "ros-jazzy-control-msgs); trajectories on ~/reference are"
)
LOST = "the controller has gone: its action server is no longer there"


class Relay:
    """A goal on its way through: the client's on one side, the controller's on the other."""

    def __init__(self) -> None:
        self.goal: Any = None
        self.controller: Any = None

    def on_feedback(self, message: Any) -> None:
        """Pass feedback of the controller on."""
        if self.goal is not None and self.goal.is_active:
            self.goal.publish_feedback(message.feedback)


def _accepted(handle: Any) -> bool:
    """Return whether a controller accepted a goal; None is a controller that has gone."""
    return handle is not None and bool(handle.accepted)


@dataclass
class Count:
    """The goals since the node was configured, and the points of the last one."""

    goals: int = 0
    with_effort: int = 0
    rejected: int = 0
    given: int = 0
    sent: int = 0
    error: float = 0.0
    before: float = 0.0
    refused_effort: bool = False


class GoalProxy:
    """Forwards goals of FollowJointTrajectory, with effort where the controller takes it.

    Args:
        controller: name of the controller; its action is `controller/follow_joint_trajectory`.
        facts: what the controller answered.
        fill: returns a trajectory with its effort; may raise UserError.
        silent: returns why no effort is to be filled now, or "".
    """

    def __init__(
        self,
        node: LifecycleNode,
        controller: str,
        facts: ControllerFacts,
        warnings: ThrottledWarnings,
        fill: Callable[[JointTrajectory], Filled],
        silent: Callable[[], str],
    ) -> None:
        self._node, self._name, self._facts, self._warnings = node, controller, facts, warnings
        self._fill_trajectory, self._silent = fill, silent
        self._count, self._without = Count(), ""
        self._relays: dict[int, Relay] = {}
        self._waiting: list[Future] = []
        interfaces = optional("control_msgs.action")
        self._kind: Any = None
        if interfaces is None:
            return
        self._kind = kind = interfaces.FollowJointTrajectory
        # A goal is answered when the controller has answered; others come in the meantime.
        group = ReentrantCallbackGroup()
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="goals")
        self._client = ActionClient(node, kind, f"{controller}/{ACTION}", callback_group=group)
        self._server = ActionServer(
            node,
            kind,
            f"~/{ACTION}",
            self._execute,
            goal_callback=self._on_goal,
            cancel_callback=self._on_cancel,
            callback_group=group,
        )

    def close(self) -> Sequence[Future]:
        """Cancel what is under way, since nobody can reach it any more, and release everything.

        Returns:
            the answers of the controller that are still to come.
        """
        if self._kind is None:
            return ()
        asked = [relay.controller.cancel_goal_async() for relay in self._relays.values()]

        def release(_: Future | None = None) -> None:
            if all(answer.done() for answer in asked):
                self._client.destroy()

        self._server.destroy()
        self._worker.shutdown(wait=False, cancel_futures=True)
        for answer in asked:
            answer.add_done_callback(release)
        if not asked:
            release()
        return asked

    async def _on_goal(self, request: Any) -> GoalResponse:
        """Answer with what the controller answers."""
        self._count.goals += 1
        if not self._client.server_is_ready():
            self._count.rejected += 1
            self._warnings.add("rejected goal", f"rejected a goal: {self._absent()}")
            return GoalResponse.REJECT
        relay = Relay()
        filled = await self._filled(request.trajectory)
        handle = None
        if filled is not None:
            handle = await self._send(request, filled.message, relay)
            self._count.refused_effort = not _accepted(handle)
        if not _accepted(handle):
            plain = await self._send(request, request.trajectory, relay)
            if filled is not None and _accepted(plain):
                self._without = "the controller rejected it with effort, and took it without"
                self._warnings.add("goal without effort", f"goal without effort: {self._without}")
            filled, handle = None, plain
        if not _accepted(handle):
            self._count.rejected += 1
            self._count.refused_effort = False
            self._warnings.add("rejected goal", f"{self._name} rejected a goal; its log says why")
            return GoalResponse.REJECT
        self._note(request.trajectory, filled)
        relay.controller = handle
        self._relays[id(request)] = relay
        return GoalResponse.ACCEPT

    async def _send(self, request: Any, trajectory: JointTrajectory, relay: Relay) -> Any:
        goal = self._kind.Goal()
        for name in goal.get_fields_and_field_types():
            setattr(goal, name, getattr(request, name))
        goal.trajectory = trajectory
        return await self._answer(self._client.send_goal_async(goal, relay.on_feedback))

    async def _answer(self, asked: Future) -> Any:
        """Return the controller's answer; None if it has gone."""
        answer = self._future()

        def take(asked: Future) -> None:
            if not answer.done():
                answer.set_result(asked.result())

        asked.add_done_callback(take)
        self._waiting.append(answer)
        try:
            return await answer
        finally:
            self._waiting.remove(answer)

    async def _filled(self, trajectory: JointTrajectory) -> Filled | None:
        """Return the trajectory with effort, or None, with the reason in `_without`."""
        verdict = self._facts.verdict()
        self._without = self._silent()
        if verdict.effort is False:
            self._without = verdict.said
        elif any(point.effort for point in trajectory.points):
            self._without = "it brought its own effort"
        if self._without:
            return None
        future, executor = self._future(), self._node.executor
        assert executor is not None

        def work() -> None:
            try:
                found: Filled | Exception = self._fill_trajectory(trajectory)
            except Exception as error:
                found = error
            future.set_result(found)
            executor.wake()

        self._worker.submit(work)
        found = await future
        if isinstance(found, Filled):
            return found
        self._without = reason(found)
        if not isinstance(found, UserError):
            self._without = f"it has no torque: {self._without}"
        self._warnings.add("goal without effort", f"a goal passes without effort: {self._without}")
        return None

    def _note(self, given: JointTrajectory, filled: Filled | None) -> None:
        if filled is None:
            text = f"as it is: {self._without}"
        else:
            count, sent = self._count, len(filled.message.points)
            count.with_effort += 1
            count.given, count.sent = len(given.points), sent
            count.error, count.before = filled.error, filled.before
            text = (
                f"with effort at {sent} points, between which torque is right within "
                f"{filled.error:.1%} of the largest ({filled.before:.1%} with those given)"
            )
            if filled.excess:
                self._warnings.add("out of range", filled.excess)
        self._node.get_logger().info(
            f"a goal of {len(given.points)} points goes to {self._name} {text}"
        )

    async def _execute(self, goal: Any) -> Any:
        """Return the controller's result."""
        relay = self._relays[id(goal.request)]
        relay.goal = goal
        try:
            response = await self._answer(relay.controller.get_result_async())
        finally:
            del self._relays[id(goal.request)]
        if response is None:
            goal.abort()
            self._warnings.add("lost goal", f"a goal was aborted: {LOST}")
            return self._kind.Result(error_code=self._kind.Result.INVALID_GOAL, error_string=LOST)
        if response.status == GoalStatus.STATUS_SUCCEEDED:
            goal.succeed()
        elif response.status == GoalStatus.STATUS_CANCELED and goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return response.result

    async def _on_cancel(self, goal: Any) -> CancelResponse:
        """Answer with what the controller answers."""
        relay = self._relays.get(id(goal.request))
        if relay is None:
            return CancelResponse.REJECT
        answer = await self._answer(relay.controller.cancel_goal_async())
        return CancelResponse.ACCEPT if answer and answer.goals_canceling else CancelResponse.REJECT

    def _future(self) -> Future:
        return Future(executor=self._node.executor)

    def _absent(self) -> str:
        return (
            f"there is no action {self._name}/{ACTION}; start the controller, or name it in the "
            "parameter controller"
        )

    def status(self) -> Status:
        """Return the state of the controller and of the goals."""
        if self._kind is None:
            return Status(Level.WARN, MISSING)
        verdict, count = self._facts.verdict(), self._count
        values: dict[str, object] = {
            "controller": self._name,
            "goals": count.goals,
            "goals with effort": count.with_effort,
            "goals rejected": count.rejected,
            "points given": count.given,
            "points sent": count.sent,
            "torque error between points": count.error,
            "torque error between the given points": count.before,
            "last goal without effort": self._without,
        }
        if not self._client.server_is_ready():
            for answer in self._waiting:
                if not answer.done():
                    answer.set_result(None)
            return Status(Level.WARN, self._absent(), values)
        said, good = verdict.said, verdict.good
        if count.refused_effort:
            said, good = f"{self._name} rejects effort; update it, or see its log", False
        elif silent := self._silent():
            said, good = f"goals pass without effort: {silent}", False
        return Status(Level.OK if good else Level.WARN, said, values)
