"""The lag of all torques behind the positions: one delay, that of the driver.

A driver reads all drives alike, so that their torques come late together. Looked at joint by joint,
a few milliseconds are too little to be named, and enough to look like friction that other effects
have: of one that creeps, or that follows the load. Over all joints one number explains them.
"""

from dataclasses import replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.confidence import HoldOut
from lagrangian_ff.diagnosis.lag import Lag
from lagrangian_ff.diagnosis.search.bayes_factor import tempered_log_bf
from lagrangian_ff.diagnosis.whitening import Whitened, whiten
from lagrangian_ff.effects import EFFECTS, Inputs
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.identification.choosing.shapes import orthonormal
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.sampling import stretches

EXPECTED = 0.005
"""Standard deviation of a lag a priori, s: drivers filter and queue over some milliseconds."""
ROUNDS = 8
SETTLED = 0.1
"""Share of its deviation by which a lag may still change."""


def lag_of(whitened: Whitened, beside: Floats | None = None) -> Lag:
    """Return the lag that a motion shows beside everything explained, to first order.

    Args:
        beside: (S N, K) orthonormal columns that may be there as well, such as `hysteresis_of`.
    """
    z, residual = column_of(whitened, beside)
    z *= EXPECTED
    information, moment = float(z @ z), float(z @ residual)
    if information <= 0.0:
        return Lag(0.0, EXPECTED, 0.0)
    size = moment / information
    rest = np.add.reduceat(z * (residual - size * z), whitened.starts)
    inflation = max(1.0, float(rest @ rest) / information)
    log_bf = tempered_log_bf(np.array([[moment]]), np.array([[information]]), inflation)
    deviation = EXPECTED * float(np.sqrt(inflation / information))
    return Lag(EXPECTED * size, deviation, float(log_bf[0]))


def column_of(whitened: Whitened, beside: Floats | None = None) -> tuple[Floats, Floats]:
    """Return the whitened torque of a lag of one second and the residual, (S N,) each.

    Args:
        beside: as of `lag_of`; neither has a part in it.
    """
    z, residual = whitened.project(whitened.late()[:, None])[:, 0], whitened.residual
    if beside is not None:
        z, residual = (one - beside @ (beside.T @ one) for one in (z, residual))
    return z, residual


def hysteresis_of(whitened: Whitened) -> Floats:
    """Return (S N, K) orthonormal columns of hysteresis on every joint, of any width.

    Friction that builds up after a reversal comes late as well; that of all gears together may
    look like one lag of tens of milliseconds.
    """
    effect = EFFECTS["hysteresis"]
    x, white = whitened.x, []
    for joint in range(whitened.joints):
        terms = [Term(effect, joint, shape) for shape in effect.candidates(x, joint)]
        columns = np.hstack([term.columns(x) for term in terms])
        white.append(whitened.whitened(columns, joint))
    return orthonormal(whitened.project(np.hstack(white)))


def set_right(whitened: Whitened, beside: Floats) -> tuple[Whitened, Lag]:
    """Return the motion with its torques earlier by the lag that it shows, and that lag.

    The torque that is predicted is smoother than the true one, and a lag of it explains more than
    its own: it is sought until none is left.

    Args:
        beside: as of `lag_of`.
    """
    first = left = lag_of(whitened, beside)
    delay = 0.0
    for _ in range(ROUNDS):
        if abs(left.delay) < SETTLED * left.deviation:
            break
        delay += left.delay
        whitened = _earlier(whitened, left.delay)
        left = lag_of(whitened, beside)
    # Each round finds the same part of what is left, and its deviation is of that part.
    part = first.delay / delay if delay else 1.0
    deviation = first.deviation / float(np.clip(part, 0.1, 1.0))
    return whitened, Lag(delay, deviation, first.log_bayes_factor)


def allowing(whitened: Whitened) -> Whitened:
    """Return the motion with a lag explained, too: one that was set right is known to some ms."""
    more = replace(whitened, lagging=True)
    return more.explaining(more.basis, more.problem.nuisance)


def confirms(held: HoldOut) -> bool:
    """Return whether unseen motion confirms a lag: one number, which was not chosen among many."""
    low, high = thresholds.USED.size_ratio
    return low < held.ratio < high and float(held.gained.sum()) > thresholds.USED.floor


def earlier(motion: Motion, delay: float) -> Motion:
    """Return a motion with its torques earlier by a delay in s, interpolated within segments."""
    tau = motion.tau.copy()
    for begin, end in stretches(motion.segment):
        time = motion.time[begin:end]
        for joint in range(tau.shape[1]):
            tau[begin:end, joint] = np.interp(time + delay, time, motion.tau[begin:end, joint])
    return replace(motion, tau=tau)


def _earlier(whitened: Whitened, delay: float) -> Whitened:
    """Return the whitened motion after its torques are moved `delay` seconds earlier.

    The load is predicted again, from the moved torques.
    """

    def again(inputs: Inputs, x: Inputs) -> Whitened:
        of, like, weight = whitened.problem, whitened.system, whitened.problem.samples.weight
        return whiten(motion, whitened.index, whitened.seconds, inputs, of, x, like, weight)

    motion = earlier(whitened.motion, delay)
    moved = again(whitened.inputs, whitened.x)
    inputs = moved.inputs_of(motion)
    return again(inputs, replace(moved, inputs=inputs).inputs_left_out())
