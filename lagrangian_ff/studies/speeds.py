"""Figs. 5 and 7 of the paper: torque errors over speed, of the arm as it is and with masses."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from matplotlib.figure import Figure

from lagrangian_ff.identification import identify
from lagrangian_ff.studies import arm
from lagrangian_ff.studies.arm import FRICTION, OURS, REFERENCE, VELOCITY, Errors
from lagrangian_ff.studies.curves import Curve, curves_figure, stroke_of
from lagrangian_ff.studies.study import Finding, Line, Results, shown
from lagrangian_ff.words import listed

TRADITIONAL = "motor+fri"
OUR_MODELS = (OURS, "chain+fri", "energy+fri")
LAGRANGIAN = (REFERENCE, "vrbf+fri", "srbfs+fri", "srbf+fri")
"""The paper's own models: kernels on the Lagrangian with friction beside them."""
ALONE = ("vrbfs", "vrbf", "srbfs", "srbf", "rbfs", "rbf", "pol")
PAPER = (TRADITIONAL, *LAGRANGIAN, "pol+fri", "rbfs+fri", "rbf+fri", *ALONE)
"""The models of section IV-B of the paper."""
MODELS = tuple(dict.fromkeys((TRADITIONAL, REFERENCE, OURS, *PAPER, *OUR_MODELS)))
"""The models that are compared, the most telling first."""


@dataclass(frozen=True)
class Prediction(arm.ArmCase):
    """A case: a model learns from the first third of a recording and is judged on the rest."""

    def run(self) -> Mapping[str, Any]:
        """Identify and judge.

        Returns:
            `speed`, `loaded`, `model`; `velocity`, the mean norm of velocity in rad/s; `rmse`, the
            error on the last two thirds in N·m (all joints), `relative`, over the torque's own rms
            there, both also in `joints`; and `chosen`.
        """
        motion = self.drive.motion()
        found = identify(motion, replace(self.settings, model=self.model))
        measured = found.held_out.tau
        error = arm.rms(measured - found.predicted)
        torque = arm.rms(measured)
        return {
            "speed": self.drive.speed,
            "loaded": self.drive.loaded,
            "model": self.model,
            "velocity": arm.mean_speed(motion),
            "rmse": float(arm.rms(error)),
            "relative": float(arm.rms(error) / arm.rms(torque)),
            "joints": {
                joint: {"rmse": float(e), "relative": float(e / t)}
                for joint, e, t in zip(motion.joints, error, torque, strict=True)
            },
            "chosen": arm.chosen_of(found),
        }


@dataclass(frozen=True)
class PredictionResults(Results):
    """Torque errors over speed.

    Attributes:
        errors: in N·m, by model.
        unloaded: of models on the arm without masses, to compare with; None has none.
    """

    errors: Errors
    unloaded: Errors | None = None

    def numbers(self) -> dict[str, Any]:
        beside = {} if self.unloaded is None else {"unloaded": self.unloaded.record()}
        return {"curves": self.errors.record(), **beside}

    def text(self) -> list[str]:
        return [
            f"{len(self.lines)} cases; RMS error of torque [N·m] on the last two thirds",
            *arm.errors_table(self.errors, self.unloaded),
        ]

    def figure(self) -> Figure:
        """Draw kernels alone and kernels with friction side by side."""
        alone, beside = "kernel alone", "friction beside the kernel"
        panels: dict[str, dict[str, Curve]] = {alone: {}, beside: {}}
        for name, curve in self._curves():
            panels[beside if FRICTION in name else alone][name] = curve
        return curves_figure(panels, VELOCITY, "RMS error of torque [N·m]")

    def _curves(self) -> Iterator[tuple[str, Curve]]:
        """Yield the curves with their names, those without masses first and dotted."""
        if self.unloaded is not None:
            for model in self.unloaded.of:
                stroke = replace(stroke_of(model), dashes=":")
                yield f"{model}, unloaded", Curve(*self.unloaded.curve(model), stroke)
        for model in self.errors.of:
            yield model, Curve(*self.errors.curve(model), stroke_of(model), model == OURS)


class PredictionStudy(arm.ArmStudy):
    """Torque error on the last two thirds of trajectories of rising speed."""

    usual, quick_usual = MODELS, MODELS[:3]
    loaded: ClassVar[bool]
    """True if the arm carries masses."""

    def every_case(self) -> Sequence[Prediction]:
        """Return cases model by model, so that a study stopped early has whole curves."""
        return self.predictions(self.models, loaded=self.loaded)

    def predictions(self, models: Sequence[str], *, loaded: bool) -> list[Prediction]:
        """Return the cases of these models along all trajectories."""
        along = self.drives(loaded=loaded)
        return [Prediction(drive, model, self.plan.settings) for model in models for drive in along]

    def errors(self, lines: Sequence[Line], *, loaded: bool) -> Errors:
        """Return the errors of the models on the arm with or without masses."""
        here = (line for line in lines if line.get("loaded") is loaded)
        return Errors.collected(here)


class SpeedsStudy(PredictionStudy):
    """The arm as it is."""

    name = "speeds"
    loaded = False

    def results(self, lines: Sequence[Line]) -> PredictionResults:
        errors = self.errors(lines, loaded=False)
        return PredictionResults(lines, prediction_findings(errors), errors)


def prediction_findings(errors: Errors) -> dict[str, Finding]:
    """Return what the cases that are done show of Figs. 5 and 7, of our models too."""
    return shown(
        {
            "motor_deteriorates": _motor_deteriorates(errors),
            "lagrangian_best": _lagrangian_best(errors),
            **{f"{model}_better": _better(errors, model) for model in OUR_MODELS},
            "friction_needed": _friction_needed(errors),
        }
    )


def _motor_deteriorates(errors: Errors) -> Finding | None:
    speeds = errors.common(TRADITIONAL, REFERENCE)
    if len(speeds) < 2:
        return None
    slow, fast = arm.ends(speeds)
    simple, reference = (
        errors.mean(model, fast) / errors.mean(model, slow) for model in (TRADITIONAL, REFERENCE)
    )
    return Finding(
        simple > max(1.0, reference),
        f"{TRADITIONAL} deteriorates with speed, and faster than {REFERENCE}: its error on the "
        f"fastest third of trajectories is {simple:.2f} times that on the slowest, that of "
        f"{REFERENCE} {reference:.2f} times",
        {"rise": {TRADITIONAL: simple, REFERENCE: reference}},
    )


def _lagrangian_best(errors: Errors) -> Finding | None:
    """Compare the paper's models, on the trajectories on which all of them are done."""
    there = [model for model in PAPER if model in errors.of]
    others = [model for model in there if model not in LAGRANGIAN]
    speeds = errors.common(*there)
    if len(others) in (0, len(there)) or not speeds:
        return None
    means = {model: errors.mean(model, speeds) for model in there}
    ours = min((model for model in there if model in LAGRANGIAN), key=means.__getitem__)
    next_ = min(others, key=means.__getitem__)
    first = sum(
        min(there, key=lambda model: errors.of[model][speed]) in LAGRANGIAN for speed in speeds
    )
    return Finding(
        means[ours] < means[next_],
        f"the Lagrangian kernels with friction are the best of the paper's models: {ours} has "
        f"{means[ours] / means[next_]:.2f} of the error of {next_}, the best of the others; on "
        f"{first} of {len(speeds)} trajectories one of them is first",
        {"mean": means, "first": first, "trajectories": len(speeds)},
    )


def _better(errors: Errors, model: str) -> Finding | None:
    speeds = errors.common(model, REFERENCE)
    if not speeds:
        return None
    ratio, below = (errors.ratio(model, REFERENCE, speeds), errors.below(model, REFERENCE, speeds))
    return Finding(
        ratio < 1.0,
        f"{model} is below {REFERENCE}: {ratio:.2f} of its error, smaller on {below} of "
        f"{len(speeds)} trajectories",
        {"ratio": ratio, "below": below, "trajectories": len(speeds)},
    )


def _friction_needed(errors: Errors) -> Finding | None:
    """Compare kernels with and without friction on the slowest third of trajectories."""
    ratios = {}
    for alone in ALONE:
        speeds = errors.common(alone, alone + FRICTION)
        if speeds:
            ratios[alone] = errors.ratio(alone + FRICTION, alone, arm.ends(speeds)[0])
    if not ratios:
        return None
    figures = listed([f"{model} {ratio:.2f}" for model, ratio in ratios.items()])
    return Finding(
        max(ratios.values()) < 1.0,
        "friction beside the kernel is needed at low speed: on the slowest third of trajectories "
        f"it leaves of the kernel's error alone: {figures}",
        {"ratio": ratios},
    )


BESIDE = (TRADITIONAL, REFERENCE)
"""Models that are also learned from the arm without masses, to compare with."""


class LoadedStudy(PredictionStudy):
    """The arm with the masses `arm.LOADS` on its first two links."""

    name = "loaded"
    loaded = True

    def every_case(self) -> Sequence[Prediction]:
        """Return the cases with masses, then those to compare with, the same as in `speeds`."""
        beside = [model for model in BESIDE if model in self.models]
        return [*super().every_case(), *self.predictions(beside, loaded=False)]

    def results(self, lines: Sequence[Line]) -> PredictionResults:
        loaded, unloaded = (self.errors(lines, loaded=with_) for with_ in (True, False))
        findings = {**prediction_findings(loaded), **loaded_findings(loaded, unloaded)}
        return PredictionResults(lines, findings, loaded, unloaded)


def loaded_findings(loaded: Errors, unloaded: Errors) -> dict[str, Finding]:
    """Compare the gap between the traditional model and the Lagrangian kernel, and its growth.

    Only trajectories count on which both models are done, with and without masses.
    """
    arms = {"loaded": loaded, "unloaded": unloaded}
    done = [set(errors.common(TRADITIONAL, REFERENCE)) for errors in arms.values()]
    speeds = sorted(set.intersection(*done))
    if not speeds:
        return {}
    slow, fast = arm.ends(speeds)
    gap = {
        name: errors.mean(TRADITIONAL, fast) - errors.mean(REFERENCE, fast)
        for name, errors in arms.items()
    }
    found = {
        "gap_wider": Finding(
            gap["loaded"] > gap["unloaded"],
            f"with masses the gap between {TRADITIONAL} and {REFERENCE} is wider on the fastest "
            f"third of trajectories: {gap['loaded']:.2f} N·m, without {gap['unloaded']:.2f} N·m",
            {"gap": gap},
        )
    }
    if len(speeds) > 1:
        growth = {
            name: errors.mean(TRADITIONAL, fast) - errors.mean(TRADITIONAL, slow)
            for name, errors in arms.items()
        }
        found["motor_deteriorates_faster"] = Finding(
            growth["loaded"] > growth["unloaded"],
            f"with masses {TRADITIONAL} deteriorates faster: from the slowest to the fastest third "
            f"of trajectories its error grows by {growth['loaded']:.2f} N·m, without by "
            f"{growth['unloaded']:.2f} N·m",
            {"growth": growth},
        )
    return found
