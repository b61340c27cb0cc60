"""Drive gains of all joints at once, from motion with and without a load of known mass.

A drive reports an effort e_j, such as a current, of which g_j N·m make the torque of its joint. The
arm's kinematics are known, its masses need not be. Then, with the regressor W of the bodies'
parameters χ, on all recordings, and that of the load on its body, W_p, where it is carried,

    e_j = a_j (W_j χ + W_p,j χ_p) + F_j φ_j + noise_j,        a_j = 1 / g_j,

where F_j has what is free on each joint: friction, with and without the load, offset and rotor.
Without the load all a_j could be multiplied, and χ divided, by any number; the mass of the load in
χ_p sets it (Gautier and Briot, "Global identification of joint drive gains and dynamic parameters
of robots", ASME J. Dyn. Sys. Meas. Control 136(5), 2014, who solve the same for g_j by total least
squares). Here efforts alone have noise: least squares in units of effort, weighted by joint.

All sums over samples are Gram matrices of blocks of time, see `gain_fit`. Intervals are those of
the jackknife over these blocks, since neighbouring samples err alike.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.gain_fit import UNEXPLAINED, Load, solved
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.identification.samples import decimated
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.rigid import Robot
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import WITHOUT_GRAVITY, Motion, concatenate

BLOCK_SECONDS = 2.0
"""s; friction and the filter remember less."""
FEWEST = 5
"""Blocks that each half of the recordings needs at least."""
SIGN_SPEED = 0.02
"""rad/s of the smoothed Coulomb step."""
LEVEL = 0.95
"""The upper end of a 90 % interval."""
DRIVES = -0.02
"""Share of the power beyond which friction that drives the joints shows a wrong sign."""
KNOWN = 0.25
"""Half width of the interval of a gain's logarithm beyond which the gain counts as unknown."""
CLEANINGS = 3
"""How often blocks that contradict the others are looked for, at most."""
OUTLYING = 5.0
"""Multiple of the usual error of its joint beyond which a block contradicts the others."""


@dataclass(frozen=True)
class DriveGain:
    """The N·m that a unit of a joint's effort makes.

    Attributes:
        joint: its name.
        gain: with its 90 % interval.
        known: whether the load says enough of it.
        share: how much of the joint's torque the load adds, root mean square.
    """

    joint: str
    gain: Estimate
    known: bool
    share: float


@dataclass(frozen=True)
class DriveGains:
    """The gains of all joints.

    Attributes:
        each: by joint.
        payload: kg, as given.
        centre: m, of the load in the frame of the joint that carries it; found, or as given.
        error: by joint, root mean square of what is left, in N·m.
        blocks: of time that the intervals come from.
        left_out: blocks that contradict the others, as by a contact: recording and time, in words.
    """

    each: tuple[DriveGain, ...]
    payload: float
    centre: tuple[float, float, float]
    error: tuple[float, ...]
    blocks: int
    left_out: tuple[str, ...] = ()

    def record(self) -> dict[str, object]:
        """Return the gains for JSON."""
        joints = {
            one.joint: {
                "gain": one.gain.value,
                "low": one.gain.low,
                "high": one.gain.high,
                "identified": one.known,
                "load_share": one.share,
                "error": error,
            }
            for one, error in zip(self.each, self.error, strict=True)
        }
        return {
            "joints": joints,
            "payload": self.payload,
            "payload_centre": list(self.centre),
            "blocks": self.blocks,
            "left_out": list(self.left_out),
        }


def drive_gains(
    unloaded: Motion | Sequence[Motion],
    loaded: Motion | Sequence[Motion],
    robot: Robot,
    payload: float,
    centre: Sequence[float] | None = None,
    progress: Progress = silent,
) -> DriveGains:
    """Return the gain of every drive, from motion without a load and with one.

    Args:
        unloaded, loaded: with their effort in any unit; joints alike.
        robot: of which the kinematics are used, not the masses.
        payload: kg, of the load at the body farthest from the base.
        centre: (3,) m, of its mass in the frame of the joint of that body; None if unknown.
        progress: receives the share done, 0 to 1.

    Raises:
        ModelError: the payload is not above 0; the recordings are too short, of other joints than
            the robot, or the load's torque does not set the scale.
    """
    if not (np.isfinite(payload) and payload > 0.0):
        raise ModelError(f"the payload is {payload} kg, expected more than 0")
    every = [
        (carried, decimated(motion))
        for carried, motions in enumerate((unloaded, loaded))
        for motion in ([motions] if isinstance(motions, Motion) else motions)
    ]
    both = concatenate([motion for _, motion in every])
    joints = both.joints
    robot = robot.of_joints(joints, both.source)
    if both.effort == WITHOUT_GRAVITY:
        robot = robot.without_gravity()
    load = Load.of(robot.tool, 10 * robot.tree.bodies, payload, centre)
    grams: list[Floats] = []
    places: list[str] = []
    counted = [0, 0]
    for number, (carried, motion) in enumerate(every):
        motion = motion.select(joints)
        blocks = motion.blocks(BLOCK_SECONDS)
        for block in np.unique(blocks):
            part = motion.take(blocks == block)
            grams.append(_gram(part, robot, load, bool(carried)))
            places.append(f"{motion.source} from {part.time[0]:.1f} s")
            counted[carried] += 1
        progress(0.5 * (number + 1) / len(every), "summing up the motion")
    for count, what in zip(counted, ("without", "with"), strict=True):
        if count < FEWEST:
            raise ModelError(
                f"{count} blocks of {BLOCK_SECONDS:g} s of motion {what} the load, expected at "
                f"least {FEWEST}: record {3 * FEWEST * BLOCK_SECONDS:g} s or more"
            )
    sums = np.array(grams)
    found = solved(sums.sum(axis=0), load, None)
    outlying = np.zeros(len(sums), dtype=bool)
    for _ in range(CLEANINGS):
        errors = found.errors(sums)
        usual = np.median(errors[~outlying], axis=0)
        outlying = np.asarray((errors > OUTLYING * usual).any(axis=1))
        if 2 * outlying.sum() > len(sums) or not outlying.any():
            break
        found = solved(sums[~outlying].sum(axis=0), load, None)
    if (found.dissipated(sums[~outlying].sum(axis=0)) < DRIVES).all():
        raise ModelError(
            "with these gains friction would drive every joint: UNLOADED and LOADED seem to be "
            "exchanged"
        )
    left_out = tuple(place for place, out in zip(places, outlying, strict=True) if out)
    sums = sums[~outlying]
    whole, left = sums.sum(axis=0), []
    for number, gram in enumerate(sums):
        left.append(solved(whole - gram, load, found).inverse)
        progress(0.5 + 0.5 * (number + 1) / len(sums), "resampling blocks")
    logs = -np.log(np.abs(left))
    away = logs - logs.mean(axis=0)
    count = len(sums)
    deviation = np.sqrt((count - 1) / count * np.sum(away**2, axis=0))
    reach = scipy.special.stdtrit(count - 1, LEVEL) * deviation
    gain = 1.0 / found.inverse
    known = (reach < KNOWN) & (found.unexplained < UNEXPLAINED)
    ends = np.sort(gain[:, None] * np.exp(reach[:, None] * [-1.0, 1.0]), axis=1)
    each = tuple(
        DriveGain(name, Estimate(g, low, high, "N·m"), bool(k), float(s))
        for name, g, (low, high), k, s in zip(
            joints, gain.tolist(), ends.tolist(), known, found.share, strict=True
        )
    )
    moment = found.moment / payload
    return DriveGains(
        each,
        payload,
        (float(moment[0]), float(moment[1]), float(moment[2])),
        tuple((np.abs(gain) * found.noise).tolist()),
        count,
        left_out,
    )


def _gram(motion: Motion, robot: Robot, load: Load, carried: bool) -> Floats:
    """Return (N, C, C) for each joint the Gram matrix of its columns.

    They are the arm's, the load's free ones, the load's known torque, the effort, and what is free
    on the joint: rotor, offset, and friction without and with the load.
    """
    x = States(motion.q, motion.qd, motion.qdd)
    rows = robot.tree.regressor(x)
    own = rows.reshape(len(x), x.joints, -1, 10)[:, :, load.body] * float(carried)
    out = []
    for joint in range(x.joints):
        qd = motion.qd[:, joint]
        friction = np.stack([qd, np.tanh(qd / SIGN_SPEED)], axis=1)
        columns = np.column_stack(
            [
                rows[:, joint],
                own[:, joint][:, list(load.free)],
                own[:, joint] @ load.known,
                motion.tau[:, joint],
                motion.qdd[:, joint],
                np.ones(len(x)),
                friction * (not carried),
                friction * carried,
            ]
        )
        out.append(columns.T @ columns)
    return np.array(out)
