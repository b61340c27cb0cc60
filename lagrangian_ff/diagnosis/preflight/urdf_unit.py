"""Whether the effort is in N·m, of an arm whose masses a URDF gives.

One arm's torques do not say their unit: heavier links look like it. With the masses of a URDF the
effort of each joint is regressed on these bodies' gravity, beside their other torque, friction,
rotor and offset. Masses in a URDF are often wrong by a quarter, seldom by half. A load that the
URDF lacks makes the effort larger: only an effort that is too small is named, or far too large.
"""

import numpy as np
import scipy

from lagrangian_ff.diagnosis.preflight.base import Check
from lagrangian_ff.diagnosis.preflight.scaled import BLOCKS, LEVEL, fitted
from lagrangian_ff.identification.samples import decimated, evenly
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.rigid import Robot
from lagrangian_ff.recording.motion import WITHOUT_GRAVITY, Motion

LEAST, MOST = 0.5, 20.0
"""Factors between the URDF's torque and the effort that no wrong mass and no load explains."""
SIGN_SPEED = 0.02
"""rad/s of the smoothed Coulomb step."""
SAMPLES = 4000
"""Samples at most, evenly spread."""
NAME = "effort unit by the URDF"


def urdf_unit_checks(motion: Motion, robot: Robot) -> list[Check]:
    """Return the joints whose effort is surely not the torque of a URDF's bodies in N·m.

    Args:
        motion: of all joints that move the robot.  robot: with the masses of its description.
    """
    if motion.effort == WITHOUT_GRAVITY:
        return []
    motion = decimated(motion)
    motion = motion.take(evenly(len(motion), SAMPLES))
    x = States(motion.q, motion.qd, motion.qdd)
    tree = robot.of_joints(motion.joints, motion.source).tree
    gravity = tree.torque(x.at_rest())
    moving = tree.torque(x) - gravity
    reach_of = float(scipy.special.stdtrit(BLOCKS - 1, LEVEL))
    off: dict[str, tuple[float, float, float]] = {}
    known = 0
    for n, name in enumerate(motion.joints):
        qd = motion.qd[:, n]
        beside = [motion.qdd[:, n], qd, np.tanh(qd / SIGN_SPEED), np.ones(len(motion))]
        columns = np.column_stack([gravity[:, n], moving[:, n], *beside])
        if not (np.ptp(gravity[:, n]) > 0.0 and np.ptp(motion.tau[:, n]) > 0.0):
            continue
        value, deviation, _ = fitted(columns, motion.tau[:, n])
        low, high = value - reach_of * deviation, value + reach_of * deviation
        known += bool(high[0] - low[0] < abs(value[0]))
        small = low[0] > 0.0 and high[0] < LEAST and low[1] < LEAST
        large = low[0] > MOST and high[1] > MOST
        if small or large:
            off[name] = float(value[0]), float(low[0]), float(high[0])
    if not off or 2 * len(off) < known:
        return []
    shown = ", ".join(f"{j} {a:.3g} [{b:.3g} to {c:.3g}]" for j, (a, b, c) in off.items())
    finding = (
        "the effort seems not to be in N·m, if the masses of the URDF are about right: a unit of "
        f"their gravity gives an effort of {shown}; a motor current, or another unit"
    )
    advice = (
        "Give N·m per unit with --effort-scale; lagrangian_ff calibrate finds it with a load of "
        "known mass"
    )
    values = {name: factor for name, (factor, _, _) in off.items()}
    return [Check(NAME, None, finding, False, advice, values)]
