"""What the kernels of mechanical Lagrangians share: their numbers, and the loops they run in."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels import threads
from lagrangian_ff.kernels.base import (
    CHUNK_ENTRIES,
    Contracted,
    DifferentiableKernel,
    Hyperparameter,
    LagrangianKernel,
    Learned,
    largest,
)
from lagrangian_ff.kernels.states import States, prepared
from lagrangian_ff.kernels.structured.slopes import slopes
from lagrangian_ff.loops import loop

Floats = NDArray[np.float64]
Self = TypeVar("Self", bound="Structured")

ROTOR_START = 1e-3

COSINE, BELL, LINE = 0, 1, 2
"""Forms of a joint's factor; see `structured.c`."""
ALL, LOWER, DIAGONAL = 0, 1, 2
"""Which pairs: each with each, each with those up to itself, or each with itself."""


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
        states = prepared(x)
        self._fill(states, states, LOWER, out)
        return out.reshape(len(x) * x.joints, -1)

    def cross(self, x: States, u: States) -> Floats:
        """See `CoupledKernel.cross`."""
        out = np.empty((len(x), x.joints, len(u), x.joints))
        self._fill(prepared(x), prepared(u), ALL, out)
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
        states = prepared(x)
        self._write(states, states, slice(0, len(x)), DIAGONAL, out)
        return np.ascontiguousarray(np.einsum("nmjm->nm", out))

    def lagrangian(self, x: States, u: States, a: Floats) -> Floats:
        """See `LagrangianKernel.lagrangian`: kinetic energy ½ qd·p, and the potential part."""
        out, weights = np.empty(len(x)), np.ascontiguousarray(a)
        states = prepared(x), len(x), prepared(u), len(u)
        loop("structured_potential")(*self._numbers(), *states, weights, out)
        return out + 0.5 * np.sum(x.qd * self.momentum(x, u, a), axis=1)

    def momentum(self, x: States, u: States, a: Floats) -> Floats:
        """See `LagrangianKernel.momentum`: M(q) qd is what qdd = qd adds to the torque at rest."""
        moved = States(x.q, np.zeros_like(x.q), x.qd)
        return self.apply(moved, u, a) - self.apply(x.at_rest(), u, a)

    def contract(self, x: States, weights: Floats, vector: Floats) -> Mapping[str, Contracted]:
        """See `DifferentiableKernel.contract`: sums of what pieces of the kernel do."""
        pieces, sums = slopes(self)
        whats = np.array([(one.kind, *one.joints, one.moved) for one in pieces], dtype=np.int64)
        inertias, shares = (
            np.array([getattr(one, name) for one in pieces]) for name in ("inertia", "share")
        )
        numbers, given = self._numbers(), (len(pieces), whats, inertias, shares, weights, vector)
        states, many = prepared(x), threads.count()

        def contracted(first: int) -> tuple[Floats, Floats]:
            totals, products = np.zeros(len(pieces)), np.zeros((len(pieces), *x.q.T.shape))
            rows = np.array([first, many])
            loop("structured_contract")(*numbers, states, len(x), rows, *given, totals, products)
            return totals, products

        found = threads.each(contracted, range(many), len(x) ** 2)
        totals = np.sum([one[0] for one in found], axis=0)
        products = np.sum([one[1] for one in found], axis=0).transpose(0, 2, 1)
        flat = products.reshape(len(pieces), -1)
        return {name: Contracted(sums[name] @ totals, sums[name] @ flat) for name in sums}

    def _fill(self, x: Floats, u: Floats, pairs: int, out: Floats) -> None:
        """Write the blocks of all rows, in as many threads as there may be."""

        def write(rows: slice) -> None:
            self._write(x, u, rows, pairs, out[rows])

        threads.over_rows(write, len(x), len(x) * len(u), lower=pairs == LOWER)

    def _write(self, x: Floats, u: Floats, rows: slice, pairs: int, out: Floats) -> None:
        """Write the blocks of some rows to out, which begins with the first of them."""
        ends = np.array([rows.start, rows.stop])
        loop("structured_blocks")(*self._numbers(), x, u, ends, len(u), pairs, out)

    def _numbers(self) -> tuple[int, int, NDArray[np.int64], Floats]:
        """Joints, whether serial, forms, and the (6, N) numbers of `Arm` in `structured.h`."""
        joints = len(self.inertia)
        links = np.zeros((2, joints))
        for held, value in zip(links, (self.link, self.potential), strict=True):
            held[joints - len(value) :] = value
        form = np.where(self.prismatic > 0.0, LINE, self.form).astype(np.int64)
        numbers = np.stack([self.inertia, *links, self.wave, self.swing, self.rotor])
        return joints, int(self.serial), form, numbers


@dataclass(frozen=True)
class BlockSum(Learned):
    """A sum over states: blocks, some rows at a time, times coefficients (M_u N,)."""

    kernel: Structured
    u: Floats
    a: Floats

    def torque(self, x: States) -> Floats:
        """See `Learned.torque`."""
        torque = np.empty((len(x), x.joints))
        chunk = max(1, CHUNK_ENTRIES // max(1, self.a.size * x.joints))
        out = np.empty((min(chunk, len(x)), x.joints, len(self.u), x.joints))
        for first in range(0, len(x), chunk):
            part = x.take(slice(first, first + chunk))
            held = out[: len(part)]
            self.kernel._fill(prepared(part), self.u, ALL, held)
            torque[first : first + chunk] = (held.reshape(-1, self.a.size) @ self.a).reshape(
                -1, x.joints
            )
        return torque
