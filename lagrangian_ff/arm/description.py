"""The arm's joints, limits and links, and loads on them."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ArmError

URDF = Path(__file__).with_name("arm6.urdf")
JOINTS: tuple[str, ...] = tuple(f"joint_{n}" for n in range(1, 7))
LINKS: tuple[str, ...] = tuple(f"link_{n}" for n in range(1, 7))
HOME: tuple[float, ...] = (0.0, -0.4, 0.2, 0.0, 0.7, 0.0)
"""rad: elbow up, tool ahead of the column; clear of everything."""

STEEL = 7850.0  # kg/m³
LOAD_POINTS = {
    "link_1": (-0.24, 0.0, 0.03),
    "link_2": (0.0, 0.215, 0.36),
    "link_3": (0.095, 0.0, 0.09),
    "link_4": (0.085, 0.0, 0.05),
    "link_5": (0.06, 0.0, 0.045),
    "link_6": (0.0, 0.0, 0.15),
}


@dataclass(frozen=True)
class Load:
    """A steel ball fixed to a link by a rod without mass.

    Attributes:
        mass: kg.
        point: m, its centre in the frame of the link; None for the usual place on that link.
    """

    mass: float
    point: tuple[float, float, float] | None = None

    @property
    def radius(self) -> float:
        """Return the radius of the ball, m."""
        return float((3.0 * self.mass / (4.0 * np.pi * STEEL)) ** (1.0 / 3.0))


Loads = Mapping[str, float | Load] | None
"""kg, or a Load, by joint or link; None for none."""

PAPER_LOADS: Mapping[str, float | Load] = {"joint_1": 2.5, "joint_2": 1.0}
"""kg on the links the first two joints move (section IV-B and Fig. 7 of the paper)."""


class Limits(NamedTuple):
    """The limits of the joints in the URDF: rad, rad, rad/s and N·m, (6,) each."""

    lower: Floats
    upper: Floats
    velocity: Floats
    effort: Floats


@lru_cache(maxsize=1)
def limits() -> Limits:
    """Return the limits of the joints, read from the URDF."""
    found = {
        joint.get("name"): joint.find("limit") for joint in ElementTree.parse(URDF).iter("joint")
    }
    rows = []
    for name in JOINTS:
        limit = found[name]
        assert limit is not None
        rows.append([float(limit.attrib[key]) for key in Limits._fields])
    table = np.array(rows).T
    table.setflags(write=False)
    return Limits(*table)


def on_links(loads: Loads) -> dict[str, Load]:
    """Return the loads by link: a joint's name stands for the link it moves, a number for kg.

    Raises:
        ArmError: no such joint or link, or a mass that is not positive and finite.
    """
    placed: dict[str, Load] = {}
    for key, value in (loads or {}).items():
        link = key.replace("joint_", "link_") if key in JOINTS else key
        if link not in LINKS:
            raise ArmError(
                f"a load on {key!r}: the arm has the joints {', '.join(JOINTS)} "
                f"and the links {', '.join(LINKS)}"
            )
        if link in placed:
            raise ArmError(f"two loads on {link}: give one of their common mass and centre")
        load = value if isinstance(value, Load) else Load(float(value))
        point = LOAD_POINTS[link] if load.point is None else load.point
        if not (np.isfinite(load.mass) and load.mass > 0 and np.all(np.isfinite(point))):
            raise ArmError(f"load on {key}: expected a positive mass in kg, got {load.mass!r}")
        placed[link] = Load(load.mass, point)
    return placed


def robot_description(loads: Loads = None) -> str:
    """Return the URDF of the arm, each load a ball fixed to its link; raises as `on_links`."""
    text = URDF.read_text(encoding="utf-8")
    parts = [_ball(link, load) for link, load in on_links(loads).items()]
    return text.replace("</robot>", "".join(parts) + "</robot>")


def _ball(link: str, load: Load) -> str:
    assert load.point is not None
    inertia = 0.4 * load.mass * load.radius**2
    where = " ".join(f"{x:.9g}" for x in load.point)
    x, y, _ = load.point
    rod = (
        f'    <visual><origin xyz="{-x / 2:.6g} {-y / 2:.6g} 0" '
        f'rpy="0 {np.pi / 2} {np.arctan2(y, x)}"/>'
        f'<geometry><cylinder radius="0.008" length="{np.hypot(x, y):.6g}"/></geometry>'
        f'<material name="graphite"/></visual>\n'
    )
    shape = f'<geometry><sphere radius="{load.radius:.6g}"/></geometry>'
    return (
        f'  <link name="load_on_{link}">\n'
        f'    <inertial>\n      <mass value="{load.mass:.9g}"/>\n'
        f'      <inertia ixx="{inertia:.9g}" ixy="0" ixz="0" iyy="{inertia:.9g}" iyz="0" '
        f'izz="{inertia:.9g}"/>\n    </inertial>\n'
        f'    <visual>{shape}<material name="steel"/></visual>\n'
        f"{rod if np.hypot(x, y) > load.radius else ''}"
        f"    <collision>{shape}</collision>\n  </link>\n"
        f'  <joint name="fix_load_on_{link}" type="fixed">\n    <parent link="{link}"/>\n'
        f'    <child link="load_on_{link}"/>\n    <origin xyz="{where}"/>\n  </joint>\n'
    )
