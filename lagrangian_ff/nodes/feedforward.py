"""The feedforward node: sends the torque of an identified model along a reference.

Topics
    ~/reference         in   trajectory_msgs/JointTrajectory; header.stamp is its start, 0 = now.
                             One point at time 0 is a streamed set-point.
    joint_states        in   sensor_msgs/JointState, to notice a dead or stray robot
    robot_description   in   std_msgs/String, for the torque limits
    ~/joint_trajectory  out  the reference with points[i].effort filled in and its start stamped
    ~/commands          out  std_msgs/Float64MultiArray, N·m in the order of `joints`, at `rate`
    ~/feedforward       out  sensor_msgs/JointState: the reference and its torque, stamped
    /diagnostics        out

Action ~/follow_joint_trajectory (control_msgs/FollowJointTrajectory), with the parameter
`controller`: goals go on to that controller, with effort at the points that need it.

Service ~/enable (std_srvs/SetBool). A lifecycle node: the model is loaded in configure, torque
flows while active, zeros are sent last on deactivate and at the end.

Not real time, not a safety function: the receiver of ~/commands must have a timeout.
"""

import sys
import traceback
from collections.abc import Callable

from lifecycle_msgs.msg import State as LifecycleStateMessage
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.node import (
    BAD_PARAMETER,
    ClosingNode,
    Diagnostics,
    Parameters,
    answer_every_transition,
    run,
)
from lagrangian_ff.nodes.common.status import Level, Status, ThrottledWarnings
from lagrangian_ff.nodes.feedforward_link import FeedforwardLink
from lagrangian_ff.nodes.streaming.plan import TERMS

Check = Callable[[object], str]
SUCCESS = TransitionCallbackReturn.SUCCESS
FAILURE = TransitionCallbackReturn.FAILURE


class FeedforwardNode(LifecycleNode, ClosingNode):
    """The lifecycle around a link: without a model no link, when not active no torque."""

    def __init__(self) -> None:
        super().__init__("feedforward")
        answer_every_transition(self)
        self._settings = Parameters(self, profiles=True)
        self._link: FeedforwardLink | None = None
        declare(self._settings, self._fixed, self._fixed_while_active)
        self._warnings = ThrottledWarnings(self.get_logger().warning)
        self._failure = ""
        self._settings.watch(self._parameters_changed)
        self._diagnostics = Diagnostics(
            self,
            "feedforward",
            housekeeping=self._once_a_second,
            model=self._model_status,
            stream=self._stream_status,
            certainty=self._certainty_status,
            joint_states=self._joint_state_status,
            controller=self._controller_status,
        )
        if self._settings.value("autostart") and self.trigger_configure() == SUCCESS:
            self.trigger_activate()

    @property
    def _active(self) -> bool:
        return bool(
            self._state_machine.current_state[0] == LifecycleStateMessage.PRIMARY_STATE_ACTIVE
        )

    def _fixed(self, value: object) -> str:
        """Return why a parameter that is read when configured cannot be set now, or ""."""
        if self._link is None:
            return ""
        return "it is read when configured: deactivate and clean up, set it, configure and activate"

    def _fixed_while_active(self, value: object) -> str:
        """Return why a parameter that is read when activated cannot be set now, or ""."""
        if self._link is None or not self._active:
            return ""
        return "it is read when activated: deactivate, set it, activate"

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the model and offer the topics; log the reason if that fails."""
        try:
            self._link = FeedforwardLink(self, self._settings, self._warnings)
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
        """Fade out, then send zeros."""
        assert self._link is not None
        self._link.stop()
        return SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Fade out, send zeros, and release the model."""
        self.close()
        return SUCCESS

    on_shutdown = on_error = on_cleanup

    def close(self) -> None:
        """Fade out, send zeros, and release the model."""
        link, self._link = self._link, None
        if link is not None:
            self.unanswered = link.close()

    def _once_a_second(self) -> None:
        self._warnings.flush()
        if self._link is not None:
            self._link.look_at_controllers()

    def _parameters_changed(self) -> None:
        if self._link is not None:
            self._link.refresh()

    def _model_status(self) -> Status:
        if self._link is None:
            level = Level.ERROR if self._failure else Level.STALE
            return Status(level, self._failure or "not configured", {})
        return self._link.model_status()

    def _stream_status(self) -> Status:
        if self._link is not None and self._active:
            return self._link.stream_status()
        if self._link is not None:
            self._link.references.ignore()
        return Status(Level.STALE, "not active", self._warnings.values())

    def _joint_state_status(self) -> Status:
        if self._link is None or not self._active:
            return Status(Level.STALE, "not active")
        return self._link.joint_state_status()

    def _certainty_status(self) -> Status:
        if self._link is None or not self._active:
            return Status(Level.STALE, "not active")
        return self._link.references.certainty()

    def _controller_status(self) -> Status | None:
        return None if self._link is None else self._link.controller_status()


def declare(parameters: Parameters, fixed: Check, fixed_while_active: Check) -> None:
    """Declare the parameters that do not depend on the model.

    Args:
        fixed: return why a parameter that is read when configured, or activated, cannot be set now.
    """
    add = parameters.declare
    add("model_file", "", "the identified model; loaded when configured, and when the file or this "
        "name changes")  # fmt: skip
    add("effects_file", "", "Python that defines effects of your own; empty = none", check=fixed)
    add("joints", [""], 'order of ~/commands; [""] = the order of the model', check=fixed)
    add("autostart", True, "configure and activate at the start", read_only=True)
    add("rate", 500.0, "Hz of the stream", low=1.0, high=2000.0, check=fixed_while_active)
    add("start_delay", 0.6, "s from the plan being ready to the start of a reference that says "
        "'now' (header.stamp 0); longer than ramp_time, so that the torque is there when the "
        "motion begins", low=0.0, high=10.0)  # fmt: skip
    add("lead_time", 0.0, "s by which the torque is sent ahead of its reference, to make up for "
        "its way to the robot", low=0.0, high=0.1)  # fmt: skip
    add("controller", "", "name of the joint_trajectory_controller that goals of "
        "~/follow_joint_trajectory go on to, empty = none", check=fixed)  # fmt: skip
    add("controller_manager", "controller_manager", "name of its manager, which is asked what the "
        "controller takes", check=fixed)  # fmt: skip
    add("without_position_loop", False, "whether torque is streamed, too, to a controller that "
        "passes it on where nobody controls the position")  # fmt: skip
    add("point_error", 0.01, "how far torque that the controller interpolates linearly between the "
        "points of a goal may be from that of the path, as a share of the largest torque "
        "identified on each joint", low=1e-4, high=1.0)  # fmt: skip
    add("max_points", 20_000, "points of the longest accepted trajectory", low=1, high=200_000)
    for term in TERMS:
        add(f"terms.{term}", True, f"whether the {term} part is sent; off where the robot "
            "compensates it already")  # fmt: skip
    add("out_of_range", "fade", "a reference outside the identified range: refuse it, fade its "
        "torque to zero there, or allow it", choices=("refuse", "fade", "allow"))  # fmt: skip
    add("range_margin", 0.25, "how far outside still counts as inside, as a fraction of the "
        "range", low=0.0, high=10.0)  # fmt: skip
    add("doubt_limit", 0.0, "half of the 90 % interval of a torque, as a share of the largest "
        "torque identified on its joint, above which the reference counts as outside the "
        "identified range; 0 = never", low=0.0, high=100.0)  # fmt: skip
    add("ramp_time", 0.5, "s in which the torque is brought in", low=0.0, high=10.0)
    add("fade_time", 0.5, "s in which the torque is faded to zero", low=0.0, high=3.0)
    add("reference_timeout", 0.2, "s without a set-point after which the torque fades; 0 = off. "
        "Trajectories do not time out", low=0.0, high=10.0)  # fmt: skip
    add("joint_state_timeout", 0.5, "s without a joint state after which the torque fades; "
        "0 = off", low=0.0, high=10.0)  # fmt: skip
    add("tracking_tolerance", 0.5, "rad a joint may be away from its reference before the torque "
        "fades, as where the robot refused the trajectory; 0 = off",
        low=0.0, high=100.0)  # fmt: skip
    add("after_end", "hold", "after the end of a trajectory: hold the torque of its last point "
        "at rest, or fade", choices=("hold", "fade"))  # fmt: skip


def main() -> int:
    """Run the executable `feedforward`."""
    return run(FeedforwardNode, sys.argv)


if __name__ == "__main__":
    sys.exit(main())
