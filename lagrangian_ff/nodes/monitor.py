"""Compares a model with live joint states and publishes what it does not explain.

Topics
    joint_states   in   sensor_msgs/JointState; best effort, so that every publisher matches
    ~/residual     out  sensor_msgs/JointState: effort = measured minus predicted, N·m
    ~/predicted    out  sensor_msgs/JointState: effort = predicted, N·m
    /diagnostics   out  the residual of the last seconds beside the error when identified; at once,
                        a touch: a collision or a load that is taken up

Both are reliable, at `rate`, with the position and velocity of the prediction. Position and effort
pass the low-pass of the model's recordings, twice forward instead of forward and backward. That
takes 25 ms at 25 Hz; the stamps are set back by as much, so that plots match the joint states.
"""

import sys
import threading
from itertools import islice

from sensor_msgs.msg import JointState

from lagrangian_ff.nodes.common.joint_state_bytes import (
    JointStateMaker,
    JointStateReader,
    MessageError,
)
from lagrangian_ff.nodes.common.models import conditioning_for, load_model, load_own_effects
from lagrangian_ff.nodes.common.node import ClosingNode, Diagnostics, Parameters, run
from lagrangian_ff.nodes.common.pacing import PacedThread, Pacer, RateMeter
from lagrangian_ff.nodes.common.status import Level, Status, ThrottledWarnings
from lagrangian_ff.nodes.common.topics import RECORDING, RELIABLE, PolledSubscription, advertise
from lagrangian_ff.nodes.watching.health import Coverage, Health, Limits
from lagrangian_ff.nodes.watching.live import Judged, LivePrediction
from lagrangian_ff.nodes.watching.states import LiveStates
from lagrangian_ff.nodes.watching.touch import TouchAlarm

PERIOD = 0.01  # s between readings of the topic
MOST = 1000
"""Messages taken at one reading; more wait for the next."""


class MonitorNode(ClosingNode):
    """Two threads: the paced one filters, predicts and publishes, the executor's reports.

    Raises:
        ModelError: the model cannot be loaded.
        EffectError: the file of effects cannot be used.
    """

    def __init__(self) -> None:
        super().__init__("monitor")
        self._settings = Parameters(self, profiles=True)
        declare(self._settings)
        value = self._settings.value
        load_own_effects(value("effects_file"))
        self._model, _ = load_model(value("model_file"))
        joints = self._model.joints
        self._settings.declare_effort(joints)
        self._settings.refuse_unknown("effort_scale", "effort_offset")
        conditioning = conditioning_for(
            self._model,
            {joint: value(f"effort_scale.{joint}") for joint in joints},
            {joint: value(f"effort_offset.{joint}") for joint in joints},
        )
        self._states = LiveStates(joints, conditioning, value("rate"))
        self._prediction = LivePrediction(self._model)
        self._health = Health(
            joints, self._model.identified.score, self._model.range, Coverage.of(self._model)
        )
        self._alarm = TouchAlarm(self._model, 1.0 / value("rate"))
        self._lock = threading.Lock()
        self._reader, self._maker = JointStateReader(), JointStateMaker(joints)
        self._warnings = ThrottledWarnings(self.get_logger().warning)
        self._meter, self._published = RateMeter(), RateMeter()
        self._residual = advertise(self, JointState, "~/residual", RELIABLE)
        self._predicted = advertise(self, JointState, "~/predicted", RELIABLE)
        self._subscription = PolledSubscription(
            self, JointState, "joint_states", RECORDING, raw=True
        )
        self._diagnostics = Diagnostics(
            self,
            "model",
            housekeeping=self._warnings.flush,
            input=self._input_status,
            residual=self._residual_status,
            touch=self._touch_status,
        )
        self._settings.watch(self._refresh)
        self._loop = PacedThread(Pacer(PERIOD), self._look, self._failed, "watch")
        self.get_logger().info(
            f"watching {self._model.name} of {', '.join(joints)} on {self._subscription.topic}"
        )

    def _refresh(self) -> None:
        value = self._settings.value
        self._limits = Limits(
            window=value("window"),
            still=value("still_speed"),
            margin=value("range_margin"),
            warn=value("warn_ratio"),
            error=value("error_ratio"),
        )

    def _look(self, due: range) -> None:
        """Take the messages that came; in the paced thread."""
        states = []
        for data, received in islice(self._subscription.take(), MOST):
            self._meter.add()
            try:
                state = self._states.take(self._reader.read(data), received)
            except MessageError as error:
                self._warnings.add("bad joint state", f"ignored {error}")
                continue
            if state is not None:
                states.append(state)
        for judged in self._prediction.take(states):
            self._publish(judged)

    def _publish(self, judged: Judged) -> None:
        state = judged.state
        with self._lock:
            self._health.add(judged, self._limits)
            touch = self._alarm.add(judged, self._limits.margin)
            alarm = self._alarm.status() if touch is not None else None
        if alarm is not None:
            self._diagnostics.send({"touch": alarm})
            self._warnings.add("touch", alarm.message)
        now = state.at, state.q, state.qd
        self._residual.publish(self._maker.fill(*now, judged.residual))
        self._predicted.publish(self._maker.fill(*now, judged.predicted))
        self._published.add()

    def _failed(self, error: Exception) -> None:
        self._warnings.add("failure", f"could not compare: {type(error).__name__}: {error}")

    def _input_status(self) -> Status:
        rate, states = self._meter.take(), self._states
        values = {
            "rate [Hz]": rate,
            "bandwidth [Hz]": states.bandwidth,
            "delay [s]": states.delay + self._prediction.waits / self._settings.value("rate"),
            "gaps": states.gaps,
            **self._warnings.counts,
        }
        if rate == 0.0:
            with self._lock:
                self._health.forget()
                self._alarm.forget()
            return Status(Level.STALE, f"no joint states on {self._subscription.topic}", values)
        if states.period == 0.0:
            return Status(Level.OK, "measuring the rate of the joint states", values)
        return Status(Level.OK, f"{1.0 / states.period:.4g} Hz", values)

    def _residual_status(self) -> Status:
        more = {
            "model": self._model.name,
            "model file": self._settings.value("model_file"),
            "held-out RMSE [N·m]": self._model.identified.score.total,
            "publish rate [Hz]": self._published.take(),
        }
        with self._lock:
            return self._health.status(self._limits, more)

    def _touch_status(self) -> Status:
        with self._lock:
            return self._alarm.status()

    def close(self) -> None:
        """End the paced thread before its publishers."""
        self._loop.stop()


def declare(parameters: Parameters) -> None:
    """Declare the parameters that do not depend on the model."""
    add = parameters.declare
    add("model_file", "", "the identified model to watch", read_only=True)
    add("effects_file", "", "Python that defines effects of your own; empty = none",
        read_only=True)  # fmt: skip
    add("rate", 100.0, "Hz of prediction and residual, at most that of the joint states",
        low=1.0, high=1000.0, read_only=True)  # fmt: skip
    add("window", 5.0, "s over which the residual is judged", low=0.5, high=600.0)
    add("warn_ratio", 2.0, "factor of the error when identified from which on it is a warning",
        low=1.0, high=1000.0)  # fmt: skip
    add("error_ratio", 4.0, "factor of the error when identified from which on it is an error",
        low=1.0, high=1000.0)  # fmt: skip
    add("still_speed", 0.01, "rad/s; a slower joint is not judged, because friction may hold it "
        "at any torque", low=0.0, high=10.0)  # fmt: skip
    add("range_margin", 0.25, "how far outside the identified range still counts as inside, as a "
        "fraction of the range", low=0.0, high=10.0)  # fmt: skip


def main() -> int:
    """Run the executable `monitor`."""
    return run(MonitorNode, sys.argv)


if __name__ == "__main__":
    sys.exit(main())
