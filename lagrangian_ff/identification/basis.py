"""The finite basis of effects, Φ(x) b in (44): which columns belong to which joint."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.effects import Effect, Inputs, checked_columns, checked_energies
from lagrangian_ff.effects.inputs import SIGN_SPEED
from lagrangian_ff.kernels import States


@dataclass(frozen=True)
class Term:
    """One effect on one joint, its shape parameters fixed.

    Attributes:
        effect: with its columns.  joint: index of the joint it acts on.
        shape: its nonlinear parameters, by name.
    """

    effect: Effect
    joint: int
    shape: Mapping[str, float] = field(default_factory=dict)

    @property
    def others(self) -> Mapping[int, float]:
        """Return the other joints that it acts on, see `Effect.others`."""
        return self.effect.others(self.joint, self.shape)

    def on(self, joints: int) -> Floats:
        """Return (N,) the factor of its columns in each joint's torque."""
        return shares(joints, self.joint, self.others)

    def columns(self, x: Inputs) -> Floats:
        """Return (M, P) the factors of the term's P parameters in its joint's torque.

        Raises:
            EffectError: the effect gave another shape, or values that are not finite.
        """
        if x.whole is not None and (self.effect.remembers or x.window > 1):
            return x.mean(checked_columns(self.effect, x.whole, self.joint, self.shape))
        return checked_columns(self.effect, x, self.joint, self.shape)


def shares(joints: int, joint: int, others: Mapping[int, float]) -> Floats:
    """Return (N,) the factor of a column in each joint's torque: 1 in that of its own."""
    out = np.zeros(joints)
    out[joint] = 1.0
    for other, factor in others.items():
        out[other] = factor
    return out


@dataclass(frozen=True)
class Basis:
    """The terms of a model and where each one's parameters lie in b."""

    terms: tuple[Term, ...]

    @property
    def size(self) -> int:
        """Return B, the number of parameters."""
        return sum(len(term.effect.parameters) for term in self.terms)

    def slices(self) -> list[tuple[Term, slice]]:
        """Return each term with the place of its parameters in b."""
        placed, first = [], 0
        for term in self.terms:
            last = first + len(term.effect.parameters)
            placed.append((term, slice(first, last)))
            first = last
        return placed

    def tangents(self, step: float) -> list[tuple[Term, Term]]:
        """Return terms of one parameter with a shape a relative step above and below its value.

        Their difference is, to first order, what an error in the shape adds.
        """
        found = []
        for term in self.terms:
            if len(term.effect.parameters) != 1:
                continue
            for shape in term.effect.shapes:
                value = term.shape.get(shape.name, 0.0)
                away = value - shape.zero
                if away > 0.0 and not shape.whole:
                    up, down = (
                        replace(term, shape={**term.shape, shape.name: value + by})
                        for by in (step * away, -step * away)
                    )
                    found.append((up, down))
        return found

    def of_joints(self, joints: tuple[int, ...]) -> "Basis":
        """Return the terms that act on these joints."""
        return Basis(tuple(term for term in self.terms if term.joint in joints))

    def conservative(self, joints: int) -> "Basis":
        """Return the terms that keep energy (`Effect.energies`) on an arm of N joints."""
        still = np.zeros((1, joints))
        x = Inputs.of(States(still, still, still))
        energies = ((t, checked_energies(t.effect, x, t.joint, t.shape)) for t in self.terms)
        return Basis(tuple(term for term, found in energies if found is not None))

    def design(self, x: Inputs) -> Floats:
        """Return Φ(x), (M, N, B): the torque of each joint per unit of each parameter."""
        return np.asarray(self.columns(x)[:, None, :] * self.on(x.joints).T)

    def on(self, joints: int) -> Floats:
        """Return (B, N) the factor of each parameter's column in each joint's torque."""
        rows = [t.on(joints) for t in self.terms for _ in t.effect.parameters]
        return np.array(rows).reshape(self.size, joints)

    def columns(self, x: Inputs) -> Floats:
        """Return (M, B) the factor of each parameter in the torque of its own joint."""
        out = np.empty((len(x), self.size))
        for term, place in self.slices():
            out[:, place] = term.columns(x)
        return out

    @property
    def joints(self) -> Ints:
        """Return (B,) the joint that each parameter belongs to."""
        whose = [term.joint for term in self.terms for _ in term.effect.parameters]
        return np.array(whose, dtype=np.int64)

    def sign_speed(self, joints: int) -> Floats:
        """Return (N,) rad/s, the width of the smoothed sign: v0 of the Coulomb terms."""
        speed = np.full(joints, SIGN_SPEED)
        for term in self.terms:
            if term.effect.sign_width in term.shape:
                speed[term.joint] = term.shape[term.effect.sign_width]
        return speed

    def constant(self, joints: int, b: Floats) -> Floats:
        """Return (N,) N·m of the constant torques, for parameters b (B,).

        Over a part of the joints' range gravity and a constant torque look alike, so that only
        their sum, the load, is known.
        """
        constant = np.zeros(joints)
        for term, place in self.slices():
            if term.effect.constant:
                constant[term.joint] += float(b[place][0])
        return constant

    def beside_load(self, x: Inputs, b: Floats) -> Floats:
        """Return (M, N) N·m of all effects that are neither in the load nor follow the torque.

        The load has the constant ones. Those that follow the torque receive this sum: a torque
        that is clipped already would not show its limit.
        """
        return self._beside_load(self._torque(x, b, follows=False), x)

    def torque(self, x: Inputs, b: Floats) -> dict[str, Floats]:
        """Return (M, N) N·m of each effect by name, for parameters b (B,).

        Effects that follow the torque receive that of the load and of all other effects.
        """
        parts = self._torque(x, b, follows=False)
        seen = replace(x, torque=x.load + self._beside_load(parts, x))
        parts |= self._torque(seen, b, follows=True)
        return {name: parts[name] for name in dict.fromkeys(t.effect.name for t in self.terms)}

    def _torque(self, x: Inputs, b: Floats, follows: bool) -> dict[str, Floats]:
        parts: dict[str, Floats] = {}
        for term, place in self.slices():
            if ("torque" in term.effect.uses) == follows:
                part = parts.setdefault(term.effect.name, np.zeros_like(x.q))
                part += np.outer(term.columns(x) @ b[place], term.on(x.joints))
        return parts

    def _beside_load(self, parts: Mapping[str, Floats], x: Inputs) -> Floats:
        constant = {term.effect.name for term in self.terms if term.effect.constant}
        others = (part for name, part in parts.items() if name not in constant)
        return sum(others, np.zeros_like(x.q))
