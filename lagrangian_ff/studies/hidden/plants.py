"""The plants of the study: arms with hidden effects, and two recordings of each."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Protocol, TypeAlias, TypeVar

import numpy as np

from lagrangian_ff.arm import JOINTS, ArmParameters, Run, Trajectory, exciting_trajectory, simulate
from lagrangian_ff.arm.hidden import Installed, Reference, Site, beyond_friction, size, sized
from lagrangian_ff.arm.hidden.base import together
from lagrangian_ff.files import whole
from lagrangian_ff.recording import load, write_npz
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.studies.hidden.cases import Hidden, HiddenCase

RECORDINGS = 2


@dataclass(frozen=True)
class Stretches:
    """The parts of each recording: (speed of the exciting trajectory, s) one after the other.

    The slow stretch shows what happens near rest, the fast one inertia and drag.
    """

    parts: tuple[tuple[int, float], ...] = ((2, 20.0), (6, 40.0))


FULL = Stretches()


@dataclass(frozen=True)
class Built(Hidden):
    """One hidden effect as it was built; `size` is the size wanted.

    Attributes:
        catalogue: its right names in the catalogue; empty if the catalogue does not have it.
        joints: the joints it acts on.
        absorbed: whether a kernel free in position can hold it, so that nothing is right too.
        physics: one sentence.
        strength: in the unit of the effect.
        facts: its numbers, by name with unit.
        reached: the size in each recording.
        visible: in each recording, the part of the size that friction of the joint's own kind
            (viscous, Coulomb, constant) cannot stand in for.
    """

    catalogue: list[str]
    joints: list[str]
    absorbed: bool
    physics: str
    strength: float
    facts: dict[str, float]
    reached: list[float]
    visible: list[float]


@dataclass(frozen=True)
class Plant:
    """A plant and the facts of its recordings.

    Attributes:
        name, motion, seed, group: of the case.
        hidden: the effects.
        saturated: the share of time with saturated motors, of each recording.
        tracking_rms: rad, of each recording.
        torque_rms: N·m of each joint, of each recording.
    """

    name: str
    hidden: list[Built]
    motion: int
    seed: int
    group: str
    saturated: list[float]
    tracking_rms: list[float]
    torque_rms: list[list[float]]

    def record(self) -> dict[str, Any]:
        """Return the plant as JSON holds it."""
        return asdict(self)

    @classmethod
    def of(cls, record: dict[str, Any]) -> "Plant":
        """Return the plant of a record."""
        return cls(**{**record, "hidden": [Built(**each) for each in record["hidden"]]})


def recorded(
    case: HiddenCase, folder: Path, stretches: Stretches = FULL, *, keep: bool = False
) -> tuple[Recording, Recording, Plant]:
    """Hide the case's effects in the arm and record it twice.

    The study's folder keeps runs of the arm without effects; with `keep` the recordings, too, and
    those that are there are used.
    """
    return kept(folder, case.name, lambda: _record(case, folder, stretches), Plant.of, keep=keep)


class Recordable(Protocol):
    """The facts of a plant."""

    def record(self) -> dict[str, Any]:
        """Return them as JSON holds them."""


Facts = TypeVar("Facts", bound=Recordable)
Recorded: TypeAlias = tuple[Recording, Recording, Facts]


def kept(
    folder: Path,
    name: str,
    make: Callable[[], Recorded[Facts]],
    read: Callable[[dict[str, Any]], Facts],
    *,
    keep: bool,
) -> Recorded[Facts]:
    """Return two recordings and the facts of their plant: those that are kept, or what `make` does.

    Args:
        folder: of the study.
        name: of the case.
        make: records the plant.
        read: makes the facts of their record.
        keep: whether to keep what is made, and to use what was kept.
    """
    place = folder / "recordings" / name
    paths, about = [place / f"{number}.npz" for number in (1, 2)], place / "info.json"
    if keep and about.is_file():
        first, second = (load(path) for path in paths)
        return first, second, read(json.loads(about.read_text(encoding="utf-8")))
    first, second, facts = make()
    if keep:
        place.mkdir(parents=True, exist_ok=True)
        for path, each in zip(paths, (first, second), strict=True):
            write_npz(path, each, overwrite=True)
        text = json.dumps(facts.record(), indent=1, ensure_ascii=False)
        with whole(about) as made:
            made.write_text(text, encoding="utf-8")
    return first, second, facts


def _record(
    case: HiddenCase, folder: Path, stretches: Stretches
) -> tuple[Recording, Recording, Plant]:
    along = _along(case.motion, folder, stretches) if case.hidden else None

    def drive(number: int, parts: Sequence[Installed]) -> Run:
        reference, noise = motion(case.motion, number, stretches), case.seed + number
        return simulate(reference, **together(parts), seed=noise)

    runs, built = hide(case.hidden, case.seed, along, drive)
    saturated = [float(run.saturated.mean()) for run in runs]
    strayed = [float(np.sqrt(np.mean(run.tracking_error**2))) for run in runs]
    torque = [np.sqrt(np.mean(run.motor_torque**2, axis=0)).tolist() for run in runs]
    about = case.name, built, case.motion, case.seed, case.group
    plant = Plant(*about, saturated, strayed, torque)
    return runs[0].recording, runs[1].recording, plant


def hide(
    hidden: Sequence[Hidden],
    seed: int,
    along: Reference | None,
    drive: Callable[[int, Sequence[Installed]], Run],
    parameters: ArmParameters | None = None,
) -> tuple[list[Run], list[Built]]:
    """Hide effects in one arm and drive it once for each recording.

    Args:
        hidden: the effects, none or more.
        seed: of their random numbers.
        along: the run without them that they are sized along; None if there are none.
        drive: drives the arm with effects for recording 0 or 1.
        parameters: of the arm.

    Returns:
        The runs, and the effects as they were built.
    """
    arm = parameters or ArmParameters()
    runs: list[Run] = []
    facts: list[dict[str, float]] = []
    strengths: list[float] = []
    measured: list[list[tuple[float, float]]] = []
    for number in range(RECORDINGS):
        # One arm: both recordings are of what was built and sized along the first motion.
        sites = [
            (one, Site(JOINTS.index(one.joint), seed + 7919 * n, number, along, arm))
            for n, one in enumerate(hidden)
            if along is not None
        ]
        strengths = strengths or [sized(one.kind, site, one.size)[1] for one, site in sites]
        placed = [
            (one, site, one.kind.install(site, strength))
            for (one, site), strength in zip(sites, strengths, strict=True)
        ]
        parts = [part for _, _, part in placed]
        facts = facts or [dict(part.facts) for part in parts]
        runs.append(drive(number, parts))
        measured.append([_sizes(one, part, site, runs[-1]) for one, site, part in placed])
    built = [
        Built(
            **asdict(one),
            catalogue=list(one.kind.catalogue),
            joints=[JOINTS[j] for j in one.kind.acts_on(JOINTS.index(one.joint))],
            absorbed=one.kind.absorbed,
            physics=one.kind.physics,
            strength=strengths[n],
            facts=facts[n],
            reached=[sizes[n][0] for sizes in measured],
            visible=[sizes[n][1] for sizes in measured],
        )
        for n, one in enumerate(hidden)
    ]
    return runs, built


def _along(pair: int, folder: Path, stretches: Stretches) -> Reference:
    """Return the run of the first motion without effects, kept in the folder."""
    name = "_".join(f"{speed}x{seconds:g}" for speed, seconds in stretches.parts)
    path = folder / "motions" / f"{pair}_{name}.npz"
    if not path.is_file():
        reference = Reference.of(simulate(motion(pair, 0, stretches)))
        path.parent.mkdir(parents=True, exist_ok=True)
        # Several processes may make it at once: each whole, the last one stays.
        with whole(path) as made, made.open("wb") as file:
            np.savez(file, **vars(reference))
    with np.load(path, allow_pickle=False) as held:
        return Reference(**{key: held[key] for key in held})


def motion(pair: int, recording: int, stretches: Stretches = FULL) -> Trajectory:
    """Return the reference of recording 0 or 1 of a pair: its stretches, at rest between them."""
    seed = 100 + RECORDINGS * pair + recording
    time, columns, begin = [], [], 0.0
    for k, (speed, seconds) in enumerate(stretches.parts):
        part = exciting_trajectory(speed, seed, seconds)
        rows = slice(1 if k else 0, None)
        time.append(begin + part.time[rows] - part.time[0])
        columns.append((part.q[rows], part.qd[rows], part.qdd[rows]))
        begin = float(time[-1][-1])
    q, qd, qdd = (np.concatenate(column) for column in zip(*columns, strict=True))
    return Trajectory(np.concatenate(time), q, qd, qdd)


def _sizes(hidden: Hidden, part: Installed, site: Site, run: Run) -> tuple[float, float]:
    """Return the size of an effect in a run, and of what plain friction cannot imitate of it."""
    here = replace(site, along=Reference.of(run))
    whole = here.along.rms(here.along.motor)[site.joint]
    left = beyond_friction(hidden.kind, part, here)
    return size(hidden.kind, part, here), float(left / whole)
