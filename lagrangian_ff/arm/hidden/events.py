"""Events during a motion: the arm picks up a load, or is pushed."""

from math import cos, pi

import numpy as np

from lagrangian_ff.arm.body import Body
from lagrangian_ff.arm.description import JOINTS, Load
from lagrangian_ff.arm.hidden.base import Installed, Site, recorded
from lagrangian_ff.arm.joint_effect import JointEffect, JointMoment
from lagrangian_ff.arm.plant import Attached
from lagrangian_ff.arm.simulation import SETTLING
from lagrangian_ff.arrays import Floats

RAMP = 0.2  # s, in which a push rises and falls


def payload(site: Site, strength: float) -> Installed:
    """Install a load of strength kg beside the tool, from 35 to 65 % of the recording on."""
    random = site.random
    time = float(site.along.time[-1]) * random.uniform(0.35, 0.65)
    angle = random.uniform(0.0, 2.0 * pi)
    point = (0.05 * cos(angle), 0.05 * float(np.sin(angle)), 0.12)
    return Installed(
        attached=Attached(time + SETTLING, {"link_6": Load(strength, point)}),
        facts={"mass [kg]": strength, "attached at [s]": time},
    )


def payload_torque(installed: Installed, site: Site) -> Floats:
    """Return the inverse dynamics with the load less that without, once it is picked up."""
    attached, run = installed.attached, site.along
    assert attached is not None
    rows = np.arange(0, len(run.time), 5)
    states = run.q[rows], run.qd[rows], run.qdd[rows]
    with Body(attached.loads) as loaded, Body() as free:
        torque = loaded.inverse_dynamics(*states) - free.inverse_dynamics(*states)
    torque[run.time[rows] + SETTLING < attached.time] = 0.0
    return torque[np.minimum(np.arange(len(run.time)) // 5, len(rows) - 1)]


class Push(JointEffect):
    """A force at the tool between two times: the joints must resist J(q)ᵀ of it.

    Args:
        force: (3,) N on the tool, along the axes of the base.
        begin, end: s of the recording; it rises and falls within 0.2 s.
    """

    def __init__(self, force: Floats, begin: float, end: float) -> None:
        self._force, self._begin, self._end = force, begin, end
        self._body = Body()
        self._none = np.zeros(len(JOINTS))

    def torque(self, moment: JointMoment) -> tuple[Floats, Floats]:
        time = recorded(moment)
        inside = min(time - self._begin, self._end - time) / RAMP
        if inside <= 0.0:
            return self._none, self._none
        share = 0.5 - 0.5 * cos(pi * min(inside, 1.0))
        arm = self._body.tool_jacobian(moment.q)
        return -share * (arm.T @ self._force), self._none


def contact(site: Site, strength: float) -> Installed:
    """Install a push of strength N in a random direction for 5 to 9 s, less in a short run."""
    random = site.random
    way = random.normal(size=3)
    end = float(site.along.time[-1])
    length = min(random.uniform(5.0, 9.0), 0.3 * end)
    begin = random.uniform(0.3, 0.95 - length / end) * end
    force = strength * way / np.linalg.norm(way)
    return Installed(
        (Push(force, begin, begin + length),),
        facts={
            **{f"force along {axis} [N]": float(f) for axis, f in zip("xyz", force, strict=True)},
            "begins [s]": begin,
            "ends [s]": begin + length,
        },
    )
