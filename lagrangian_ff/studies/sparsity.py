"""Section V of the paper: error and time with fewer centres than samples."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.identification.blueprint import Blueprint, solve
from lagrangian_ff.kernels import States
from lagrangian_ff.report.colours import FAINT
from lagrangian_ff.report.style import new_figure, styled
from lagrangian_ff.studies.arm import ArmCase, ArmStudy, Plan, rms
from lagrangian_ff.studies.curves import DASHED, SOLID, Look, stroke_of, x_ticks, y_ticks
from lagrangian_ff.studies.study import Finding, Line, Results, cells, done, grouped, row

ASKED = 15_000
"""States whose prediction is timed, as many as validate Figs. 2 and 3."""
CENTRES, QUICK_CENTRES = (12, 25, 50, 100, 200, 400), (10, 40)
FULL = Plan((3, 5, 8), 60.0, Settings())
QUICK = Plan((5,), 9.0, Settings(samples=40, block_seconds=1.0, evaluations=6))
WITHIN = 1.1
"""Landmarks are enough where their error is within this of that of the most landmarks."""
WAYS = ("landmarks", "samples")
"""A model learns from all training samples, or from the centres alone."""
LEAST_SECONDS = 1e-6
"""Times below what the clock resolves count as this."""
COLUMNS = (
    ("rmse", "RMS error on motion held out [N·m]"),
    ("fitting", "processor time to fit, all else given [s]"),
    ("predicting", "processor time for 15,000 states [s]"),
)
PANELS = (("rmse", "error on motion held out [N·m]"), ("fitting", "processor time to fit [s]"))
DASHES = {"landmarks": SOLID, "samples": DASHED}


@dataclass(frozen=True)
class Sparse(ArmCase):
    """A case: one model of one recording on a number of centres.

    Attributes:
        centres: the number of states that the kernel is built on.
        exact: whether the model learns from these alone; else from every training sample.
    """

    centres: int
    exact: bool

    @property
    def name(self) -> str:
        """Return `speed05-vrbfs+fri-landmarks0100`, or `…-samples0100` if the fit is exact."""
        return f"{super().name}-{WAYS[self.exact]}{self.centres:04d}"

    def run(self) -> Mapping[str, Any]:
        """Identify, judge and time.

        Returns:
            `rmse`, the error on motion held out in N·m (all joints), `relative`, over the torque's
            own rms; `learned_from`, the number of samples; processor seconds `fitting` the
            coefficients once everything is chosen, and `predicting` 15,000 states.
        """
        motion = self.drive.motion()
        settings = replace(self.settings, model=self.model, landmarks=self.centres)
        if self.exact:
            settings = replace(settings, samples=self.centres, landmarks=0)
        found = identify(motion, settings)
        blueprint = Blueprint.of(found.model)
        data = blueprint.data
        inputs = Inputs.of(States.of(data.q, data.qd, data.qdd), data.time, data.segment)
        asked = States.of(motion.q[:ASKED], motion.qd[:ASKED], motion.qdd[:ASKED])
        times = ASKED / len(asked)
        error = rms(found.held_out.tau - found.predicted)
        return {
            "speed": self.drive.speed,
            "model": self.model,
            "centres": self.centres,
            "exact": self.exact,
            "learned_from": len(found.training),
            "rmse": float(rms(error)),
            "relative": float(rms(error) / rms(rms(found.held_out.tau))),
            "fitting": _processor_seconds(lambda: solve(blueprint, inputs)),
            "predicting": times
            * _processor_seconds(lambda: found.model.predict(asked.q, asked.qd, asked.qdd)),
        }


def _processor_seconds(work: Callable[[], object]) -> float:
    """Return the time of the faster of two calls, so that compiling does not count."""
    spent = []
    for _ in range(2):
        began = time.process_time()
        work()
        spent.append(time.process_time() - began)
    return min(spent)


@dataclass(frozen=True)
class SparsityCurve:
    """Geometric means over the trajectories, by rising number of centres.

    Attributes:
        centres: their numbers.
        rmse: N·m, on motion held out.
        fitting, predicting: s, processor time.
    """

    centres: list[int]
    rmse: list[float]
    fitting: list[float]
    predicting: list[float]

    @classmethod
    def of(cls, lines: Sequence[Line]) -> "SparsityCurve":
        """Return the means of the lines of one model and way."""
        groups = dict(sorted(grouped(lines, "centres").items()))
        means = ([_mean(group, what) for group in groups.values()] for what, _ in COLUMNS)
        return cls(list(groups), *means)


def _mean(lines: Sequence[Line], what: str) -> float:
    return float(np.exp(np.mean([np.log(max(line[what], LEAST_SECONDS)) for line in lines])))


Curves = Mapping[str, Mapping[str, SparsityCurve]]
"""By model and way."""


@dataclass(frozen=True)
class SparsityResults(Results):
    """Error and time over the number of centres, by model and way."""

    curves: Curves

    def numbers(self) -> dict[str, Any]:
        return {
            "curves": {
                model: {way: asdict(curve) for way, curve in ways.items()}
                for model, ways in self.curves.items()
            }
        }

    def text(self) -> list[str]:
        text = [f"{len(self.lines)} cases; geometric means over the trajectories"]
        every = [curve for ways in self.curves.values() for curve in ways.values()]
        centres = sorted({count for curve in every for count in curve.centres})
        for what, title in COLUMNS:
            text += ["", f"{title}, by the number of centres:", row("", map(str, centres), 26)]
            for model, ways in self.curves.items():
                for way, curve in ways.items():
                    values = dict(zip(curve.centres, getattr(curve, what), strict=True))
                    name = f"{model}, {'all samples' if way == WAYS[0] else 'centres alone'}"
                    text.append(row(name, cells(centres, values, "{:.3g}".format), 26))
        return text

    def figure(self) -> Figure:
        """Draw the error and the time to fit side by side."""
        with styled():
            figure = new_figure(3.9)
            if not self.curves:
                figure.text(0.5, 0.5, "no case is done", ha="center", color=FAINT)
                return figure
            for axes, (what, title) in zip(figure.subplots(1, 2), PANELS, strict=True):
                _panel(axes, self.curves, what)
                axes.set_title(title)
            handles, labels = axes.get_legend_handles_labels()
            figure.legend(handles, labels, loc="outside lower center", ncol=len(labels))
        return figure


def _panel(axes: Axes, curves: Curves, what: str) -> None:
    counts: set[int] = set()
    for model, ways in curves.items():
        for way, curve in ways.items():
            label = f"{model}, {'all samples' if way == WAYS[0] else 'the centres alone'}"
            look: Look = {"linestyle": DASHES[way], "marker": "o", "markersize": 3.5}
            colour = stroke_of(model).colour
            axes.plot(curve.centres, getattr(curve, what), color=colour, label=label, **look)
            counts.update(curve.centres)
    axes.set_xscale("log")
    axes.set_yscale("log")
    x_ticks(axes, sorted(counts))
    y_ticks(axes)
    axes.set_xlabel("centres")


class SparsityStudy(ArmStudy):
    """How many centres does a kernel need?"""

    name = "sparsity"
    usual, quick_usual = ("vrbfs+fri", "chain+fri"), ("vrbfs+fri",)
    plan, quick_plan = FULL, QUICK

    def every_case(self) -> Sequence[Sparse]:
        """Return cases trajectory by trajectory, few centres first."""
        return [
            Sparse(drive, model, self.plan.settings, centres, exact)
            for drive in self.drives()
            for centres in (QUICK_CENTRES if self.request.quick else CENTRES)
            for model in self.models
            for exact in (False, True)
        ]

    def results(self, lines: Sequence[Line]) -> SparsityResults:
        curves = {
            model: {
                way: SparsityCurve.of([line for line in some if WAYS[line["exact"]] == way])
                for way in WAYS
            }
            for model, some in grouped(done(lines), "model").items()
        }
        return SparsityResults(lines, _findings(curves), curves)


def _findings(curves: Curves) -> dict[str, Finding]:
    found = {}
    for model, ways in curves.items():
        sparse, exact = (ways[way] for way in WAYS)
        if not sparse.centres or sparse.centres != exact.centres:
            continue
        most, best = sparse.centres[-1], sparse.rmse[-1]
        enough = next(
            count
            for count, error in zip(sparse.centres, sparse.rmse, strict=True)
            if error <= WITHIN * best
        )
        found[f"{model} enough"] = Finding(
            enough < most,
            f"{model}: {enough} landmarks come within {WITHIN:g} of the error of {most}",
            {"landmarks": enough},
        )
        ratios = np.array(sparse.rmse) / exact.rmse
        found[f"{model} more data"] = Finding(
            bool(np.all(ratios <= 1.0)),
            f"{model}: with all samples the error is {ratios.min():.2f} to {ratios.max():.2f} of "
            "that of an exact fit to the centres alone",
            {"least": float(ratios.min()), "most": float(ratios.max())},
        )
    return found
