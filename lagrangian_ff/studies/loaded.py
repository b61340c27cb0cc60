"""Fig. 7 of the paper: as `speeds`, with masses on the arm."""

from collections.abc import Sequence

from lagrangian_ff.studies.arm import REFERENCE, Errors, ends
from lagrangian_ff.studies.speeds import (
    TRADITIONAL,
    Prediction,
    PredictionResults,
    PredictionStudy,
    prediction_findings,
)
from lagrangian_ff.studies.study import Finding, Line

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
    slow, fast = ends(speeds)
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
