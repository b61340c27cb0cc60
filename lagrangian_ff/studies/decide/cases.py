"""The arms of the study: what hides in each, and what is asked of it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arm import JOINTS
from lagrangian_ff.arm.hidden import HIDDEN
from lagrangian_ff.studies.hidden.cases import Hidden, percent
from lagrangian_ff.studies.nuisances.drawn import Nuisances

NEVER = ("payload", "contact", "saturation", "delay", "eccentricity", "spring", "warm_up")
"""Hidden effects that are left out: events, faults of sensors, what any Lagrangian contains, and
what needs minutes at work."""
BUDGET = 240.0
"""s of motion of an investigation."""
COUNTS = {"motion": 12, "five": 12, "two": 5, "clean": 5, "sooner": 12}
"""Arms of each group."""
SMALL = {"motion": 1, "five": 1, "two": 1, "clean": 1, "sooner": 1}


@dataclass(frozen=True)
class DecideCase:
    """One arm.

    Attributes:
        name: unique in the study.
        group: `motion` (what does a designed motion decide?); `five`, `two` or `clean` (what does
            an investigation find, of 5 %, of 2 %, of nothing?); or `sooner` (is an arm identified
            after less motion if it is designed?).
        hidden: the effect; None for none.
        seed: of everything that is drawn.
    """

    name: str
    group: str
    hidden: Hidden | None
    seed: int

    @property
    def nuisances(self) -> Nuisances:
        """Return the nuisances of the arm, whose effort is all of the torque."""
        return replace(Nuisances.draw(self.seed), without_gravity=0)


def cases(seed: int = 0, *, small: bool = False) -> list[DecideCase]:
    """Return all cases, or a few if `small`, group by group."""
    counts = SMALL if small else COUNTS
    return [case for group, count in counts.items() for case in _group(seed, group, count)]


def _group(seed: int, group: str, count: int) -> Iterator[DecideCase]:
    """Yield arms that hide each effect in turn, in a random order."""
    size = {"motion": 0.05, "five": 0.05, "two": 0.02}.get(group, 0.0)
    able = [
        name
        for name, kind in HIDDEN.items()
        if kind.catalogue and name not in NEVER and kind.largest >= size
    ]
    random = np.random.default_rng(_seed(seed, group))
    for k in range(count):
        if k % len(able) == 0:
            random.shuffle(able)
        if size == 0.0:
            name = f"{group}-{k:02d}"
            yield DecideCase(name, group, None, _seed(seed, name))
            continue
        effect = able[k % len(able)]
        drawn = _seed(seed, f"{group} {effect} {k}")
        joint = JOINTS[int(np.random.default_rng([drawn, 1]).choice(HIDDEN[effect].joints))]
        name = f"{group}-{effect}-{joint}-{percent(size)}-{k:02d}"
        yield DecideCase(name, group, Hidden(effect, joint, size), drawn)


def _seed(seed: int, word: str) -> int:
    return int(np.random.default_rng([seed, *word.encode()]).integers(2**31))
