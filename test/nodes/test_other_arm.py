"""Arms that the package does not know, as `tools/other_arm.py` drives them, are moved."""

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("pybullet")
pytest.importorskip("pinocchio")

from lagrangian_ff.diagnosis.excite import Clearance, Limits, excite
from lagrangian_ff.nodes.attached.client import Client
from lagrangian_ff.nodes.attached.rig import connected
from lagrangian_ff.progress import silent

TOOL = Path(__file__).parents[2] / "tools" / "other_arm.py"
TOPIC = "/other_arm/joint_trajectory"
REACH, FASTEST, HARDEST = 0.4, 0.4, 2.0
ENDING = 30.0  # s


@contextmanager
def driven(arm: str) -> Iterator[Path]:
    """Yield the URDF of an arm that a process drives."""
    command = [sys.executable, "-u", str(TOOL), arm]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        found = next(filter(None, (re.search(r"--urdf (.*)", one) for one in process.stdout)))
        yield Path(found[1])
    finally:
        process.terminate()
        try:
            assert process.wait(ENDING) == 0
        finally:
            process.kill()


@pytest.mark.parametrize("arm", ["iiwa", "panda"])
def test_it_follows_a_motion_of_its_own_joints(
    arm: str, ros_environment: dict[str, str], tmp_path: Path
) -> None:
    with driven(arm) as urdf:
        client = Client()
        with connected(client, TOPIC, (), urdf, None, tmp_path) as rig:
            assert len(rig.joints) == 7
            assert not any("finger" in joint for joint in rig.joints)
            start = rig.pose()
            assert Clearance.of(urdf, rig.joints, start[None])(start[None]) == ""
            every = np.ones(len(rig.joints))
            near = Limits(start - REACH, start + REACH, FASTEST * every, HARDEST * every)
            motion = excite("exciting", rig.joints, near, start=start, duration=8.0)
            found = rig.run(motion, None, silent)
    # How late the drives are depends on how busy the machine is; where they go does not.
    for end in (np.min, np.max):
        np.testing.assert_allclose(end(found.position, 0), end(motion.q, 0), atol=0.05)
    assert np.abs(found.effort).max() > 5.0


def test_it_is_investigated_without_ros_too(tmp_path: Path) -> None:
    page = tmp_path / "story.html"
    tool = TOOL.with_name("other_arm_at_once.py")
    options = ["xarm6", "--hidden", "ripple@1:0.1", "--minutes", "0.4", "--report", str(page)]
    done = subprocess.run([sys.executable, str(tool), *options], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "confirmed and added: ripple on joint1" in done.stdout
    assert "ripple on joint1" in page.read_text()
