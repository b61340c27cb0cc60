"""The steps of the demo: record, identify, then track with more and more feedforward."""

import os
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import closing
from functools import partial
from pathlib import Path

from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.srv import SetParameters
from rclpy.context import Context
from rclpy.qos import QoSProfile
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.arm import Trajectory, exciting_trajectory
from lagrangian_ff.demo import arm_link
from lagrangian_ff.demo.bound import bound_of
from lagrangian_ff.demo.conductor import Conductor
from lagrangian_ff.demo.findings import Findings
from lagrangian_ff.demo.folder import Folder
from lagrangian_ff.demo.options import Options
from lagrangian_ff.demo.processes import Nodes, OtherWork, processor_seconds
from lagrangian_ff.demo.stages import Stages
from lagrangian_ff.diagnosis import compare
from lagrangian_ff.errors import DemoError, LostRunError
from lagrangian_ff.identification import Model
from lagrangian_ff.nodes.common.topics import message_of
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording import condition, write_bag
from lagrangian_ff.report import Tracking

IDENTIFICATION = "identify: identification"
STREAM, MODEL = "feedforward: stream", "feedforward: model"
SETTLING = 0.3  # s in which messages under way arrive
SLOWEST_IDENTIFICATION = 600.0  # s
SLOWEST_CLOCK = 0.1  # times real time; an arm that is slower has stopped
TRIES = 3  # of a run of which joint states were lost
ARM_AND_RECORDER = (
    *((Trigger, f"/identify/{action}") for action in ("start", "stop", "identify", "save")),
    (SetParameters, "/arm/set_parameters"),
)
FEEDFORWARD = (
    (SetParameters, "/feedforward/set_parameters"),
    (ChangeState, "/feedforward/change_state"),
)
# The arm keeps its own time, and the stream answers each joint state: tracking shows the model, not
# the load of the machine.
WAIT = 1.0  # s for an answer
TICK = 1.0 / arm_link.RATE
OWN_CLOCK = {
    "publish_clock": True,
    "wait_for_command": WAIT,
    "qos_overrides./arm/commands.subscription.reliability": "reliable",
}
RELIABLE_STATES = {"qos_overrides./joint_states.subscription.reliability": "reliable"}
FEEDFORWARD_TO_ARM = {"~/joint_trajectory": "/arm/joint_trajectory", "~/commands": "/arm/commands"}


def motions_of(options: Options) -> dict[str, Trajectory]:
    """Return exciting trajectories, `training` and `unseen`, from and to the arm's home position.

    Raises:
        ArmError: none was found within the arm's limits.
    """
    return {
        "training": exciting_trajectory(options.speed, options.seed, options.duration),
        "unseen": exciting_trajectory(options.speed, options.seed + 1, options.unseen_duration),
    }


class Scenario:
    """Everything from starting the nodes to the last run.

    Args:
        options: what was asked for.
        motions: see `motions_of`.
        folder, stages: of the results, and of the progress.
    """

    def __init__(
        self, options: Options, motions: Mapping[str, Trajectory], folder: Folder, stages: Stages
    ) -> None:
        self._options = options
        self._motions = motions
        self._folder = folder
        self._stages = stages
        self.findings = Findings(options)

    def play(self, context: Context, domain: int) -> Findings:
        """Play all steps; every process has ended when this returns or raises.

        Raises:
            DemoError: a node failed.
        """
        environment = {**os.environ, **surroundings(domain)}
        with Nodes(self._folder.logs, environment) as self._nodes:
            self._start_arm_and_recorder()
            with closing(Conductor(context, self._nodes)) as self._conductor:
                self._arm = arm_link.ArmLink(self._conductor)
                with self._stages.stage("start", "the arm and the recorder start"):
                    self._conductor.until(self._arm.ready, "the arm")
                    for kind, service in ARM_AND_RECORDER:
                        self._conductor.meet(kind, service)
                seed = self._options.seed + 1
                with bound_of(list(self._motions.values()), seed) as bound:
                    self._record()
                    self._identify()
                    self._load()
                    others = OtherWork(lambda: processor_seconds(self._nodes.numbers()))
                    self._track(friction=False)
                    self._track(friction=True)
                    self.findings.others = others.processors()
                    self.findings.stream = self._conductor.status(STREAM)
                    self._nodes.end()
                    self._judge(bound)
            self.findings.memory = self._nodes.peaks()
        return self.findings

    def _start_arm_and_recorder(self) -> None:
        options, folder = self._options, self._folder
        self._nodes.start(
            "arm",
            parameters={
                "feedforward_source": "none",
                "seed": options.seed,
                "clock_speed": options.clock_speed,
                "clock_until": arm_link.BEFORE,
                **OWN_CLOCK,
            },
        )
        self._nodes.start(
            "identify",
            parameters={
                "model": options.model,
                "train": options.train,
                "samples": options.samples,
                "output_directory": str(folder.recording.absolute()),
                "model_file": str(folder.model.absolute()),
                **RELIABLE_STATES,
            },
        )

    def _start_feedforward(self) -> None:
        """Start the node, which sleeps until there is a model."""
        self._nodes.start(
            "feedforward",
            parameters={
                "autostart": False,
                "use_sim_time": True,
                # The arm reads a whole trajectory before it starts.
                "start_delay": arm_link.LEAD,
                # A torque acts a tick after the joint state that it answers.
                "lead_time": TICK,
                # The torque is sent even if the unseen motion is faster than that learned from: the
                # arm is simulated, and the demo shows how well the model extrapolates.
                "out_of_range": "allow",
                **RELIABLE_STATES,
            },
            remap=FEEDFORWARD_TO_ARM,
        )

    def _record(self) -> None:
        trajectory = self._motions["training"]
        doing = f"the arm moves for {trajectory.duration:.0f} s and is recorded"
        with self._stages.stage("record", doing) as report:
            self._settle()
            self._conductor.trigger("/identify/start")
            self._run("training", "none", lambda: self._arm.send(trajectory), report)
            self._settle()
            self._conductor.trigger("/identify/stop")

    def _identify(self) -> None:
        """Identify in another process, while the arm moves on."""
        trajectory, options = self._motions["unseen"], self._options
        doing = (
            f"identify learns {options.model} from it; meanwhile the arm makes "
            f"{trajectory.duration:.0f} s of another motion"
        )
        with self._stages.stage("identify", doing) as report:
            self._conductor.trigger("/identify/identify")
            self._start_feedforward()
            self._unseen = self._run("unseen", "none", lambda: self._arm.send(trajectory), report)

            def identified() -> str:
                if failure := self._conductor.complaint(IDENTIFICATION):
                    raise DemoError(f"identify: {failure}")
                state = self._conductor.status(IDENTIFICATION)
                report(float(state.get("progress", 1.0)), state.get("label", ""))
                return state.get("model file", "")

            self._conductor.until(identified, "the model", SLOWEST_IDENTIFICATION)
            self._conductor.trigger("/identify/save")

    def _load(self) -> None:
        with self._stages.stage("load", "feedforward loads the model"):
            conductor = self._conductor
            for kind, service in FEEDFORWARD:
                conductor.meet(kind, service)
            model = str(self._folder.model.absolute())
            conductor.set_parameters("/feedforward", {"model_file": model})
            for step in ("configure", "activate"):
                if not conductor.transition("/feedforward", step):
                    why = conductor.complaint(MODEL) or "see its log"
                    raise DemoError(f"feedforward: {step} failed: {why}")
            self._references = conductor.node.create_publisher(
                JointTrajectory, "/feedforward/reference", QoSProfile(depth=10)
            )
            conductor.until(
                lambda: self._references.get_subscription_count() > 0, "feedforward's topics"
            )
        self._nodes.end("identify")
        self._arm.set(feedforward_source=self._options.through, clock_until=0.0)

    def _track(self, *, friction: bool) -> None:
        run = "all" if friction else "without_friction"
        said = "with friction" if friction else "without its friction part"
        self._conductor.set_parameters("/feedforward", {"terms.friction": friction})
        for name, trajectory in self._motions.items():
            doing = f"feedforward {said} on the {name} motion"
            with self._stages.stage(f"{name}_{run}", doing) as report:
                self._run(name, run, partial(self._refer, trajectory), report)

    def _refer(self, trajectory: Trajectory) -> arm_link.Drive:
        """Send a trajectory to the arm by way of the feedforward."""
        drive = self._arm.listen(trajectory)
        self._references.publish(message_of(trajectory, 0))
        return drive

    def _run(
        self, name: str, run: str, send: Callable[[], arm_link.Drive], report: Progress
    ) -> arm_link.Track:
        """Drive the arm once, again if joint states were lost; return the joint states.

        Raises:
            LostRunError: none of the tries was whole.
        """
        longest = max(self._options.duration, self._options.unseen_duration)
        patience = longest / SLOWEST_CLOCK + 60.0
        for left in reversed(range(TRIES)):
            drive = send()
            show = partial(_show, drive, report)
            try:
                self._conductor.until(drive.over, "the end of the motion", patience, show)
                found, measured = drive.result(run)
                break
            except LostRunError:
                if not left:
                    raise
        self.findings.keep(name, run, found, drive.speed)
        return measured

    def _settle(self) -> None:
        """Let the last joint states arrive everywhere while the arm's clock stands still."""
        end = time.monotonic() + SETTLING
        self._conductor.until(lambda: time.monotonic() >= end, "a moment of rest")

    def _judge(self, bound: Callable[[], list[Tracking]]) -> None:
        """Compare the model with the motion it never saw, and tracking with its bound."""
        with self._stages.stage("judge", "the model is compared with the motion it never saw"):
            model = Model.load(self._folder.model)
            recording = arm_link.recording_of(self._unseen, "the motion never seen")
            write_bag(self._folder.unseen, recording)
            self.findings.identification = model.identified
            self.findings.comparison = compare(
                model, condition(recording, model.identified.conditioning), intervals=True
            )
            for name, found in zip(self._motions, bound(), strict=True):
                self.findings.keep(name, "bound", found)


def _show(drive: arm_link.Drive, report: Progress) -> None:
    report(drive.fraction, "")


def surroundings(domain: int) -> dict[str, str]:
    """Return what the nodes' environment has besides that of the demo."""
    prefixes = [path for path in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if path]
    if sys.prefix not in prefixes and (Path(sys.prefix) / "share/ament_index").is_dir():
        prefixes.append(sys.prefix)
    return {
        "ROS_DOMAIN_ID": str(domain),
        "AMENT_PREFIX_PATH": os.pathsep.join(prefixes),
        "PYTHONUNBUFFERED": "1",
    }
