"""Holds a model against joint states as they come, and publishes what it does not explain.

Topics
    joint_states   in   sensor_msgs/JointState; best effort, so that every publisher matches
    ~/residual     out  sensor_msgs/JointState: effort = measured minus predicted, N·m
    ~/predicted    out  sensor_msgs/JointState: effort = predicted, N·m
    /diagnostics   out  the residual of the last seconds against the error when identified

Both are reliable, at `rate`, and bear the position and velocity the model was asked at. Position
and effort pass the low-pass of the model's recordings, twice forward instead of forward and
backward: that takes 25 ms at 25 Hz, and the stamps are set back by as much, so that they lie on
the joint states in a plot.
"""

import sys
import threading
from itertools import islice

from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState

from lagrangian_ff.nodes.common.complaints import Complaints
from lagrangian_ff.nodes.common.diagnostics import Diagnostics
from lagrangian_ff.nodes.common.errors import MessageError
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateReader
from lagrangian_ff.nodes.common.messages import JointStateMaker
from lagrangian_ff.nodes.common.own_effects import load_own_effects
from lagrangian_ff.nodes.common.pacing import PacedThread, Pacer, RateMeter
from lagrangian_ff.nodes.common.parameters import Parameters
from lagrangian_ff.nodes.common.polled import PolledSubscription
from lagrangian_ff.nodes.common.qos import RECORDING, RELIABLE, overridable
from lagrangian_ff.nodes.common.running import ClosingNode, run
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.common.treatment import treatment
from lagrangian_ff.nodes.identify_parameters import declare_joints
from lagrangian_ff.nodes.monitor_parameters import declare, limits
from lagrangian_ff.nodes.streaming.loading import load_model
from lagrangian_ff.nodes.watching.cover import Cover
from lagrangian_ff.nodes.watching.health import Health
from lagrangian_ff.nodes.watching.live import Judged, LivePrediction
from lagrangian_ff.nodes.watching.states import LiveStates, State

PERIOD = 0.02  # s between looks at what has come
MOST = 1000
"""Messages taken at one look; more wait for the next."""


class MonitorNode(ClosingNode):
    """Two threads: the paced one filters, predicts and publishes, the executor's tells how it is.

    Raises:
        ModelError: the model cannot be loaded.
        EffectError: the file of effects cannot be used.
    """

    def __init__(self) -> None:
        super().__init__("monitor")
        self._settings = Parameters(self)
        declare(self._settings)
        value = self._settings.value
        load_own_effects(value("effects_file"))
        self._model, _ = load_model(value("model_file"), ())
        joints = self._model.joints
        declare_joints(self._settings, joints)
        conditioning = treatment(
            self._model,
            {joint: value(f"effort_scale.{joint}") for joint in joints},
            {joint: value(f"effort_offset.{joint}") for joint in joints},
        )
        self._states = LiveStates(joints, conditioning, value("rate"))
        self._prediction = LivePrediction(self._model)
        self._cover = Cover.of(self._model)
        self._health = Health.of(joints, self._model.record, self._model.range)
        self._lock = threading.Lock()
        self._reader, self._maker = JointStateReader(), JointStateMaker(joints)
        self._complaints = Complaints(self.get_logger().warning)
        self._meter, self._published = RateMeter(), RateMeter()
        self._residual = _publisher(self, "~/residual")
        self._predicted = _publisher(self, "~/predicted")
        self._subscription = PolledSubscription(
            self, JointState, "joint_states", RECORDING, raw=True
        )
        self._diagnostics = Diagnostics(
            self, "model", {"input": self._input_status, "residual": self._residual_status},
            self._complaints.flush,
        )  # fmt: skip
        self._limits = limits(self._settings)
        self._settings.watch(self._parameters_changed)
        self._loop = PacedThread(Pacer(PERIOD), self._look, self._failed, "watch")
        self.get_logger().info(
            f"watching {self._model.name} of {', '.join(joints)} on {self._subscription.topic}"
        )

    def _parameters_changed(self) -> None:
        self._limits = limits(self._settings)

    def _look(self, due: range) -> None:
        """Take what has come, in the paced thread."""
        states = []
        for data, received in islice(self._subscription.take(), MOST):
            self._meter.add()
            state = self._state(data, received)
            if state is not None:
                states.append(state)
        for judged in self._prediction.take(states):
            self._tell(judged)

    def _state(self, data: bytes, received: int) -> State | None:
        try:
            return self._states.take(self._reader.read(data), received)
        except MessageError as error:
            self._complaints.add("bad joint state", f"ignored {error}")
            return None

    def _tell(self, judged: Judged) -> None:
        state = judged.state
        with self._lock:
            self._health.add(judged, self._limits)
            if self._cover is not None:
                self._cover.add(judged, self._limits)
        for publisher, effort in (
            (self._residual, judged.residual),
            (self._predicted, judged.predicted),
        ):
            publisher.publish(self._maker.fill(state.at, state.q, state.qd, effort))
        self._published.add()

    def _failed(self, error: Exception) -> None:
        self._complaints.add("failure", f"could not compare: {type(error).__name__}: {error}")

    def _input_status(self) -> Status:
        rate, states = self._meter.take(), self._states
        values = {
            "rate [Hz]": rate,
            "bandwidth [Hz]": states.bandwidth,
            "delay [s]": states.delay + self._prediction.waits / self._settings.value("rate"),
            "gaps": states.gaps,
            **self._complaints.counts,
        }
        if rate == 0.0:
            with self._lock:
                self._health.forget()
                if self._cover is not None:
                    self._cover.forget()
            return Status(Level.STALE, f"no joint states on {self._subscription.topic}", values)
        if states.period == 0.0:
            return Status(Level.OK, "measuring the rate of the joint states", values)
        return Status(Level.OK, f"{1.0 / states.period:.4g} Hz", values)

    def _residual_status(self) -> Status:
        record = self._model.record
        more = {
            "model": self._model.name,
            "model file": self._settings.value("model_file"),
            "held-out RMSE [N·m]": record.get("rmse", float("nan")),
            "publish rate [Hz]": self._published.take(),
        }
        with self._lock:
            if self._cover is not None:
                more |= self._cover.values()
            return self._health.status(self._limits, more)

    def close(self) -> None:
        """End the paced thread before its publishers go."""
        self._loop.stop()


def _publisher(node: Node, topic: str) -> Publisher:
    return node.create_publisher(JointState, topic, RELIABLE, qos_overriding_options=overridable())


def main() -> int:
    """Entry point of the executable `monitor`."""
    return run(MonitorNode, sys.argv)


if __name__ == "__main__":
    sys.exit(main())
