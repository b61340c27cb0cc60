"""Was the diagnosis of a case right? One pure function decides."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

Outcome = Literal["right", "class", "part", "wrong", "nothing"]
OUTCOMES: tuple[Outcome, ...] = ("right", "class", "part", "wrong", "nothing")
CLAIM = "confirmed"
"""The verdict by which a finding claims to be true; all others are suggestions."""


@dataclass(frozen=True)
class Truth:
    """One hidden effect, as the diagnosis should name it.

    Attributes:
        names: of the catalogue, each of them right; empty for what no catalogue has.
        joints: where it acts; a finding on any of them is in the right place.
    """

    names: tuple[str, ...]
    joints: tuple[str, ...]


@dataclass(frozen=True)
class Judgement:
    """What is said of a case.

    Attributes:
        outcome: `right`: every truth is claimed by its name. `class`: every truth is claimed,
            some only among those that a finding says it cannot be told from. `part`: some truths
            are claimed and others missed. `wrong`: a claim that it should not have made.
            `nothing`: no claim; right where nothing, or nothing of the catalogue, is hidden.
        false: effect and joints of each claim that matches no truth. A single hidden effect may
            be right beside them: they are counted apart there.
        suggested: truths, by their place, that are named by a finding that claims nothing.
    """

    outcome: Outcome
    false: tuple[str, ...]
    suggested: tuple[int, ...]


def judge(truths: Sequence[Truth], findings: Sequence[Mapping[str, Any]]) -> Judgement:
    """Compare findings with what was hidden.

    With one truth of the catalogue, a claim that matches makes the case right whatever else is
    claimed; with two, with none, or outside the catalogue every claim that matches none is wrong.

    Args:
        truths: what was hidden.
        findings: of the diagnosis's record: `effect`, `joints`, `verdict`, `ambiguous_with`.
    """
    matches: dict[int, str] = {}
    false = []
    for finding in findings:
        if finding["verdict"] != CLAIM:
            continue
        hits = {k: how for k, t in enumerate(truths) if (how := _match(t, finding))}
        for k, how in hits.items():
            matches[k] = "right" if "right" in (how, matches.get(k)) else how
        if not hits:
            false.append(f"{finding['effect']} on {', '.join(finding['joints'])}")
    named = (f for f in findings if f["verdict"] != CLAIM)
    suggested = {k for f in named for k, t in enumerate(truths) if _match(t, f)} - set(matches)
    return Judgement(_outcome(truths, matches, bool(false)), tuple(false), tuple(sorted(suggested)))


def _match(truth: Truth, finding: Mapping[str, Any]) -> str:
    """`right` by name, `class` as one that cannot be told from it, or empty."""
    if not set(truth.joints) & set(finding["joints"]):
        return ""
    if finding["effect"] in truth.names:
        return "right"
    return "class" if set(truth.names) & set(finding.get("ambiguous_with") or ()) else ""


def _outcome(truths: Sequence[Truth], matches: Mapping[int, str], false: bool) -> Outcome:
    alone = len(truths) == 1 and matches
    if false and not alone:
        return "wrong"
    if not matches:
        return "nothing"
    if len(matches) < len(truths):
        return "part"
    return "right" if set(matches.values()) == {"right"} else "class"
