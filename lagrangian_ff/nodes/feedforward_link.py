"""The configured part of the feedforward node: a model, its stream, and their topics."""

import time
from collections.abc import Sequence

import numpy as np
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from std_srvs.srv import SetBool

from lagrangian_ff.nodes.common import topics
from lagrangian_ff.nodes.common.joint_state_bytes import (
    JointStateMaker,
    JointStateReader,
    MessageError,
)
from lagrangian_ff.nodes.common.models import load_own_effects
from lagrangian_ff.nodes.common.node import Parameters
from lagrangian_ff.nodes.common.pacing import FollowingPacer, NodeTime, PacedThread, Pacer, Pacing
from lagrangian_ff.nodes.common.status import Level, Status, ThrottledWarnings, errors_of
from lagrangian_ff.nodes.feedforward_action import GoalProxy
from lagrangian_ff.nodes.feedforward_controller import ControllerFacts
from lagrangian_ff.nodes.feedforward_references import References
from lagrangian_ff.nodes.streaming.life import SignsOfLife
from lagrangian_ff.nodes.streaming.plan import TERMS, reason
from lagrangian_ff.nodes.streaming.replacing import ModelFile
from lagrangian_ff.nodes.streaming.stream import (
    FAREWELL,
    LATE,
    LIMITS_PER_SECOND,
    LONGEST_STEP,
    Settings,
    StreamMonitor,
    TorqueStream,
    effort_limits,
)

LOOKS = 50.0  # Hz at which joint states are read
REST = 0.002  # s between readings of simulated time while no joint state comes


class FeedforwardLink:
    """The link between the topics and the stream of torques.

    Three threads: the executor's does what is not urgent, the planner's computes plans of
    trajectories, the paced one takes references and sends torques.

    Attributes:
        references: the references that come, and their plans.

    Raises:
        ModelError: the model cannot be loaded or is of other joints.
        EffectError: the file of effects cannot be used.
    """

    def __init__(
        self, node: LifecycleNode, parameters: Parameters, warnings: ThrottledWarnings
    ) -> None:
        self._node, self._parameters, self._warnings = node, parameters, warnings
        load_own_effects(parameters.value("effects_file"))
        self._file = ModelFile(
            lambda: str(parameters.value("model_file")), parameters.strings("joints")
        )
        ready = self._ready = self._file.first
        joints = self._joints = ready.model.joints
        declare_joints(parameters, joints)
        parameters.refuse_unknown("scale", "limits", "terms")
        self._described: dict[str, float] = {}
        self._time, self._rate = NodeTime(node), float(parameters.value("rate"))
        self._stream = TorqueStream(joints, self._settings())
        self._monitor, self._life = StreamMonitor(), SignsOfLife()
        self._seen = 0
        self._reader, self._maker = JointStateReader(), JointStateMaker(joints)
        self._loop: PacedThread | None = None
        self.references = References(node, parameters, warnings, self._time, ready, self._stream)
        self._make_topics()
        self._facts = ControllerFacts(
            node,
            parameters.value("controller"),
            parameters.value("controller_manager"),
            joints,
            self._judge_controllers,
        )
        self._proxy = self._make_proxy()
        node.get_logger().info(
            f"{ready.model.name} of {', '.join(joints)} loaded from {ready.file}"
        )

    def _make_topics(self) -> None:
        node = self._node
        self._commands = topics.advertise(node, Float64MultiArray, "~/commands", topics.RELIABLE)
        self._stamped = topics.advertise(node, JointState, "~/feedforward", topics.RELIABLE)
        self._states = topics.PolledSubscription(
            node, JointState, "joint_states", topics.SHARED, raw=True
        )
        self._description = node.create_subscription(
            String, "robot_description", self._on_description, topics.LATCHED
        )
        self._service = node.create_service(SetBool, "~/enable", self._on_enable)

    def _make_proxy(self) -> GoalProxy | None:
        value = self._parameters.value
        if not value("controller"):
            return None
        return GoalProxy(
            self._node,
            value("controller"),
            self._facts,
            self._warnings,
            lambda message: self.references.fill(message, value("point_error")),
            self._silent,
        )

    def _silent(self) -> str:
        """Return why goals get no effort now, or ""."""
        if not self.references.active:
            return "the node is not active"
        return "" if self._stream.enabled else "~/enable is false"

    def start(self) -> None:
        """Begin to stream, zeros until a reference comes."""
        self.look_at_controllers()
        self.references.ignore()
        self.references.active = True
        self._stream.forget()
        self._monitor = StreamMonitor()
        rate = self._rate = float(self._parameters.value("rate"))
        self._stream.settings = self._settings()
        self._every = max(1, round(rate / LOOKS))
        pacer: Pacing = Pacer(1.0 / rate)
        if self._time.simulated:
            # In step with the joint states: each is answered, however fast the simulation goes.
            pacer = FollowingPacer(1.0 / rate, self._time.now, self._await_joint_states)
        self._loop = PacedThread(pacer, self._tick, self._tick_failed, "stream")

    def stop(self) -> None:
        """Fade out, stop, send zeros, and return when they have arrived."""
        self.references.active = False
        self.references.drop()
        if self._loop is None:
            return
        self._stream.end("deactivated")
        deadline = time.monotonic() + 2.0 * self._stream.settings.fade_time + 0.5
        while time.monotonic() < deadline and (last := self._monitor.last) and last.tau.any():
            time.sleep(0.005)
        self._loop.stop()
        self._loop = None
        self._stream.forget()
        for _ in range(FAREWELL):
            self._commands.publish(topics.command(np.zeros(len(self._joints))))
        self._commands.wait_for_all_acked(Duration(seconds=0.2))

    def close(self) -> Sequence[Future]:
        """Stop and release everything; return what the controller must still answer."""
        self.stop()
        unanswered = () if self._proxy is None else self._proxy.close()
        self._facts.close()
        self.references.close()
        for publisher in (self._commands, self._stamped):
            self._node.destroy_publisher(publisher)
        self._node.destroy_subscription(self._description)
        self._states.destroy()
        self._node.destroy_service(self._service)
        return unanswered

    def refresh(self) -> None:
        """Apply changed parameters and limits."""
        self.references.refresh()
        self._stream.settings = self._settings()

    def _settings(self) -> Settings:
        """Return the stream's settings; limits not given come from the robot or the model."""
        value, joints = self._parameters.value, self._joints
        limit = np.array(
            [
                value(f"limits.{joint}.effort") or self._described.get(joint) or float(largest)
                for joint, largest in zip(joints, self._ready.model.range.tau_max, strict=True)
            ]
        )
        rate = np.array([value(f"limits.{joint}.effort_rate") for joint in joints])
        return Settings(
            scale=np.array([value(f"scale.{joint}") for joint in joints]),
            effort_limit=limit,
            effort_rate=np.where(rate > 0.0, rate, LIMITS_PER_SECOND * limit),
            switches=np.array([float(value(f"terms.{term}")) for term in TERMS]),
            ramp_time=value("ramp_time"),
            fade_time=value("fade_time"),
            reference_timeout=value("reference_timeout"),
            joint_state_timeout=value("joint_state_timeout"),
            tracking_tolerance=value("tracking_tolerance"),
            after_end=value("after_end"),
            lead=value("lead_time"),
            # Simulated time moves in the steps of /clock.
            longest=max(LATE / self._rate, LONGEST_STEP if self._time.simulated else 0.0),
        )

    def _await_joint_states(self) -> None:
        self._states.wait(REST)
        self._take_joint_states()

    def _take_joint_states(self) -> None:
        for data, _ in self._states.take():
            try:
                state = self._reader.read(data)
                columns = state.columns(self._joints)
                fault = state.fault() if columns else ""
            except MessageError as error:
                fault = str(error)
            if fault:
                self._warnings.add("bad joint state", f"ignored {fault}")
            elif columns:
                if state.stamp:
                    self._time.stamped(state.stamp)
                at = self._life.news(state.stamp, self._time.now())
                if at is not None:
                    self._stream.joint_state_came(self._time.steady(), at, state.position[columns])

    def _on_description(self, message: String) -> None:
        try:
            self._described = effort_limits(message.data)
        except MessageError as error:
            self._warnings.add("bad robot description", str(error))
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

    def _tick(self, due: range) -> None:
        if self.references.idle and (ready := self._file.take()):
            self._ready = ready
            self.references.use(ready)
            self._stream.settings = self._settings()
            self._node.get_logger().info(f"{ready.model.name} loaded from {ready.file} takes over")
        self.references.follow()
        if any(index % self._every == 0 for index in due):
            self._take_joint_states()
        self._send()

    def _send(self) -> None:
        now = self._time.now()
        output = self._stream.tick(now, self._time.steady())
        self._commands.publish(topics.command(output.tau[self._ready.columns]))
        listened = self._stamped.get_subscription_count() > 0
        if listened and output.q is not None and output.qd is not None:
            at = now + round(self._stream.settings.lead * 1e9)
            self._stamped.publish(self._maker.fill(at, output.q, output.qd, output.tau))
        if faded := self._monitor.note(output):
            self._warnings.add("faded", f"torque fades to zero: {faded}")

    def _tick_failed(self, error: Exception) -> None:
        self._stream.drop()
        self._warnings.add("failed tick", f"reference dropped: {reason(error)}")
        self._send()

    def model_status(self) -> Status:
        """Return the state of the model: its error and its limits; look whether it is replaced."""
        self._file.look()
        model, file = self._ready.model, self._ready.file
        limits = zip(self._joints, self._stream.settings.effort_limit, strict=True)
        values = {
            "model file": file,
            "model": model.name,
            **errors_of(model.identified.score),
            **{f"effort limit {joint} [N·m]": float(limit) for joint, limit in limits},
        }
        if refusal := self._file.refusal:
            said = f"the model loaded before stays in use: {refusal}"
            return Status(Level.WARN, said, values)
        return Status(Level.OK, f"{model.name} loaded", values)

    def stream_status(self) -> Status:
        """Return the state of the stream."""
        more = {
            "reference age [s]": self._stream.reference_age(self._time.steady()),
            "enabled": self._stream.enabled,
            "receivers of commands": self._commands.get_subscription_count(),
            **self.references.values(),
            **self._warnings.values(),
        }
        # Simulated seconds may be longer or shorter than the monitor's.
        status = self._monitor.status(0.0 if self._time.simulated else self._rate, more)
        if fault := self._fault():
            level = max(status.level, Level.WARN)
            return Status(level, f"{status.message}; {fault}", status.values)
        return status

    def _fault(self) -> str:
        """Return what is wrong around the node and what to do, or ""."""
        topic = self._commands.topic_name
        if (senders := self._node.count_publishers(topic)) > 1:
            return (
                f"{senders} nodes send torque on {topic} in turn: end all but one, or start them "
                "in namespaces (a killed one is listed for 20 s more)"
            )
        now, before = self._time.now(), self._seen
        self._seen = now
        if not self._time.simulated:
            return ""
        if now == 0:
            return "use_sim_time is set, but nobody publishes /clock"
        if now == before:
            return (
                f"simulated time stands at {now / 1e9:.3f} s, and no torque is sent: let the "
                "simulation go on; for a robot set use_sim_time to false"
            )
        return ""

    def look_at_controllers(self) -> None:
        """Ask the controllers again, and forbid torque that would move a joint without feedback."""
        self._facts.ask()
        self._judge_controllers()

    def _judge_controllers(self) -> None:
        alone = self._parameters.value("without_position_loop")
        self._stream.forbidden = "" if alone else self._facts.open_loop()

    def controller_status(self) -> Status | None:
        """Return the state of the controller that goals go on to; None without one."""
        return None if self._proxy is None else self._proxy.status()

    def joint_state_status(self) -> Status:
        """Return the state of the joint states."""
        return self._life.status(self._node.count_publishers(self._states.topic))


def declare_joints(parameters: Parameters, joints: tuple[str, ...]) -> None:
    """Declare the parameters of each joint of the model."""
    add = parameters.declare
    for joint in joints:
        add(f"scale.{joint}", 1.0, "factor of the torque", low=0.0, high=1.0)
        add(f"limits.{joint}.effort", 0.0, "N·m at most; 0 = of the robot description, or without "
            "one the largest identified", low=0.0, high=1e6)  # fmt: skip
        add(f"limits.{joint}.effort_rate", 0.0, f"N·m/s at most; 0 = {LIMITS_PER_SECOND:g} torque "
            "limits a second", low=0.0, high=1e8)  # fmt: skip
