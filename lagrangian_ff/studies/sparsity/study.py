"""Error and time against the number of centres, with all samples and with the centres alone."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lagrangian_ff.identification import Settings
from lagrangian_ff.studies.arm.drive import drives
from lagrangian_ff.studies.arm.models import asked
from lagrangian_ff.studies.arm.plan import Plan
from lagrangian_ff.studies.common.case import Line
from lagrangian_ff.studies.common.findings import Finding, finding, told
from lagrangian_ff.studies.common.study import Numbers, Request, Study, failures, failures_told
from lagrangian_ff.studies.sparsity.case import Sparse
from lagrangian_ff.studies.sparsity.figure import sparsity_figure

CENTRES, QUICK_CENTRES = (12, 25, 50, 100, 200, 400), (10, 40)
MODELS, QUICK_MODELS = ("vrbfs+fri", "chain+fri"), ("vrbfs+fri",)
FULL = Plan((3, 5, 8), 60.0, Settings())
QUICK = Plan((5,), 9.0, Settings(samples=40, block_seconds=1.0, evaluations=6))
WITHIN = 1.1
"""Landmarks are enough where their error is within this of that of the most landmarks."""
WAYS = ("landmarks", "samples")


class SparsityStudy(Study):
    """How many centres does a kernel need?

    Args:
        request: `models` are compared.
        folder: where recordings are kept.

    Raises:
        UserError: there is no such model.
    """

    name = "sparsity"
    takes = frozenset({"models", "keep"})

    def __init__(self, request: Request, folder: Path) -> None:
        super().__init__(request, folder)
        self.plan = QUICK if request.quick else FULL
        self.centres = QUICK_CENTRES if request.quick else CENTRES
        self.models = asked(request.models, QUICK_MODELS if request.quick else MODELS)

    def every_case(self) -> Sequence[Sparse]:
        """See `Study.every_case`: trajectory by trajectory, few centres first."""
        return [
            Sparse(drive, model, self.plan.settings, centres, exact)
            for drive in drives(self.plan, self.request, self.folder)
            for centres in self.centres
            for model in self.models
            for exact in (False, True)
        ]

    def numbers(self, lines: Sequence[Line]) -> Numbers:
        """For JSON.

        Returns:
            `cases`, `failed`; `curves`, from model and way (`landmarks`: all training samples,
            `samples`: the centres alone) to `centres`, and geometric means over the trajectories
            of `rmse` in N·m, and of `fitting` and `predicting` in s; and `findings`.
        """
        curves = _curves(lines)
        return {
            "cases": len(lines),
            "failed": failures(lines),
            "curves": curves,
            "findings": _findings(curves),
        }

    def table(self, numbers: Numbers) -> list[str]:
        """See `Study.table`."""
        text = [f"{numbers['cases']} cases; geometric means over the trajectories"]
        curves = numbers["curves"]
        centres = sorted(
            {c for ways in curves.values() for one in ways.values() for c in one["centres"]}
        )
        for what, title in (
            ("rmse", "RMS error on motion held out [N·m]"),
            ("fitting", "processor time to fit, all else given [s]"),
            ("predicting", "processor time for 15,000 states [s]"),
        ):
            text += ["", f"{title}, by the number of centres:", _row("", map(str, centres))]
            for model, ways in curves.items():
                for way, one in ways.items():
                    by_count = dict(zip(one["centres"], one[what], strict=True))
                    cells = [f"{by_count[c]:.3g}" if c in by_count else "-" for c in centres]
                    text.append(_row(f"{model}, {_said(way)}", cells))
        text += told(numbers["findings"])
        text += failures_told(numbers["failed"])
        return text

    def figure(self, numbers: Numbers) -> Figure:
        """See `sparsity_figure`."""
        return sparsity_figure(numbers["curves"])


def _curves(lines: Sequence[Line]) -> dict[str, dict[str, dict[str, Any]]]:
    held: dict[str, dict[str, dict[int, list[Line]]]] = {}
    for line in lines:
        if "failed" not in line:
            ways = held.setdefault(line["model"], {way: {} for way in WAYS})
            ways[WAYS[line["exact"]]].setdefault(line["centres"], []).append(line)
    return {
        model: {
            way: {
                "centres": sorted(by_count),
                **{
                    what: [_mean(by_count[count], what) for count in sorted(by_count)]
                    for what in ("rmse", "fitting", "predicting")
                },
            }
            for way, by_count in ways.items()
        }
        for model, ways in held.items()
    }


def _mean(lines: Sequence[Line], what: str) -> float:
    return float(np.exp(np.mean([np.log(max(line[what], 1e-6)) for line in lines])))


def _findings(curves: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> dict[str, Finding]:
    found = {}
    for model, ways in curves.items():
        sparse, exact = (ways[way] for way in WAYS)
        if not sparse["centres"] or sparse["centres"] != exact["centres"]:
            continue
        best = sparse["rmse"][-1]
        enough = next(
            count
            for count, error in zip(sparse["centres"], sparse["rmse"], strict=True)
            if error <= WITHIN * best
        )
        found[f"{model} enough"] = finding(
            enough < sparse["centres"][-1],
            f"{model}: {enough} landmarks come within {WITHIN:g} of the error of "
            f"{sparse['centres'][-1]}",
            landmarks=enough,
        )
        ratios = np.array(sparse["rmse"]) / exact["rmse"]
        found[f"{model} more data"] = finding(
            bool(np.all(ratios <= 1.0)),
            f"{model}: with all samples the error is {ratios.min():.2f} to {ratios.max():.2f} of "
            "that of an exact fit to the centres alone",
            least=float(ratios.min()),
            most=float(ratios.max()),
        )
    return found


def _said(way: str) -> str:
    return "all samples" if way == "landmarks" else "centres alone"


def _row(name: str, cells: Any) -> str:
    return (f"  {name:<26}" + "".join(f"{cell:>9}" for cell in cells)).rstrip()
