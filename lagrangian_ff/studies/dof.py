"""Fig. 2 of the paper, and what Fig. 3 shares with it: error against the number of joints."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from lagrangian_ff.arrays import Floats
from lagrangian_ff.report.colours import FAINT
from lagrangian_ff.report.style import new_figure, styled
from lagrangian_ff.studies.curves import Look, stroke_of
from lagrangian_ff.studies.learning import Learned, learn, model_of
from lagrangian_ff.studies.robots import Samples, Scene, draw_samples
from lagrangian_ff.studies.study import Finding, Line, Request, Results, Study, cells, done, row

MOST_JOINTS, QUICK_JOINTS = 8, 3
PAPER = ("rbf", "rbfs", "srbf", "srbfs", "vrbf", "vrbfs")
OURS = ("energy_rbf", "energy", "chain_rbf", "chain")
FLOOR = {"mean": 1e-8, "variance": 1e-16}
"""What is smaller is drawn here: exact but for rounding, and no reason to squeeze the rest."""


@dataclass(frozen=True)
class Learning:
    """A case: one model learns one robot, and is validated on states it has not seen.

    Attributes:
        scene: what the robot is like, and the numbers of samples.
        gamma: γ of (42); None chooses it.
        seed: of the study.
        joints: N.
        robot: its number.
        model: its name.
    """

    scene: Scene
    gamma: float | None
    seed: int
    joints: int
    robot: int
    model: str

    @property
    def name(self) -> str:
        """Return a name such as `n6-robot03-vrbfs`."""
        return f"n{self.joints}-robot{self.robot:02d}-{self.model}"

    def run(self) -> Mapping[str, Any]:
        """Learn and validate.

        Returns:
            `error`, the root of the mean squared error over validation samples and joints,
            N^-1/2 ‖y − f‖ of section IV-A, in the robot's `unit` of torque, N·m; `spread`, that of
            the torques themselves; what was chosen; and in a robot with friction, of a model with
            `fri`, `frictionless`: the error of the same kernel with the same numbers and noise
            where there is no friction.
        """
        spec = model_of(self.model)
        samples = draw_samples(self.scene, self.seed, self.joints, self.robot)
        learned = learn(spec, samples.x, samples.tau, samples.fold, self.gamma)
        found = {
            "joints": self.joints,
            "robot": self.robot,
            "model": self.model,
            "error": error_of(learned, samples, samples.truth),
            "spread": float(np.std(samples.truth)),
            "unit": samples.unit,
            **learned.record(),
        }
        if self.scene.friction and spec.effects:
            bare = learned.without_friction(samples.tau - samples.friction)
            found["frictionless"] = error_of(bare, samples, samples.truth - samples.asked_friction)
        return found


def error_of(learned: Learned, samples: Samples, truth: Floats) -> float:
    """Return the rms error over validation samples and joints; the truth (V, N) is in its unit."""
    return float(np.sqrt(np.mean((learned.torque(samples.asked) - truth) ** 2)))


@dataclass(frozen=True)
class RobotError:
    """The error of one model on one robot, in the robot's unit of torque.

    Attributes:
        error: on validation samples.
        gamma_raised: the factor by which γ was raised.
        frictionless: the error without friction; not a number if it was not asked.
    """

    error: float
    gamma_raised: float
    frictionless: float = np.nan


RobotErrors = Mapping[str, Mapping[int, Mapping[int, RobotError]]]
"""By model, number of joints and robot."""


def errors_of(lines: Sequence[Line]) -> RobotErrors:
    """Return the errors of the cases that did not fail, models in the order of the lines."""
    found: dict[str, dict[int, dict[int, RobotError]]] = {}
    for line in done(lines):
        by_robot = found.setdefault(line["model"], {}).setdefault(line["joints"], {})
        error = RobotError(line["error"], line["gamma_raised"], line.get("frictionless", np.nan))
        by_robot[line["robot"]] = error
    return {model: dict(sorted(held.items())) for model, held in found.items()}


@dataclass(frozen=True)
class Statistics:
    """Errors of one model over the robots of one number of joints.

    Attributes:
        mean, variance, median: of the errors; the variance of one robot is None.
        count: number of robots.
        gamma_raised: the largest factor by which γ was raised.
    """

    mean: float
    variance: float | None
    median: float
    count: int
    gamma_raised: float

    @classmethod
    def of(cls, errors: Sequence[RobotError]) -> "Statistics":
        """Return the statistics of some errors."""
        values = [each.error for each in errors]
        return cls(
            float(np.mean(values)),
            float(np.var(values, ddof=1)) if len(values) > 1 else None,
            float(np.median(values)),
            len(values),
            max(each.gamma_raised for each in errors),
        )


@dataclass(frozen=True)
class Compared:
    """A claim at one number of joints.

    Attributes:
        holds: whether it does.
        means: the mean errors behind it, by model.
        robots: the number of robots that they are of.
    """

    holds: bool
    means: Mapping[str, float]
    robots: int


@dataclass(frozen=True)
class Comparison:
    """A claim about models.

    Attributes:
        claim: in words.
        joints: whether it holds, by the number of joints.
    """

    claim: str
    joints: Mapping[int, Compared]

    def finding(self) -> Finding:
        """Return whether the claim holds at every number of joints, and at which."""
        holds = [str(n) for n, each in self.joints.items() if each.holds]
        fails = [str(n) for n, each in self.joints.items() if not each.holds]
        said = f"at {', '.join(holds)} joints" if holds else "nowhere"
        said += f"; not at {', '.join(fails)}" if fails and holds else ""
        rows = {str(n): asdict(each) for n, each in self.joints.items()}
        return Finding(not fails, f"{self.claim}: {said}", {"joints": rows})


def order(errors: RobotErrors, better_first: Sequence[str], least_joints: int = 1) -> Comparison:
    """Compare whether mean errors rise in this order of models, over the robots that all learned.

    It is claimed from `least_joints` joints on.
    """
    found = {}
    for joints in sorted({n for model in better_first for n in errors.get(model, {})}):
        each = [errors.get(model, {}).get(joints, {}) for model in better_first]
        robots = set.intersection(*(set(one) for one in each))
        if joints < least_joints or not robots:
            continue
        means = [float(np.mean([one[robot].error for robot in robots])) for one in each]
        holds = bool(np.all(np.diff(means) > 0.0))
        found[joints] = Compared(holds, dict(zip(better_first, means, strict=True)), len(robots))
    return Comparison(" < ".join(better_first), found)


Rows = Mapping[str, Mapping[int, Statistics]]
"""By model and number of joints."""


@dataclass(frozen=True)
class DofResults(Results):
    """Errors over the number of joints.

    Attributes:
        models: statistics by model and number of joints.
        by_friction: whether the figure has a row of panels for models without and with `fri`.
    """

    models: Rows
    by_friction: bool = False

    @classmethod
    def of(
        cls, lines: Sequence[Line], comparisons: Sequence[Comparison], *, by_friction: bool = False
    ) -> "DofResults":
        """Return the statistics of the lines, and a finding for each comparison."""
        models = {
            model: {joints: Statistics.of(list(by.values())) for joints, by in by_joints.items()}
            for model, by_joints in errors_of(lines).items()
        }
        findings = {each.claim: each.finding() for each in comparisons}
        return cls(lines, findings, models, by_friction)

    def numbers(self) -> dict[str, Any]:
        return {
            "models": {
                model: {str(joints): asdict(each) for joints, each in by_joints.items()}
                for model, by_joints in self.models.items()
            }
        }

    def text(self) -> list[str]:
        joints = sorted({n for by_joints in self.models.values() for n in by_joints})
        text = [f"{len(self.lines)} cases", ""]
        text += ["mean error of torque, of the largest one in training, by the number of joints:"]
        text += [row("", map(str, joints), 16)]
        for model, by_joints in self.models.items():
            means = {n: each.mean for n, each in by_joints.items()}
            text.append(row(model, cells(joints, means, "{:.1e}".format), 16))
        counts = sorted({each.count for by in self.models.values() for each in by.values()})
        if counts:
            robots = str(counts[0]) if len(counts) == 1 else f"{counts[0]} to {counts[-1]}"
            text += ["", f"each the mean over {robots} robot{'' if counts[-1] == 1 else 's'}"]
        return text

    def figure(self) -> Figure:
        """Draw mean and variance side by side, as in Figs. 2 and 3."""
        rows: list[tuple[str, Rows]] = [("", self.models)]
        if self.by_friction:
            knowing = {m: by for m, by in self.models.items() if m.endswith("+fri")}
            without = {m: by for m, by in self.models.items() if m not in knowing}
            rows = [(", without fri", without), (", with fri", knowing)]
            rows = [(title, held) for title, held in rows if held] or [("", {})]
        with styled():
            figure = new_figure(0.9 + 3.5 * len(rows))
            panels = figure.subplots(len(rows), 2, squeeze=False, sharex=True, sharey="col")
            letters = iter("abcdefgh")
            for (title, models), pair in zip(rows, panels, strict=True):
                for axes, what in zip(pair, ("mean", "variance"), strict=True):
                    _panel(axes, models, what)
                    axes.set_title(f"({next(letters)})  {what} of the error{title}")
                # The legend has the order in which the lines end.
                ends = {model: list(by.values())[-1].mean for model, by in models.items()}
                ending = sorted(ends, key=lambda model: -ends[model])
                by_label = dict(zip(*reversed(pair[0].get_legend_handles_labels()), strict=True))
                handles = [by_label[model] for model in ending]
                pair[1].legend(handles, ending, loc="upper left", bbox_to_anchor=(1.01, 1.0))
                pair[0].set_ylabel("rms error / largest torque")
            for axes in panels[-1]:
                axes.set_xlabel("joints")
        return figure


def _panel(axes: Axes, models: Rows, what: str) -> None:
    floored = False
    for model, by_joints in models.items():
        stroke = stroke_of(model)
        known = [getattr(each, what) for each in by_joints.values()]
        values = np.maximum([np.nan if value is None else value for value in known], FLOOR[what])
        floored |= bool(np.any(values == FLOOR[what]))
        width, mark, above = (1.7, "o", 3) if stroke.ours else (1.2, None, 2)
        look: Look = {"linewidth": width, "marker": mark, "markersize": 3.5, "zorder": above}
        axes.plot(list(by_joints), values, **stroke.line, **look, label=model)
    axes.set_yscale("log")
    if floored:
        axes.set_ylim(bottom=0.5 * FLOOR[what])
        corner: Look = {"transform": axes.get_yaxis_transform(), "ha": "right", "va": "bottom"}
        axes.text(1.0, FLOOR[what], "or less", **corner, fontsize=7, color=FAINT)
    axes.yaxis.set_major_locator(LogLocator(numticks=12))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.tick_params(which="minor", length=0)


class RobotStudy(Study):
    """A study of models that learn random robots.

    Raises:
        UserError: there is no such model.
    """

    takes = frozenset({"robots", "models"})
    robots: ClassVar[int]
    quick_robots: ClassVar[int] = 2
    usual: ClassVar[tuple[str, ...]]
    """The models of a request that names none."""
    quick_usual: ClassVar[tuple[str, ...]]

    def __init__(self, request: Request, folder: Path) -> None:
        super().__init__(request, folder)
        for model in request.models:
            model_of(model)
        quick = request.quick
        self.models = request.models or (self.quick_usual if quick else self.usual)
        self.drawn = range(request.robots or (self.quick_robots if quick else self.robots))


class DofStudy(RobotStudy):
    """Models learn random robots of more and more joints."""

    scene: ClassVar[Scene]
    quick_scene: ClassVar[Scene]
    gamma: ClassVar[float | None]

    def every_case(self) -> Sequence[Learning]:
        """Return cases robot by robot, each of every number of joints."""
        quick, seed = self.request.quick, self.request.seed
        scene = self.quick_scene if quick else self.scene
        return [
            Learning(scene, self.gamma, seed, joints, robot, model)
            for robot in self.drawn
            for joints in range(1, (QUICK_JOINTS if quick else MOST_JOINTS) + 1)
            for model in self.models
        ]


IDEAL_CLAIMS = (
    ("vrbfs", "srbfs", "rbfs"),
    ("vrbf", "srbf", "rbf"),
    ("rbfs", "rbf"),
    ("srbfs", "srbf"),
    ("vrbfs", "vrbf"),
    ("chain", "vrbfs"),
)
"""Each model errs less than those after it: the paper claims all but the last."""
LEAST_JOINTS = 2
"""A single joint leaves nothing for one Lagrangian to share."""


class IdealStudy(DofStudy):
    """How well does each kernel learn rigid bodies?"""

    name = "ideal"
    robots = 16
    usual = ("motor", *PAPER, "pol", *OURS)
    quick_usual = ("rbf", "rbfs", "srbfs", "vrbfs", "chain")
    scene = Scene()
    quick_scene = Scene(training=100, validation=500)
    gamma = 1e-12

    def results(self, lines: Sequence[Line]) -> DofResults:
        """Return the statistics, and whether models stand in the order claimed."""
        errors = errors_of(lines)
        found = [order(errors, claim, LEAST_JOINTS) for claim in IDEAL_CLAIMS]
        return DofResults.of(lines, [each for each in found if each.joints])
