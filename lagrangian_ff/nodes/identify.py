"""The identify node: records joint states, identifies a model, and finds what it lacks.

Topics
    joint_states        in   sensor_msgs/JointState; best effort, so that every publisher matches
    robot_description   in   std_msgs/String, latched; used if `use_robot_description` is set
    /diagnostics        out  progress, the held-out error of each joint, and what was found

Services (std_srvs/Trigger); the jobs begin at once and answer, progress and end are on
/diagnostics and in the log
    ~/start      begin a recording: a bag in `output_directory`, written at once; says how long the
                 disk lasts. Also while a job goes on
    ~/stop       end it; start and stop again to add another
    ~/save       copy the last model to `model_file`
    ~/clear      forget recordings and model, cancel the present job; files stay

    ~/load, ~/identify, ~/compare, ~/diagnose, ~/add, ~/investigate: the jobs, see `recorder.jobs`
    ~/proceed, ~/abort: of the process that investigates, while it does: permit what /diagnostics
                 says that it asks for; stop the arm at once
"""

import shutil
import sys
from collections.abc import Callable, Sequence
from datetime import datetime
from functools import partial
from pathlib import Path

from rclpy.clock import Clock, ClockType
from rclpy.context import Context
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger

from lagrangian_ff.errors import UserError
from lagrangian_ff.files import whole
from lagrangian_ff.identification.settings import LOSSES, Settings
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.nodes.common.models import load_own_effects
from lagrangian_ff.nodes.common.node import BAD_PARAMETER, ClosingNode, Diagnostics, Parameters, run
from lagrangian_ff.nodes.common.pacing import RateMeter
from lagrangian_ff.nodes.common.status import Level, Status, ThrottledWarnings
from lagrangian_ff.nodes.common.topics import LATCHED, RECORDING, PolledSubscription
from lagrangian_ff.nodes.recorder.bag_recorder import BagRecorder, free_space, lasting
from lagrangian_ff.nodes.recorder.jobs import JOBS
from lagrangian_ff.nodes.recorder.jobs.base import Job, Situation
from lagrangian_ff.nodes.recorder.jobs.identify import Identify
from lagrangian_ff.nodes.recorder.jobs.load import Load
from lagrangian_ff.nodes.recorder.session import Session, new_path
from lagrangian_ff.recording.motion import EFFORTS, LONGEST_DELAY, Conditioning
from lagrangian_ff.worker import Worker

SHORT = 600.0  # s that the disk lasts, from which on it is a warning


class IdentifyNode(ClosingNode):
    """Opens and closes bags, starts a process for each job, and reports.

    Args:
        jobs: each becomes a service.
        context: of rclpy; None for the default one.
    """

    def __init__(self, jobs: Sequence[type[Job]] = JOBS, context: Context | None = None) -> None:
        super().__init__("identify", context=context)
        self._jobs = tuple(jobs)
        self._settings = Parameters(self, profiles=True)
        declare(self._settings)
        self._session = Session()
        self._worker: Worker[Job] | None = None
        self._warnings = ThrottledWarnings(self.get_logger().warning)
        self._subscription = PolledSubscription(
            self, JointState, "joint_states", RECORDING, raw=True
        )
        self._recorder = BagRecorder(self._subscription.take, self._warnings.add)
        self._description = ""
        self.create_subscription(String, "robot_description", self._on_description, LATCHED)
        self._reports = self.create_publisher(String, "~/report", LATCHED)
        self._meter, self._seen = RateMeter(), 0
        own = {"start": self._start, "stop": self._stop, "save": self._save, "clear": self._clear}
        for service, do in own.items():
            self._offer(service, partial(Session.refusal, service=service), do)
        for job in self._jobs:
            self._offer(job.service, job.refusal, partial(self._begin, job))
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(0.1, self._check_worker, clock=steady)
        self._diagnostics = Diagnostics(
            self,
            "joint state recorder",
            housekeeping=self._once_a_second,
            input=self._input_status,
            jobs=self._job_statuses,
        )
        self.get_logger().info(
            f"ready to record {self._subscription.topic} into {self._situation().directory}; "
            "call ~/start"
        )
        if self._settings.strings("recordings"):
            self.get_logger().info(self._begin(Load))

    def _on_description(self, message: String) -> None:
        self._description = message.data

    def _joints(self) -> tuple[str, ...]:
        """Return the joints known so far, with their parameters declared."""
        heard = tuple(dict.fromkeys((*self._recorder.joints, *self._session.joints)))
        joints = self._settings.strings("joints") or heard
        self._settings.declare_effort((*joints, *heard))
        return joints

    def _situation(self, joints: Sequence[str] = ()) -> Situation:
        topic, description = self._subscription.topic, self._description
        node = self.get_fully_qualified_name()
        return Situation(self._session, self._settings.value, topic, joints, description, node)

    def _offer(
        self, service: str, refusal: Callable[[Session], str], do: Callable[[], str]
    ) -> None:
        """Create a service that refuses in words what is impossible now."""

        def answer(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            refused = refusal(self._session)
            try:
                response.message = refused or do()
                response.success = not refused
            except (UserError, OSError, *BAD_PARAMETER) as error:
                response.message, response.success = str(error), False
            self._diagnostics.publish()
            # rclpy ties a severity to the line that logs: one line for each.
            if response.success:
                self.get_logger().info(f"~/{service}: {response.message}")
            else:
                self.get_logger().warning(f"~/{service}: {response.message}")
            return response

        self.create_service(Trigger, f"~/{service}", answer)

    def _start(self) -> str:
        topic = self._subscription.topic
        stem = f"{self._settings.value('bag_prefix')}_{datetime.now():%Y%m%d_%H%M%S}"
        directory = self._situation().directory
        path, reserve = new_path(directory, stem), self._reserve
        if (free := free_space(directory)) < reserve:
            raise UserError(
                f"{directory} has {free / 1e9:.2f} GB left, and {reserve / 1e9:g} GB are to stay "
                "free (disk_reserve): delete recordings or set output_directory"
            )
        self._recorder.open(path, topic, reserve)
        self._session.current = path
        said = f"recording {topic} to {path}; {lasting(free, reserve, self._recorder.rate)}"
        return said if self.count_publishers(topic) else f"{said}; nobody publishes there yet"

    @property
    def _reserve(self) -> int:
        return round(self._settings.value("disk_reserve") * 1e9)

    def _stop(self) -> str:
        path, self._session.current = self._session.current, None
        assert path is not None
        self._recorder.close_bag()
        tally = self._recorder.tally
        if tally.samples == 0:
            raise UserError(
                f"no joint states came on {self._subscription.topic}; {path} is empty and not used"
            )
        self._session.bags.append(path)
        said = f"recorded {tally} of {', '.join(tally.joints)[:200]} to {path}"
        if self._recorder.failure:
            said += f"; it ended early: {self._recorder.failure}"
        if self._settings.value("identify_on_stop"):
            try:
                refused = Identify.refusal(self._session)
                said += f"; not identified: {refused}" if refused else f"; {self._begin(Identify)}"
            except (UserError, *BAD_PARAMETER) as error:
                said += f"; not identified: {error}"
        return said

    def _begin(self, job: type[Job]) -> str:
        joints = self._joints()
        if joints:
            self._settings.refuse_unknown("effort_scale", "effort_offset", "add")
        request = job.request(self._situation(joints))
        self._worker = Worker(request)
        self._session.busy = job.doing
        return request.summary()

    def _save(self) -> str:
        model, path = self._session.model, self._situation().saved_model
        assert model is not None
        path.parent.mkdir(parents=True, exist_ok=True)
        said = f"saved {model.file.name} as {path}"
        if path.exists():
            of = datetime.fromtimestamp(path.stat().st_mtime)
            kept = path.with_name(f"{path.stem}_{of:%Y%m%d_%H%M%S}{path.suffix}")
            shutil.copy2(path, kept)
            said += f"; the model that was there is kept as {kept.name}"
        with whole(path) as made:
            shutil.copyfile(model.file, made)
        return said

    def _clear(self) -> str:
        said = f"forgot {len(self._session.bags)} recordings and the model"
        if self._cancel():
            said += f", stopped {self._session.busy}"
        self._session = Session()
        return f"{said}; their files stay"

    def _cancel(self) -> bool:
        worker, self._worker = self._worker, None
        if worker is not None:
            worker.cancel()
        return worker is not None

    def _check_worker(self) -> None:
        outcome = self._worker.outcome() if self._worker else None
        if self._worker is None or outcome is None:
            return
        job, self._worker = self._worker.job, None
        self._session.busy = ""
        self._session.failures.pop(job.service, None)
        if outcome.result is None:
            self._session.failures[job.service] = outcome.error
            self.get_logger().error(f"~/{job.service} failed: {outcome.error}")
        else:
            self._session.take(job.service, outcome.result)
            if outcome.result.report:
                text = Path(outcome.result.report).read_text("utf-8")
                self._reports.publish(String(data=text))
            self.get_logger().info("\n".join(outcome.result.log))
        self._diagnostics.publish()

    def _once_a_second(self) -> None:
        self._warnings.flush()
        self._joints()

    def _input_status(self) -> Status:
        received, self._seen = self._recorder.received - self._seen, self._recorder.received
        self._meter.add(received)
        rate, tally = self._meter.take(), self._recorder.tally
        free, volume = free_space(self._situation().directory), self._recorder.rate
        level, message = Level.OK, self._session.state
        if self._recorder.failure:
            level, message = Level.ERROR, f"recording ended: {self._recorder.failure}"
        elif received == 0:
            level, message = Level.STALE, f"no joint states on {self._subscription.topic}"
        elif free - self._reserve < SHORT * volume:
            level, message = Level.WARN, f"{message}; {lasting(free, self._reserve, volume)}"
        values = {
            "state": self._session.state,
            "rate [Hz]": rate,
            "joints": ", ".join(self._recorder.joints),
            "bag": self._session.current or "",
            "samples": tally.samples,
            "seconds": tally.seconds,
            "disk": lasting(free, self._reserve, volume),
            **self._warnings.counts,
        }
        return Status(level, message, values)

    def _job_statuses(self) -> dict[str, Status]:
        """Return the state of every job, the present one with its progress."""
        found: dict[str, Status] = {}
        for job in self._jobs:
            found |= job.statuses(self._session)
        worker, state = self._worker, self._session.busy
        if worker is not None:
            values = {"state": state, "progress": worker.fraction, "label": worker.label}
            found[worker.job.title] = Status(Level.OK, f"{state}: {worker.label}", values)
        return found

    def close(self) -> None:
        """End the bag properly and the present job at once."""
        self._cancel()
        self._recorder.stop()


def declare(parameters: Parameters) -> None:
    """Declare the parameters that do not depend on the joints; defaults are the settings'."""
    add = parameters.declare
    add("joints", [""], 'joints to identify, from base to tool; [""] = all, put in order')
    add("effects_file", "", "Python that defines effects of your own; empty = none")
    add("model", "", "model to identify, a sum of kernels and bases; empty = auto+fri, or auto "
        "where friction is compensated in the drive",
        check=lambda name: _refused_model(name, parameters.value("effects_file")))  # fmt: skip
    add("effort", Conditioning.effort, "what the effort holds: all torque, or all but gravity or "
        "friction that the driver or the drive compensates", choices=EFFORTS)  # fmt: skip
    add("effort_delay", 0.0, "s by which the effort comes later than the position",
        low=-LONGEST_DELAY, high=LONGEST_DELAY)  # fmt: skip
    add("prismatic", [""], 'joints that slide, in m and N, where no urdf says it; [""] = all turn')
    add("urdf", "", "file of the robot's description, whose rigid bodies are part of the model; "
        "empty = none")  # fmt: skip
    add("use_robot_description", False, "take the description from the topic robot_description")
    add("train", Settings.train, "fraction of the motion to train on, the rest is held out",
        low=0.01, high=1.0)  # fmt: skip
    add("samples", Settings.samples, "samples to train on", low=10, high=20_000)
    add("landmarks", -1, "samples the kernel is built on, while all are learned from; 0 = an exact "
        "model of `samples`, -1 = exact up to two minutes of training motion, else 300",
        low=-1, high=20_000)  # fmt: skip
    add("positive", Settings.positive, "whether the mass matrix is kept positive definite along "
        "the training motion")  # fmt: skip
    add("loss", Settings.loss, "what a residual costs; huber weighs down contacts and gross "
        "errors", choices=LOSSES)  # fmt: skip
    add("bandwidth", 0.0, "Hz of the low-pass on position and effort; 0 = as wide as their noise "
        "allows, up to 25 Hz", low=0.0, high=500.0)  # fmt: skip
    add("units", [""], 'what drivers report in another unit than rad or N·m, such as position=deg '
        'or effort=mNm; [""] = nothing')  # fmt: skip
    add("recordings", [""], 'bags, CSV or NumPy files, used as if they had been recorded here: at '
        'the start, and with ~/load; [""] = none')  # fmt: skip
    add("output_directory", ".", "where bags, models and findings are written")
    add("bag_prefix", "recording", "how the names of bags begin")
    add("model_file", "", "the model to compare, diagnose and add to until one is identified, and "
        "where ~/save puts the last one (empty = model.npz in output_directory)")  # fmt: skip
    add("disk_reserve", 0.5, "GB of the disk that a recording leaves free; it ends before",
        low=0.0, high=1e6)  # fmt: skip
    add("identify_on_stop", False, "whether ~/stop begins the identification, too")
    add("add.effect", "", "name of the effect that ~/add adds, see lagrangian_ff effects; empty = "
        "what the last diagnosis confirmed")  # fmt: skip
    add("add.joint", "", "the joint that ~/add adds it to")
    add("investigate.topic", "", "where ~/investigate sends trajectories that move the arm")
    add("investigate.urdf", "", "file of the robot's description, whose limits ~/investigate keeps "
        "and whose links it keeps clear of each other")  # fmt: skip
    add("investigate.limits", "", "file of joint limits, as MoveIt's joint_limits.yaml; kept too")
    add("investigate.speed", 0.5, "share of the highest speeds that its motions may take",
        low=0.01, high=1.0)  # fmt: skip
    add("investigate.minutes", 4.0, "min of motion, all in all", low=0.15, high=60.0)


def _refused_model(name: str, effects_file: str) -> str:
    """Return why there is no model of this name, or ""."""
    try:
        load_own_effects(effects_file)
        if name:
            parse(name)
    except UserError as error:
        return str(error)
    return ""


def main() -> int:
    """Run the executable `identify`."""
    return run(IdentifyNode, sys.argv)


if __name__ == "__main__":
    sys.exit(main())
