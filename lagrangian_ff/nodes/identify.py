"""Records joint states, identifies the inverse dynamics from them, and finds what the model lacks.

Topics
    joint_states        in   sensor_msgs/JointState; best effort, so that every publisher matches
    robot_description   in   std_msgs/String, latched; used if `use_robot_description` is set
    /diagnostics        out  progress, the held-out error of each joint, and what was found

Services (std_srvs/Trigger); those of the second half begin the work and answer at once, progress
and end are on /diagnostics and in the log
    ~/start      begin a recording: a bag in `output_directory`, on disk as it comes
    ~/stop       end it; start and stop again to add another
    ~/save       copy the last model to `model_file`
    ~/clear      forget recordings and model, cancel what is under way; files stay

    ~/identify   a model from all recordings since ~/clear
    ~/compare    where the model fails on the last recording
    ~/diagnose   which effects the model lacks; the last recording confirms what the others suggest
    ~/add        the effect `add.effect`, or what was confirmed, into a new model beside the old one
"""

import os
import shutil
import sys
from collections.abc import Callable
from datetime import datetime
from functools import partial

from rclpy.clock import Clock, ClockType
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.complaints import Complaints
from lagrangian_ff.nodes.common.diagnostics import Diagnostics
from lagrangian_ff.nodes.common.pacing import RateMeter
from lagrangian_ff.nodes.common.parameters import Parameters
from lagrangian_ff.nodes.common.polled import PolledSubscription
from lagrangian_ff.nodes.common.qos import LATCHED, RECORDING
from lagrangian_ff.nodes.common.running import BAD_PARAMETER, ClosingNode, run
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.identify_parameters import declare, declare_joints
from lagrangian_ff.nodes.recorder.findings import finding_statuses, lines, work_status
from lagrangian_ff.nodes.recorder.intake import Intake
from lagrangian_ff.nodes.recorder.job import Job
from lagrangian_ff.nodes.recorder.order import Task
from lagrangian_ff.nodes.recorder.ordering import directory_of, make_order, saved_model, summary
from lagrangian_ff.nodes.recorder.session import BUSY, Session, State, new_path, stamped


class IdentifyNode(ClosingNode):
    """Opens and closes bags, hands orders to a process, and says how it goes."""

    def __init__(self) -> None:
        super().__init__("identify")
        self._settings = Parameters(self)
        declare(self._settings)
        self._session = Session()
        self._job: Job | None = None
        self._complaints = Complaints(self.get_logger().warning)
        self._subscription = PolledSubscription(
            self, JointState, "joint_states", RECORDING, raw=True
        )
        self._intake = Intake(self._subscription.take, self._complaints.add)
        self._description = ""
        self.create_subscription(String, "robot_description", self._on_description, LATCHED)
        self._meter, self._seen = RateMeter(), 0
        services: dict[str, Callable[[], str]] = {
            "start": self._start, "stop": self._stop, "save": self._save, "clear": self._clear,
            **{task.value: partial(self._begin, task) for task in Task},
        }  # fmt: skip
        for action, do in services.items():
            self.create_service(Trigger, f"~/{action}", self._answer(action, do))
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(0.1, self._look_after_the_job, clock=steady)
        self._diagnostics = Diagnostics(
            self, "joint state recorder",
            {"input": self._input_status}, self._once_a_second, self._work_statuses,
        )  # fmt: skip
        directory = directory_of(self._settings.value)
        self.get_logger().info(
            f"ready to record {self._subscription.topic} into {directory}; call ~/start"
        )

    def _on_description(self, message: String) -> None:
        self._description = message.data

    def _joints(self) -> tuple[str, ...]:
        """The joints known by now, each with its own parameters."""
        joints = self._settings.strings("joints") or self._intake.tally.joints
        declare_joints(self._settings, joints)
        return joints

    def _answer(
        self, action: str, do: Callable[[], str]
    ) -> Callable[[Trigger.Request, Trigger.Response], Trigger.Response]:
        """The callback of a service: refuses in words what is impossible now."""

        def answer(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            refusal = self._session.refusal(action)
            try:
                response.message = refusal or do()
                response.success = not refusal
            except (UserError, OSError, *BAD_PARAMETER) as error:
                response.message, response.success = str(error), False
            self._diagnostics.publish()
            # rclpy ties a severity to the line that logs: one line for each.
            if response.success:
                self.get_logger().info(f"~/{action}: {response.message}")
            else:
                self.get_logger().warning(f"~/{action}: {response.message}")
            return response

        return answer

    def _start(self) -> str:
        directory = directory_of(self._settings.value)
        path = new_path(directory, stamped(self._settings.value("bag_prefix"), datetime.now()))
        self._intake.open(path, self._subscription.topic)
        self._session.current, self._session.state = path, State.RECORDING
        publishers = self.count_publishers(self._subscription.topic)
        return f"recording {self._subscription.topic} to {path}" + (
            "" if publishers else "; nobody publishes there yet"
        )

    def _stop(self) -> str:
        session, path = self._session, self._session.current
        assert path is not None
        session.state, session.current = State.IDLE, None
        self._intake.close_bag()
        tally = self._intake.tally
        if tally.samples == 0:
            raise UserError(
                f"no joint states came on {self._subscription.topic}; {path} is empty and not used"
            )
        session.bags.append(path)
        said = f"recorded {tally} of {', '.join(tally.joints)} to {path}"
        if self._intake.failure:
            said += f"; it ended early: {self._intake.failure}"
        if self._settings.value("identify_on_stop"):
            try:
                said += f"; {self._begin(Task.IDENTIFY)}"
            except (UserError, *BAD_PARAMETER) as error:
                said += f"; not identified: {error}"
        return said

    def _begin(self, task: Task) -> str:
        """Hand a task to a process of its own."""
        order = make_order(
            task, self._session, self._settings.value, self._subscription.topic, self._joints(),
            self._description,
        )  # fmt: skip
        self._job = Job(order)
        self._session.state = BUSY[task]
        return summary(order)

    def _save(self) -> str:
        result = self._session.result
        assert result is not None
        path = saved_model(self._settings.value)
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_name(f"{path.name}.part")
        shutil.copyfile(result.model, part)
        os.replace(part, path)
        return f"saved {result.model.name} as {path}"

    def _clear(self) -> str:
        count = len(self._session.bags)
        cancelled = self._cancel()
        self._session = Session()
        return f"forgot {count} recordings and the model{cancelled}; their files stay"

    def _cancel(self) -> str:
        if self._job is None:
            return ""
        self._job.cancel()
        self._job = None
        return f", stopped {self._session.state.value}"

    def _look_after_the_job(self) -> None:
        outcome = self._job.outcome() if self._job else None
        if self._job is None or outcome is None:
            return
        order, self._job = self._job.order, None
        self._session.finish(order, outcome.record, outcome.error)
        if outcome.record is None:
            self.get_logger().error(f"~/{order.task.value} failed: {outcome.error}")
        else:
            self.get_logger().info("\n".join(lines(order, outcome.record)))
        self._diagnostics.publish()

    def _once_a_second(self) -> None:
        self._complaints.flush()
        self._joints()

    def _input_status(self) -> Status:
        received, self._seen = self._intake.received - self._seen, self._intake.received
        self._meter.add(received)
        rate, tally = self._meter.take(), self._intake.tally
        level, message = Level.OK, self._session.state.value
        if self._intake.failure:
            level, message = Level.ERROR, f"recording ended: {self._intake.failure}"
        elif received == 0:
            level, message = Level.STALE, f"no joint states on {self._subscription.topic}"
        values = {
            "state": self._session.state.value,
            "rate [Hz]": rate,
            "joints": ", ".join(tally.joints),
            "bag": self._session.current or "",
            "samples": tally.samples,
            "seconds": tally.seconds,
            **self._complaints.counts,
        }
        return Status(level, message, values)

    def _work_statuses(self) -> dict[str, Status]:
        """How each kind of work stands, and what was found out about the model."""
        found = {
            name: status
            for task in Task
            for name, status in work_status(task, self._session, self._job).items()
        }
        return found | finding_statuses(self._session)

    def close(self) -> None:
        """End the bag properly and the work at once."""
        self._cancel()
        self._intake.stop()


def main() -> int:
    """Entry point of the executable `identify`."""
    return run(IdentifyNode, sys.argv)


if __name__ == "__main__":
    sys.exit(main())
