"""Is an arm identified after less motion if the motion is designed?"""

from collections.abc import Sequence

import numpy as np

from lagrangian_ff.arm import HOME, JOINTS, Trajectory, working_motion
from lagrangian_ff.diagnosis import compare
from lagrangian_ff.diagnosis.excite import Parameters, Reference, design
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.investigation.motions import first_motion
from lagrangian_ff.recording import Motion, condition_alike
from lagrangian_ff.studies.decide.rig import Clearance, SimulatedRig, arm_limits
from lagrangian_ff.studies.nuisances.drawn import Nuisances

FIRST = 10.0
"""s of `exciting` that both begin with: a design needs a model."""
TIMES = (10.0, 14.0, 18.0, 22.0, 26.0, 32.0, 40.0)
"""s of motion after which the errors are compared."""
UNSEEN = 20.0
"""s of working motion on which they are measured."""


def errors(nuisances: Nuisances, seed: int, model: str) -> dict[str, list[float]]:
    """Return the errors after each of `TIMES`, of `exciting` and of the designed motion.

    Each is the root of the mean nmse of all joints on working motion that nobody learned from.

    Args:
        nuisances: of the arm.  seed: of all that is drawn.
        model: kernel and effects that are learned.
    """
    settings = Settings(model=model, train=1.0)
    limits, clear, start = arm_limits(), Clearance(), np.array(HOME)
    rig = SimulatedRig(nuisances, None, seed, limits)
    path = first_motion(JOINTS, limits, start, TIMES[-1], seed=seed, clear=clear)
    usual = rig.follow(_trajectory(path))
    (motion,) = condition_alike([usual])
    first = identify([_until(motion, FIRST)], settings).model
    made = design(
        first, Parameters(), limits, start=start, seconds=TIMES[-1] - FIRST, clear=clear, seed=seed
    )
    designed = rig.follow(_trajectory(made.reference))
    unseen = rig.follow(working_motion("spline", UNSEEN, 0.0, 0.45, seed + 1, nuisances.parameters))
    one, other, held = condition_alike([usual, designed, unseen])
    return {
        "exciting": [_error([_until(one, t)], held, settings) for t in TIMES],
        "designed": [
            _error([_until(one, FIRST), _until(other, t - FIRST)], held, settings) for t in TIMES
        ],
    }


def ratio(found: dict[str, list[float]]) -> float:
    """Return the s of designed motion until the error is that of `exciting`, over the s of that.

    The latter's smallest error counts, and when it came. Between measured times the log of the
    designed motion's error is taken as linear. Infinite where the error is never reached.
    """
    usual, designed = np.array(found["exciting"]), np.array(found["designed"])
    when = TIMES[int(usual.argmin())]
    below = np.flatnonzero(designed <= usual.min())
    if not len(below):
        return np.inf
    until = slice(max(0, below[0] - 1), below[0] + 1)
    errors, times = np.log(designed[until][::-1]), np.array(TIMES)[until][::-1]
    return float(np.interp(np.log(usual.min()), errors, times)) / when


def _trajectory(path: Reference) -> Trajectory:
    return Trajectory(path.time, path.q, path.qd, path.qdd, JOINTS)


def _until(motion: Motion, seconds: float) -> Motion:
    return motion.take(motion.time < motion.time[0] + seconds)


def _error(learned: Sequence[Motion], unseen: Motion, settings: Settings) -> float:
    sound = [one for one in learned if len(one)]
    found: Model = identify(sound, settings).model
    return float(np.sqrt(np.nanmean(compare(found, unseen).score.nmse)))
