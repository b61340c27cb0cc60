"""What the demo does, step by step: record, identify, then track with more and more feedforward."""

import os
import sys
from contextlib import closing
from pathlib import Path

from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.srv import SetParameters
from rclpy.context import Context
from rclpy.qos import QoSProfile
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.demo.arm_link import ArmLink, Drive, message_of
from lagrangian_ff.demo.capture import Track, recording_of
from lagrangian_ff.demo.conductor import Conductor
from lagrangian_ff.demo.errors import DemoError
from lagrangian_ff.demo.findings import Findings
from lagrangian_ff.demo.folder import Folder
from lagrangian_ff.demo.options import Options
from lagrangian_ff.demo.processes import Nodes
from lagrangian_ff.demo.stages import Stages
from lagrangian_ff.demo.trajectories import Motions
from lagrangian_ff.diagnosis import compare
from lagrangian_ff.identification import Model
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording import condition, write_bag

SECOND_ARM = "bound"  # namespace
IDENTIFICATION = "identify: identification"
STREAM, MODEL = "feedforward: stream", "feedforward: model"
STILL = 0.5  # s of rest that are recorded before and after the motion
SLOWEST_IDENTIFICATION = 600.0  # s
SERVICES = (
    *((Trigger, f"/identify/{action}") for action in ("start", "stop", "identify", "save")),
    *(
        (SetParameters, f"{node}/set_parameters")
        for node in ("/arm", f"/{SECOND_ARM}/arm", "/feedforward")
    ),
    (ChangeState, "/feedforward/change_state"),
)
# A busy machine holds the arm up now and then, and it then publishes many samples at once: with the
# usual short queues some would be lost.
DEEP = 2000
DEEP_ARM = {
    f"qos_overrides.{topic}.publisher.depth": DEEP
    for topic in ("/joint_states", "/arm/reference_state")
}
DEEP_BOUND = {name.replace("./", f"./{SECOND_ARM}/"): depth for name, depth in DEEP_ARM.items()}
RELIABLE_RECORDING = {"qos_overrides./joint_states.subscription.reliability": "reliable"}
FEEDFORWARD_TO_ARM = {
    "~/joint_trajectory": "/arm/joint_trajectory",
    "~/commands": "/arm/commands",
}


class Scenario:
    """Everything from starting the nodes to the last run.

    Args:
        options: what was asked for.
        motions: the two trajectories.
        folder: where results go.
        stages: told what is going on.
    """

    def __init__(self, options: Options, motions: Motions, folder: Folder, stages: Stages) -> None:
        self._options = options
        self._motions = motions
        self._folder = folder
        self._stages = stages
        self.findings = Findings(options)

    def play(self, context: Context, domain: int) -> Findings:
        """Do it all; every process has ended when this returns or raises.

        Raises:
            DemoError: a node did not do what was asked of it.
        """
        environment = {**os.environ, **_surroundings(domain)}
        with Nodes(self._folder.logs, environment) as nodes:
            self._start(nodes)
            with closing(Conductor(context, nodes)) as self._conductor:
                self._arm = ArmLink(self._conductor)
                self._second = ArmLink(self._conductor, SECOND_ARM)
                with self._stages.stage("start", "three nodes start, and a second arm"):
                    self._conductor.until(self._arm.ready, "the arm")
                    self._conductor.until(self._second.ready, "the second arm")
                    for kind, service in SERVICES:
                        self._conductor.meet(kind, service)
                    self._second.feed("true")
                self._record()
                self._identify()
                self._load()
                self._track(friction=False)
                self._track(friction=True)
                self.findings.stream = self._conductor.status(STREAM)
            self.findings.memory = nodes.peaks()
        return self.findings

    def _start(self, nodes: Nodes) -> None:
        options, folder = self._options, self._folder
        nodes.start(
            "arm", parameters={"feedforward_source": "none", "seed": options.seed, **DEEP_ARM}
        )
        nodes.start(
            "arm",
            parameters={"feedforward_source": "none", "seed": options.seed + 1, **DEEP_BOUND},
            remap={"__ns": f"/{SECOND_ARM}"},
            log="bound_arm",
        )
        # Not active before there is a model.
        nodes.start(
            "feedforward",
            # Where the unseen motion is faster than what was learned from, the torque is sent all
            # the same: the arm is simulated, and what the model knows there is to be seen.
            parameters={"autostart": False, "out_of_range": "allow"},
            remap=FEEDFORWARD_TO_ARM,
        )
        nodes.start(
            "identify",
            parameters={
                "model": options.model,
                "train": options.train,
                "samples": options.samples,
                "output_directory": str(folder.recording.absolute()),
                "model_file": str(folder.model.absolute()),
                **RELIABLE_RECORDING,
            },
        )

    def _record(self) -> None:
        trajectory = self._motions.training
        doing = f"the arm moves for {trajectory.duration:.0f} s and is recorded"
        with self._stages.stage("record", doing) as tell:
            self._conductor.trigger("/identify/start")
            self._rest()
            drive = self._arm.send(trajectory)
            bound = self._second.send(trajectory)
            self._wait([drive, bound], tell)
            self._rest()
            self._conductor.trigger("/identify/stop")
            self._keep("training", "none", drive)
            self._keep("training", "bound", bound)

    def _identify(self) -> None:
        """The identification runs in its own process, so the arm moves on meanwhile."""
        trajectory, options = self._motions.unseen, self._options
        doing = (
            f"identify learns {options.model} from it; meanwhile the arm makes "
            f"{trajectory.duration:.0f} s of another motion"
        )
        with self._stages.stage("identify", doing) as tell:
            self._conductor.trigger("/identify/identify")
            drive = self._arm.send(trajectory)
            bound = self._second.send(trajectory)
            self._wait([drive, bound], tell)
            measured = self._keep("unseen", "none", drive)
            self._keep("unseen", "bound", bound)

            def identified() -> str:
                failure = self._conductor.complaint(IDENTIFICATION)
                if failure:
                    raise DemoError(f"identify: {failure}")
                state = self._conductor.status(IDENTIFICATION)
                tell(float(state.get("progress", 1.0)), state.get("label", ""))
                return state.get("model file", "")

            self._conductor.until(identified, "the model", SLOWEST_IDENTIFICATION)
            self._conductor.trigger("/identify/save")
            self._judge(measured)

    def _judge(self, measured: Track) -> None:
        """Hold the model against the motion it never saw."""
        model = Model.load(self._folder.model)
        recording = recording_of(measured, "the motion never seen")
        write_bag(self._folder.unseen, recording)
        self.findings.identification = dict(model.record)
        self.findings.comparison = compare(model, condition(recording), intervals=True)

    def _load(self) -> None:
        with self._stages.stage("load", "feedforward loads the model"):
            conductor = self._conductor
            conductor.set_parameters(
                "/feedforward", {"model_file": str(self._folder.model.absolute())}
            )
            for step in ("configure", "activate"):
                if not conductor.transition("/feedforward", step):
                    raise DemoError(
                        f"feedforward: {step} failed: {conductor.complaint(MODEL) or 'see its log'}"
                    )
            self._references = conductor.node.create_publisher(
                JointTrajectory, "/feedforward/reference", QoSProfile(depth=10)
            )
            conductor.until(
                lambda: self._references.get_subscription_count() > 0, "feedforward's topics"
            )
            self._arm.feed(self._options.through)

    def _track(self, *, friction: bool) -> None:
        run = "all" if friction else "without_friction"
        said = "with friction" if friction else "without its friction part"
        self._conductor.set_parameters("/feedforward", {"terms.friction": friction})
        for name, trajectory in self._motions.named().items():
            doing = f"feedforward {said} on the {name} motion"
            with self._stages.stage(f"{name}_{run}", doing) as tell:
                drive = self._arm.listen(trajectory)
                self._references.publish(message_of(trajectory, 0))
                self._wait([drive], tell)
                self._keep(name, run, drive)

    def _keep(self, trajectory: str, run: str, drive: Drive) -> Track:
        found, measured, pace = drive.result(run)
        self.findings.keep(trajectory, run, found, pace)
        return measured

    def _wait(self, drives: list[Drive], tell: Progress) -> None:
        longest = max(self._options.duration, self._options.unseen_duration)
        self._conductor.until(
            lambda: all(drive.over() for drive in drives),
            "the end of the motion",
            patience=2.0 * longest + 60.0,
            meanwhile=lambda: tell(min(drive.fraction for drive in drives), ""),
        )

    def _rest(self) -> None:
        end = self._conductor.now() + round(STILL * 1e9)
        self._conductor.until(lambda: self._conductor.now() >= end, "a moment of rest")


def _surroundings(domain: int) -> dict[str, str]:
    """What the nodes' environment says besides that of the demo."""
    prefixes = [path for path in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if path]
    if sys.prefix not in prefixes and (Path(sys.prefix) / "share/ament_index").is_dir():
        prefixes.append(sys.prefix)
    return {
        "ROS_DOMAIN_ID": str(domain),
        "AMENT_PREFIX_PATH": os.pathsep.join(prefixes),
        "PYTHONUNBUFFERED": "1",
    }
