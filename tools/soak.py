"""Let all nodes run for half an hour and see whether they grow, leak, lose or come late.

make soak, or python tools/soak.py [--minutes 30] [--output out/soak]

The simulated arm moves and is recorded by `identify`, driven by `feedforward` at 1 kHz and watched
by `monitor`, each in its own process. Judged are their memory and open files from when they have
settled to the end, the time between commands beside that of a loop that does nothing, and the
joint states in the bag.
"""

import argparse
import os
import subprocess
import sys
import time
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rclpy.context import Context
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.arm import ArmParameters, Driver, exciting_trajectory, fine, reported, simulate
from lagrangian_ff.demo.arm_link import message_of
from lagrangian_ff.demo.conductor import Conductor, own_graph
from lagrangian_ff.demo.processes import NodeProcess, Nodes
from lagrangian_ff.demo.scenario import FEEDFORWARD_TO_ARM, surroundings
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.nodes.common.topics import PolledSubscription
from lagrangian_ff.recording import condition, load
from lagrangian_ff.report.style import new_figure, png, styled

Floats = NDArray[np.float64]

NODES = ("arm", "identify", "feedforward", "monitor")
RATE = 1000.0  # Hz of the commands
STATE = 0.002  # s between joint states
GROWTH = 2.0  # MB
LATE = 3.0  # ms, the bound of docs/speed.md for the 99th percentile
MOTION = 9.0  # s
SETTLED = 120.0, 0.6  # s, and share of the time, after which nothing may grow any more
DEEP = QoSProfile(depth=10_000, reliability=ReliabilityPolicy.RELIABLE)
MEMORY, FILES = 0, 1


@dataclass(frozen=True)
class Soak:
    """The measurements of a run of S seconds.

    Attributes:
        held: (S, nodes, 2) memory in MB and open files.
        late: (S, 2) ms by which the 99th percentile of the commands, and the last, missed their
            period; `bare` is the same of a loop that does nothing.
        commands, wrong: how many came, and how many of them were not finite.
        kept, lost: joint states in the bag, and missing between them.
    """

    held: Floats
    late: Floats
    bare: Floats
    commands: int
    wrong: int
    kept: int
    lost: int

    @property
    def settled(self) -> Floats:
        """Return (nodes, 2): memory and files once all nodes have seen several motions."""
        since = round(min(SETTLED[0], SETTLED[1] * len(self.held)))
        return np.asarray(np.median(self.held[since : since + self._tenth], axis=0))

    @property
    def growth(self) -> Floats:
        """Return (nodes, 2): how much more they hold in the last tenth of the time."""
        return np.asarray(np.median(self.held[-self._tenth :], axis=0) - self.settled)

    @property
    def _tenth(self) -> int:
        return max(1, len(self.held) // 10)

    @property
    def failures(self) -> list[str]:
        """Return what is not as it should be."""
        found = []
        for name, (memory, files) in zip(NODES, self.growth, strict=True):
            if memory > GROWTH:
                found.append(f"{name} grew by {memory:.1f} MB")
            if files > 0:
                found.append(f"{name} has {files:.0f} more open files")
        late, bare = (float(np.median(one[:, 0])) for one in (self.late, self.bare))
        if late > LATE + bare:
            found.append(f"commands came {late:.1f} ms late, a bare loop {bare:.1f} ms")
        if self.wrong or not self.commands:
            found.append(f"{self.wrong} of {self.commands} commands are not finite")
        if self.lost or not self.kept:
            found.append(f"{self.lost} joint states lost beside {self.kept} in the bag")
        return found

    def text(self) -> str:
        """Return the figures."""
        lines = [f"{len(self.held)} s, {self.commands} commands, {self.wrong} not finite"]
        for k, name in enumerate(NODES):
            memory, files = self.growth[k]
            lines.append(
                f"{name:12} {self.held[-1, k, MEMORY]:6.1f} MB, grown by {memory:+.2f}; "
                f"{self.held[-1, k, FILES]:.0f} open files, {files:+.0f}"
            )
        for name, one in (("commands", self.late), ("a bare loop", self.bare)):
            lines.append(
                f"{name:12} 99 % of a second within {np.median(one[:, 0]):.2f} ms of their period "
                f"(median), {one[:, 0].max():.1f} ms (worst); the latest {one[:, 1].max():.1f} ms"
            )
        lines.append(f"{self.kept} joint states in the bag, {self.lost} lost")
        return "\n".join(lines)

    def draw(self, path: Path) -> None:
        """Draw memory, open files and lateness over time."""
        with styled():
            figure = new_figure(7.0)
            memory, files, late = figure.subplots(3, 1, sharex=True)
            at = np.arange(len(self.held)) / 60.0
            for k, name in enumerate(NODES):
                memory.plot(at, self.held[:, k, MEMORY] - self.settled[k, MEMORY], label=name)
                files.plot(at, self.held[:, k, FILES] - self.settled[k, FILES])
            memory.axhspan(-GROWTH, GROWTH, alpha=0.1)
            memory.set_ylim(-4.0 * GROWTH, 3.0 * GROWTH)
            memory.set_ylabel("memory beyond settled [MB]")
            memory.legend(ncols=len(NODES), loc="upper left")
            files.set_ylim(-3.0, 3.0)
            files.set_ylabel("open files beyond settled")
            late.semilogy(at, np.maximum(self.late[:, 1], 1e-2), label="latest command")
            late.semilogy(at, np.maximum(self.late[:, 0], 1e-2), label="99 % of the commands")
            idle = np.maximum(self.bare[:, 0], 1e-2)
            late.semilogy(np.arange(len(idle)) / 60.0, idle, label="99 % of a bare loop")
            late.axhline(LATE, linestyle="--")
            late.set_ylim(1e-2, 1e4)
            late.set_ylabel("late, second by second [ms]")
            late.set_xlabel("time [min]")
            late.legend(ncols=3, loc="upper left")
            path.write_bytes(png(figure))


def lateness(at: Floats) -> tuple[float, float]:
    """Return the 99th percentile and the most, ms, by which times in ns missed their period."""
    if len(at) < 3:
        return 1e3, 1e3
    late = np.diff(at) / 1e6 - 1e3 / RATE
    return float(np.quantile(late, 0.99)), float(late.max())


def bare() -> None:
    """Wake at the rate of the commands until killed, and print the lateness of each second."""
    period, due, at = round(1e9 / RATE), time.monotonic_ns(), []
    while True:
        due += period
        time.sleep(max(0, due - time.monotonic_ns()) / 1e9)
        at.append(time.monotonic_ns())
        if len(at) == RATE:
            print(*lateness(np.array(at, dtype=np.float64)), flush=True)
            at.clear()


def passed(moment: float) -> bool:
    """Return whether a moment of the monotonic clock has passed."""
    return time.monotonic() >= moment


def held(process: NodeProcess) -> tuple[float, int]:
    """Return memory in MB and open files of a process."""
    folder = Path(f"/proc/{process.number}")
    lines = (folder / "status").read_text().splitlines()
    resident = next(line for line in lines if line.startswith("VmRSS:"))
    return int(resident.split()[1]) / 1024.0, len(os.listdir(folder / "fd"))


def make_model(path: Path) -> None:
    """Identify the arm from half a minute of it."""
    usual = fine(ArmParameters())
    run = simulate(exciting_trajectory(4, 7), parameters=usual)
    recording = reported(run, Driver(1.0 / STATE), usual, 0)
    identify(condition(recording), Settings(train=1.0, samples=200, evaluations=5)).model.save(path)


def soaked(context: Context, domain: int, seconds: int, folder: Path) -> Soak:
    """Run the nodes for this time and return what was seen."""
    model = folder / "model.npz"
    make_model(model)
    environment = {**os.environ, **surroundings(domain)}
    with Nodes(folder, environment) as nodes:
        processes = [
            nodes.start("arm", parameters={"feedforward_source": "stream"}),
            nodes.start("identify", parameters={"output_directory": str(folder / "bags")}),
            nodes.start(
                "feedforward",
                parameters={"model_file": str(model), "rate": RATE, "out_of_range": "allow"},
                remap=FEEDFORWARD_TO_ARM,
            ),
            nodes.start("monitor", parameters={"model_file": str(model)}),
        ]
        with closing(Conductor(context, nodes)) as conductor:
            return watched(conductor, processes, seconds, folder)


def watched(conductor: Conductor, processes: list[NodeProcess], seconds: int, folder: Path) -> Soak:
    """Keep the arm moving and look at everything once a second."""
    commands = PolledSubscription(conductor.node, Float64MultiArray, "/arm/commands", DEEP)
    references = conductor.node.create_publisher(JointTrajectory, "/feedforward/reference", 10)
    conductor.until(references.get_subscription_count, "the feedforward")
    conductor.meet(Trigger, "/identify/start")
    conductor.meet(Trigger, "/identify/stop")
    conductor.until(lambda: conductor.node.count_publishers("/joint_states"), "the arm")
    conductor.trigger("/identify/start")
    rows, late, came, wrong = [], [], 0, 0
    idle = folder / "bare.txt"
    with idle.open("w") as file:
        loop = subprocess.Popen([sys.executable, __file__, "--bare"], stdout=file)
    try:
        began, moves_until, motion = time.monotonic(), 0.0, 0
        list(commands.take())
        for second in range(seconds):
            now = time.monotonic()
            if now > moves_until:
                trajectory = exciting_trajectory(4, 7 + motion % 3, MOTION)
                references.publish(message_of(trajectory, 0))
                moves_until, motion = now + trajectory.duration + 2.0, motion + 1
            conductor.until(partial(passed, began + second + 1.0), "a second")
            taken = [(at, message.data) for message, at in commands.take()]
            late.append(lateness(np.array([at for at, _ in taken], dtype=np.float64)))
            came += len(taken)
            wrong += sum(not np.isfinite(tau).all() for _, tau in taken)
            rows.append([held(process) for process in processes])
            if (second + 1) % 60 == 0:
                print(f"{(second + 1) // 60} min", flush=True)
    finally:
        loop.kill()
        loop.wait()
    conductor.trigger("/identify/stop")
    (bag,) = (folder / "bags").iterdir()
    steps = np.diff(load(bag).time)
    lost = int(np.round(steps / STATE - 1.0).clip(0.0).sum())
    alone = np.loadtxt(idle, ndmin=2)
    return Soak(np.array(rows), np.array(late), alone, came, wrong, len(steps) + 1, lost)


def main() -> int:
    """Soak; return 1 if anything is not as it should be."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--output", type=Path, default=Path("out/soak"))
    parser.add_argument("--bare", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.bare:
        bare()
    options.output.mkdir(parents=True, exist_ok=True)
    with own_graph(None) as (context, domain):
        found = soaked(context, domain, round(60.0 * options.minutes), options.output)
    found.draw(options.output / "soak.png")
    print(found.text())
    print("\n".join(found.failures) or "nothing grew, leaked, was lost or came late")
    return 1 if found.failures else 0


if __name__ == "__main__":
    sys.exit(main())
