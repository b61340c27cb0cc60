"""What masses on the arm change, as Fig. 7 of the paper has it beside Fig. 5."""

from collections.abc import Sequence

from lagrangian_ff.studies.arm.errors import Errors, ends
from lagrangian_ff.studies.arm.findings import REFERENCE, TRADITIONAL
from lagrangian_ff.studies.common.findings import Finding, finding


def compared(loaded: Errors, unloaded: Errors) -> dict[str, Finding]:
    """The gap between the traditional model and the Lagrangian kernel, and how it grows.

    On trajectories that both models are done on, with and without masses; none are no finding.
    """
    both = loaded.common(TRADITIONAL, REFERENCE), unloaded.common(TRADITIONAL, REFERENCE)
    speeds = sorted(set(both[0]) & set(both[1]))
    if not speeds:
        return {}
    slow, fast = ends(speeds)
    gaps = {name: _gap(errors, fast) for name, errors in _named(loaded, unloaded)}
    found = {
        "gap_wider": finding(
            gaps["loaded"] > gaps["unloaded"],
            f"with masses the gap between {TRADITIONAL} and {REFERENCE} is wider on the fastest "
            f"third of trajectories: {gaps['loaded']:.2f} N·m, without {gaps['unloaded']:.2f} N·m",
            gap=gaps,
        )
    }
    if len(speeds) > 1:
        growth = {
            name: errors.mean(TRADITIONAL, fast) - errors.mean(TRADITIONAL, slow)
            for name, errors in _named(loaded, unloaded)
        }
        found["motor_deteriorates_faster"] = finding(
            growth["loaded"] > growth["unloaded"],
            f"with masses {TRADITIONAL} deteriorates faster: from the slowest to the fastest third "
            f"of trajectories its error grows by {growth['loaded']:.2f} N·m, without by "
            f"{growth['unloaded']:.2f} N·m",
            growth=growth,
        )
    return found


def _gap(errors: Errors, speeds: Sequence[int]) -> float:
    return errors.mean(TRADITIONAL, speeds) - errors.mean(REFERENCE, speeds)


def _named(loaded: Errors, unloaded: Errors) -> list[tuple[str, Errors]]:
    return [("loaded", loaded), ("unloaded", unloaded)]
