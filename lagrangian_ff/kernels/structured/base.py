"""The base of kernels of mechanical Lagrangians, and its derivatives by its hyperparameters.

K is linear in link, potential and rotor: the derivative by one of them is the kernel with this one
alone, of the joints up to it. K is affine in every joint's factor, whose square is linearised (see
`serial.c`): the derivative by ω is K with the factor moved along its own derivative, less K. And K
is a quadratic form Σ_jk Λ_j Λ_k B_jk of the inertias: with S_j the form of the joints from j on
alone, and P_j that of the joints up to j,

    Λ_j ∂K/∂Λ_j = S_j − S_{j+1} + P_j − P_{j−1}.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar, TypeVar

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.kernels import threads
from lagrangian_ff.kernels.base import (
    CHUNK_ENTRIES,
    Contracted,
    DifferentiableKernel,
    Hyperparameter,
    LagrangianKernel,
    Learned,
    chunks,
    largest,
)
from lagrangian_ff.kernels.states import States, prepared
from lagrangian_ff.loops import loop

Self = TypeVar("Self", bound="Structured")

ROTOR_START = 1e-3

COSINE, BELL, LINE = 0, 1, 2
"""Forms of a joint's factor; see `structured.c`."""
ALL, LOWER, DIAGONAL = 0, 1, 2
"""Pairs: each with each, each with those up to itself, or each with itself."""
KINETIC, POTENTIAL, ROTOR = 0, 1, 2
"""The parts of the kernel; a rotor's is qdd qdd' of one joint."""
STAYS = -1
"""Stands for a joint if no factor is moved."""


@dataclass(frozen=True)
class Structured(DifferentiableKernel, LagrangianKernel):
    """A kinetic part quadratic in velocity, a potential part, and rotors.

    Attributes:
        inertia: (N,) Λ, s²/rad² in the kernel's units: how much a joint's motion weighs.
        link: (N,) κ, the weight of each link's kinetic energy; (1,) if all links share one.
        potential: λ, likewise the weight of potential energy; 0 where the torque has no gravity.
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

    quadratic = True
    separates = True
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
    differentiable = ("inertia", "link", "potential", "wave", "swing", "rotor")
    variances: ClassVar[tuple[str, ...]] = ("potential",)

    @classmethod
    def start(cls: type[Self], x: States) -> Self:
        """Return inertias that bring each velocity to 1, and equal weights of all links."""
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

    def without_gravity(self: Self) -> Self:
        return self.replace(potential=np.zeros_like(self.potential))

    def gram(self, x: States) -> Floats:
        out = np.empty((len(x), x.joints, len(x), x.joints))
        states = prepared(x)
        self._fill(states, states, LOWER, out)
        return out.reshape(len(x) * x.joints, -1)

    def cross(self, x: States, u: States) -> Floats:
        out = np.empty((len(x), x.joints, len(u), x.joints))
        self._fill(prepared(x), prepared(u), ALL, out)
        return out.reshape(len(x) * x.joints, -1)

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        return self.learned(u, a).torque(x)

    def learned(self, u: States, a: Floats) -> Learned:
        return BlockSum(self, prepared(u), np.ravel(a))

    def variance(self, x: States) -> Floats:
        out = np.empty((len(x), x.joints, 1, x.joints))
        states = prepared(x)
        self._write(states, states, slice(0, len(x)), DIAGONAL, out)
        return np.ascontiguousarray(np.einsum("nmjm->nm", out))

    def lagrangian(self, x: States, u: States, a: Floats) -> Floats:
        # Kinetic energy ½ qd·p, and the potential part.
        out, weights = np.empty(len(x)), np.ascontiguousarray(a)
        states = prepared(x), len(x), prepared(u), len(u)
        loop("structured_potential")(*self.numbers(), *states, weights, out)
        return out + 0.5 * np.sum(x.qd * self.momentum(x, u, a), axis=1)

    def momentum(self, x: States, u: States, a: Floats) -> Floats:
        # M(q) qd is what qdd = qd adds to the torque at rest.
        moved = States(x.q, np.zeros_like(x.q), x.qd)
        return self.apply(moved, u, a) - self.apply(x.at_rest(), u, a)

    def contract(self, x: States, weights: Floats, vector: Floats) -> Mapping[str, Contracted]:
        pieces, sums = derivatives(self)
        whats = np.array([(one.kind, *one.joints, one.moved) for one in pieces], dtype=np.int64)
        inertias, shares = (
            np.array([getattr(one, name) for one in pieces]) for name in ("inertia", "share")
        )
        numbers, given = self.numbers(), (len(pieces), whats, inertias, shares, weights, vector)
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
        """Write the blocks of all rows, in threads."""

        def write(rows: slice) -> None:
            self._write(x, u, rows, pairs, out[rows])

        threads.over_rows(write, len(x), len(x) * len(u), lower=pairs == LOWER)

    def _write(self, x: Floats, u: Floats, rows: slice, pairs: int, out: Floats) -> None:
        """Write the blocks of some rows to out, which begins with the first of them."""
        ends = np.array([rows.start, rows.stop])
        loop("structured_blocks")(*self.numbers(), x, u, ends, len(u), pairs, out)

    def numbers(self) -> tuple[int, int, Ints, Floats]:
        """Return joints, whether serial, forms, and (6, N) numbers of `Arm` in `structured.h`."""
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
        torque = np.empty((len(x), x.joints))
        chunk = max(1, CHUNK_ENTRIES // max(1, self.a.size * x.joints))
        out = np.empty((min(chunk, len(x)), x.joints, len(self.u), x.joints))
        for rows in chunks(len(x), chunk):
            part = x.take(rows)
            held = out[: len(part)]
            self.kernel._fill(prepared(part), self.u, ALL, held)
            torque[rows] = (held.reshape(-1, self.a.size) @ self.a).reshape(-1, x.joints)
        return torque


@dataclass(frozen=True)
class Piece:
    """One part of a kernel with other hyperparameters, of some of the joints.

    Attributes:
        kind: KINETIC, POTENTIAL or ROTOR.
        joints: the first, and the one after the last.
        inertia: (N,) Λ.
        share: (N,) κ or λ of the links.
        moved: the joint whose factor takes a step of 1 + ω along its derivative by ω, or STAYS.
    """

    kind: int
    joints: tuple[int, int]
    inertia: Floats
    share: Floats
    moved: int = STAYS


def derivatives(kernel: Structured) -> tuple[list[Piece], dict[str, Floats]]:
    """Return E pieces of a kernel, and by name (K, E) their weights in K derivatives."""
    count, inertia, serial = len(kernel.inertia), kernel.inertia, kernel.serial
    every, joints, links = (0, count), range(count), range(count - len(kernel.link), count)
    # No mass of a serial arm depends on its first joint.
    turning = joints[1:] if serial else joints
    index, alone = np.arange(count), np.eye(count)
    link, potential = kernel.link @ alone[links], kernel.potential @ alone[links]
    pieces: list[Piece] = []

    def put(more: Iterable[Piece]) -> slice:
        before = len(pieces)
        pieces.extend(more)
        return slice(before, len(pieces))

    linked = put(Piece(KINETIC, (0, i + 1), inertia, alone[i]) for i in links)
    waved = put(Piece(KINETIC, every, inertia, link, n) for n in turning)
    up_to = put(Piece(KINETIC, every, inertia * (index <= j), link) for j in joints[:-1])
    # In a serial arm the joints from j on do not depend on those before.
    from_on = put(
        Piece(KINETIC, (j if serial else 0, count), inertia * (index >= j), link)
        for j in joints[1:]
    )
    weighed = put(Piece(POTENTIAL, (0, i + 1), inertia, alone[i]) for i in links)
    swung = put(Piece(POTENTIAL, every, inertia, potential, n) for n in joints)
    turned = put(Piece(ROTOR, (n, n + 1), inertia, link) for n in joints)

    one = np.eye(len(pieces))
    kinetic, height = kernel.link @ one[linked], kernel.potential @ one[weighed]
    nothing = np.zeros(len(pieces))
    s = np.vstack([kinetic, one[from_on], nothing])
    p = np.vstack([nothing, one[up_to], kinetic])
    by_log_inertia = np.diff(p - s, axis=0) + _scaled(2.0 * kernel.rotor * inertia**2, one[turned])
    wave = np.zeros((count, len(pieces)))
    wave[turning] = one[waved] - kinetic
    return pieces, {
        "inertia": _scaled(1.0 / inertia, by_log_inertia),
        "link": one[linked],
        "potential": one[weighed],
        "wave": _scaled(1.0 / (1.0 + kernel.wave), wave),
        "swing": _scaled(1.0 / (1.0 + kernel.swing), one[swung] - height),
        "rotor": _scaled(inertia**2, one[turned]),
    }


def _scaled(by: Floats, rows: Floats) -> Floats:
    return np.asarray(by[:, None] * rows)
