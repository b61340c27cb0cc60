"""What the kernels of mechanical Lagrangians share: their numbers, and the loops they run in."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels.base import (
    CHUNK_ENTRIES,
    Contracted,
    DifferentiableKernel,
    Hyperparameter,
    LagrangianKernel,
    Learned,
    largest,
)
from lagrangian_ff.kernels.compiled import Prepared, prepared
from lagrangian_ff.kernels.states import States
from lagrangian_ff.kernels.structured import lanes, threads
from lagrangian_ff.kernels.structured.factors import LINE

Floats = NDArray[np.float64]
Self = TypeVar("Self", bound="Structured")

Parts = tuple[bool, bool]
Nudge = tuple[int, int, float]

ROTOR_START = 1e-3
KINETIC, POTENTIAL = (True, False), (False, True)
TILE_ENTRIES = 100_000
"""Entries of the Gram matrix whose derivatives are taken at once, so that they stay in cache."""


@dataclass(frozen=True)
class Structured(DifferentiableKernel, LagrangianKernel):
    """A kinetic part quadratic in velocity, a potential part, and rotors.

    Attributes:
        inertia: (N,) Λ, s²/rad² in the kernel's units: how much a joint's motion weighs.
        link: (N,) κ, the weight of each link's kinetic energy; (1,) where links are not told apart.
        potential: λ, likewise the weight of potential energy.
        wave: (N,) ω of the kinetic part's factors: how much it changes with each joint.
        swing: (N,) ω of the potential part's factors.
        rotor: (N,) ρ, the weight of rotors that turn with their own joint only.
        prismatic: (N,) 1 where a joint slides, 0 where it turns.
    """

    inertia: Floats
    link: Floats
    potential: Floats
    wave: Floats
    swing: Floats
    rotor: Floats
    prismatic: Floats

    quadratic: ClassVar[bool] = True
    form: ClassVar[int]
    serial: ClassVar[bool]
    searched: ClassVar[tuple[Hyperparameter, ...]] = (
        Hyperparameter("inertia", "s²/rad²", "Λ: weight of the joints' motion", 1e-3, 1e3),
        Hyperparameter("potential", "1", "λ: weight of potential energy", 1e-3, 1e3),
        Hyperparameter("wave", "1", "ω: how much inertia changes with the joints", 1e-2, 1e2),
        Hyperparameter("swing", "1", "ω: how much gravity changes with the joints", 1e-2, 1e2),
    )
    further: ClassVar[tuple[Hyperparameter, ...]] = (
        Hyperparameter("link", "1", "κ: weight of each link's kinetic energy", 1.0, 1.0),
        Hyperparameter("rotor", "1", "ρ: weight of the rotors' own inertia", 1.0, 1.0),
        Hyperparameter("prismatic", "", "1 where a joint slides", 1.0, 1.0),
    )
    differentiable: ClassVar[tuple[str, ...]] = (
        "inertia", "link", "potential", "wave", "swing", "rotor",
    )  # fmt: skip
    variances: ClassVar[tuple[str, ...]] = ("potential",)

    @classmethod
    def start(cls: type[Self], x: States) -> Self:
        """Every joint weighs as its velocity asks for, every link and its gravity alike."""
        joints = x.joints
        links = joints if cls.serial else 1
        return cls(
            inertia=np.array([1.0 / largest(x.qd[:, n]) ** 2 for n in range(joints)]),
            link=np.ones(links),
            potential=np.ones(links),
            wave=np.ones(joints),
            swing=np.ones(joints),
            rotor=np.full(joints, ROTOR_START),
            prismatic=np.zeros(joints),
        )

    @property
    def hyperparameters(self) -> Mapping[str, Floats]:
        """See `Kernel.hyperparameters`."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def replace(self: Self, **hyperparameters: Floats) -> Self:
        """See `Kernel.replace`."""
        return replace(self, **hyperparameters)

    def gram(self, x: States) -> Floats:
        """See `CoupledKernel.gram`."""
        out = np.empty((len(x), x.joints, len(x), x.joints))
        self._fill(prepared(x), prepared(x), lanes.LOWER, out)
        return out.reshape(len(x) * x.joints, -1)

    def cross(self, x: States, u: States) -> Floats:
        """See `CoupledKernel.cross`."""
        out = np.empty((len(x), x.joints, len(u), x.joints))
        self._fill(prepared(x), prepared(u), lanes.ALL, out)
        return out.reshape(len(x) * x.joints, -1)

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        """See `Kernel.apply`; in chunks, so that memory stays bounded."""
        return BlockSum(self, prepared(u), np.ravel(a)).torque(x)

    def learned(self, u: States, a: Floats) -> Learned:
        """See `Kernel.learned`."""
        return BlockSum(self, prepared(u), np.ravel(a))

    def variance(self, x: States) -> Floats:
        """See `Kernel.variance`."""
        out = np.empty((len(x), x.joints, 1, x.joints))
        self._write(prepared(x), prepared(x), (0, len(x)), lanes.DIAGONAL, out)
        return np.ascontiguousarray(np.einsum("nmjm->nm", out))

    def lagrangian(self, x: States, u: States, a: Floats) -> Floats:
        """See `LagrangianKernel.lagrangian`: kinetic energy ½ qd·p, and the potential part."""
        out, weights = np.empty(len(x)), np.ascontiguousarray(a)
        lanes.write_potential(prepared(x), prepared(u), self._numbers(), weights, out)
        return out + 0.5 * np.sum(x.qd * self.momentum(x, u, a), axis=1)

    def momentum(self, x: States, u: States, a: Floats) -> Floats:
        """See `LagrangianKernel.momentum`: M(q) qd is what qdd = qd adds to the torque at rest."""
        moved = States(x.q, np.zeros_like(x.q), x.qd)
        return self.apply(moved, u, a) - self.apply(x.at_rest(), u, a)

    def contract(self, x: States, weights: Floats, vector: Floats) -> Mapping[str, Contracted]:
        """See `DifferentiableKernel.contract`.

        K is linear in link, potential and rotor and in each factor of the potential part, and of
        second degree in each inertia and in each factor of the kinetic part: a value, or half the
        difference of two at any distance, is the derivative itself.
        """
        states, changes = prepared(x), [*self._changes()]
        height = max(1, TILE_ENTRIES // (len(vector) * x.joints))
        tiles = range(0, len(x), height)
        # As many heaps of tiles as threads, so that each holds what it adds up.
        heaps = [tiles[start :: threads.count()] for start in range(threads.count())]

        def contracted(heap: range) -> Mapping[str, Contracted]:
            found = {}
            for name in self.differentiable:
                count = len(getattr(self, name))
                found[name] = Contracted(np.zeros(count), np.zeros((count, len(vector))))
            for first in heap:
                rows = first, min(len(x), first + height)
                tile = _Tile.of(weights, vector, rows, x.joints)
                out = np.zeros((rows[1] - rows[0], x.joints, rows[1], x.joints))
                for one in changes:
                    one.kernel._write(states, states, rows, lanes.LOWER, out, one.parts, one.nudge)
                    into = found[one.name]
                    tile.add(out, one.factor, into.total, into.product[one.place], one.place)
            return found

        found = threads.each(contracted, heaps, len(x) ** 2)
        return {
            name: Contracted(
                np.sum([one[name].total for one in found], axis=0),
                np.sum([one[name].product for one in found], axis=0),
            )
            for name in self.differentiable
        }

    def _changes(self: Self) -> "Iterator[_Change[Self]]":
        """The kernels whose weighed sum is the derivative by each hyperparameter."""
        none = {name: np.zeros_like(getattr(self, name)) for name in ("potential", "rotor")}
        bare = self.replace(**none)
        for place, one in enumerate(np.eye(len(self.link))):
            yield _Change("link", place, 1.0, bare.replace(link=one), KINETIC)
            yield _Change("potential", place, 1.0, bare.replace(potential=one), POTENTIAL)
        for joint, one in enumerate(np.eye(len(self.rotor))):
            yield _Change("rotor", joint, 1.0, self.replace(rotor=one), (False, False))
            for sign in (1.0, -1.0):
                inertia = self.inertia * (1.0 + 0.5 * sign * one)
                moved = self.replace(inertia=inertia)
                yield _Change("inertia", joint, sign / self.inertia[joint], moved, KINETIC)
                swing = lanes.SWING, joint, 0.5 * sign
                still = self.replace(rotor=none["rotor"])
                yield _Change("swing", joint, sign, still, POTENTIAL, swing)
                if joint > 0 or not self.serial:
                    wave = lanes.WAVE, joint, 0.5 * sign
                    yield _Change("wave", joint, sign, bare, KINETIC, wave)

    def _fill(self, x: Prepared, u: Prepared, pairs: int, out: Floats) -> None:
        """Write all rows, in as many threads as there may be."""
        samples = len(x[0])

        def write(rows: tuple[int, int]) -> None:
            self._write(x, u, rows, pairs, out[slice(*rows)])

        ranges = threads.row_ranges(samples, pairs == lanes.LOWER)
        threads.each(write, ranges, samples * len(u[0]))

    def _write(
        self,
        x: Prepared,
        u: Prepared,
        rows: tuple[int, int],
        pairs: int,
        out: Floats,
        parts: Parts = (True, True),
        nudge: Nudge = (lanes.NOTHING, 0, 0.0),
    ) -> None:
        """See `lanes.write_blocks`; out begins with the first of the rows."""
        lanes.write_blocks(x, u, rows, rows[0], pairs, self._numbers(), parts, nudge, out)

    def _numbers(self) -> tuple[Any, ...]:
        joints = len(self.inertia)
        links = np.zeros((2, joints))
        for held, value in zip(links, (self.link, self.potential), strict=True):
            held[joints - len(value) :] = value
        form = np.where(self.prismatic > 0.0, LINE, self.form)
        others = (self.wave, self.swing, self.rotor)
        return self.serial, form, self.inertia, links[0], links[1], *others


@dataclass(frozen=True)
class BlockSum(Learned):
    """A sum over states: blocks, some rows at a time, times coefficients (M_u N,)."""

    kernel: Structured
    u: Prepared
    a: Floats

    def torque(self, x: States) -> Floats:
        """See `Learned.torque`."""
        torque = np.empty((len(x), x.joints))
        chunk = max(1, CHUNK_ENTRIES // max(1, self.a.size * x.joints))
        out = np.empty((min(chunk, len(x)), x.joints, len(self.u[0]), x.joints))
        for first in range(0, len(x), chunk):
            part = x.take(slice(first, first + chunk))
            held = out[: len(part)]
            self.kernel._fill(prepared(part), self.u, lanes.ALL, held)
            torque[first : first + chunk] = (held.reshape(-1, self.a.size) @ self.a).reshape(
                -1, x.joints
            )
        return torque


@dataclass(frozen=True)
class _Change(Generic[Self]):
    """A kernel whose weighed sum is, times the factor, a part of a derivative.

    Attributes:
        name, place: by which number.  factor: of the sum.
        kernel: with changed numbers.  parts, nudge: see `lanes.write_blocks`.
    """

    name: str
    place: int
    factor: float
    kernel: Self
    parts: Parts
    nudge: Nudge = (lanes.NOTHING, 0, 0.0)


@dataclass(frozen=True)
class _Tile:
    """Some rows of a symmetric matrix, up to the diagonal, and what they are contracted with.

    Attributes:
        start: the first row.  weights: (R, C) those of pairs below the diagonal doubled.
        left, right: (R,) and (C,) the vector's part along rows and columns.
    """

    start: int
    weights: Floats
    left: Floats
    right: Floats

    @classmethod
    def of(cls, weights: Floats, vector: Floats, rows: tuple[int, int], joints: int) -> "_Tile":
        start, stop = rows[0] * joints, rows[1] * joints
        lower = np.tril(weights[start:stop, :stop], start - 1)
        part = 2.0 * lower
        part[:, start:] += np.diag(np.diag(weights)[start:stop])
        # Blocks on the diagonal come whole: what stands above it there is counted with it.
        for first in range(0, stop - start, joints):
            here, there = slice(first, first + joints), slice(start + first, start + first + joints)
            below = lower[here, there]
            part[here, there] += below.T - below
        return cls(start, part, vector[start:stop], vector[:stop])

    def add(self, out: Floats, factor: float, total: Floats, product: Floats, place: int) -> None:
        """Add a factor of the tile's contractions, given its blocks up to the diagonal."""
        rows = len(self.left)
        joints = out.shape[1]
        whole = out.reshape(rows, -1)
        total[place] += factor * np.vdot(self.weights, whole)
        product[self.start : self.start + rows] += factor * (whole @ self.right)
        mirrored = self.left @ whole
        # Samples paired with themselves have no mirror image.
        for first in range(0, rows, joints):
            here = slice(first, first + joints)
            there = slice(self.start + first, self.start + first + joints)
            mirrored[there] -= self.left[here] @ whole[here, there]
        product[: len(mirrored)] += factor * mirrored
