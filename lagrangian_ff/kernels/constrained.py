"""Mechanisms with closed loops, and the kernel of their torques: Gᵀ K_T G, eq. (48).

The torque of the active joints is that of the tree's joints projected by G = ∂q_tr/∂q_a, so that a
kernel K_T of the tree's torques gives one of theirs. The states of the tree are
qd_tr = G qd, qdd_tr = G qdd + dG/dt qd.
"""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels import base
from lagrangian_ff.kernels.dense import dense_cross, dense_gram
from lagrangian_ff.kernels.states import States

KIND = "linkage"
STEP = 1e-5
"""s, over which the Jacobian is differenced along the motion."""


class Linkage(base.Mechanism):
    """A mechanism with loops, cut open into a tree of T joints that follow its N active ones.

    A subclass defines `name`, `joints`, `positions` and `jacobian`; it may define `jacobian_rate`
    if the change of the Jacobian is known in closed form.

    Attributes:
        name: of the linkage, as the model file has it.
        joints: (N,) names of the active joints, in the order that `positions` takes.
    """

    name: str
    joints: tuple[str, ...]

    @abstractmethod
    def positions(self, q: Floats) -> Floats:
        """Return (M, T) the positions q_tr of the tree's joints for q (M, N) of the active ones."""

    @abstractmethod
    def jacobian(self, q: Floats) -> Floats:
        """Return (M, T, N) G = ∂q_tr/∂q."""

    def jacobian_rate(self, q: Floats, qd: Floats) -> Floats:
        """Return (M, T, N) dG/dt, 1/s; by central differences along the motion."""
        ahead, behind = self.jacobian(q + STEP * qd), self.jacobian(q - STEP * qd)
        return np.asarray((ahead - behind) / (2.0 * STEP))

    def tree(self, x: States) -> tuple[States, Floats]:
        """Return the tree's states (M, T) and G (M, T, N) for states (M, N) of the active joints.

        Raises:
            ModelError: `positions` or `jacobian` gave another shape, or values that are not finite.
        """
        g = _sound(self.name, "jacobian", self.jacobian(x.q), (len(x), -1, x.joints))
        joints = g.shape[1]
        q = _sound(self.name, "positions", self.positions(x.q), (len(x), joints))
        rate = self.jacobian_rate(x.q, x.qd)
        rate = _sound(self.name, "jacobian_rate", rate, (len(x), joints, x.joints))
        qd = np.einsum("mtn,mn->mt", g, x.qd)
        qdd = np.einsum("mtn,mn->mt", g, x.qdd) + np.einsum("mtn,mn->mt", rate, x.qd)
        return States.of(q, qd, qdd), g

    def of_joints(self, joints: tuple[str, ...], source: str) -> "Linkage":
        """Return the linkage; a recording's joints must be in its order."""
        if joints != self.joints:
            raise ModelError(
                f"the joints of {source} are not the active ones of {self.name}: recorded are "
                f"{', '.join(joints)}, expected are {', '.join(self.joints)}, in this order; "
                "choose and order them with Recording.select or --joints"
            )
        return self

    def around(self, family: base.Family) -> "ClosedFamily":
        meaning = f"the loops of {self.name} closed: {family.meaning}"
        return ClosedFamily(self, family, meaning, family.searched, family.differentiable)

    def record(self) -> dict[str, object]:
        return {"kind": KIND, "name": self.name}

    def stored(self) -> dict[str, object]:
        """Return the name alone: what it computes is code, which a model file does not hold."""
        return self.record()


@dataclass(frozen=True)
class ClosedFamily(base.MechanismFamily):
    """The kernels of a linkage, for a family of kernels of its tree; none has a Lagrangian."""

    mechanism: Linkage

    has_lagrangian = False

    def start(self, x: States) -> "Closed":
        """Return the kernel as the family starts on the tree's states."""
        made = ClosedDifferentiable if self.differentiable else Closed
        return made(self, self.inner.start(self.mechanism.tree(x)[0]))


@dataclass(frozen=True)
class Closed(base.MechanismKernel):
    """A kernel of the tree, projected onto the active joints."""

    of: ClosedFamily

    def gram(self, x: States) -> Floats:
        tree, g = self.of.mechanism.tree(x)
        with np.errstate(all="ignore"):  # memory above the diagonal is not initialised
            return _projected(dense_gram(self.kernel, tree), g, g)

    def cross(self, x: States, u: States) -> Floats:
        (at, g), (of, h) = self.of.mechanism.tree(x), self.of.mechanism.tree(u)
        return _projected(dense_cross(self.kernel, at, of), g, h)

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        (at, g), (of, h) = self.of.mechanism.tree(x), self.of.mechanism.tree(u)
        torque = self.kernel.apply(at, of, np.einsum("mtn,mn->mt", h, a))
        return np.asarray(np.einsum("mtn,mt->mn", g, torque))


class ClosedDifferentiable(Closed, base.DifferentiableKernel):
    """A projected kernel with derivatives by its hyperparameters."""

    def contract(self, x: States, weights: Floats, vector: Floats) -> Mapping[str, base.Contracted]:
        assert isinstance(self.kernel, base.DifferentiableKernel)
        tree, g = self.of.mechanism.tree(x)
        lifted = _projected(base.symmetric(weights), g.transpose(0, 2, 1), g.transpose(0, 2, 1))
        moved = np.einsum("mtn,mn->mt", g, vector.reshape(len(x), x.joints))
        found = {}
        for name, one in self.kernel.contract(tree, lifted, moved.ravel()).items():
            product = one.product.reshape(-1, len(x), tree.joints)
            projected = np.einsum("mtn,kmt->kmn", g, product).reshape(len(product), -1)
            found[name] = base.Contracted(one.total, projected)
        return found


def _projected(matrix: Floats, g: Floats, h: Floats) -> Floats:
    """Return (M N, K L) gᵀ matrix h by blocks: matrix (M T, K S), g (M, T, N), h (K, S, L)."""
    (m, t, n), (k, s, _) = g.shape, h.shape
    left = g.transpose(0, 2, 1) @ matrix.reshape(m, t, k * s)
    right = left.reshape(m * n, k, s).transpose(1, 0, 2) @ h
    return np.ascontiguousarray(right.transpose(1, 0, 2)).reshape(m * n, -1)


def _sound(name: str, what: str, values: Floats, shape: tuple[int, ...]) -> Floats:
    found = np.asarray(values, dtype=np.float64)
    fits = found.ndim == len(shape) and all(
        wanted in (-1, size) for wanted, size in zip(shape, found.shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("T" if size < 0 else str(size) for size in shape)
        raise ModelError(
            f"linkage {name}: {what}() gave shape {found.shape}, expected ({wanted}): samples "
            "first, then the joints of the tree"
        )
    if not np.isfinite(found).all():
        sample = int(np.argwhere(~np.isfinite(found))[0][0])
        raise ModelError(
            f"linkage {name}: {what}() is not finite at sample {sample}: the active joints stand "
            "where the loop cannot be closed, or at a singularity"
        )
    return found


class FiveBar(Linkage):
    """Cranks at (0, 0) and (base, 0), forearms that meet above the base.

    Angles count from the x axis. Cut open at the hand, it is a tree of four joints: the angle
    of each crank, and that of its forearm to it: left crank, left elbow, right crank, right elbow.

    Args:
        base: m between the cranks' axes.
        cranks, forearms: m, left and right.
        joints: names of the two driven joints.
    """

    name = "five-bar"

    def __init__(
        self,
        base: float,
        cranks: tuple[float, float],
        forearms: tuple[float, float],
        joints: tuple[str, str] = ("left", "right"),
    ) -> None:
        self.joints = joints
        self._axes = np.array([[0.0, 0.0], [base, 0.0]])
        self._cranks, self._forearms = np.array(cranks), np.array(forearms)

    def positions(self, q: Floats) -> Floats:
        """Return the angles of cranks and forearms; NaN if the forearms do not reach each other."""
        forearms = self._forearm_angles(q)
        between = np.angle(np.exp(1j * (forearms - q)))
        return np.stack([q[:, 0], between[:, 0], q[:, 1], between[:, 1]], axis=1)

    def jacobian(self, q: Floats) -> Floats:
        forearms = self._forearm_angles(q)
        # The hand is on both arms. Columns of ∂hand/∂angle: left forearm, minus right forearm;
        # and the cranks.
        passive = _across(forearms, self._forearms) * np.array([1.0, -1.0])
        active = _across(q, self._cranks) * np.array([-1.0, 1.0])
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = np.empty((len(q), 2, 2))
            inverse[:, 0, 0], inverse[:, 0, 1] = passive[:, 1, 1], -passive[:, 0, 1]
            inverse[:, 1, 0], inverse[:, 1, 1] = -passive[:, 1, 0], passive[:, 0, 0]
            determinant = inverse[:, 0, 0] * inverse[:, 1, 1] - inverse[:, 0, 1] * inverse[:, 1, 0]
            turned = inverse @ active / determinant[:, None, None]
        out = np.zeros((len(q), 4, 2))
        out[:, 0, 0] = out[:, 2, 1] = 1.0
        out[:, 1], out[:, 3] = turned[:, 0], turned[:, 1]
        out[:, 1, 0] -= 1.0
        out[:, 3, 1] -= 1.0
        return out

    def _forearm_angles(self, q: Floats) -> Floats:
        """Return (M, 2) rad of the forearms: two circles about the elbows meet at the hand."""
        tips = np.stack([np.cos(q), np.sin(q)], axis=2) * self._cranks[None, :, None]
        elbows = self._axes[None] + tips
        apart = elbows[:, 1] - elbows[:, 0]
        distance = np.linalg.norm(apart, axis=1)
        left, right = self._forearms
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (distance**2 + left**2 - right**2) / (2.0 * distance)
            above = np.sqrt(left**2 - along**2)
            unit = apart / distance[:, None]
            normal = np.stack([-unit[:, 1], unit[:, 0]], axis=1)
            hand = elbows[:, 0] + along[:, None] * unit + above[:, None] * normal
        arms = hand[:, None, :] - elbows
        return np.arctan2(arms[:, :, 1], arms[:, :, 0])


def _across(angle: Floats, length: Floats) -> Floats:
    """Return (M, 2, K) the derivative of each rod's end (x, y) by its angle (M, K)."""
    return np.stack([-np.sin(angle) * length, np.cos(angle) * length], axis=1)
