"""From the topic ~/reference to plans that the stream plays."""

from rclpy.lifecycle import LifecycleNode
from rclpy.serialization import deserialize_message
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Model
from lagrangian_ff.nodes.common.complaints import Complaints
from lagrangian_ff.nodes.common.errors import RefusedReference
from lagrangian_ff.nodes.common.messages import annotated, nanoseconds, points
from lagrangian_ff.nodes.common.node_time import NodeTime
from lagrangian_ff.nodes.common.parameters import Parameters
from lagrangian_ff.nodes.common.polled import PolledSubscription
from lagrangian_ff.nodes.common.qos import REFERENCES, RELIABLE, overridable
from lagrangian_ff.nodes.common.status import Status
from lagrangian_ff.nodes.feedforward_parameters import policy
from lagrangian_ff.nodes.streaming.doubt import PAUSE, Doubt, status
from lagrangian_ff.nodes.streaming.one_state import OneAtATime
from lagrangian_ff.nodes.streaming.plan import Plan, make_plan
from lagrangian_ff.nodes.streaming.planner import Planner, reason
from lagrangian_ff.nodes.streaming.reference import Reference, read_reference
from lagrangian_ff.nodes.streaming.stream import TorqueStream

TOLD_EVERY = 10  # looks at the doubt of set-points, where it is told only
LONGEST_SETPOINT = 16_384  # bytes; a longer message is read beside the stream


class References:
    """Takes references, has their torques computed, and hands the plans to the stream.

    A set-point is taken and computed in the stream's own thread, at the tick that sends it: between
    threads it would wait for each of them. Trajectories are computed in the planner's.

    Args:
        node: the node.  parameters: its parameters.  complaints: where refusals are told.
        time: what it goes by.  model: whose torques.  stream: plays the plans.

    Attributes:
        active: whether references are followed.
    """

    def __init__(
        self, node: LifecycleNode, parameters: Parameters, complaints: Complaints, time: NodeTime,
        model: Model, stream: TorqueStream,
    ) -> None:  # fmt: skip
        self._node, self._parameters, self._complaints = node, parameters, complaints
        self._time = time
        self._model, self._stream = model, stream
        self.active = False
        self._followed = self._superseded = self._looks = 0
        self._doubt = Doubt.of(model)
        self._setpoints = OneAtATime(model)
        self._planner: Planner[JointTrajectory] = Planner(
            model, self._on_plan, self._refused, self._doubt
        )
        self.refresh()
        self._trajectories = node.create_publisher(
            JointTrajectory, "~/joint_trajectory", RELIABLE, qos_overriding_options=overridable()
        )
        self._subscription = PolledSubscription(
            node, JointTrajectory, "~/reference", REFERENCES, raw=True
        )
        # What takes milliseconds is asked beside the stream.
        self._look = node.create_timer(PAUSE, self._look_at_doubt)

    def refresh(self) -> None:
        """Take up parameters that have changed."""
        self._rules = policy(self._parameters)
        self._longest = self._parameters.value("max_points")

    def drop(self) -> None:
        """Compute nothing more of what came."""
        self._planner.drop()

    def close(self) -> None:
        """Give everything back."""
        self._planner.stop()
        self._node.destroy_timer(self._look)
        self._node.destroy_publisher(self._trajectories)
        self._subscription.destroy()

    def ignore(self) -> None:
        """What comes while there is no stream is not followed later."""
        if not self.active and any(True for _ in self._subscription.take()):
            self._complaints.add("reference while inactive", "ignored a reference: not active")

    def follow(self) -> None:
        """Take what has come, oldest first; in the stream's thread.

        After a stall only the newest of many set-points is worth its time.
        """
        if not self.active:
            self.ignore()
            return
        waiting = None
        for data, _ in self._subscription.take():
            message = None
            if len(data) <= LONGEST_SETPOINT:
                message = deserialize_message(data, JointTrajectory)
            if message is not None and len(message.points) == 1:
                self._superseded += waiting is not None
                waiting = message
                continue
            if waiting is not None:
                self._follow_setpoint(waiting)
                waiting = None
            self._submit(data, message)
        if waiting is not None:
            self._follow_setpoint(waiting)

    def _submit(self, data: bytes, message: JointTrajectory | None) -> None:
        """Have a trajectory planned; a long one is still in its bytes."""

        def read() -> tuple[Reference, JointTrajectory]:
            whole = message or deserialize_message(data, JointTrajectory)
            return self._read(whole), whole

        self._planner.submit(read, self._rules)

    def _follow_setpoint(self, message: JointTrajectory) -> None:
        try:
            doubts = self._doubt.latest if self._doubt else None
            plan = make_plan(self._setpoints, self._read(message), self._rules, doubts=doubts)
        except UserError as error:
            self._refused(error)
            return
        # A trajectory still being planned is out of date.
        self._planner.drop()
        if plan.excess.worst and self._rules.out_of_range == "fade":
            self._complaints.add("out of range", f"faded: {plan.excess.worst}")
            self._stream.withhold("the set-point is outside the identified range")
            return
        at = nanoseconds(message.header.stamp)
        self._play(plan, at or self._time.now())
        if self._trajectories.get_subscription_count():
            self._publish_annotated(plan, message, at)

    def _read(self, message: JointTrajectory) -> Reference:
        """The reference in a message.

        Raises:
            RefusedReference: it cannot be followed; says why.
        """
        return read_reference(points(message), self._model.joints, self._longest)

    def _play(self, plan: Plan, start: int) -> None:
        self._stream.play(plan, start, self._time.steady())
        self._followed += 1

    def _look_at_doubt(self) -> None:
        self._looks += 1
        if self._rules.doubt_limit == 0.0 and self._looks % TOLD_EVERY:
            return
        plan = self._stream.plan
        if self._doubt and plan is not None and plan.reference.is_setpoint:
            self._doubt.look(plan.reference.q, plan.reference.qd, plan.reference.qdd)

    def _on_plan(self, plan: Plan, message: JointTrajectory) -> None:
        """Play and republish a trajectory whose torques are ready; in the planner's thread."""
        if not self.active:
            return
        now, reference = self._time.now(), plan.reference
        delay = round(self._parameters.value("start_delay") * 1e9)
        start = nanoseconds(message.header.stamp) or now + delay
        ahead = (start - now) / 1e9
        if ahead < -reference.duration:
            self._refused(RefusedReference(f"it ended {-ahead - reference.duration:.3f} s ago"))
            return
        self._play(plan, start)
        self._publish_annotated(plan, message, start)
        self._node.get_logger().info(
            f"feedforward for {len(reference.time)} points, {reference.duration:.3f} s, starts in "
            f"{ahead:.3f} s; filled in: {', '.join(reference.filled) or 'nothing'}"
        )
        if plan.excess.worst:
            met = "fades to zero there" if (plan.weight < 1.0).any() else "is sent all the same"
            self._complaints.add("out of range", f"{plan.excess.worst}; the torque {met}")
        if ahead < 0.0:
            self._complaints.add(
                "late start",
                f"the reference started {-ahead:.3f} s before its torques were computed; stamp it "
                "later, or 0",
            )

    def _publish_annotated(self, plan: Plan, message: JointTrajectory, start: int) -> None:
        now = self._stream.settings
        effort = plan.effort(now.switches, now.scale, now.effort_limit)
        self._trajectories.publish(annotated(message, self._model.joints, effort, start))

    def _refused(self, error: Exception) -> None:
        self._complaints.add("refused reference", f"refused a reference: {reason(error)}")

    def certainty(self) -> Status:
        """How sure the model is of the torques along the present reference."""
        plan = self._stream.plan
        doubt = None if plan is None else plan.doubt
        return status(self._model.joints, self._doubt is not None, doubt, self._rules.doubt_limit)

    def values(self) -> dict[str, object]:
        """For the diagnostics."""
        return {
            "references followed": self._followed,
            "set-points superseded": self._superseded,
            "planned": self._planner.fraction,
            "receivers of trajectories": self._trajectories.get_subscription_count(),
        }
