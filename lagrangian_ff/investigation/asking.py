"""The next question: what a diagnosis leaves open, the most promising first."""

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.excite import Between, Everything, For, Question, Suspect
from lagrangian_ff.diagnosis.excite.questions import shown_by_motion
from lagrangian_ff.diagnosis.observable import Observability
from lagrangian_ff.diagnosis.results import Diagnosis
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.effects.usual import weight

TWICE = 2
"""How often one question is asked, at most: a second motion of its kind doubles the evidence."""
MOST_EVERYTHING = 3
HOPE = 8.0
"""Nats from which on the best candidate of a joint, beside what was found, is worth a motion. One
that stood out was judged already: what it gains is another's."""


def next_question(
    found: Diagnosis,
    shown: Callable[[], Observability],
    asked: Sequence[Question],
    size: float,
    gears: Mapping[str, str] | None = None,
) -> Question | None:
    """Return what to ask next; None if nothing is open.

    Args:
        found: of all motions so far.
        shown: returns what these motions could show; called if nothing else is open.
        asked: so far.
        size: share of a joint's torque from which on an effect should be seen.
        gears: by joint, the kind of its gear; what is usual in it is asked for first.
    """
    for question in _open(found, gears or {}):
        if asked.count(question) < TWICE:
            return question
    everything = Everything()
    if asked.count(everything) < MOST_EVERYTHING and _unseen(shown(), size):
        return everything
    return None


def _open(found: Diagnosis, gears: Mapping[str, str]) -> Iterator[Question]:
    for one in found.findings:
        if not shown_by_motion(one.effect):
            continue
        suspect = Suspect(one.effect.name, one.joint)
        gear = gears.get(one.joint)
        rivals = sorted(filter(_shown, one.rivals), key=lambda name: -weight(name, gear))
        yield from (Between(suspect, Suspect(name, one.joint)) for name in rivals)
        if not rivals and not one.confirmed:
            yield For(suspect)
    known = {(one.effect.name, joint) for one in found.findings for joint in one.joints}
    looked: set[str] = set()
    for ranked in found.waiting:
        new = ranked.named and _shown(ranked.name) and (ranked.name, ranked.joint) not in known
        judged = ranked.stands_out and ranked.log_bayes_factor > thresholds.USED.floor
        if new and not judged and ranked.joint not in looked and ranked.log_bayes_factor > HOPE:
            looked.add(ranked.joint)
            yield For(Suspect(ranked.name, ranked.joint))


def _shown(name: str) -> bool:
    """Return whether there is an effect of this name, and some motion shows it."""
    return name in EFFECTS and shown_by_motion(EFFECTS[name])


def _unseen(shown: Observability, size: float) -> bool:
    """Return whether an effect of this size could be there unseen, and another motion shows it."""
    every = np.array(list(shown.least.values()))
    return bool(np.any(np.isfinite(every) & (every > size)))
