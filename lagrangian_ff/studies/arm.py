"""Studies on the simulated arm: the models, the trajectories, their recordings and their errors."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from lagrangian_ff.arm import PAPER_LOADS, Trajectory, exciting_trajectory, simulate
from lagrangian_ff.arm.exciting import SPEEDS
from lagrangian_ff.arm.simulation import Feedforward
from lagrangian_ff.arrays import Floats
from lagrangian_ff.identification import Identification, Settings
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.recording import Conditioning, condition, load, write_npz
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.studies.study import Line, Request, Study, cells, done, row

OURS, REFERENCE = "auto+fri", "vrbfs+fri"
"""Our default, and the paper's best."""
FRICTION = "+fri"

LOADS = PAPER_LOADS
"""Steel balls of 2.5 kg on link 1, behind the column, and of 1 kg on link 2, beside the elbow.

Their centres are `lagrangian_ff.arm.description.LOAD_POINTS` in the frames of the links."""
HELD = 2 * len(SPEEDS)
"""Trajectories and recordings that a process keeps: all of one study, 4 MB each."""
VELOCITY = "mean norm of velocity [rad/s]"
NAME, CELL = 22, 8  # characters in the table of errors


@dataclass(frozen=True)
class Plan:
    """The trajectories of a study, and how models are identified from them.

    Attributes:
        speeds: of the exciting trajectories, rising.
        seconds: length of each; None is 30 to 40 s.
        settings: of every identification but for the model.
    """

    speeds: tuple[int, ...]
    seconds: float | None
    settings: Settings


# Of section IV-B of the paper. The first third of 30 to 40 s holds three or four blocks of 3 s,
# fewer than the paper's five folds: each block is a fold.
FULL = Plan(
    tuple(SPEEDS),
    None,
    Settings(train=1 / 3, samples=500, block_seconds=3.0, folds=5, selection="validation"),
)
SMALL = replace(FULL.settings, samples=60, block_seconds=1.0, folds=3, evaluations=6)
QUICK = Plan((2, 5, 9), 9.0, SMALL)


@dataclass(frozen=True)
class Drive:
    """One trajectory and the arm that makes it, recorded once for all models.

    Loaded or not, the arm makes the same motion with the same noise in its sensors.

    Attributes:
        speed: of the exciting trajectory.
        seed: of the motion and of the noise.
        seconds: its length; None is 30 to 40 s.
        loaded: whether the arm carries `LOADS`.
        kept: the folder where the recording with the servo alone is kept; None keeps none.
    """

    speed: int
    seed: int
    seconds: float | None
    loaded: bool = False
    kept: Path | None = None

    @property
    def name(self) -> str:
        """Return a name such as `speed04` or `loaded04`."""
        return f"{'loaded' if self.loaded else 'speed'}{self.speed:02d}"

    @property
    def trajectory(self) -> Trajectory:
        """Return the reference."""
        return _trajectory(self.speed, self.seed, self.seconds)

    @property
    def recording(self) -> Recording:
        """Return the recording with the servo alone."""
        return _recording(self)

    def motion(self) -> Motion:
        """Return the recording, low-passed as in the paper."""
        return condition(self.recording, Conditioning(bandwidth=25.0))

    def run(self, feedforward: Feedforward = None) -> Recording:
        """Drive the arm along the trajectory, with the feedforward of `simulate`."""
        loads = LOADS if self.loaded else None
        noise = self.seed * (SPEEDS[-1] + 1) + self.speed
        return simulate(self.trajectory, feedforward, loads=loads, seed=noise).recording

    def tracking_error(self, run: Recording) -> Floats:
        """Return reference minus measured position, (M, 6) rad."""
        start = self.trajectory.time[0] - run.time[0]
        return np.asarray(self.trajectory.sample(run.time + start)[0] - run.position)


_trajectory = lru_cache(maxsize=HELD)(exciting_trajectory)


@lru_cache(maxsize=HELD)
def _recording(drive: Drive) -> Recording:
    if drive.kept is None:
        return drive.run()
    path = drive.kept / f"{drive.name}.npz"
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_npz(path, drive.run(), overwrite=True)
    return load(path)


class ArmStudy(Study):
    """A study of models on the simulated arm.

    The folder keeps recordings on request.

    Raises:
        ModelError: there is no such model.
    """

    takes = frozenset({"models", "keep"})
    usual: ClassVar[tuple[str, ...]]
    """The models of a request that names none."""
    quick_usual: ClassVar[tuple[str, ...]]
    plan: Plan = FULL
    quick_plan: Plan = QUICK

    def __init__(self, request: Request, folder: Path) -> None:
        super().__init__(request, folder)
        if request.quick:
            self.plan = self.quick_plan
        self.models = self.asked(request.models)

    def asked(self, models: Sequence[str]) -> tuple[str, ...]:
        """Return the models that are asked for, each once, or the usual ones."""
        for model in models:
            parse(model)
        usual = self.quick_usual if self.request.quick else self.usual
        return tuple(dict.fromkeys(models or usual))

    def drives(self, *, loaded: bool = False) -> list[Drive]:
        """Return drives along all trajectories, rising in speed."""
        kept = self.folder / "recordings" if self.request.keep else None
        plan, seed = self.plan, self.request.seed
        return [Drive(speed, seed, plan.seconds, loaded, kept) for speed in plan.speeds]


@dataclass(frozen=True)
class ArmCase:
    """A case: a model of the arm along one trajectory.

    Attributes:
        drive: the arm and its trajectory.
        model: kernel and effects.
        settings: of the identification but for the model.
    """

    drive: Drive
    model: str
    settings: Settings

    @property
    def name(self) -> str:
        """Return a name such as `speed04-vrbfs+fri`."""
        return f"{self.drive.name}-{self.model}"


def mean_speed(motion: Motion) -> float:
    """Return the mean over time of the norm of all joints' velocities, in rad/s."""
    return float(np.linalg.norm(motion.qd, axis=1).mean())


def chosen_of(found: Identification) -> dict[str, object]:
    """Return what the data chose: the kernel, the scale of torques, and every hyperparameter."""
    return {key: found.record[key] for key in ("model", "scale", "hyperparameters")}


def rms(values: Any) -> Any:
    """Return the root mean square over the first axis."""
    return np.sqrt(np.mean(np.square(values), axis=0))


@dataclass(frozen=True)
class Errors:
    """Errors of models on trajectories of rising speed; some may not be done yet.

    Attributes:
        of: for each model, or what else is compared, its error by speed.
        velocity: rad/s, the mean norm of velocity by speed.
    """

    of: Mapping[str, Mapping[int, float]]
    velocity: Mapping[int, float]

    @classmethod
    def collected(cls, lines: Iterable[Line], key: str = "model") -> "Errors":
        """Collect the errors of the cases that did not fail; `key` is the field with the model."""
        of: dict[str, dict[int, float]] = {}
        velocity: dict[int, float] = {}
        for line in sorted(done(lines), key=lambda line: int(line["speed"])):
            of.setdefault(line[key], {})[line["speed"]] = line["rmse"]
            velocity[line["speed"]] = line["velocity"]
        return cls(of, velocity)

    def common(self, *names: str) -> list[int]:
        """Return the rising speeds at which all of these are done; empty if a name is missing."""
        of_each = [set(self.of.get(name, ())) for name in names]
        return sorted(set.intersection(*of_each)) if of_each else []

    def mean(self, name: str, speeds: Sequence[int]) -> float:
        """Return the geometric mean: every trajectory counts alike, whatever its torques."""
        return float(np.exp(np.mean(np.log([self.of[name][speed] for speed in speeds]))))

    def ratio(self, name: str, other: str, speeds: Sequence[int]) -> float:
        """Return the error over the other's error, in the geometric mean."""
        return self.mean(name, speeds) / self.mean(other, speeds)

    def below(self, name: str, other: str, speeds: Sequence[int]) -> int:
        """Return the number of trajectories on which its error is the smaller one."""
        return sum(self.of[name][speed] < self.of[other][speed] for speed in speeds)

    def curve(self, name: str) -> tuple[list[float], list[float]]:
        """Return mean velocities, in rad/s, and the errors there."""
        by_speed = self.of[name]
        return [self.velocity[speed] for speed in by_speed], list(by_speed.values())

    def record(self) -> dict[str, Any]:
        """Return `speed`, `velocity` and `rmse` as lists for each model, as JSON holds them."""
        found = {}
        for name, by_speed in self.of.items():
            velocity, rmse = self.curve(name)
            found[name] = {"speed": list(by_speed), "velocity": velocity, "rmse": rmse}
        return found


def ends(speeds: Sequence[int]) -> tuple[Sequence[int], Sequence[int]]:
    """Return the slowest and the fastest third of trajectories, at least one each."""
    third = max(1, len(speeds) // 3)
    return speeds[:third], speeds[-third:]


def errors_table(errors: Errors, beside: Errors | None = None, unit: float = 1.0) -> list[str]:
    """Return a row for each model, with a column for each trajectory and the geometric mean.

    `beside` are those on the arm without masses; `unit` is that of the errors that are written.
    """
    unloaded = beside or Errors({}, {})
    velocity = {**errors.velocity, **unloaded.velocity}
    speeds = sorted(velocity)
    if not speeds:
        return []
    text = [
        "",
        row("speed", [*map(str, speeds), "mean"], NAME, CELL),
        row("velocity [rad/s]", [f"{velocity[speed]:.2f}" for speed in speeds], NAME, CELL),
    ]
    rows = {**errors.of, **{f"{name}, unloaded": of for name, of in unloaded.of.items()}}
    for name, by_speed in rows.items():
        scaled = {speed: error / unit for speed, error in by_speed.items()}
        # Over other trajectories a mean would be of something else.
        whole = len(scaled) == len(speeds)
        mean = _figure(float(np.exp(np.mean(np.log(list(scaled.values())))))) if whole else "-"
        text.append(row(name, [*cells(speeds, scaled, _figure), mean], NAME, CELL))
    return text


def _figure(value: float) -> str:
    return f"{value:.3g}" if value < 100.0 else f"{value:.0f}"
