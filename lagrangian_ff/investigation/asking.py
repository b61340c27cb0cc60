"""The next question: what a diagnosis leaves open, the most promising first."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.excite import (
    Between,
    Design,
    Everything,
    For,
    Parameters,
    Question,
    Suspect,
)
from lagrangian_ff.diagnosis.excite.assumed import Key
from lagrangian_ff.diagnosis.excite.questions import shown_by_motion
from lagrangian_ff.diagnosis.results import Diagnosis, Finding
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.effects.usual import weight

TWICE = 2
"""How often one question is asked, at most: a second motion of its kind doubles the evidence."""
MOST_EVERYTHING = 3
NEW = 0.04
"""Share of all effects and joints that a motion shows for the first time, to be worth making."""
LESS = 0.8
"""Share of what a model missed of unseen motion, below which more motion taught it something."""
HOPE = 8.0
"""Nats from which on the best candidate of a joint, beside what was found, is worth a motion. One
that stood out was judged already: what it gains is another's."""


def next_question(
    found: Diagnosis,
    unseen: Callable[[], bool],
    asked: Sequence[Question],
    gears: Mapping[str, str] | None = None,
    denied: Collection[Suspect] = (),
) -> Question | None:
    """Return what to ask next; None if nothing is open.

    Args:
        found: of all motions so far.
        unseen: returns whether an effect that should be seen could be there unseen; called if
            nothing that was found is open.
        asked: so far.
        gears: by joint, the kind of its gear; what is usual in it is asked for first.
        denied: what a motion that would have shown it did not show. It is no longer asked about,
            nor told from its rivals.
    """
    everything = Everything()
    for question in _open(found, gears or {}, denied):
        if _times(question, asked) < TWICE:
            return question
    if asked.count(everything) < MOST_EVERYTHING and unseen():
        return everything
    more: list[Question] = list(_faint(found))
    if found.failing and not found.unexplained:  # what nobody explains is why it fails, and stays
        more.append(Parameters())
    return next((one for one in more if _times(one, asked) < TWICE), None)


def about_formulas(
    every: Sequence[tuple[Between, Finding]], asked: Sequence[Question]
) -> Between | None:
    """Return the next question about two formulas; None if each joint was asked about already.

    More motion may propose others for the same joint: they are no new question.
    """
    for question, _ in every:
        of_joint = [one for one in asked if _formulas(one) and _joints(one) == _joints(question)]
        if len(of_joint) < TWICE:
            return question
    return None


def _formulas(question: Question) -> bool:
    return any(one.formula is not None for one in question.suspects)


def _joints(question: Question) -> set[str]:
    return {one.joint for one in question.suspects}


def _times(question: Question, asked: Sequence[Question]) -> int:
    """Return how often a question was asked, of two rivals in either order."""
    return sum(_key(one) == _key(question) for one in asked)


def _key(question: Question) -> tuple[type, list[str]]:
    return type(question), sorted(map(str, question.suspects))


def _open(
    found: Diagnosis, gears: Mapping[str, str], denied: Collection[Suspect]
) -> Iterator[Question]:
    """Yield the questions that what was found leaves open."""
    for one in found.findings:
        suspect = Suspect(one.effect.name, one.joint)
        if not _shown(one.effect.name) or suspect in denied:
            continue
        gear = gears.get(one.joint)
        rivals = sorted(filter(_shown, one.rivals), key=lambda name: -weight(name, gear))
        yield from (Between(suspect, Suspect(name, one.joint)) for name in rivals)
        if not rivals and not one.confirmed and not one.useless:
            yield For(suspect)


def _faint(found: Diagnosis) -> Iterator[Question]:
    """Yield the questions for what is too faint to be found, or to lower the error."""
    known = {(one.effect.name, joint) for one in found.findings for joint in one.joints}
    looked: set[str] = set()
    for ranked in found.waiting:
        new = ranked.named and _shown(ranked.name) and (ranked.name, ranked.joint) not in known
        judged = ranked.stands_out and ranked.log_bayes_factor > thresholds.USED.floor
        if new and not judged and ranked.joint not in looked and ranked.log_bayes_factor > HOPE:
            looked.add(ranked.joint)
            yield For(Suspect(ranked.name, ranked.joint))
    # More of what is there only sharpens its parameters, until the error falls.
    there = [
        one for one in found.findings if one.useless and not one.rivals and _shown(one.effect.name)
    ]
    yield from (For(Suspect(one.effect.name, one.joint)) for one in there)


def promising(found: Diagnosis, made: Design, seen: Mapping[Key, float]) -> bool:
    """Return whether motions can settle a question, as often as it may be asked.

    What stands out already is confirmed by any motion that shows it. What else there is, a motion
    tells with which some effects would be seen that all motions so far do not show.

    Args:
        made: one of these motions.
        seen: where everything is asked about, by effect and joint the nats that all motions so far
            would show of it, at the size that this motion is designed for.
    """
    limits, question, nats = thresholds.USED, made.question, made.nats
    if isinstance(question, Everything):
        joints = made.joints
        gains = [(seen[one.effect, joints.index(one.joint)], one.nats) for one in made.expected]
        new = [has < limits.floor <= has + more for has, more in gains]
        return sum(new) >= NEW * len(gains)
    if isinstance(question, Between):
        return TWICE * nats >= limits.rival_nats
    if isinstance(question, Parameters):
        return True
    assert isinstance(question, For)
    wanted = question.suspect.effect, question.suspect.joint
    if wanted in [(one.effect.name, one.joint) for one in found.findings]:
        return True
    return TWICE * nats >= max(HOPE, limits.floor - _evidence(found, question.suspect))


def denies(question: Question, before: Diagnosis, after: Diagnosis) -> bool:
    """Return whether a motion brought nothing of what it was made for, so that another will not.

    All motions with it show no more of the effect; or the model misses hardly less.

    Args:
        before, after: of all motions without it and with it.
    """
    if isinstance(question, Parameters):
        return sum(after.failing.values()) > LESS * sum(before.failing.values())
    if not isinstance(question, For):
        return False
    return _evidence(after, question.suspect) <= _evidence(before, question.suspect)


def unsettled(question: Question, found: Diagnosis) -> bool:
    """Return whether what a question names was found, and is neither confirmed nor ruled out."""
    if not question.suspects:
        return False
    first, *others = question.suspects
    return any(
        (one.effect.name, one.joint) == (first.effect, first.joint)
        and not one.confirmed
        and all(other.effect in one.rivals for other in others)
        for one in found.findings
    )


def _evidence(found: Diagnosis, suspect: Suspect) -> float:
    """Return the log Bayes factor of an effect in nats, whether it was found or not; 0 for none.

    A rival of what was found has at least what was found less the nats that rule out.
    """
    wanted = suspect.effect, suspect.joint
    leads = [one.log_bayes_factor for one in found.waiting if (one.name, one.joint) == wanted]
    there = [one for one in found.findings if (one.effect.name, one.joint) == wanted]
    beside = [
        one.log_bayes_factor - thresholds.USED.rival_nats
        for one in found.findings
        if one.joint == suspect.joint and suspect.effect in one.rivals
    ]
    return max([0.0, *leads, *beside, *(one.log_bayes_factor for one in there)])


def _shown(name: str) -> bool:
    """Return whether there is an effect of this name, and some motion shows it."""
    return name in EFFECTS and shown_by_motion(EFFECTS[name])
