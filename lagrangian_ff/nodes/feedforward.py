"""Sends the torque of an identified model along a reference.

Topics
    ~/reference         in   trajectory_msgs/JointTrajectory; header.stamp is its start, 0 = now.
                             One point at time 0 is a streamed set-point.
    joint_states        in   sensor_msgs/JointState, only to know that the robot is alive
    robot_description   in   std_msgs/String, for the torque limits
    ~/joint_trajectory  out  the reference with points[i].effort filled in and its start stamped
    ~/commands          out  std_msgs/Float64MultiArray, N·m in the order of `joints`, at `rate`
    ~/feedforward       out  sensor_msgs/JointState: the reference and its torque, stamped
    /diagnostics        out

Service ~/enable (std_srvs/SetBool). A lifecycle node: the model is loaded in configure, torque
flows while active, zeros are sent last on deactivate and at the end.

Not real time, not a safety function: whoever receives ~/commands must have a timeout.
"""

import sys
import traceback

from lifecycle_msgs.msg import State as LifecycleStateMessage
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.complaints import Complaints
from lagrangian_ff.nodes.common.diagnostics import Diagnostics
from lagrangian_ff.nodes.common.parameters import Parameters
from lagrangian_ff.nodes.common.running import BAD_PARAMETER, ClosingNode, run
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.feedforward_link import FeedforwardLink
from lagrangian_ff.nodes.feedforward_parameters import declare

SUCCESS = TransitionCallbackReturn.SUCCESS
FAILURE = TransitionCallbackReturn.FAILURE


class FeedforwardNode(LifecycleNode, ClosingNode):
    """The lifecycle around a link: no model, no link; not active, no torque."""

    def __init__(self) -> None:
        super().__init__("feedforward")
        self._settings = Parameters(self)
        declare(self._settings)
        self._complaints = Complaints(self.get_logger().warning)
        self._link: FeedforwardLink | None = None
        self._failure = ""
        self._settings.watch(self._parameters_changed)
        self._diagnostics = Diagnostics(
            self, "feedforward", {
                "model": self._model_status, "stream": self._stream_status,
                "certainty": self._certainty_status,
            }, self._complaints.flush,
        )  # fmt: skip
        if self._settings.value("autostart") and self.trigger_configure() == SUCCESS:
            self.trigger_activate()

    @property
    def _active(self) -> bool:
        return bool(
            self._state_machine.current_state[0] == LifecycleStateMessage.PRIMARY_STATE_ACTIVE
        )

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the model and offer the topics; fails with the reason in the log."""
        try:
            self._link = FeedforwardLink(self, self._settings, self._complaints)
        except (UserError, *BAD_PARAMETER) as error:
            self._failure = str(error)
            self.get_logger().error(
                f"cannot be configured: {error}; put it right, then configure again"
            )
            return FAILURE
        except Exception as error:
            # rclpy would swallow it without a word.
            self._failure = f"{type(error).__name__}: {error}"
            self.get_logger().error(f"cannot be configured:\n{traceback.format_exc()}")
            return FAILURE
        self._failure = ""
        return SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to stream."""
        assert self._link is not None
        self._link.start()
        return SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Fade out, then zeros."""
        assert self._link is not None
        self._link.stop()
        return SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give the model back."""
        self._drop()
        return SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Fade out, zeros, and give the model back."""
        self._drop()
        return SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """As on shutdown; the node can be configured again."""
        self._drop()
        return SUCCESS

    def close(self) -> None:
        """Fade out and send the last zeros."""
        self._drop()

    def _drop(self) -> None:
        link, self._link = self._link, None
        if link is not None:
            link.close()

    def _parameters_changed(self) -> None:
        if self._link is not None:
            self._link.refresh()

    def _model_status(self) -> Status:
        if self._link is None:
            level = Level.ERROR if self._failure else Level.STALE
            return Status(level, self._failure or "not configured", {})
        return self._link.model_status()

    def _stream_status(self) -> Status:
        if self._link is not None and not self._active:
            self._link.ignore_references()
        if self._link is None or not self._active:
            return Status(Level.STALE, "not active", dict(self._complaints.counts))
        return self._link.stream_status()

    def _certainty_status(self) -> Status:
        if self._link is None or not self._active:
            return Status(Level.STALE, "not active")
        return self._link.certainty_status()


def main() -> int:
    """Entry point of the executable `feedforward`."""
    return run(FeedforwardNode, sys.argv)


if __name__ == "__main__":
    sys.exit(main())
