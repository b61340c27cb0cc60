"""Whether the arm, in a pose, comes near itself or the floor."""

from collections.abc import Mapping
from types import TracebackType

import numpy as np
import pybullet
from numpy.typing import NDArray

from lagrangian_ff.arm.body import Body
from lagrangian_ff.arm.description import JOINTS, LINKS, Load
from lagrangian_ff.arm.trajectory import Trajectory
from lagrangian_ff.errors import ArmError

Floats = NDArray[np.float64]

CHECK_EVERY = 0.05  # s


class Surroundings:
    """The arm over a floor, in a world of its own.

    Links that share a joint touch by design and are not compared; the loads on a link count as
    part of it.

    Args:
        loads: kg (or Load) by joint or link.
        margin: m, what is nearer counts as contact.
    """

    def __init__(
        self, loads: Mapping[str, float | Load] | None = None, *, margin: float = 0.0
    ) -> None:
        self._margin = margin
        self._body = Body(loads)
        self._args = {"physicsClientId": self._body.client}
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, **self._args)
        self._floor = pybullet.createMultiBody(0, plane, **self._args)
        self._pairs, self._low = self._candidates()

    def _candidates(self) -> tuple[list[tuple[int, int]], list[int]]:
        order = {"base_link": 0} | {name: n for n, name in enumerate(LINKS, start=1)}
        links = [(-1, 0)]
        for k in range(pybullet.getNumJoints(self._body.id, **self._args)):
            name = pybullet.getJointInfo(self._body.id, k, **self._args)[12].decode()
            links.append((k, order[name.removeprefix("load_on_")]))
        pairs = [
            (a, b) for a, rank_a in links for b, rank_b in links if rank_b - rank_a > 1 and a != b
        ]
        # The base and the first link cannot reach the floor.
        return pairs, [k for k, rank in links if rank > 1]

    def first_contact(self, q: Floats) -> str | None:
        """What comes nearer than the margin at q (6,) rad, in words; None if nothing does."""
        body, floor, args = self._body.id, self._floor, self._args
        self._body.set_state(q, np.zeros_like(q))
        for a, b in self._pairs:
            if pybullet.getClosestPoints(body, body, self._margin, a, b, **args):
                return f"{self._name(a)} and {self._name(b)}"
        for link in self._low:
            if pybullet.getClosestPoints(body, floor, self._margin, link, **args):
                return f"{self._name(link)} and the floor"
        return None

    def _name(self, link: int) -> str:
        if link < 0:
            return "base_link"
        return str(pybullet.getJointInfo(self._body.id, link, **self._args)[12].decode())

    def close(self) -> None:
        """End the world."""
        self._body.close()

    def __enter__(self) -> "Surroundings":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def check_clearance(
    trajectory: Trajectory, loads: Mapping[str, float | Load] | None = None
) -> None:
    """Whether the arm can follow a trajectory without touching itself or the floor.

    Args:
        trajectory: of the arm's joints; looked at every 50 ms.
        loads: kg (or Load) by joint or link.

    Raises:
        ArmError: it cannot; names what touches, and when.
    """
    count = int(np.ceil(trajectory.duration / CHECK_EVERY)) + 1
    times = np.linspace(trajectory.time[0], trajectory.time[-1], count)
    with Surroundings(loads) as surroundings:
        for time, q in zip(times, trajectory.select(JOINTS).sample(times)[0], strict=True):
            contact = surroundings.first_contact(q)
            if contact is not None:
                raise ArmError(f"trajectory: {contact} touch at {time:.2f} s")
