"""Judge a diagnosis against what was hidden: one pure function decides."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import Enum
from typing import Any

from lagrangian_ff.diagnosis.confidence import Verdict
from lagrangian_ff.diagnosis.results import Found


class Outcome(str, Enum):
    """The outcome of a case.

    RIGHT: every truth is confirmed by its name. CLASS: every truth is claimed, some only as one of
    several effects that the data cannot tell apart. PART: some truths are claimed and others
    missed. WRONG: a claim that holds no truth. NOTHING: no claim; right where nothing, or nothing
    of the catalogue, is hidden.
    """

    RIGHT = "right"
    CLASS = "class"
    PART = "part"
    WRONG = "wrong"
    NOTHING = "nothing"


@dataclass(frozen=True)
class Truth:
    """One hidden effect, as the diagnosis should name it.

    Attributes:
        names: its right names in the catalogue; empty if the catalogue does not have it.
        joints: where it acts; a finding that any of them causes is in the right place.
    """

    names: tuple[str, ...]
    joints: tuple[str, ...]


@dataclass(frozen=True)
class Judgement:
    """The judgement of a case.

    Attributes:
        outcome: of the case.
        false: effect and joints of each claim that matches no truth. A single hidden effect may
            be right beside them: they are counted apart there.
        suggested: indices of truths that a finding names without a claim.
    """

    outcome: Outcome
    false: tuple[str, ...]
    suggested: tuple[int, ...]

    def record(self) -> dict[str, Any]:
        """Return the judgement as JSON holds it."""
        return {**asdict(self), "outcome": self.outcome.value}

    @classmethod
    def of(cls, record: Mapping[str, Any]) -> "Judgement":
        """Return the judgement of a record."""
        outcome = Outcome(record["outcome"])
        return cls(outcome, tuple(record["false"]), tuple(record["suggested"]))


def claims(finding: Found) -> bool:
    """Return whether a finding claims that something is there; a suggestion does not."""
    return finding.verdict is not Verdict.SUGGESTED


def judge(
    truths: Sequence[Truth], findings: Sequence[Found], allowed: Sequence[Truth] = ()
) -> Judgement:
    """Compare findings with what was hidden.

    With one truth of the catalogue, a claim that matches makes the case right whatever else is
    claimed; with two, with none, or outside the catalogue every claim that matches none is wrong.
    A claim of what is `allowed`, which is there but need not be found, is neither right nor wrong.
    """
    matches: dict[int, Outcome] = {}
    suggested: set[int] = set()
    false = []
    for finding in findings:
        hits = {k: how for k, truth in enumerate(truths) if (how := _match(truth, finding))}
        if not claims(finding):
            suggested |= set(hits)
            continue
        for k, how in hits.items():
            matches[k] = Outcome.RIGHT if Outcome.RIGHT in (how, matches.get(k)) else how
        if not hits and not any(_match(one, finding) for one in allowed):
            names = [finding.effect.name, *finding.rivals]
            false.append(f"{' or '.join(names)} on {', '.join(finding.joints)}")
    outcome = _outcome(truths, matches, bool(false))
    return Judgement(outcome, tuple(false), tuple(sorted(suggested - set(matches))))


def _match(truth: Truth, finding: Found) -> Outcome | None:
    """Return RIGHT if the finding names the truth alone, CLASS if as one of several."""
    places = {finding.cause} if finding.cause else set(finding.joints)
    if not places.intersection(truth.joints):
        return None
    if finding.effect.name in truth.names:
        return Outcome.CLASS if finding.verdict is Verdict.AMBIGUOUS else Outcome.RIGHT
    return Outcome.CLASS if set(truth.names).intersection(finding.rivals) else None


def _outcome(truths: Sequence[Truth], matches: Mapping[int, Outcome], false: bool) -> Outcome:
    if false and not (len(truths) == 1 and matches):
        return Outcome.WRONG
    if not matches:
        return Outcome.NOTHING
    if len(matches) < len(truths):
        return Outcome.PART
    return Outcome.RIGHT if set(matches.values()) == {Outcome.RIGHT} else Outcome.CLASS
