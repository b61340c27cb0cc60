"""A real driver's report of a run: at its rate, late, rounded, in a wrong unit, with losses."""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from lagrangian_ff.arm.description import JOINTS
from lagrangian_ff.arm.parameters import ArmParameters, PerJoint
from lagrangian_ff.arm.plant import true_torque
from lagrangian_ff.arm.simulation import Run
from lagrangian_ff.arrays import Floats
from lagrangian_ff.recording.recording import Recording

NONE: PerJoint = (0.0,) * len(JOINTS)
LEAST_VELOCITY = 0.008  # s, between the positions that a velocity is the difference of
STAMPING = 2e-5  # s between messages that waited together
GRAVITY_EVERY = 5  # samples of the run


@dataclass(frozen=True)
class Driver:
    """The faults of a driver, on the link's side of the gears; one value a joint in N·m.

    Attributes:
        rate: Hz of its reports.
        gains: reported over true effort.
        delay: s by which the effort is older than the position beside it.
        white: standard deviation of noise that is independent from sample to sample.
        coloured, memory: standard deviation of noise that is forgotten over `memory` s (AR(1)).
        effort_step, position_step: of rounding; rad for positions.
        jitter: s, mean lateness of the stamps; samples are taken evenly.
        lost: share of the samples that never arrive.  burst: mean number of neighbours lost.
        gravity: whether the effort holds the torque of gravity; if not, the driver takes it off.
    """

    rate: float
    gains: PerJoint = (1.0,) * len(JOINTS)
    delay: float = 0.0
    white: PerJoint = NONE
    coloured: PerJoint = NONE
    memory: float = 0.01
    effort_step: PerJoint = NONE
    position_step: float = 0.0
    jitter: float = 0.0
    lost: float = 0.0
    burst: float = 1.0
    gravity: bool = True


def fine(parameters: ArmParameters) -> ArmParameters:
    """Return the arm with sensors so good that all faults are the driver's."""
    return replace(parameters, encoder_counts=2**24, current_noise=NONE, velocity_measured=False)


def reported(run: Run, driver: Driver, parameters: ArmParameters, seed: int) -> Recording:
    """Return the driver's recording of a run of the arm with `fine` sensors.

    Args:
        run: whose recording has what the sensors see.
        driver: its faults.
        parameters: of the arm, for its gravity.
        seed: of the noise, the stamps and the losses.
    """
    random = np.random.default_rng(seed)
    seen = run.recording
    position = seen.position
    count = int((seen.time[-1] - seen.time[0]) * driver.rate) + 1
    time = seen.time[0] + np.arange(count) / driver.rate
    position = scipy.interpolate.CubicSpline(seen.time, position)(time)
    # The motors hold a torque for a tick; what is seen at its end is that of its middle.
    middle = seen.time - 0.5 * parameters.tick
    effort = _at(time - driver.delay, middle, seen.effort)
    if not driver.gravity:
        effort -= _gravity(run, parameters, time - driver.delay)
    effort *= driver.gains
    effort += random.normal(size=effort.shape) * driver.white
    effort += _coloured(effort.shape, driver.memory * driver.rate, random) * driver.coloured
    effort = _rounded(effort, driver.effort_step)
    position = _rounded(position, driver.position_step)
    velocity = _difference(position, driver.rate)
    stamps = _stamps(time, driver.jitter * random.exponential(size=count))
    kept = _kept(count, driver, random)
    position, velocity, effort = (table[kept] for table in (position, velocity, effort))
    when = stamps[kept] - stamps[0]
    return Recording(JOINTS, when, position, velocity, effort, source="simulated driver")


def _gravity(run: Run, parameters: ArmParameters, at: Floats) -> Floats:
    """Return the torque (M, 6) N·m of the links' weight along a run, at M times in s."""
    q = run.position[::GRAVITY_EVERY]
    still = np.zeros_like(q)
    torque = true_torque(q, still, still, friction=False, parameters=parameters)
    return _at(at, run.recording.time[::GRAVITY_EVERY], torque)


def _at(when: Floats, time: Floats, values: Floats) -> Floats:
    """Return (M, 6) between the values (K, 6) at K times, on straight lines."""
    return np.stack([np.interp(when, time, column) for column in values.T], axis=1)


def _coloured(shape: tuple[int, ...], memory: float, random: np.random.Generator) -> Floats:
    """Return noise of unit deviation that is forgotten over `memory` samples: AR(1)."""
    kept = float(np.exp(-1.0 / memory))
    drawn = random.normal(size=shape)
    drawn[1:] *= np.sqrt(1.0 - kept**2)
    return np.asarray(scipy.signal.lfilter([1.0], [1.0, -kept], drawn, axis=0))


def _rounded(values: Floats, step: float | PerJoint) -> Floats:
    steps = np.broadcast_to(np.asarray(step, dtype=np.float64), values.shape[1:])
    some = np.where(steps > 0.0, steps, 1.0)
    return np.where(steps > 0.0, np.rint(values / some) * some, values)


def _difference(position: Floats, rate: float) -> Floats:
    """Return the velocity (M, 6) rad/s as drivers make it: a difference to an earlier position."""
    back = max(1, round(LEAST_VELOCITY * rate))
    before = np.concatenate([np.repeat(position[:1], back, axis=0), position[:-back]])
    return (position - before) * (rate / back)


def _stamps(time: Floats, late: Floats) -> Floats:
    """Return the stamps (M,) of messages that wait for each other in a queue."""
    order = STAMPING * np.arange(len(time))
    return np.asarray(np.maximum.accumulate(time + late - order) + order)


def _kept(count: int, driver: Driver, random: np.random.Generator) -> Floats:
    """Return which samples arrive, (M,) booleans; the first does."""
    kept = np.ones(count, dtype=bool)
    starts = np.flatnonzero(random.uniform(size=count) < driver.lost / driver.burst)
    for start in starts:
        kept[start : start + random.geometric(1.0 / driver.burst)] = False
    kept[0] = True
    return kept
