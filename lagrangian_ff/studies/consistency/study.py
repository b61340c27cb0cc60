"""Theorem 2, measured: error against the number of samples."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lagrangian_ff.report.colours import FAINT
from lagrangian_ff.studies.common.case import Line
from lagrangian_ff.studies.common.curves import Curve, curves_figure
from lagrangian_ff.studies.common.findings import Finding, finding, told
from lagrangian_ff.studies.common.strokes import DOTTED, stroke_of
from lagrangian_ff.studies.common.study import Numbers, Request, Study, failures, failures_told
from lagrangian_ff.studies.consistency.case import Growing
from lagrangian_ff.studies.regression.learn import asked
from lagrangian_ff.studies.robots.samples import Scene

JOINTS = 2
ROBOTS, QUICK_ROBOTS = 8, 2
COUNTS, QUICK_COUNTS = (25, 50, 100, 200, 400, 800, 1600), (25, 100)
MODELS = ("rbfs+fri", "srbfs+fri", "vrbfs+fri", "chain+fri", "vrbfs", "chain")
QUICK_MODELS = ("rbfs+fri", "chain+fri", "chain")
SCENE = Scene(friction=True, noise=0.05)
NEAR = 1.05
"""Measured errors within this of the noise alone are said to be at the noise floor."""


class ConsistencyStudy(Study):
    """More samples for the same robots: where does the error end?

    Args:
        request: `robots` of two joints each, and the `models` by their names.
        folder: nothing is kept there.

    Raises:
        UserError: there is no such model.
    """

    name = "consistency"
    takes = frozenset({"robots", "models"})

    def __init__(self, request: Request, folder: Path) -> None:
        super().__init__(request, folder)
        self.models = asked(request.models, QUICK_MODELS if request.quick else MODELS)

    def every_case(self) -> Sequence[Growing]:
        """See `Study.every_case`: robot by robot, few samples first."""
        quick, seed = self.request.quick, self.request.seed
        scene = replace(SCENE, validation=500) if quick else SCENE
        return [
            Growing(replace(scene, training=count), seed, JOINTS, robot, model)
            for robot in range(self.request.robots or (QUICK_ROBOTS if quick else ROBOTS))
            for count in (QUICK_COUNTS if quick else COUNTS)
            for model in self.models
        ]

    def numbers(self, lines: Sequence[Line]) -> Numbers:
        """For JSON.

        Returns:
            `cases`, `failed`; `noise`, the standard deviation of the measured torques' noise;
            `models`, from the name to `samples`, the mean `error` and `measured`, the error of
            torques with their noise, of as many `robots`, and the `bound` (50); and `findings`.
        """
        models = _by_model(lines)
        return {
            "cases": len(lines),
            "failed": failures(lines),
            "noise": SCENE.noise,
            "models": models,
            "findings": {name: _found(name, held) for name, held in models.items()},
        }

    def table(self, numbers: Numbers) -> list[str]:
        """See `Study.table`."""
        counts = sorted({count for held in numbers["models"].values() for count in held["samples"]})
        text = [
            f"{numbers['cases']} cases; mean error of torque without its noise, of the largest one "
            f"in training, by the number of samples; noise {numbers['noise']:g}",
            "",
            _row("", [*map(str, counts), "bound (50)"]),
        ]
        for model, held in numbers["models"].items():
            by_count = dict(zip(held["samples"], held["error"], strict=True))
            cells = [f"{by_count[count]:.4f}" if count in by_count else "-" for count in counts]
            text.append(_row(model, [*cells, f"{held['bound']:.2g}"]))
        text += told(numbers["findings"])
        text += failures_told(numbers["failed"])
        return text

    def figure(self, numbers: Numbers) -> Figure:
        """The error without noise, and that of measured torques, which ends at the noise."""
        clean, noisy = "error of torques without noise", "error of measured torques"
        panels: dict[str, dict[str, Curve]] = {clean: {}, noisy: {}}
        for model, held in numbers["models"].items():
            stroke = stroke_of(model)
            for panel, what in zip(panels.values(), ("error", "measured"), strict=True):
                panel[model] = Curve(
                    held["samples"], held[what], stroke.colour, stroke.dashes, stroke.ours
                )
        if numbers["models"]:
            ends = _ends(numbers["models"])
            panels[noisy]["noise"] = Curve(ends, [numbers["noise"]] * 2, FAINT, DOTTED)
            bounds = [held["bound"] for m, held in numbers["models"].items() if "+fri" not in m]
            if bounds:
                panels[clean]["(50), no fri"] = Curve(ends, [max(bounds)] * 2, FAINT, DOTTED)
        return curves_figure(
            panels, "training samples", "error [of the largest torque]", logarithmic=True
        )


def _by_model(lines: Sequence[Line]) -> dict[str, dict[str, Any]]:
    """The means over robots of each model, by rising number of samples."""
    held: dict[str, dict[int, list[Line]]] = {}
    for line in lines:
        if "failed" not in line:
            held.setdefault(line["model"], {}).setdefault(line["samples"], []).append(line)
    return {
        model: {
            "samples": sorted(by_count),
            "error": [_rms(by_count[count], "error") for count in sorted(by_count)],
            "measured": [
                float(np.hypot(_rms(by_count[count], "error"), SCENE.noise))
                for count in sorted(by_count)
            ],
            "robots": [len(by_count[count]) for count in sorted(by_count)],
            "bound": _rms(by_count[max(by_count)], "bound"),
        }
        for model, by_count in held.items()
    }


def _rms(lines: Sequence[Line], what: str) -> float:
    return float(np.sqrt(np.mean([line[what] ** 2 for line in lines])))


def _found(model: str, held: Mapping[str, Any]) -> Finding:
    """Whether the error ends where Theorem 2 says."""
    count, error, bound = held["samples"][-1], held["error"][-1], held["bound"]
    falls = len(held["error"]) > 1 and error < held["error"][0]
    if "+fri" in model:
        floor = held["measured"][-1] / SCENE.noise
        return finding(
            falls and floor < NEAR,
            f"{model}: {held['error'][0]:.3g} with {held['samples'][0]} samples, {error:.3g} with "
            f"{count}; the error of measured torques is then {floor:.3f} of the noise",
            error=error,
            floor=floor,
        )
    return finding(
        error <= bound,
        f"{model}, which has no friction, ends at {error:.3g}: eq. (50) allows {bound:.3g}",
        error=error,
        bound=bound,
    )


def _ends(models: Mapping[str, Mapping[str, Any]]) -> list[int]:
    counts = [count for held in models.values() for count in held["samples"]]
    return [min(counts), max(counts)]


def _row(name: str, cells: Sequence[str]) -> str:
    return (
        f"  {name:<14}" + "".join(f"{cell:>9}" for cell in cells[:-1]) + f"{cells[-1]:>12}"
    ).rstrip()
