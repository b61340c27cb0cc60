"""The cases of the study: which effect is hidden where, and how large it is."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arm import JOINTS
from lagrangian_ff.arm.hidden import HIDDEN, HiddenEffect

SIZES = (0.02, 0.05, 0.10, 0.20)
MOTIONS = 3
"""Pairs of motions that the cases share among them."""

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
    """One hidden effect.

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
        """The physics."""
        return HIDDEN[self.effect]


@dataclass(frozen=True)
class Case:
    """One plant and two recordings of it.

    Attributes:
        name: unique in the study; the key under which its result is kept.
        hidden: what is hidden in the plant: nothing, one effect or two.
        motion: which pair of motions is driven, 0 to MOTIONS − 1.
        seed: of the noise and of what chance decides about the effects.
    """

    name: str
    hidden: tuple[Hidden, ...]
    motion: int
    seed: int

    @property
    def group(self) -> str:
        """`clean`, `alone`, `pair` or `outside` (of the catalogue)."""
        if not self.hidden:
            return "clean"
        if not all(hidden.kind.catalogue for hidden in self.hidden):
            return "outside"
        return "alone" if len(self.hidden) == 1 else "pair"


def cases(seed: int = 0, *, small: bool = False) -> list[Case]:
    """All cases of the study, the same for the same seed.

    Args:
        seed: of the joints that are drawn and of the cases' own seeds.
        small: a few cases, to see the study work.

    Returns:
        The most telling first, so that a study that is stopped early has something of everything:
        clean plants, then each effect by size from 10 % on.
    """
    found = list(_small(seed) if small else _full(seed))
    names = [case.name for case in found]
    assert len(set(names)) == len(names)
    return found


def _full(seed: int) -> Iterator[Case]:
    make = _Maker(seed)
    alone = {name: make.joints(kind, FULL_JOINTS) for name, kind in HIDDEN.items()}
    for size in (0.10, 0.05, 0.20, 0.02):
        for k in range(FULL_CLEAN // len(SIZES)):
            yield make.clean(k + FULL_CLEAN // len(SIZES) * SIZES.index(size))
        for name, joints in alone.items():
            count = FULL_JOINTS if HIDDEN[name].catalogue else OUTSIDE_JOINTS
            for joint in joints[: count if size <= HIDDEN[name].largest else 0]:
                yield make.alone(name, joint, size)
    for size in (0.10, 0.20):
        for first, second in PAIRS:
            yield make.pair(first, second, size)


def _small(seed: int) -> Iterator[Case]:
    make = _Maker(seed)
    for k in range(SMALL_CLEAN):
        yield make.clean(k)
    for name in ("ripple", "quadratic_drag", "stribeck", "position_friction", "pitting"):
        yield make.alone(name, "joint_2", 0.20)
    yield make.pair("ripple", "quadratic_drag", 0.20)


class _Maker:
    def __init__(self, seed: int) -> None:
        self._seed = seed

    def joints(self, kind: HiddenEffect, count: int) -> list[str]:
        """Joints for an effect, the arm's and the wrist's in turn."""
        random = self._random("joints", kind.name)
        large = [j for j in kind.joints if j < 3]
        small = [j for j in kind.joints if j >= 3]
        for half in (large, small):
            random.shuffle(half)
        turns = [j for pair in zip(large, small, strict=False) for j in pair]
        turns += [*large[len(small) :], *small[len(large) :]]
        return [JOINTS[j] for j in turns[:count]]

    def clean(self, number: int) -> Case:
        """A plant as described."""
        return self._case(f"clean-{number:02d}", ())

    def alone(self, effect: str, joint: str, size: float) -> Case:
        """One effect."""
        return self._case(f"{effect}-{joint}-{_percent(size)}", (Hidden(effect, joint, size),))

    def pair(self, first: str, second: str, size: float) -> Case:
        """Two effects on two joints, or on one, as the seed has it."""
        random = self._random("pair", first, second)
        both = [
            Hidden(name, JOINTS[int(random.choice(HIDDEN[name].joints))], size)
            for name in (first, second)
        ]
        where = "-".join(f"{hidden.effect}-{hidden.joint}" for hidden in both)
        return self._case(f"pair-{where}-{_percent(size)}", tuple(both))

    def _case(self, name: str, hidden: tuple[Hidden, ...]) -> Case:
        # The same physics at every size: seed and motion follow from effect and joint alone.
        stem = name.rpartition("-")[0] if hidden else name
        random = self._random("case", stem)
        return Case(name, hidden, int(random.integers(MOTIONS)), int(random.integers(2**31)))

    def _random(self, *words: str) -> np.random.Generator:
        """Chance of its own for each use, so that a case stays as it is when others are added."""
        text = [int.from_bytes(word.encode(), "little") for word in words]
        return np.random.default_rng([self._seed, *text])


def _percent(size: float) -> str:
    return f"{100.0 * size:02.0f}"
