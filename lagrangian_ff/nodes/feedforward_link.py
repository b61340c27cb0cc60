"""The model, its stream and their topics: what a configured feedforward node has."""

import time

import numpy as np
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.complaints import Complaints
from lagrangian_ff.nodes.common.errors import MessageError, RefusedReference
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateReader
from lagrangian_ff.nodes.common.messages import (
    JointStateMaker,
    annotated,
    command,
    nanoseconds,
    points,
)
from lagrangian_ff.nodes.common.pacing import PacedThread, Pacer
from lagrangian_ff.nodes.common.parameters import Parameters
from lagrangian_ff.nodes.common.polled import PolledSubscription
from lagrangian_ff.nodes.common.qos import LATCHED, NEWEST, RELIABLE, overridable
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.common.summary import held_out
from lagrangian_ff.nodes.feedforward_parameters import declare_joints, policy, settings
from lagrangian_ff.nodes.streaming.doubt import Doubt, status
from lagrangian_ff.nodes.streaming.loading import load_model
from lagrangian_ff.nodes.streaming.monitor import Monitor
from lagrangian_ff.nodes.streaming.plan import Plan, make_plan
from lagrangian_ff.nodes.streaming.planner import Planner, reason
from lagrangian_ff.nodes.streaming.reference import read_reference
from lagrangian_ff.nodes.streaming.stream import Settings, TorqueStream
from lagrangian_ff.nodes.streaming.urdf_limits import effort_limits

FAREWELL = 3  # zeros sent at the end
LOOKS = 50.0  # a second, whether joint states still come


class FeedforwardLink:
    """Between the topics and the stream of torques.

    Three threads: the executor's takes messages, the planner's computes plans, the paced one
    sends.

    Raises:
        ModelError: the model cannot be loaded or is of other joints.
    """

    def __init__(self, node: LifecycleNode, parameters: Parameters, complaints: Complaints) -> None:
        self._node, self._parameters, self._complaints = node, parameters, complaints
        file = parameters.value("model_file")
        self._model, self._columns = load_model(file, parameters.strings("joints"))
        joints = self._model.joints
        declare_joints(parameters, joints)
        self._described: dict[str, float] = {}
        self._stream = TorqueStream(joints, self._settings())
        self._monitor = Monitor()
        self._reader, self._maker = JointStateReader(), JointStateMaker(joints)
        self._loop: PacedThread | None = None
        self._doubt = Doubt.of(self._model)
        self._planner: Planner[JointTrajectory] = Planner(
            self._model, self._on_plan, self._refused, self._doubt
        )
        self._make_topics()
        node.get_logger().info(f"{self._model.name} of {', '.join(joints)} loaded from {file}")

    def _make_topics(self) -> None:
        node, options = self._node, overridable()
        self._trajectories = node.create_publisher(
            JointTrajectory, "~/joint_trajectory", RELIABLE, qos_overriding_options=options
        )
        self._commands = node.create_publisher(
            Float64MultiArray, "~/commands", RELIABLE, qos_overriding_options=options
        )
        self._stamped = node.create_publisher(
            JointState, "~/feedforward", RELIABLE, qos_overriding_options=options
        )
        self._states = PolledSubscription(node, JointState, "joint_states", NEWEST, raw=True)
        self._subscriptions = (
            node.create_subscription(
                JointTrajectory, "~/reference", self._on_reference, RELIABLE,
                qos_overriding_options=options,
            ),
            node.create_subscription(String, "robot_description", self._on_description, LATCHED),
        )  # fmt: skip
        self._service = node.create_service(SetBool, "~/enable", self._on_enable)

    def start(self) -> None:
        """Begin to stream: zeros until a reference comes."""
        self._stream.forget()
        self._monitor = Monitor()
        rate = self._parameters.value("rate")
        self._every = max(1, round(rate / LOOKS))
        pacer = Pacer(1.0 / rate)
        self._loop = PacedThread(pacer, self._tick, self._tick_failed, "stream")

    def stop(self) -> None:
        """Fade out, stop, and send zeros; returns when they have arrived."""
        self._planner.drop()
        if self._loop is None:
            return
        self._stream.withhold("deactivated")
        deadline = time.monotonic() + 2.0 * self._stream.settings.fade_time + 0.1
        while time.monotonic() < deadline and self._sending():
            time.sleep(0.005)
        self._loop.stop()
        self._loop = None
        self._stream.forget()
        for _ in range(FAREWELL):
            self._commands.publish(command(np.zeros(len(self._columns))))
        self._commands.wait_for_all_acked(Duration(seconds=0.2))

    def _sending(self) -> bool:
        return self._monitor.last is not None and self._monitor.last.gain > 0.0

    def close(self) -> None:
        """Stop and give everything back."""
        self.stop()
        self._planner.stop()
        for publisher in (self._trajectories, self._commands, self._stamped):
            self._node.destroy_publisher(publisher)
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        self._states.destroy()
        self._node.destroy_service(self._service)

    def refresh(self) -> None:
        """Take up parameters or limits that have changed."""
        self._stream.settings = self._settings()

    def _settings(self) -> Settings:
        model = self._model
        return settings(self._parameters, model.joints, model.range, self._described)

    def _look_at_joint_states(self) -> None:
        for data, _ in self._states.take():
            self._look_at(data)

    def _look_at(self, data: bytes) -> None:
        try:
            state = self._reader.read(data)
        except MessageError as error:
            self._complaints.add("bad joint state", f"ignored {error}")
            return
        missing = [joint for joint in self._model.joints if joint not in state.names]
        if len(missing) == len(self._model.joints):
            return  # of another part of the robot
        fault = f"joint states without {', '.join(missing)}" if missing else state.fault()
        if fault:
            self._complaints.add("bad joint state", f"ignored {fault}")
        else:
            columns = [state.names.index(joint) for joint in self._model.joints]
            at = state.stamp or self._now()
            self._stream.joint_state_came(time.monotonic(), at, state.position[columns])

    def _on_description(self, message: String) -> None:
        try:
            self._described = effort_limits(message.data)
        except MessageError as error:
            self._complaints.add("bad robot description", str(error))
            return
        self.refresh()

    def _on_enable(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._stream.enabled = request.data
        response.success = True
        response.message = (
            "torque is brought in when there is a reference"
            if request.data
            else f"torque fades to zero within {self._stream.settings.fade_time:g} s"
        )
        self._node.get_logger().info(f"~/enable {request.data}: {response.message}")
        return response

    def _on_reference(self, message: JointTrajectory) -> None:
        if self._loop is None:
            self._complaints.add("reference while inactive", "ignored a reference: not active")
            return
        rules = policy(self._parameters)
        try:
            longest = self._parameters.value("max_points")
            reference = read_reference(points(message), self._model.joints, longest)
            if not reference.is_setpoint:
                self._planner.submit(reference, rules, message)
                return
            doubts = self._doubt.now_and_then if self._doubt else None
            plan = make_plan(self._model, reference, rules, doubts=doubts)
        except UserError as error:
            self._refused(error)
            return
        # A set-point is computed at once; a trajectory still being planned is out of date.
        self._planner.drop()
        if plan.excess.worst and rules.out_of_range == "fade":
            self._complaints.add("out of range", f"faded: {plan.excess.worst}")
            self._stream.withhold("the set-point is outside the identified range")
            return
        at = nanoseconds(message.header.stamp)
        self._stream.play(plan, at or self._now(), time.monotonic())
        self._publish_annotated(plan, message, at)

    def _on_plan(self, plan: Plan, message: JointTrajectory) -> None:
        """Play and republish a trajectory whose torques are ready; in the planner's thread."""
        if self._loop is None:
            return
        now, reference = self._now(), plan.reference
        delay = round(self._parameters.value("start_delay") * 1e9)
        start = nanoseconds(message.header.stamp) or now + delay
        ahead = (start - now) / 1e9
        if ahead < -reference.duration:
            self._refused(RefusedReference(f"it ended {-ahead - reference.duration:.3f} s ago"))
            return
        self._stream.play(plan, start, time.monotonic())
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

    def _now(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)

    def _tick(self, due: range) -> None:
        if any(index % self._every == 0 for index in due):
            self._look_at_joint_states()
        now = self._now()
        output = self._stream.tick(now, time.monotonic())
        self._commands.publish(command(output.tau[self._columns]))
        if output.q is not None and output.qd is not None:
            at = now + round(self._stream.settings.lead * 1e9)
            self._stamped.publish(self._maker.fill(at, output.q, output.qd, output.tau))
        faded = self._monitor.note(output)
        if faded:
            self._complaints.add("faded", f"torque fades to zero: {faded}")

    def _tick_failed(self, error: Exception) -> None:
        self._stream.forget()
        self._complaints.add("failed tick", f"reference dropped: {reason(error)}")

    def model_status(self) -> Status:
        """Which model, how good, and within which limits."""
        limits = zip(self._model.joints, self._stream.settings.effort_limit, strict=True)
        values = {
            "model file": self._parameters.value("model_file"),
            "model": self._model.name,
            **held_out(self._model.record),
            **{f"effort limit {joint} [N·m]": float(limit) for joint, limit in limits},
        }
        return Status(Level.OK, f"{self._model.name} loaded", values)

    def certainty_status(self) -> Status:
        """How sure the model is of the torques along the present reference."""
        plan = self._stream.plan
        doubt = None if plan is None else plan.doubt
        limit = policy(self._parameters).doubt_limit
        return status(self._model.joints, self._doubt is not None, doubt, limit)

    def stream_status(self) -> Status:
        """What is being sent."""
        more = {
            "reference age [s]": self._stream.reference_age(time.monotonic()),
            "enabled": self._stream.enabled,
            "planned": self._planner.fraction,
            "receivers of commands": self._commands.get_subscription_count(),
            "receivers of trajectories": self._trajectories.get_subscription_count(),
            **self._complaints.counts,
        }
        return self._monitor.status(self._parameters.value("rate"), more)
