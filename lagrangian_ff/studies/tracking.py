"""Fig. 6 of the paper: the tracking error over speed, with precomputed torque."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

from matplotlib.figure import Figure

from lagrangian_ff.identification import identify
from lagrangian_ff.report.colours import INK
from lagrangian_ff.studies import arm
from lagrangian_ff.studies.arm import FRICTION, OURS, REFERENCE, VELOCITY, Errors
from lagrangian_ff.studies.curves import Curve, Stroke, curves_figure, stroke_of
from lagrangian_ff.studies.study import Finding, Line, Results, shown

NONE, TRUE = "none", "true"
"""The servo alone; and the plant's own torques, the bound of what feedforward can do."""
MRAD = 1e-3
SPECIAL = {
    NONE: ("no feedforward", Stroke(INK)),
    TRUE: ("the plant's own torques", Stroke(INK, ":")),
}


@dataclass(frozen=True)
class Tracked(arm.ArmCase):
    """A case: a feedforward learned from the first third, driven along the whole trajectory.

    The model may also be `none` or `true`.
    """

    def run(self) -> Mapping[str, Any]:
        """Record with the servo alone, identify, drive with the precomputed torque.

        Returns:
            `speed`, `feedforward`; `velocity`, the mean norm of velocity with the servo alone in
            rad/s; `rmse`, the error of position on the last two thirds in rad (all joints), also
            in `joints`; and `chosen`, if there is a model.
        """
        alone = self.drive.motion()
        chosen: dict[str, Any] = {}
        if self.model == NONE:
            run = self.drive.recording
        elif self.model == TRUE:
            run = self.drive.run("true")
        else:
            found = identify(alone, replace(self.settings, model=self.model))
            chosen = {"chosen": arm.chosen_of(found)}
            run = self.drive.run(found.model.predict)
        learned = round(self.settings.train * len(run))
        error = arm.rms(self.drive.tracking_error(run)[learned:])
        return {
            "speed": self.drive.speed,
            "feedforward": self.model,
            "velocity": arm.mean_speed(alone),
            "rmse": float(arm.rms(error)),
            "joints": dict(zip(alone.joints, error.tolist(), strict=True)),
            **chosen,
        }


@dataclass(frozen=True)
class TrackingResults(Results):
    """Tracking errors over speed, in rad by feedforward."""

    errors: Errors

    def numbers(self) -> dict[str, Any]:
        return {"curves": self.errors.record()}

    def text(self) -> list[str]:
        return [
            f"{len(self.lines)} cases; RMS tracking error [mrad] on the last two thirds",
            *arm.errors_table(self.errors, unit=MRAD),
        ]

    def figure(self) -> Figure:
        """Draw a line for each feedforward; models without friction are dashed."""
        curves = {}
        for name in self.errors.of:
            label, stroke = SPECIAL.get(name, (name, stroke_of(name)))
            if FRICTION not in name and name not in SPECIAL:
                stroke = replace(stroke, dashes="--")
            velocity, error = self.errors.curve(name)
            curves[label] = Curve(velocity, [e / MRAD for e in error], stroke, name == OURS)
        return curves_figure(
            {"Precomputed torque, the last two thirds of each trajectory": curves},
            VELOCITY,
            "RMS tracking error [mrad]",
        )


class TrackingStudy(arm.ArmStudy):
    """Position error along trajectories of rising speed, by feedforward.

    Nothing and the plant's own torques are always fed forward, beside the models.
    """

    name = "tracking"
    usual = quick_usual = ("vrbfs+fri", "auto+fri", "vrbfs", "motor+fri")

    def asked(self, models: Sequence[str]) -> tuple[str, ...]:
        """Return what is fed forward."""
        return NONE, TRUE, *super().asked([m for m in models if m not in (NONE, TRUE)])

    def every_case(self) -> Sequence[Tracked]:
        """Return the cases without feedforward, with the true one, then model by model."""
        along = self.drives()
        return [Tracked(drive, fed, self.plan.settings) for fed in self.models for drive in along]

    def results(self, lines: Sequence[Line]) -> TrackingResults:
        errors = Errors.collected(lines, "feedforward")
        return TrackingResults(lines, tracking_findings(errors), errors)


def tracking_findings(errors: Errors) -> dict[str, Finding]:
    """Return what the cases that are done show: three groups, and how near the bound we come."""
    return shown(
        {
            "three_groups": _three_groups(errors),
            "bound_below": _bound_below(errors),
            "ours_nearest": _ours_nearest(errors),
        }
    )


def _three_groups(errors: Errors) -> Finding | None:
    models = [name for name in errors.of if name not in (NONE, TRUE)]
    groups = [
        [NONE],
        [model for model in models if FRICTION not in model],
        [model for model in models if FRICTION in model],
    ]
    speeds = errors.common(NONE, *models)
    if not speeds or not all(groups):
        return None
    means = [{name: errors.mean(name, speeds) for name in group} for group in groups]
    none, without, with_ = (_span(list(group.values())) for group in means)
    apart = [_apart(errors, worse, better, speeds) for worse, better in pairwise(groups)]
    return Finding(
        all(min(worse.values()) > max(better.values()) for worse, better in pairwise(means)),
        f"tracking falls in three groups: {none} mrad without feedforward, {without} without "
        f"friction in the model, {with_} with it; the first two are apart on {apart[0]} of "
        f"{len(speeds)} trajectories, the last two on {apart[1]}",
        {
            "mean": {name: mean for group in means for name, mean in group.items()},
            "apart": apart,
            "trajectories": len(speeds),
        },
    )


def _span(means: Sequence[float]) -> str:
    return " to ".join(f"{mean / MRAD:.1f}" for mean in dict.fromkeys((min(means), max(means))))


def _apart(errors: Errors, worse: list[str], better: list[str], speeds: list[int]) -> int:
    """Return the number of trajectories on which all of one group are above all of the other."""
    return sum(
        min(errors.of[name][speed] for name in worse)
        > max(errors.of[name][speed] for name in better)
        for speed in speeds
    )


def _bound_below(errors: Errors) -> Finding | None:
    speeds = errors.common(NONE, TRUE)
    if not speeds:
        return None
    ratio, below = errors.ratio(TRUE, NONE, speeds), errors.below(TRUE, NONE, speeds)
    return Finding(
        below == len(speeds),
        f"the plant's own torques, the bound for any model, leave {ratio:.3f} of the error without "
        "feedforward",
        {"ratio": ratio},
    )


def _ours_nearest(errors: Errors) -> Finding | None:
    speeds = errors.common(OURS, REFERENCE, TRUE)
    if not speeds:
        return None
    over = {name: errors.ratio(name, TRUE, speeds) for name in (OURS, REFERENCE)}
    below = errors.below(OURS, REFERENCE, speeds)
    return Finding(
        over[OURS] < over[REFERENCE],
        f"{OURS} is nearer to the bound than {REFERENCE}: {over[OURS]:.2f} times it, {REFERENCE} "
        f"{over[REFERENCE]:.2f} times; smaller on {below} of {len(speeds)} trajectories",
        {"over_bound": over, "below": below, "trajectories": len(speeds)},
    )
