"""The cases of the study: arms with hidden effects, and two recordings of each."""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lagrangian_ff.arm import JOINTS, Run, Trajectory, exciting_trajectory, simulate
from lagrangian_ff.arm.hidden import HIDDEN, HiddenEffect, Installed, Reference, Site, size, sized
from lagrangian_ff.arm.hidden.base import together
from lagrangian_ff.files import whole
from lagrangian_ff.recording import load, write_npz
from lagrangian_ff.recording.recording import Recording

SIZES = (0.02, 0.05, 0.10, 0.20)
MOTIONS = 3
"""Pairs of motions that the cases share."""
PAIRS = (
    ("stribeck", "ripple"),
    ("load_friction", "delay"),
    ("warm_up", "quadratic_drag"),
    ("position_friction", "hysteresis"),
    ("asymmetric_viscous", "payload"),
    ("coupled", "gear_mesh"),
)
FULL_CLEAN, SMALL_CLEAN = 40, 4
FULL_JOINTS, OUTSIDE_JOINTS = 3, 2
RECORDINGS = 2


@dataclass(frozen=True)
class Hidden:
    """One effect to hide.

    Attributes:
        effect: its name in `lagrangian_ff.arm.hidden.HIDDEN`.
        joint: the name of the joint it acts on, or where its size is measured.
        size: RMS of its torque over RMS of that joint's motor torque.
    """

    effect: str
    joint: str
    size: float

    @property
    def kind(self) -> HiddenEffect:
        """Return the physics."""
        return HIDDEN[self.effect]


@dataclass(frozen=True)
class HiddenCase:
    """One plant and two recordings of it.

    Attributes:
        name: unique in the study.
        hidden: the effects in the plant: none, one or two.
        motion: index of the pair of motions that it makes, 0 to MOTIONS − 1.
        seed: of the noise and of the effects' random numbers.
    """

    name: str
    hidden: tuple[Hidden, ...]
    motion: int
    seed: int

    @property
    def group(self) -> str:
        """Return `clean`, `alone`, `pair` or `outside` (of the catalogue)."""
        if not self.hidden:
            return "clean"
        if not all(hidden.kind.catalogue for hidden in self.hidden):
            return "outside"
        return "alone" if len(self.hidden) == 1 else "pair"


def cases(seed: int = 0, *, small: bool = False) -> list[HiddenCase]:
    """Return all cases of the study, or a few if `small`, the same for the same seed.

    The most telling come first, so that a study that is stopped early has some of each kind: clean
    plants, then each effect by size from 10 % on.
    """
    found = list((_small if small else _full)(_Maker(seed)))
    assert len({case.name for case in found}) == len(found)
    return found


def _full(make: "_Maker") -> Iterator[HiddenCase]:
    clean = FULL_CLEAN // len(SIZES)
    alone = {name: make.joints(kind, FULL_JOINTS) for name, kind in HIDDEN.items()}
    for size_ in (0.10, 0.05, 0.20, 0.02):
        for k in range(clean):
            yield make.clean(k + clean * SIZES.index(size_))
        for name, joints in alone.items():
            count = FULL_JOINTS if HIDDEN[name].catalogue else OUTSIDE_JOINTS
            for joint in joints[: count if size_ <= HIDDEN[name].largest else 0]:
                yield make.alone(name, joint, size_)
    for size_ in (0.10, 0.20):
        for first, second in PAIRS:
            yield make.pair(first, second, size_)


def _small(make: "_Maker") -> Iterator[HiddenCase]:
    for k in range(SMALL_CLEAN):
        yield make.clean(k)
    for name in ("ripple", "quadratic_drag", "stribeck", "position_friction", "pitting"):
        yield make.alone(name, "joint_2", 0.20)
    yield make.pair("ripple", "quadratic_drag", 0.20)


class _Maker:
    def __init__(self, seed: int) -> None:
        self._seed = seed

    def joints(self, kind: HiddenEffect, count: int) -> list[str]:
        """Return joints for an effect, the arm's and the wrist's in turn."""
        random = self._random("joints", kind.name)
        large = [j for j in kind.joints if j < 3]
        small = [j for j in kind.joints if j >= 3]
        for half in (large, small):
            random.shuffle(half)
        turns = [j for pair in zip(large, small, strict=False) for j in pair]
        turns += [*large[len(small) :], *small[len(large) :]]
        return [JOINTS[j] for j in turns[:count]]

    def clean(self, number: int) -> HiddenCase:
        """Return a plant without effects."""
        return self._case(f"clean-{number:02d}", ())

    def alone(self, effect: str, joint: str, size_: float) -> HiddenCase:
        """Return a plant with one effect."""
        return self._case(f"{effect}-{joint}-{_percent(size_)}", (Hidden(effect, joint, size_),))

    def pair(self, first: str, second: str, size_: float) -> HiddenCase:
        """Return a plant with two effects, on joints that the seed draws."""
        random = self._random("pair", first, second)
        both = [
            Hidden(name, JOINTS[int(random.choice(HIDDEN[name].joints))], size_)
            for name in (first, second)
        ]
        where = "-".join(f"{hidden.effect}-{hidden.joint}" for hidden in both)
        return self._case(f"pair-{where}-{_percent(size_)}", tuple(both))

    def _case(self, name: str, hidden: tuple[Hidden, ...]) -> HiddenCase:
        # The same physics at every size: seed and motion follow from effect and joint alone.
        stem = name.rpartition("-")[0] if hidden else name
        random = self._random("case", stem)
        return HiddenCase(name, hidden, int(random.integers(MOTIONS)), int(random.integers(2**31)))

    def _random(self, *words: str) -> np.random.Generator:
        """Return random numbers for one use, so that a case stays the same when others join."""
        text = [int.from_bytes(word.encode(), "little") for word in words]
        return np.random.default_rng([self._seed, *text])


def _percent(size_: float) -> str:
    return f"{100.0 * size_:02.0f}"


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
    place = folder / "recordings" / case.name
    paths, about = [place / f"{number}.npz" for number in (1, 2)], place / "info.json"
    if keep and about.is_file():
        first, second = (load(path) for path in paths)
        return first, second, Plant.of(json.loads(about.read_text(encoding="utf-8")))
    first, second, plant = _record(case, folder, stretches)
    if keep:
        place.mkdir(parents=True, exist_ok=True)
        for path, each in zip(paths, (first, second), strict=True):
            write_npz(path, each)
        text = json.dumps(plant.record(), indent=1, ensure_ascii=False)
        with whole(about) as made:
            made.write_text(text, encoding="utf-8")
    return first, second, plant


def _record(
    case: HiddenCase, folder: Path, stretches: Stretches
) -> tuple[Recording, Recording, Plant]:
    along = _along(case.motion, folder, stretches) if case.hidden else None
    runs: list[Run] = []
    facts: list[dict[str, float]] = []
    strengths: list[float] = []
    measured: list[list[tuple[float, float]]] = []
    for number in range(RECORDINGS):
        # One arm: both recordings are of what was built and sized along the first motion.
        sites = [
            (hidden, Site(JOINTS.index(hidden.joint), case.seed + 7919 * n, number, along))
            for n, hidden in enumerate(case.hidden)
            if along is not None
        ]
        strengths = strengths or [
            sized(hidden.kind, site, hidden.size)[1] for hidden, site in sites
        ]
        placed = [
            (hidden, site, hidden.kind.install(site, strength))
            for (hidden, site), strength in zip(sites, strengths, strict=True)
        ]
        parts = [part for _, _, part in placed]
        facts = facts or [dict(part.facts) for part in parts]
        reference, noise = motion(case.motion, number, stretches), case.seed + number
        run = simulate(reference, **together(parts), seed=noise)
        runs.append(run)
        measured.append([_sizes(hidden, part, site, run) for hidden, site, part in placed])
    built = [
        Built(
            **asdict(hidden),
            catalogue=list(hidden.kind.catalogue),
            joints=[JOINTS[j] for j in hidden.kind.acts_on(JOINTS.index(hidden.joint))],
            absorbed=hidden.kind.absorbed,
            physics=hidden.kind.physics,
            strength=strengths[n],
            facts=facts[n],
            reached=[sizes[n][0] for sizes in measured],
            visible=[sizes[n][1] for sizes in measured],
        )
        for n, hidden in enumerate(case.hidden)
    ]
    saturated = [float(run.saturated.mean()) for run in runs]
    strayed = [float(np.sqrt(np.mean(run.tracking_error**2))) for run in runs]
    torque = [np.sqrt(np.mean(run.motor_torque**2, axis=0)).tolist() for run in runs]
    about = case.name, built, case.motion, case.seed, case.group
    plant = Plant(*about, saturated, strayed, torque)
    return runs[0].recording, runs[1].recording, plant


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
    """Return the size of an effect in a run, and of what plain friction leaves of it."""
    here = Site(site.joint, site.seed, site.recording, Reference.of(run))
    torque = hidden.kind.torque(part, here)[:, site.joint]
    v = run.velocity[:, site.joint]
    plain = np.stack([v, np.tanh(v / 0.02), np.ones_like(v)], axis=1)
    left = torque - plain @ np.linalg.lstsq(plain, torque, rcond=None)[0]
    whole = np.sqrt(np.mean(run.motor_torque[:, site.joint] ** 2))
    return size(hidden.kind, part, here), float(np.sqrt(np.mean(left**2)) / whole)
