"""Was the diagnosis of a case right? One pure function decides."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

Outcome = Literal["right", "class", "part", "wrong", "nothing"]
OUTCOMES: tuple[Outcome, ...] = ("right", "class", "part", "wrong", "nothing")
CONFIRMED, AMBIGUOUS = "confirmed", "ambiguous"
"""How verdicts begin that claim something: this effect is there, or one of these is."""


def claims(finding: Mapping[str, Any]) -> bool:
    """Whether a finding claims that something is there; what is only suggested does not."""
    return str(finding["verdict"]).startswith((CONFIRMED, AMBIGUOUS))


@dataclass(frozen=True)
class Truth:
    """One hidden effect, as the diagnosis should name it.

    Attributes:
        names: of the catalogue, each of them right; empty for what no catalogue has.
        joints: where it acts; a finding that any of them causes is in the right place.
    """

    names: tuple[str, ...]
    joints: tuple[str, ...]


@dataclass(frozen=True)
class Judgement:
    """What is said of a case.

    Attributes:
        outcome: `right`: every truth is confirmed by its name. `class`: every truth is claimed,
            some only as one of several that the data cannot tell apart. `part`: some truths are
            claimed and others missed. `wrong`: a claim that holds no truth.
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
        findings: of the diagnosis's record: `effect`, `joints`, `caused_by`, `verdict`,
            `ambiguous_with`.
    """
    matches: dict[int, str] = {}
    false = []
    for finding in findings:
        if not claims(finding):
            continue
        hits = {k: how for k, t in enumerate(truths) if (how := _match(t, finding))}
        for k, how in hits.items():
            matches[k] = "right" if "right" in (how, matches.get(k)) else how
        if not hits:
            false.append(_words(finding))
    named = (f for f in findings if not claims(f))
    suggested = {k for f in named for k, t in enumerate(truths) if _match(t, f)} - set(matches)
    return Judgement(_outcome(truths, matches, bool(false)), tuple(false), tuple(sorted(suggested)))


def _match(truth: Truth, finding: Mapping[str, Any]) -> str:
    """`right` by its name alone, `class` as one of several, or empty."""
    cause = finding.get("caused_by")
    if not set(truth.joints) & ({cause} if cause else set(finding["joints"])):
        return ""
    if finding["effect"] in truth.names:
        return "class" if str(finding["verdict"]).startswith(AMBIGUOUS) else "right"
    return "class" if set(truth.names) & set(finding.get("ambiguous_with") or ()) else ""


def _words(finding: Mapping[str, Any]) -> str:
    names = [finding["effect"], *(finding.get("ambiguous_with") or ())]
    return f"{' or '.join(names)} on {', '.join(finding['joints'])}"


def _outcome(truths: Sequence[Truth], matches: Mapping[int, str], false: bool) -> Outcome:
    alone = len(truths) == 1 and matches
    if false and not alone:
        return "wrong"
    if not matches:
        return "nothing"
    if len(matches) < len(truths):
        return "part"
    return "right" if set(matches.values()) == {"right"} else "class"
