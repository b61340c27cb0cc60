"""Records joint states and identifies the inverse dynamics from them.

Topics
    joint_states   in   sensor_msgs/JointState; best effort, so that every publisher matches
    /diagnostics   out  progress while identifying, then the held-out error of each joint

Services (std_srvs/Trigger)
    ~/start      begin a recording: a bag in `output_directory`, on disk as it comes
    ~/stop       end it; start and stop again to add another
    ~/identify   begin to identify from all recordings since ~/clear; answers at once, progress
                 and end are on /diagnostics and in the log
    ~/save       copy the last model to `model_file`
    ~/clear      forget recordings and model, cancel an identification; files stay
"""

import os
import shutil
import sys
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from rclpy.clock import Clock, ClockType
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.complaints import Complaints
from lagrangian_ff.nodes.common.diagnostics import Diagnostics
from lagrangian_ff.nodes.common.pacing import RateMeter
from lagrangian_ff.nodes.common.parameters import Parameters
from lagrangian_ff.nodes.common.polled import PolledSubscription
from lagrangian_ff.nodes.common.qos import RECORDING
from lagrangian_ff.nodes.common.running import ClosingNode, run
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.common.summary import held_out, lines
from lagrangian_ff.nodes.recorder.intake import Intake
from lagrangian_ff.nodes.recorder.job import Job, Outcome
from lagrangian_ff.nodes.recorder.order import Order
from lagrangian_ff.nodes.recorder.session import Result, Session, State, new_path, stamped


class IdentifyNode(ClosingNode):
    """Opens and closes bags, hands orders to a process, and says how it goes."""

    def __init__(self) -> None:
        super().__init__("identify")
        self._settings = Parameters(self)
        self._declare()
        self._session = Session()
        self._job: Job | None = None
        self._complaints = Complaints(self.get_logger().warning)
        self._subscription = PolledSubscription(
            self, JointState, "joint_states", RECORDING, raw=True
        )
        self._intake = Intake(self._subscription.take, self._complaints.add)
        self._meter, self._seen = RateMeter(), 0
        for action, do in (
            ("start", self._start), ("stop", self._stop), ("identify", self._identify),
            ("save", self._save), ("clear", self._clear),
        ):  # fmt: skip
            self.create_service(Trigger, f"~/{action}", self._answer(action, do))
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(0.1, self._look_after_the_job, clock=steady)
        self._diagnostics = Diagnostics(
            self, "joint state recorder",
            {"input": self._input_status, "identification": self._identification_status},
            self._once_a_second,
        )  # fmt: skip
        self.get_logger().info(
            f"ready to record {self._subscription.topic} into {self._directory()}; call ~/start"
        )

    def _declare(self) -> None:
        declare = self._settings.declare
        declare("joints", [""], 'joints to identify, in this order; [""] = all recorded ones')
        declare("model", "vrbfs+fri", "model to identify, a sum of kernels and bases")
        declare(
            "train", 2.0 / 3.0, "fraction of the motion to train on, the rest is held out",
            low=0.01, high=1.0,
        )  # fmt: skip
        declare("samples", 500, "samples to train on", low=10, high=20_000)
        declare("bandwidth", 25.0, "Hz of the low-pass on position and effort", low=0.5, high=500.0)
        declare("output_directory", ".", "where bags and models are written")
        declare("bag_prefix", "recording", "how the names of bags begin")
        declare(
            "model_file", "",
            "where ~/save puts the model; empty = model.npz in output_directory",
        )  # fmt: skip
        declare("identify_on_stop", False, "whether ~/stop begins the identification, too")

    def _declare_joints(self) -> tuple[str, ...]:
        """The joints known by now, each with its own parameters."""
        joints = self._settings.strings("joints") or self._intake.tally.joints
        for joint in joints:
            self._settings.declare(
                f"effort_scale.{joint}", 1.0, "N·m per unit of effort", low=-1e6, high=1e6
            )
            self._settings.declare(
                f"effort_offset.{joint}", 0.0, "N·m added after scaling", low=-1e6, high=1e6
            )
        return joints

    def _directory(self) -> Path:
        return Path(self._settings.value("output_directory")).expanduser().absolute()

    def _answer(
        self, action: str, do: Callable[[], str]
    ) -> Callable[[Trigger.Request, Trigger.Response], Trigger.Response]:
        """The callback of a service: refuses in words what is impossible now."""

        def answer(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            refusal = self._session.refusal(action)
            try:
                response.message = refusal or do()
                response.success = not refusal
            except (UserError, OSError) as error:
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
        directory = self._directory()
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
            said += f"; {self._identify()}"
        return said

    def _identify(self) -> str:
        bags, value = self._session.bags, self._settings.value
        joints = self._declare_joints()
        order = Order(
            bags=tuple(map(str, bags)),
            output=str(new_path(self._directory(), f"{bags[-1].name}_model", ".npz")),
            topic=self._subscription.topic,
            joints=self._settings.strings("joints"),
            model=value("model"),
            train=value("train"),
            samples=value("samples"),
            bandwidth=value("bandwidth"),
            effort_scale={joint: value(f"effort_scale.{joint}") for joint in joints},
            effort_offset={joint: value(f"effort_offset.{joint}") for joint in joints},
        )
        self._job = Job(order)
        self._session.state = State.IDENTIFYING
        return f"started to identify {order.model} from {', '.join(bag.name for bag in bags)}"

    def _save(self) -> str:
        result = self._session.result
        assert result is not None
        wanted = self._settings.value("model_file")
        path = Path(wanted).expanduser().absolute() if wanted else self._directory() / "model.npz"
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
        return ", cancelled the identification"

    def _look_after_the_job(self) -> None:
        outcome = self._job.outcome() if self._job else None
        if self._job is None or outcome is None:
            return
        output, self._job = self._job.output, None
        self._session.state = State.IDLE
        self._finish(outcome, output)
        self._diagnostics.publish()

    def _finish(self, outcome: Outcome, output: Path) -> None:
        self._session.failure = outcome.error
        if outcome.record is None:
            self.get_logger().error(f"no model was identified: {outcome.error}")
            return
        self._session.result = Result(output, outcome.record)
        self.get_logger().info("\n".join([*lines(outcome.record), f"  model file: {output}"]))

    def _once_a_second(self) -> None:
        self._complaints.flush()
        self._declare_joints()

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

    def _identification_status(self) -> Status:
        if self._job is not None:
            return Status(
                Level.OK,
                f"identifying: {self._job.label}",
                {"state": "identifying", "progress": self._job.fraction, "label": self._job.label},
            )
        session = self._session
        values: dict[str, object] = {"state": session.state.value, "recordings": len(session.bags)}
        if session.result is not None:
            record = session.result.record
            values |= {
                "model file": session.result.model,
                "model": record["model"],
                "held-out RMSE [N·m]": record["rmse"],
                "held-out nMSE": record["nmse"],
                **held_out(record),
            }
        if session.failure:
            return Status(Level.ERROR, f"identification failed: {session.failure}", values)
        return Status(Level.OK, "identified" if session.result else "no model yet", values)

    def close(self) -> None:
        """End the bag properly and the identification at once."""
        self._cancel()
        self._intake.stop()


def main() -> int:
    """Entry point of the executable `identify`."""
    return run(IdentifyNode, sys.argv)


if __name__ == "__main__":
    sys.exit(main())
