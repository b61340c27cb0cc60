"""The way of a reference from its topic to a plan that the stream plays."""

from dataclasses import dataclass

import numpy as np
from rclpy.lifecycle import LifecycleNode
from rclpy.serialization import deserialize_message
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common import topics
from lagrangian_ff.nodes.common.node import Parameters
from lagrangian_ff.nodes.common.pacing import NodeTime
from lagrangian_ff.nodes.common.status import Status, ThrottledWarnings
from lagrangian_ff.nodes.streaming.dense import linear_error, needed
from lagrangian_ff.nodes.streaming.plan import Plan, Planner, Policy, make_plan, reason
from lagrangian_ff.nodes.streaming.ranges import PAUSE, doubt_status
from lagrangian_ff.nodes.streaming.reference import (
    Reference,
    RefusedReference,
    read_path,
    read_reference,
)
from lagrangian_ff.nodes.streaming.replacing import ReadyModel
from lagrangian_ff.nodes.streaming.stream import TorqueStream

LOOK_EVERY = 10  # periods between evaluations of the doubt of set-points without a limit
LONGEST_SETPOINT = 16_384  # bytes; a longer message is read in the planner's thread


@dataclass(frozen=True)
class Filled:
    """A trajectory with effort.

    Attributes:
        message: with the points that it needs.
        error: of torque that is linear between these points, the largest of all joints, in parts
            of the largest torque identified on the joint.
        before: the same with the points that were given.
        excess: where it leaves the identified range, in words; "" if it does not.
    """

    message: JointTrajectory
    error: float
    before: float
    excess: str


class References:
    """Takes references, has their torques computed, and hands the plans to the stream.

    A set-point is taken and computed in the stream's own thread, at the tick that sends it: between
    threads it would wait for each of them. Trajectories are computed in the planner's.

    Attributes:
        active: whether references are followed.
    """

    def __init__(
        self,
        node: LifecycleNode,
        parameters: Parameters,
        warnings: ThrottledWarnings,
        time: NodeTime,
        model: ReadyModel,
        stream: TorqueStream,
    ) -> None:
        self._node, self._parameters, self._warnings = node, parameters, warnings
        self._time = time
        self._joints, self._ready, self._stream = model.model.joints, model, stream
        self.active = False
        self._followed = self._superseded = self._looks = 0
        self._planner: Planner[JointTrajectory | None] = Planner(
            model.model, self._on_plan, self._refused, model.doubt
        )
        self.refresh()
        self._trajectories = topics.advertise(
            node, JointTrajectory, "~/joint_trajectory", topics.RELIABLE
        )
        self._subscription = topics.PolledSubscription(
            node, JointTrajectory, "~/reference", topics.REFERENCES, raw=True
        )
        # The doubt takes milliseconds: it is evaluated beside the stream.
        self._look = node.create_timer(PAUSE, self._look_at_doubt)

    def refresh(self) -> None:
        """Apply changed parameters."""
        value = self._parameters.value
        self._policy = Policy(
            value("out_of_range"), value("range_margin"), value("fade_time"), value("doubt_limit")
        )
        self._longest = value("max_points")

    @property
    def idle(self) -> bool:
        """Return whether no trajectory is being computed."""
        return self._planner.idle

    def use(self, model: ReadyModel) -> None:
        """Use another model from now on, and for the present reference too; in the stream's thread.

        Trajectories that are being computed would be lost: wait until it is `idle`.
        """
        self._ready = model
        self._planner.use(model.model, model.doubt)
        plan = self._stream.plan
        if plan is not None:
            reference = plan.reference
            self._planner.submit(lambda: (reference, None), self._policy)

    def drop(self) -> None:
        """Drop the trajectories that are still being planned."""
        self._planner.drop()

    def close(self) -> None:
        """Release everything."""
        self._planner.stop()
        self._node.destroy_timer(self._look)
        self._node.destroy_publisher(self._trajectories)
        self._subscription.destroy()

    def ignore(self) -> None:
        """Drop the references that came while nothing is streamed."""
        if not self.active and any(True for _ in self._subscription.take()):
            self._warnings.add("reference while inactive", "ignored a reference: not active")

    def follow(self) -> None:
        """Follow the references that came, oldest first; in the stream's thread.

        After a stall only the newest of several set-points is computed.
        """
        if not self.active:
            self.ignore()
            return
        waiting = None
        for data, _ in self._subscription.take():
            message = None
            if len(data) <= LONGEST_SETPOINT:
                try:
                    message = deserialize_message(data, JointTrajectory)
                except Exception as error:  # of rclpy; the bytes are no trajectory
                    self._refused(error)
                    continue
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
        """Let the planner compute a trajectory; a long one is still serialised."""

        def read() -> tuple[Reference, JointTrajectory]:
            if (count := topics.count_points(data)) > self._longest:
                raise RefusedReference(f"{count} points; expected 1 to {self._longest}")
            whole = message or deserialize_message(data, JointTrajectory)
            return self._read(whole), whole

        self._planner.submit(read, self._policy)

    def _follow_setpoint(self, message: JointTrajectory) -> None:
        try:
            doubt = self._ready.doubt
            doubts = doubt.latest if doubt else None
            model = self._ready.one_state
            plan = make_plan(model, self._read(message), self._policy, doubts=doubts)
        except UserError as error:
            self._refused(error)
            return
        # A trajectory still being planned is out of date.
        self._planner.drop()
        if plan.excess.worst and self._policy.out_of_range == "fade":
            self._warnings.add("out of range", f"faded: {plan.excess.worst}")
            self._stream.withhold("the set-point is outside the identified range")
            return
        at = topics.nanoseconds(message.header.stamp)
        self._play(plan, at or self._time.now())
        if self._trajectories.get_subscription_count():
            self._publish_annotated(plan, message, at)

    def _read(self, message: JointTrajectory) -> Reference:
        """Return the reference in a message, or raise RefusedReference."""
        return read_reference(topics.points(message), self._joints, self._longest)

    def _play(self, plan: Plan, start: int) -> None:
        self._stream.play(plan, start, self._time.steady())
        self._followed += 1

    def _look_at_doubt(self) -> None:
        self._looks += 1
        if self._policy.doubt_limit == 0.0 and self._looks % LOOK_EVERY:
            return
        plan, doubt = self._stream.plan, self._ready.doubt
        if doubt and plan is not None and plan.reference.is_setpoint:
            doubt.look(plan.reference.q, plan.reference.qd, plan.reference.qdd)

    def _on_plan(self, plan: Plan, message: JointTrajectory | None) -> None:
        """Play and republish a planned trajectory; in the planner's thread."""
        if not self.active:
            return
        if message is None:
            self._stream.exchange(plan)
            return
        now, reference = self._time.now(), plan.reference
        delay = round(self._parameters.value("start_delay") * 1e9)
        start = topics.nanoseconds(message.header.stamp) or now + delay
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
            self._warnings.add("out of range", f"{plan.excess.worst}; the torque {met}")
        states = reference.sample(plan.time)
        for words, share in self._ready.model.curves_outside(*states).items():
            self._warnings.add(
                "outside a curve", f"{share:.0%} of the reference leaves what {words} has seen"
            )
        if ahead < 0.0:
            self._warnings.add(
                "late start",
                f"the reference started {-ahead:.3f} s before its torques were computed; stamp it "
                "later, or 0",
            )

    def fill(self, message: JointTrajectory, share: float) -> Filled:
        """Return the trajectory with the effort that its path takes, in the caller's thread.

        Args:
            share: how far torque that is linear between the points may be from that of the path,
                as a share of the largest torque identified on each joint.

        Raises:
            RefusedReference: there is no torque for this trajectory.
        """
        given = topics.points(message)
        path = read_path(given, self._joints, self._longest)
        model, now = self._ready.model, self._stream.settings
        doubts = self._ready.doubt if self._policy.doubt_limit > 0.0 else None
        plan = make_plan(model, path, self._policy, doubts=doubts)
        tau = plan.effort(now.switches, now.scale, now.effort_limit)
        largest = np.maximum(model.range.tau_max, np.finfo(float).tiny)
        at = needed(plan.time, tau, plan.own, share * largest)
        whole = read_path(given, message.joint_names, self._longest)
        return Filled(
            topics.resampled(message, whole, plan.time[at], self._joints, tau[at]),
            float(np.max(linear_error(plan.time, tau, at) / largest)),
            float(np.max(linear_error(plan.time, tau, plan.own) / largest)),
            plan.excess.worst,
        )

    def _publish_annotated(self, plan: Plan, message: JointTrajectory, start: int) -> None:
        now = self._stream.settings
        effort = plan.effort(now.switches, now.scale, now.effort_limit)[plan.own]
        self._trajectories.publish(topics.annotated(message, self._joints, effort, start))

    def _refused(self, error: Exception) -> None:
        self._warnings.add("refused reference", f"refused a reference: {reason(error)}")

    def certainty(self) -> Status:
        """Return how sure the torques of the present reference are."""
        plan = self._stream.plan
        doubt = None if plan is None else plan.doubt
        known = self._ready.doubt is not None
        return doubt_status(self._joints, known, doubt, self._policy.doubt_limit)

    def values(self) -> dict[str, object]:
        """Return figures for the diagnostics."""
        return {
            "references followed": self._followed,
            "set-points superseded": self._superseded,
            "planned": self._planner.fraction,
            "receivers of trajectories": self._trajectories.get_subscription_count(),
        }
