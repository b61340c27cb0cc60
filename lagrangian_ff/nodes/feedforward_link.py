"""The model, its stream and their topics: what a configured feedforward node has."""

import time

import numpy as np
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from std_srvs.srv import SetBool

from lagrangian_ff.nodes.common.complaints import Complaints
from lagrangian_ff.nodes.common.errors import MessageError
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateReader
from lagrangian_ff.nodes.common.messages import JointStateMaker, command
from lagrangian_ff.nodes.common.node_time import NodeTime
from lagrangian_ff.nodes.common.own_effects import load_own_effects
from lagrangian_ff.nodes.common.pacing import FollowingPacer, PacedThread, Pacer, Pacing
from lagrangian_ff.nodes.common.parameters import Parameters
from lagrangian_ff.nodes.common.polled import PolledSubscription
from lagrangian_ff.nodes.common.qos import LATCHED, RELIABLE, SHARED, overridable
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.common.summary import held_out
from lagrangian_ff.nodes.feedforward_parameters import declare_joints, settings
from lagrangian_ff.nodes.feedforward_references import References
from lagrangian_ff.nodes.streaming.loading import load_model
from lagrangian_ff.nodes.streaming.monitor import Monitor
from lagrangian_ff.nodes.streaming.planner import reason
from lagrangian_ff.nodes.streaming.stream import Settings, TorqueStream
from lagrangian_ff.nodes.streaming.urdf_limits import effort_limits

FAREWELL = 3  # zeros sent at the end
LOOKS = 50.0  # a second, whether joint states still come
REST = 0.002  # s; simulated time is looked at that often where no joint state tells it


class FeedforwardLink:
    """Between the topics and the stream of torques.

    Three threads: the executor's takes what is not urgent, the planner's computes plans of
    trajectories, the paced one takes references and sends.

    Raises:
        ModelError: the model cannot be loaded or is of other joints.
        EffectError: the file of effects cannot be used.
    """

    def __init__(self, node: LifecycleNode, parameters: Parameters, complaints: Complaints) -> None:
        self._node, self._parameters, self._complaints = node, parameters, complaints
        load_own_effects(parameters.value("effects_file"))
        file = parameters.value("model_file")
        self._model, self._columns = load_model(file, parameters.strings("joints"))
        joints = self._model.joints
        declare_joints(parameters, joints)
        self._described: dict[str, float] = {}
        self._stream = TorqueStream(joints, self._settings())
        self._monitor = Monitor()
        self._time = NodeTime(node)
        self._reader, self._maker = JointStateReader(), JointStateMaker(joints)
        self._loop: PacedThread | None = None
        self._references = References(
            node, parameters, complaints, self._time, self._model, self._stream
        )
        self._make_topics()
        node.get_logger().info(f"{self._model.name} of {', '.join(joints)} loaded from {file}")

    def _make_topics(self) -> None:
        node, options = self._node, overridable()
        self._commands = node.create_publisher(
            Float64MultiArray, "~/commands", RELIABLE, qos_overriding_options=options
        )
        self._stamped = node.create_publisher(
            JointState, "~/feedforward", RELIABLE, qos_overriding_options=options
        )
        self._states = PolledSubscription(node, JointState, "joint_states", SHARED, raw=True)
        self._description = node.create_subscription(
            String, "robot_description", self._on_description, LATCHED
        )
        self._service = node.create_service(SetBool, "~/enable", self._on_enable)

    def start(self) -> None:
        """Begin to stream: zeros until a reference comes."""
        self.ignore_references()
        self._references.active = True
        self._stream.forget()
        self._monitor = Monitor()
        rate = self._parameters.value("rate")
        self._every = max(1, round(rate / LOOKS))
        pacer: Pacing = Pacer(1.0 / rate)
        if self._time.simulated:
            # In step with the joint states: each is answered, however fast the simulation goes.
            pacer = FollowingPacer(1.0 / rate, self._time.now, self._await_joint_states)
        self._loop = PacedThread(pacer, self._tick, self._tick_failed, "stream")

    def stop(self) -> None:
        """Fade out, stop, and send zeros; returns when they have arrived."""
        self._references.active = False
        self._references.drop()
        if self._loop is None:
            return
        self._stream.end("deactivated")
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
        self._references.close()
        for publisher in (self._commands, self._stamped):
            self._node.destroy_publisher(publisher)
        self._node.destroy_subscription(self._description)
        self._states.destroy()
        self._node.destroy_service(self._service)

    def refresh(self) -> None:
        """Take up parameters or limits that have changed."""
        self._references.refresh()
        self._stream.settings = self._settings()

    def _settings(self) -> Settings:
        model = self._model
        return settings(self._parameters, model.joints, model.range, self._described)

    def _await_joint_states(self) -> None:
        self._states.wait(REST)
        self._look_at_joint_states()

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
            at = state.stamp or self._time.now()
            self._time.stamped(at)
            self._stream.joint_state_came(self._time.steady(), at, state.position[columns])

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

    def ignore_references(self) -> None:
        """What comes while there is no stream is not followed later."""
        self._references.ignore()

    def _tick(self, due: range) -> None:
        self._references.follow()
        if any(index % self._every == 0 for index in due):
            self._look_at_joint_states()
        now = self._time.now()
        output = self._stream.tick(now, self._time.steady())
        self._commands.publish(command(output.tau[self._columns]))
        listened = self._stamped.get_subscription_count() > 0
        if listened and output.q is not None and output.qd is not None:
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
        return self._references.certainty()

    def stream_status(self) -> Status:
        """What is being sent."""
        more = {
            "reference age [s]": self._stream.reference_age(self._time.steady()),
            "enabled": self._stream.enabled,
            "receivers of commands": self._commands.get_subscription_count(),
            **self._references.values(),
            **self._complaints.counts,
        }
        if self._time.simulated and self._time.now() == 0:
            return Status(Level.WARN, "use_sim_time is set, but nobody publishes /clock", more)
        # Simulated seconds may be longer or shorter than the monitor's.
        rate = 0.0 if self._time.simulated else self._parameters.value("rate")
        return self._monitor.status(rate, more)
