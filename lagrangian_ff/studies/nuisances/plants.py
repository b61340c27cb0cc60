"""The cases of the study, and two recordings of each arm as its driver reports them."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lagrangian_ff.arm import JOINTS, Run, reported, simulate, working_motion
from lagrangian_ff.arm.hidden import HIDDEN, Installed, Reference
from lagrangian_ff.arm.hidden.base import together
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.studies.hidden.cases import Hidden, percent
from lagrangian_ff.studies.hidden.plants import Built, hide, kept
from lagrangian_ff.studies.nuisances.drawn import Nuisances

CLEAN, OUTSIDE = 64, 64
KNOWN = {0.10: 60, 0.05: 60, 0.20: 36, 0.02: 36}
"""Arms with an effect of the catalogue, by its size."""
SMALL_CLEAN, SMALL_OUTSIDE, SMALL_KNOWN = 2, 2, {0.20: 4, 0.10: 2}
OUTSIDE_SIZES = 0.10, 0.05, 0.20
IN_GEARS = "elasticity", "backlash"
"""Hidden effects that take the place of the elastic gear of their joint."""
REST_SPEED = 5e-3
"""rad/s; below it in all joints the arm is at rest."""


@dataclass(frozen=True)
class NuisanceCase:
    """One arm, with nuisances and perhaps a hidden effect.

    Attributes:
        name: unique in the study.
        group: `clean`, `alone` (an effect of the catalogue) or `outside` (of the catalogue).
        hidden: the effect, or none.
        seed: of everything that is drawn.
    """

    name: str
    group: str
    hidden: tuple[Hidden, ...]
    seed: int


def cases(seed: int = 0, *, small: bool = False) -> list[NuisanceCase]:
    """Return all cases, or some ten if `small`, in an order that mixes all groups evenly."""
    known = SMALL_KNOWN if small else KNOWN
    clean, outside = (SMALL_CLEAN, SMALL_OUTSIDE) if small else (CLEAN, OUTSIDE)
    rows = [
        *_spread(_clean(seed, clean)),
        *_spread(_outside(seed, outside)),
        *(place for size, count in known.items() for place in _spread(_known(seed, size, count))),
    ]
    return [case for _, case in sorted(rows, key=lambda row: row[0])]


def _spread(some: Iterator[NuisanceCase]) -> list[tuple[float, NuisanceCase]]:
    every = list(some)
    return [((k + 0.5) / len(every), case) for k, case in enumerate(every)]


def _clean(seed: int, count: int) -> Iterator[NuisanceCase]:
    for k in range(count):
        name = f"clean-{k:02d}"
        yield NuisanceCase(name, "clean", (), _seed(seed, name))


def _outside(seed: int, count: int) -> Iterator[NuisanceCase]:
    strange = [name for name, kind in HIDDEN.items() if not kind.catalogue]
    for k in range(count):
        effect = strange[k % len(strange)]
        size = OUTSIDE_SIZES[k // len(strange) % len(OUTSIDE_SIZES)]
        yield _hiding(seed, "outside", effect, size, k)


def _known(seed: int, size: float, count: int) -> Iterator[NuisanceCase]:
    """Yield each effect that can be so large in turn, in a random order."""
    able = [name for name, kind in HIDDEN.items() if kind.catalogue and size <= kind.largest]
    random = np.random.default_rng(_seed(seed, f"order {size:g}"))
    for k in range(count):
        if k % len(able) == 0:
            random.shuffle(able)
        yield _hiding(seed, "alone", able[k % len(able)], size, k)


def _hiding(seed: int, group: str, effect: str, size: float, number: int) -> NuisanceCase:
    stem = f"{effect}-{percent(size)}-{number:02d}"
    drawn = _seed(seed, stem)
    joint = JOINTS[int(np.random.default_rng([drawn, 1]).choice(HIDDEN[effect].joints))]
    name = f"{effect}-{joint}-{percent(size)}-{number:02d}"
    return NuisanceCase(name, group, (Hidden(effect, joint, size),), drawn)


def _seed(seed: int, word: str) -> int:
    """Return the seed of one use, so that a case stays the same when others join."""
    return int(np.random.default_rng([seed, *word.encode()]).integers(2**31))


@dataclass(frozen=True)
class NuisancePlant:
    """An arm and the facts of its recordings.

    Attributes:
        name, group, seed: of the case.
        hidden: the effect as it was built.
        nuisances: all that was drawn.
        seconds, moving: s of each recording, and those in which a joint moves.
        saturated: share of the time with saturated motors, of each recording.
        torque_rms: N·m of each joint, of each recording.
    """

    name: str
    group: str
    seed: int
    hidden: list[Built]
    nuisances: Nuisances
    seconds: list[float]
    moving: list[float]
    saturated: list[float]
    torque_rms: list[list[float]]

    def record(self) -> dict[str, Any]:
        """Return the plant as JSON holds it."""
        return asdict(self)

    @classmethod
    def of(cls, record: dict[str, Any]) -> "NuisancePlant":
        """Return the plant of a record."""
        hidden = [Built(**each) for each in record["hidden"]]
        return cls(**{**record, "hidden": hidden, "nuisances": Nuisances.of(record["nuisances"])})


def recorded(
    case: NuisanceCase, folder: Path, *, keep: bool = False, longest: float | None = None
) -> tuple[Recording, Recording, NuisancePlant]:
    """Record the arm of a case twice; with `keep` as `lagrangian_ff.studies.hidden` keeps it.

    `longest` limits the motions, in s.
    """
    nuisances = Nuisances.draw(case.seed)
    if longest is not None:
        nuisances = replace(nuisances, seconds=min(nuisances.seconds, longest))
    return kept(folder, case.name, lambda: _record(case, nuisances), NuisancePlant.of, keep=keep)


def _record(case: NuisanceCase, nuisances: Nuisances) -> tuple[Recording, Recording, NuisancePlant]:
    parameters, driver = nuisances.parameters, nuisances.driver
    stiff = [JOINTS.index(one.joint) for one in case.hidden if one.effect in IN_GEARS]
    everywhere = nuisances.installed(stiff)
    motions = [
        working_motion(
            nuisances.motion,
            nuisances.seconds,
            nuisances.rest,
            nuisances.pace,
            case.seed + number,
            parameters,
        )
        for number in range(2)
    ]

    def drive(number: int, parts: Sequence[Installed]) -> Run:
        return simulate(motions[number], parameters=parameters, **together([*everywhere, *parts]))

    along = Reference.of(drive(0, ())) if case.hidden else None
    runs, built = hide(case.hidden, case.seed, along, drive, parameters)
    first, second = (
        reported(run, driver, parameters, case.seed + number) for number, run in enumerate(runs)
    )
    moves = [np.any(np.abs(run.reference.qd) > REST_SPEED, axis=1).mean() for run in runs]
    seconds = [run.reference.duration for run in runs]
    plant = NuisancePlant(
        name=case.name,
        group=case.group,
        seed=case.seed,
        hidden=built,
        nuisances=nuisances,
        seconds=seconds,
        moving=[float(a * b) for a, b in zip(seconds, moves, strict=True)],
        saturated=[float(run.saturated.mean()) for run in runs],
        torque_rms=[np.sqrt(np.mean(run.motor_torque**2, axis=0)).tolist() for run in runs],
    )
    return first, second, plant
