"""The arm's description: limits, loads, valid inertias, and what importing it costs."""

import subprocess
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

from lagrangian_ff.arm import HOME, ArmParameters, Load, limits, robot_description
from lagrangian_ff.arm.description import URDF, on_links
from lagrangian_ff.errors import ArmError


def inertias(urdf: str) -> dict[str, tuple[float, np.ndarray]]:
    found = {}
    for link in ElementTree.fromstring(urdf).iter("link"):
        mass, entry = link.find("inertial/mass"), link.find("inertial/inertia")
        assert mass is not None
        assert entry is not None
        x, y, z, xy, xz, yz = (
            float(entry.attrib["i" + k]) for k in ("xx", "yy", "zz", "xy", "xz", "yz")
        )
        tensor = np.array([[x, xy, xz], [xy, y, yz], [xz, yz, z]])
        found[link.attrib["name"]] = (float(mass.attrib["value"]), tensor)
    return found


def test_every_inertia_belongs_to_some_real_body() -> None:
    for name, (mass, tensor) in inertias(URDF.read_text()).items():
        principal = np.linalg.eigvalsh(tensor)
        assert mass > 0, name
        assert principal[0] > 0, name
        # Triangle inequality: no body has one principal moment above the sum of the others.
        assert principal[2] < principal[0] + principal[1], name


def test_the_moving_links_weigh_what_a_research_arm_does() -> None:
    masses = [mass for name, (mass, _) in inertias(URDF.read_text()).items() if "base" not in name]
    assert 12 < sum(masses) < 25


def test_limits_come_from_the_urdf_and_hold_the_home_pose() -> None:
    low, high, velocity, effort = limits()
    assert low.shape == high.shape == velocity.shape == effort.shape == (6,)
    assert np.all((low < HOME) & (high > HOME))
    assert np.all(velocity > 0)
    assert np.all(effort > 0)
    with pytest.raises(ValueError, match="read-only"):
        low[0] = 0.0


def test_a_load_is_a_ball_of_steel_on_its_link() -> None:
    urdf = robot_description({"joint_1": 2.5, "link_2": Load(1.0, (0.1, 0.0, 0.2))})
    mass, tensor = inertias(urdf)["load_on_link_1"]
    radius = (2.5 / 7850.0 / (4 / 3 * np.pi)) ** (1 / 3)
    assert mass == 2.5
    np.testing.assert_allclose(tensor, 0.4 * 2.5 * radius**2 * np.eye(3), rtol=1e-6)
    fixed = ElementTree.fromstring(urdf).find("joint[@name='fix_load_on_link_2']")
    assert fixed is not None
    origin, parent = fixed.find("origin"), fixed.find("parent")
    assert origin is not None
    assert parent is not None
    assert (origin.get("xyz"), parent.get("link")) == ("0.1 0 0.2", "link_2")


def test_without_loads_the_description_is_the_file() -> None:
    assert robot_description() == URDF.read_text()


@pytest.mark.parametrize(
    ("loads", "words"),
    [
        ({"joint_7": 1.0}, "joint_7.*joint_1"),
        ({"joint_1": -1.0}, "positive mass"),
        ({"joint_1": float("nan")}, "positive mass"),
        ({"joint_1": 1.0, "link_1": 1.0}, "two loads on link_1"),
    ],
)
def test_impossible_loads_are_refused(loads: dict[str, float], words: str) -> None:
    with pytest.raises(ArmError, match=words):
        on_links(loads)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"viscous": (1.0,)}, "viscous: expected 6 values"),
        ({"coulomb": (-1.0,) * 6}, "coulomb: expected not negative"),
        ({"gear_ratio": (0.0,) * 6}, "gear_ratio: expected positive"),
        ({"current_noise": (float("nan"),) * 6}, "current_noise"),
        ({"physics_rate": 1250}, "physics_rate.*multiple of"),
    ],
)
def test_impossible_parameters_are_refused(change: dict, words: str) -> None:
    with pytest.raises(ArmError, match=words):
        ArmParameters(**change)


def test_trajectories_are_read_without_pybullet() -> None:
    code = (
        "import sys\n"
        "from lagrangian_ff.arm import Trajectory, read_trajectory, JOINTS, limits\n"
        "import lagrangian_ff.arm.trajectory\n"
        "sys.exit('pybullet' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
