"""The arm that is drawn: where its joints are, and what is no description of one."""

from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from lagrangian_ff.errors import ModelError
from lagrangian_ff.workbench.skeleton import read_skeleton

JOINT = (
    '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/>'
    '<origin xyz="0 0 {4}" rpy="{5}"/><axis xyz="0 1 0"/></joint>'
)


def robot(folder: Path, *joints: tuple[object, ...]) -> Path:
    file = folder / "arm.urdf"
    inside = "".join(JOINT.format(*one) for one in joints)
    file.write_text(f'<robot name="arm">{inside}</robot>')
    return file


def test_joints_come_after_those_that_carry_them(tmp_path: Path) -> None:
    file = robot(
        tmp_path,
        ("tip", "fixed", "b", "c", 0.1, "0 0 0"),
        ("elbow", "revolute", "a", "b", 0.4, "0 0 1.5707963267948966"),
        ("base", "prismatic", "world", "a", 0.3, "0 0 0"),
    )
    found = read_skeleton(file)
    assert [one["name"] for one in found] == ["base", "elbow", "tip"]
    assert [one["parent"] for one in found] == [-1, 0, 1]
    assert found[0]["kind"] == "prismatic"
    turned = np.array(found[1]["rotation"]).reshape(3, 3)
    np.testing.assert_allclose(turned @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-12)


def test_the_simulated_arm_has_its_six_joints() -> None:
    found = read_skeleton(Path(str(files("lagrangian_ff"))) / "arm" / "arm6.urdf")
    moving = [one["name"] for one in found if one["kind"] == "revolute"]
    assert moving == [f"joint_{n}" for n in range(1, 7)]


@pytest.mark.parametrize(
    "text",
    ["", "<robot/>", "<sdf><joint/></sdf>", "no xml",
     '<robot><joint name="a"><parent link="x"/></joint></robot>',
     '<robot><joint name="a"><parent link="b"/><child link="a"/></joint>'
     '<joint name="b"><parent link="a"/><child link="b"/></joint></robot>',
     '<robot><joint><parent link="a"/><child link="b"/><origin xyz="0 0"/></joint></robot>'],
)  # fmt: skip
def test_what_is_no_arm_is_said(text: str, tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(text)
    with pytest.raises(ModelError, match="expected the URDF of an arm"):
        read_skeleton(file)
