"""The cases of the study: which effects are hidden, where, and how large."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arm import JOINTS
from lagrangian_ff.arm.hidden import HIDDEN, HiddenEffect

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
        return self._case(f"{effect}-{joint}-{percent(size_)}", (Hidden(effect, joint, size_),))

    def pair(self, first: str, second: str, size_: float) -> HiddenCase:
        """Return a plant with two effects, on joints that the seed draws."""
        random = self._random("pair", first, second)
        both = [
            Hidden(name, JOINTS[int(random.choice(HIDDEN[name].joints))], size_)
            for name in (first, second)
        ]
        where = "-".join(f"{hidden.effect}-{hidden.joint}" for hidden in both)
        return self._case(f"pair-{where}-{percent(size_)}", tuple(both))

    def _case(self, name: str, hidden: tuple[Hidden, ...]) -> HiddenCase:
        # The same physics at every size: seed and motion follow from effect and joint alone.
        stem = name.rpartition("-")[0] if hidden else name
        random = self._random("case", stem)
        return HiddenCase(name, hidden, int(random.integers(MOTIONS)), int(random.integers(2**31)))

    def _random(self, *words: str) -> np.random.Generator:
        """Return random numbers for one use, so that a case stays the same when others join."""
        text = [int.from_bytes(word.encode(), "little") for word in words]
        return np.random.default_rng([self._seed, *text])


def percent(size_: float) -> str:
    """Return a size as names have it, such as 05."""
    return f"{100.0 * size_:02.0f}"
