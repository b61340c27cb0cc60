"""The results of measured arms: errors beside those of the standard way, verdicts, time, memory."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lagrangian_ff.diagnosis.confidence import Verdict
from lagrangian_ff.report.colours import FAINT, INK, RUNS
from lagrangian_ff.report.style import new_figure, styled
from lagrangian_ff.studies.measured.known import Known
from lagrangian_ff.studies.study import Finding, Line, Results, done, row, shown

STANDARD, KINEMATICS, DIAGNOSIS = "standard", "@kinematics", "diagnosis"
"""The standard way; what stands behind a model that is given the kinematics; the diagnosis."""
AS_GOOD, BETTER = 1.0, 0.9
"""Errors that the default is to have at most, in parts of that of the standard way: without and
with the kinematics that the standard way is given."""
LATE = 0.5
"""s by which a contact may begin and end beside the pulse and still count as that."""
FIRST = 22
TICKS = (0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0)


@dataclass(frozen=True)
class Errors:
    """The errors of one way on the motion to test on.

    Attributes:
        model: what it was in the end.
        joints: names.  rmse: N·m by joint.  nmse: by joint.
        ratio: geometric mean over the joints of the rmse over that of the standard way, so that
            each joint counts alike, whatever its torque; None without one.
        seconds: processor time of identification.  memory: GB at most.
    """

    model: str
    joints: tuple[str, ...]
    rmse: tuple[float, ...]
    nmse: tuple[float, ...]
    ratio: float | None
    seconds: float
    memory: float

    @property
    def mean(self) -> float:
        """Return the mean nmse."""
        return float(np.mean(self.nmse))


@dataclass(frozen=True)
class Judged:
    """The findings of a diagnosis, judged by what is known of the arm.

    Attributes:
        right, wrong: confirmed, or one of several that fit; in words.
        suggested: no more than suggested.  missing: what is known to be there and was not named.
        unexplained: in words.
        seconds: processor time of the diagnosis.  memory: GB at most.
    """

    right: tuple[str, ...]
    wrong: tuple[str, ...]
    suggested: tuple[str, ...]
    missing: tuple[str, ...]
    unexplained: tuple[str, ...]
    seconds: float
    memory: float


@dataclass(frozen=True)
class Use:
    """A use of an arm's recordings: the errors of each way, and the diagnosis if it is done."""

    arm: str
    split: str
    errors: Mapping[str, Errors]
    judged: Judged | None

    @property
    def name(self) -> str:
        """Return the name of arm and use."""
        return f"{self.arm}, {self.split}"


def judge(known: Known, line: Line) -> Judged:
    """Return the judgement of a diagnosis's line."""
    right: list[str] = []
    wrong: list[str] = []
    suggested: list[str] = []
    expected = (*known.may, *known.must)
    met = set()
    record = line["record"]
    for one in (*record["findings"], *map(_as_finding, record.get("contacts", ()))):
        effects, joints = [one["effect"], *one["ambiguous_with"]], one["joints"]
        fits = [each for each in expected if each.fits(effects, joints)]
        if one["effect"] == "contact" and line["contacts"]:
            fits = fits if _touches(one, line["contacts"]) else []
        words = f"{' or '.join(effects)} on {', '.join(joints)}"
        if one["verdict"] == Verdict.SUGGESTED.value:
            suggested.append(words)
            continue
        met.update(fits)
        (right if fits else wrong).append(words)
    missing = [f"{' or '.join(e.effects)}" for e in known.must if e not in met]
    rest = [f"{u['joint']} over {u['coordinate']}" for u in record["unexplained"]]
    return Judged(
        tuple(right),
        tuple(wrong),
        tuple(suggested),
        tuple(missing),
        tuple(rest),
        line["cpu"]["diagnose"],
        line["memory"],
    )


def _as_finding(contact: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a touch of the arm as a finding is recorded."""
    begin, end = contact["begin"], contact["end"]
    return {
        "effect": "contact",
        "joints": list(contact["sizes"]),
        "ambiguous_with": [],
        "verdict": (Verdict.CONFIRMED if contact["sure"] else Verdict.SUGGESTED).value,
        "parameters": {},
        "shape": {"t0": begin, "length": end - begin},
    }


def _touches(finding: Mapping[str, Any], pulses: Sequence[Sequence[float]]) -> bool:
    """Return whether a contact that was found is one of the pulses."""
    values = {name: one["value"] for name, one in finding["parameters"].items()}
    held = {**values, **finding["shape"]}
    begin, end = held["t0"], held["t0"] + held.get("length", float("inf"))
    return any(abs(begin - first) < LATE and abs(end - last) < LATE for first, last in pulses)


@dataclass(frozen=True)
class MeasuredResults(Results):
    """Errors and verdicts by arm and use."""

    uses: Sequence[Use]

    @classmethod
    def of(cls, lines: Sequence[Line], arms: Sequence[Known]) -> "MeasuredResults":
        """Return the results of lines; those that failed count nowhere."""
        known = {arm.name: arm for arm in arms}
        places: dict[tuple[str, str], list[Line]] = {}
        for line in done(lines):
            places.setdefault((line["arm"], line["split"]), []).append(line)
        uses = [_use(known[arm], split, some) for (arm, split), some in places.items()]
        return cls(lines, _findings(uses), uses)

    def numbers(self) -> dict[str, Any]:
        return {
            "uses": {
                use.name: {
                    "errors": {way: asdict(each) for way, each in use.errors.items()},
                    "diagnosis": asdict(use.judged) if use.judged else None,
                }
                for use in self.uses
            }
        }

    def text(self) -> list[str]:
        text = [f"{len(self.lines)} cases; nmse on the motion to test on"]
        for use in self.uses:
            text += ["", *_table(use), *_verdicts(use.judged)]
        return text

    def figure(self) -> Figure:
        """Draw the errors of every way in parts of that of the standard way."""
        ways = list(dict.fromkeys(way for use in self.uses for way in use.errors))
        ways = [way for way in ways if way != STANDARD]
        with styled():
            drawn = new_figure(1.6 + 0.3 * max(len(self.uses), 3))
            axes = drawn.subplots()
            for place, way in enumerate(ways):
                held = [
                    (k, use.errors[way].ratio)
                    for k, use in enumerate(self.uses)
                    if way in use.errors
                ]
                points = [(ratio, k) for k, ratio in held if ratio is not None]
                colour = RUNS[place % len(RUNS)]
                axes.plot(
                    *zip(*points, strict=True), "o", color=colour, label=way
                ) if points else None
            for limit in (AS_GOOD, BETTER):
                axes.axvline(limit, color=INK if limit == AS_GOOD else FAINT, linewidth=0.8)
            axes.set_xscale("log")
            low, high = axes.get_xlim()
            ticks = [tick for tick in TICKS if low <= tick <= high]
            axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
            axes.minorticks_off()
            axes.set_yticks(range(len(self.uses)), [use.name for use in self.uses])
            axes.set_ylim(max(len(self.uses), 1) - 0.5, -0.5)
            axes.set_xlabel("error over that of the standard way")
            if ways:
                drawn.legend(loc="outside lower center", ncol=len(ways))
        return drawn


def _use(known: Known, split: str, lines: Sequence[Line]) -> Use:
    made = {line["way"]: line for line in lines if line["way"] != DIAGNOSIS}
    base = made[STANDARD]["rmse"] if STANDARD in made else None
    judged = next((judge(known, line) for line in lines if line["way"] == DIAGNOSIS), None)
    return Use(known.name, split, {way: _errors(one, base) for way, one in made.items()}, judged)


def _errors(line: Line, base: Sequence[float] | None) -> Errors:
    ratio = float(np.exp(np.mean(np.log(np.divide(line["rmse"], base))))) if base else None
    joints, rmse, nmse = (tuple(line[name]) for name in ("joints", "rmse", "nmse"))
    return Errors(line["model"], joints, rmse, nmse, ratio, line["cpu"]["identify"], line["memory"])


def _findings(uses: Sequence[Use]) -> dict[str, Finding]:
    judged = [(use.name, use.judged) for use in uses if use.judged]
    wrong = {name: each.wrong for name, each in judged if each.wrong}
    missing = {name: each.missing for name, each in judged if each.missing}
    return shown(
        {
            "without kinematics": _claim(uses, "", AS_GOOD),
            "with kinematics": _claim(uses, KINEMATICS, BETTER),
            "no wrong name": Finding(
                not wrong,
                f"{len(wrong)} of {len(judged)} diagnoses confirm what is not known to be there",
                {"wrong": wrong},
            )
            if judged
            else None,
            "what is there": Finding(
                not missing,
                f"{len(missing)} of {len(judged)} diagnoses miss what is known to be there",
                {"missing": missing},
            )
            if judged
            else None,
        }
    )


def _claim(uses: Sequence[Use], behind: str, limit: float) -> Finding | None:
    """Return whether the first model comes within a limit of the standard way everywhere."""
    ratios = {}
    for use in uses:
        models = [way for way in use.errors if way != STANDARD and KINEMATICS not in way]
        way = f"{models[0]}{behind}" if models else ""
        ratio = use.errors[way].ratio if way in use.errors else None
        if ratio is not None:
            ratios[use.name] = ratio
    if not ratios:
        return None
    worse = {name: ratio for name, ratio in ratios.items() if ratio > limit}
    given = "with the kinematics" if behind else "without kinematics"
    most = max(ratios.values())
    says = (
        f"{given} the error is at most {limit:g} of that of the standard way in "
        f"{len(ratios) - len(worse)} of {len(ratios)} uses (largest: {most:.2f})"
    )
    return Finding(not worse, says, {"ratios": ratios})


def _table(use: Use) -> list[str]:
    """Return the errors of each way as lines."""
    if not use.errors:
        return [f"{use.name}:"]
    joints = next(iter(use.errors.values())).joints
    head = ("mean", "× stand.", *(_short(joint) for joint in joints), "s", "GB")
    lines = [f"{use.name}:", row("", head, FIRST)]
    for way, one in use.errors.items():
        ratio = "-" if one.ratio is None else f"{one.ratio:.2f}"
        each = (f"{value:.4f}" for value in one.nmse)
        cells = (f"{one.mean:.4f}", ratio, *each, f"{one.seconds:.1f}", f"{one.memory:.2f}")
        lines.append(row(way, cells, FIRST))
    rmse = use.errors.get(STANDARD) or next(iter(use.errors.values()))
    name = "standard" if STANDARD in use.errors else next(iter(use.errors))
    cells = ("", "", *(f"{value:.3g}" for value in rmse.rmse))
    lines.append(row(f"{name}, rmse N·m", cells, FIRST))
    return lines


def _short(joint: str) -> str:
    """Return a joint's name in eight characters: the end of it, where it differs from others."""
    return joint.removesuffix("_joint")[-8:]


def _verdicts(judged: Judged | None) -> list[str]:
    """Return what the diagnosis said, and whether that is right."""
    if judged is None:
        return []
    said = (
        ("right", judged.right),
        ("WRONG", judged.wrong),
        ("missed", judged.missing),
        ("suggested", judged.suggested),
        ("unexplained", judged.unexplained),
    )
    lines = [f"    {name}: {'; '.join(some)}" for name, some in said if some]
    cost = f"{judged.seconds:.1f} s, {judged.memory:.2f} GB"
    return [f"  diagnosis ({cost}):", *(lines or ["    nothing is confirmed or suggested"])]
