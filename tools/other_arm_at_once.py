"""Investigate an arm that this package does not know, without ROS: minutes instead of a quarter.

    .venv/bin/python tools/other_arm_at_once.py xarm6 --hidden tight_place@3:0.05

Arm, friction and hidden effects are those of `other_arm.py` beside this file. Its states come as
fast as they are computed, and none is late.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from other_arm import STEP, Arm, Floats, asked_for

from lagrangian_ff.cli.common import investigating
from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.diagnosis.excite import Clearance, Reference, floor_at
from lagrangian_ff.identification import Model
from lagrangian_ff.investigation import Plan, investigate
from lagrangian_ff.investigation.allowed import allowed
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording import Recording
from lagrangian_ff.report import investigation_page

AFTER = 0.3  # s recorded after the end of a motion
SPEED = {"iiwa": 0.15, "panda": 0.5, "xarm6": 0.5}
"""Share of the highest speeds of an arm's URDF: those of PyBullet's iiwa are 10 rad/s."""


class ArmAtOnce:
    """Moves an arm as fast as it is computed."""

    def __init__(self, arm: Arm) -> None:
        self.joints = arm.kind.joints
        self._arm = arm

    def pose(self) -> Floats:
        """Return (N,) rad, where it stands."""
        return self._arm.q.copy()

    def run(self, motion: Reference, model: Model | None, progress: Progress) -> Recording:
        """Return what is measured of a motion."""
        arm, seconds = self._arm, float(motion.time[-1])
        at = np.arange(round((seconds + AFTER) / STEP)) * STEP
        wanted = np.stack([np.interp(at, motion.time, one) for one in motion.q.T], axis=1)
        rows = []
        for step, reference in enumerate(wanted):
            arm.step(reference)
            if step % arm.kind.every == 0:
                rows.append((at[step], arm.q, arm.qd, arm.torque()))
        time, q, qd, tau = (np.array(one) for one in zip(*rows, strict=True))
        return Recording(self.joints, time, q, qd, tau)


def main() -> None:
    """Investigate it, print the story and write its page."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else "")
    parser.add_argument("--minutes", type=float, default=4.0)
    parser.add_argument("--report", type=Path, help="the story on one page")
    arm, given = asked_for(parser)
    console = Console()
    limits = allowed(arm.kind.joints, arm.urdf, speed=SPEED[given.arm])
    clear = Clearance.of(arm.urdf, arm.kind.joints, arm.home[None], [floor_at(0.0)])
    plan = Plan(limits, budget=60.0 * given.minutes, clear=clear, seed=given.seed)
    progress = investigating.lines(console)
    story = investigate(ArmAtOnce(arm), plan, lambda proposal: True, progress)
    investigating.say(story, console)
    if given.report is not None:
        console.say(f"saved: {investigation_page(given.report, story)}")


if __name__ == "__main__":
    main()
