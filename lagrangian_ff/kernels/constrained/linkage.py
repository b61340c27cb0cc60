"""Closed loops, told by how the joints of the opened mechanism follow the active ones."""

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels.base import Kernel
from lagrangian_ff.kernels.constrained.closed import closed
from lagrangian_ff.kernels.mechanism import Mechanism
from lagrangian_ff.kernels.states import States

Floats = NDArray[np.float64]

KIND = "linkage"
STEP = 1e-5
"""s, over which the Jacobian is differenced along the motion."""


class Linkage(Mechanism):
    """A mechanism with loops, cut open into a tree of T joints that follow its N active ones.

    A subclass gives `name`, `joints`, `positions` and `jacobian`; where the change of the Jacobian
    is known in closed form, `jacobian_rate` may give that, too.

    Attributes:
        name: of the linkage, as the model's file tells it.
        joints: (N,) names of the active joints, in the order that `positions` takes.
    """

    name: str
    joints: tuple[str, ...]

    @abstractmethod
    def positions(self, q: Floats) -> Floats:
        """(M, T) positions q_tr of the tree's joints, for those of the active ones, q (M, N)."""

    @abstractmethod
    def jacobian(self, q: Floats) -> Floats:
        """(M, T, N) G = ∂q_tr/∂q."""

    def jacobian_rate(self, q: Floats, qd: Floats) -> Floats:
        """(M, T, N) dG/dt, 1/s; by central differences along the motion."""
        ahead, behind = self.jacobian(q + STEP * qd), self.jacobian(q - STEP * qd)
        return np.asarray((ahead - behind) / (2.0 * STEP))

    def tree(self, x: States) -> tuple[States, Floats]:
        """The states (M, T) of the tree, and G (M, T, N), for states (M, N) of the active joints.

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
        """See `Mechanism.of_joints`; the order must be that of the linkage."""
        if joints != self.joints:
            raise ModelError(
                f"the joints of {source} are not the active ones of {self.name}: recorded are "
                f"{', '.join(joints)}, expected are {', '.join(self.joints)}, in this order; "
                "choose and order them with Recording.select or --joints"
            )
        return self

    def around(self, family: type[Kernel]) -> type[Kernel]:
        """See `Mechanism.around`."""
        return closed(self, family)

    def record(self) -> dict[str, object]:
        """See `Mechanism.record`."""
        return {"kind": KIND, "name": self.name}

    def stored(self) -> dict[str, object]:
        """See `Mechanism.stored`; what it computes is code, which a model's file does not hold."""
        return self.record()


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
