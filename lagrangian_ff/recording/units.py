"""The units of a recording: converted where an option names them, doubted where they contradict.

Nothing is converted in silence. What contradicts itself is named with the option that mends it:
velocity that is not the derivative of position, samples that are too far apart to be seconds,
angles that make sense as degrees only, effort without the noise that every sensor has.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from math import comb

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording.recording import Recording, publishers
from lagrangian_ff.recording.stamps import order

_DEGREE = np.pi / 180.0
_RPM = 2.0 * np.pi / 60.0

UNITS: Mapping[str, Mapping[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "position": {"rad": 1.0, "deg": _DEGREE, "mrad": 1e-3},
    "velocity": {"rad/s": 1.0, "deg/s": _DEGREE, "rpm": _RPM, "mrad/s": 1e-3},
    "effort": {
        "Nm": 1.0,
        "mNm": 1e-3,
        "Nmm": 1e-3,
        "Ncm": 1e-2,
        "kNm": 1e3,
        "kgfcm": 0.0980665,
        "kgfm": 9.80665,
        "lbfin": 0.1129848,
        "lbfft": 1.3558179,
    },
}
"""By quantity, the number of seconds, rad, rad/s or N·m in one of each unit, usual ones first."""

_LIKELY = (20.0, 20e3)  # Hz, rates of joint states
_OVER = 0.02  # s to either side, over which velocity and position are compared
_FOLLOWS = 0.95  # correlation of velocity and derivative above which a factor can be told
_APART = 0.7  # and below which they contradict
_SAME = 1.1  # either way: a factor that may be noise or a filter
_ALIKE = 1.05  # either way: a factor that is this unit
_TURNS = 6.5  # rad; angles over less may be degrees without a sign of it
_TWO_TURNS = 13.0  # rad; few arms have joints half of which turn that far
_BETTER = (0.5, 0.9)  # times the error with degrees that shows they are: below two turns, above
_SAMPLES = 4000  # that are looked at
_BLOCKS = 10
_DIFFERENCE = 6  # order of the differences that show noise: what is smooth hardly shows in them
_APART_MOST = 0.005  # s between the samples of these differences, at most
_SILENT = 1e-5  # noise over the signal's deviation, 100 dB, that no sensor of torque reaches
_NOISIER = 30.0  # times more noise of the position, which then was not smoothed, was measured
_NORMAL = 0.6745  # median of the absolute value of a normal variable


@dataclass(frozen=True)
class Doubt:
    """A quantity that contradicts the others.

    Attributes:
        quantity: time, position, velocity or effort.
        joint: whose; None for all.
        finding: what contradicts what, in words.
        factor: recorded by expected.
        remedy: the option that mends it; empty if there is none.
    """

    quantity: str
    joint: str | None
    finding: str
    factor: float
    remedy: str = ""

    def text(self) -> str:
        """Return one sentence."""
        return f"{self.finding}; {self.remedy}" if self.remedy else self.finding


def checked_units(units: Mapping[str, str]) -> dict[str, str]:
    """Return units by quantity as they are written in `UNITS`; N·m may have its point.

    Raises:
        RecordingError: a quantity or unit is not known; names those that are.
    """
    found = {}
    for quantity, given in units.items():
        if quantity not in UNITS:
            raise RecordingError(
                f"units: there is no quantity {quantity!r}, expected {', '.join(UNITS)}"
            )
        unit = given.replace("·", "").replace("*", "").replace("µ", "u")
        if unit not in UNITS[quantity]:
            raise RecordingError(
                f"units: {quantity} in {given!r}, expected {', '.join(UNITS[quantity])}"
            )
        found[quantity] = unit
    return found


def named_units(texts: Iterable[str]) -> dict[str, str]:
    """Return units by quantity, each given as quantity=unit.

    Raises:
        RecordingError: one is of another form, or a quantity is named twice.
    """
    found: dict[str, str] = {}
    for text in texts:
        quantity, sign, unit = text.partition("=")
        if not sign or not unit:
            raise RecordingError(f"units: {text!r}, expected quantity=unit, as in position=deg")
        if quantity in found:
            raise RecordingError(f"units: {quantity} is given twice")
        found[quantity] = unit
    return checked_units(found)


def factor_of(units: Mapping[str, str], quantity: str) -> float:
    """Return the number of seconds, rad, rad/s or N·m in the unit of a quantity."""
    return UNITS[quantity][units[quantity]] if quantity in units else 1.0


def converted(recording: Recording, units: Mapping[str, str]) -> Recording:
    """Return the recording in s, rad, rad/s and N·m, with a note on what was converted."""
    if not units:
        return recording
    time = factor_of(units, "time")
    tables = {
        name: getattr(recording, name) * factor_of(units, name)
        for name in ("position", "velocity", "effort")
    }
    said = ", ".join(f"{quantity} from {unit}" for quantity, unit in units.items())
    return replace(
        recording,
        time=recording.time * time,
        start=recording.start * time,
        notes=(*recording.notes, f"converted as asked: {said}"),
        **tables,
    )


def find_doubts(recording: Recording) -> tuple[Doubt, ...]:
    """Return what contradicts the units s, rad and rad/s."""
    found: list[Doubt] = []
    for publisher in publishers(recording):
        rows, joints = publisher.rows, publisher.joints
        known = rows[np.isfinite(recording.position[np.ix_(rows, joints)]).all(axis=1)]
        ordered = order(recording.time[known])
        rows = known[ordered.index]
        if len(rows) < 10 * _BLOCKS or not ordered.period > 0.0:
            continue
        found += (of_time := _of_time(ordered.period))
        seconds = 1.0 / of_time[0].factor if of_time and of_time[0].remedy else 1.0
        found += _of_effort(recording, rows, joints, ordered.period * seconds)
        found += (of_velocity := _of_velocity(recording, rows, joints, seconds))
        if not any("position=" in one.remedy for one in of_velocity):
            found += _of_position(recording, rows, joints)
    return tuple(found)


def _of_time(period: float) -> list[Doubt]:
    if 1e-6 < period <= 2.0 / _LIKELY[0]:
        return []
    apart = f"stamps lie {period:.4g} s apart, {1.0 / period:.3g} Hz"
    for unit, seconds in UNITS["time"].items():
        if _LIKELY[0] <= 1.0 / (period * seconds) <= _LIKELY[1] and seconds < 1.0:
            finding = f"{apart}; in {unit} they would be {1.0 / (period * seconds):.4g} Hz"
            return [Doubt("time", None, finding, 1.0 / seconds, f"--units time={unit} reads them")]
    return [Doubt("time", None, f"{apart}: are they in s?", np.nan)]


def _of_velocity(recording: Recording, rows: Ints, joints: Ints, seconds: float) -> list[Doubt]:
    """Return where velocity is not the derivative of position; stamps count `seconds`."""
    time = seconds * recording.time[rows]
    usual = float(np.median(np.diff(time)))
    reach = max(2, round(_OVER / usual))
    if len(rows) < 4 * reach:
        return []
    q = recording.position[np.ix_(rows, joints)]
    v = recording.velocity[np.ix_(rows, joints)]
    span = time[2 * reach :] - time[: -2 * reach]
    # The mean velocity over a span against the way made in it, by the trapezoidal rule.
    total = np.concatenate([np.zeros((1, len(joints))), np.cumsum(0.5 * (v[1:] + v[:-1]), axis=0)])
    mean = (total[2 * reach :] - total[: -2 * reach]) / (2 * reach)
    rate = (q[2 * reach :] - q[: -2 * reach]) / span[:, None]
    whole = span < 1.2 * 2 * reach * usual
    step = max(1, len(whole) // _SAMPLES)
    mean, rate = mean[whole][::step], rate[whole][::step]
    if not len(rate):
        return []
    good = np.isfinite(mean).all(axis=0) & (np.ptp(rate, axis=0) > 0)
    good &= np.nan_to_num(np.ptp(mean, axis=0)) > 0
    columns = np.flatnonzero(good)
    if not columns.size or len(mean) < 10:
        return []
    names = [recording.joints[joints[k]] for k in columns]
    return _compared(mean[:, columns], rate[:, columns], names)


def _compared(velocity: Floats, rate: Floats, names: list[str]) -> list[Doubt]:
    """Return the doubts of velocities and derivatives of position, (M, J) both."""
    velocity, rate = velocity - velocity.mean(axis=0), rate - rate.mean(axis=0)
    sizes = np.sqrt((velocity**2).sum(axis=0)), np.sqrt((rate**2).sum(axis=0))
    correlation = (velocity.T @ rate) / np.outer(*sizes)
    own = np.diag(correlation)
    factor = sizes[0] / sizes[1]
    follows = np.abs(own) > _FOLLOWS
    off = follows & ((factor > _SAME) | (factor < 1.0 / _SAME))
    common = float(np.median(factor[follows])) if follows.any() else 1.0
    unused = "it is not used: qd is differentiated from position"
    found = []
    if off.all() and np.all(np.abs(np.log(factor / common)) < np.log(_ALIKE)):
        what, remedy = _named(common)
        finding = f"velocity is {common:.4g} times the derivative of position{what}"
        found.append(Doubt("velocity", None, finding, common, remedy or unused))
        off[:] = False
    for k, name in enumerate(names):
        other = int(np.argmax(np.abs(correlation[k])))
        if off[k]:
            what, remedy = _named(float(factor[k]))
            finding = f"velocity of {name} is {factor[k]:.4g} times the derivative of its position"
            # An option counts for all joints, so it mends no single one.
            found.append(Doubt("velocity", name, finding + what, float(factor[k]), unused))
        elif own[k] < -_FOLLOWS:
            finding = f"velocity of {name} has the sign opposite to the derivative of its position"
            found.append(Doubt("velocity", name, finding, -1.0, unused))
        elif abs(own[k]) < _APART and abs(correlation[k, other]) > _FOLLOWS:
            finding = f"velocity of {name} is that of {names[other]}, by the positions"
            remedy = f"{unused}; are the columns of position or effort swapped, too?"
            found.append(Doubt("velocity", name, finding, np.nan, remedy))
        elif abs(own[k]) < 0.5 * _APART:
            finding = (
                f"velocity of {name} does not follow the derivative of its position "
                f"(correlation {own[k]:.2f})"
            )
            found.append(Doubt("velocity", name, finding, np.nan, unused))
    return found


def _of_effort(recording: Recording, rows: Ints, joints: Ints, period: float) -> list[Doubt]:
    """Return a doubt of efforts that are far smoother than the position: nothing measured them."""
    longest = max(1, int(_APART_MOST / period + 1e-6))
    apart = [2**k for k in range(longest.bit_length())]

    def noise(values: Floats) -> float:
        size = float(np.std(values))
        if not size > 0.0 or len(values) < 10 * _DIFFERENCE * apart[-1]:
            return np.nan
        # A value that a driver repeats or interpolates shows its noise over some samples only.
        return max(_noise(values[::step]) for step in apart) / size

    commanded = []
    for joint in joints.tolist():
        position, effort = recording.position[rows, joint], recording.effort[rows, joint]
        if np.isfinite(effort).all():
            least, other = noise(effort), noise(position)
            if least < _SILENT and other > max(_NOISIER * least, _SILENT):
                commanded.append(recording.joints[joint])
    if not commanded:
        return []
    finding = (
        f"effort of {', '.join(commanded)} has no noise, as no sensor's: it was commanded or "
        "computed, not measured"
    )
    remedy = (
        "what the drive made of it does not show; learn and compare with recordings of one kind"
    )
    return [Doubt("effort", None, finding, np.nan, remedy)]


def _noise(values: Floats) -> float:
    """Return the standard deviation of white noise on a smooth signal (M,), in its unit."""
    differences = np.abs(np.diff(values, _DIFFERENCE))
    size = float(np.median(differences)) / _NORMAL
    return size / float(np.sqrt(comb(2 * _DIFFERENCE, _DIFFERENCE)))


def _named(factor: float) -> tuple[str, str]:
    """Return what the factor of velocity over the derivative of position means, and the option."""
    causes = [
        (UNITS["velocity"]["rad/s"] / one, f": it is in {unit}", f"velocity={unit}")
        for unit, one in UNITS["velocity"].items()
        if unit != "rad/s"
    ]
    causes += [
        (one, f": position is in {unit}", f"position={unit}")
        for unit, one in UNITS["position"].items()
        if unit != "rad"
    ]
    # Stamps of another unit make the derivative smaller; so do positions in thousands of rad.
    causes += [
        (1.0 / one, f": stamps are in {unit}", f"time={unit}")
        for unit, one in UNITS["time"].items()
        if one < 1e-3
    ]
    for number, what, option in causes:
        if abs(np.log(factor / number)) < np.log(_ALIKE):
            return what, f"--units {option} converts it"
    return "", ""


def _of_position(recording: Recording, rows: Ints, joints: Ints) -> list[Doubt]:
    """Return whether angles are degrees: the torque follows them as degrees and not as rad."""
    rows = rows[:: max(1, len(rows) // _SAMPLES)]
    q, tau = recording.position[np.ix_(rows, joints)], recording.effort[np.ix_(rows, joints)]
    widest = float(np.ptp(q, axis=0).max())
    whole = np.isfinite(tau).all(axis=1)
    if widest < _TURNS or whole.sum() < 0.5 * len(rows):
        return []
    q, tau = q[whole], tau[whole]
    as_rad, as_degrees = (_unexplained(one, tau) for one in (q, q * _DEGREE))
    far = float(np.median(np.ptp(q, axis=0))) > _TWO_TURNS
    if as_degrees > _BETTER[far] * as_rad:
        return []
    finding = (
        f"positions span up to {widest:.4g}: taken as degrees they explain {1 - as_degrees:.0%} of "
        f"the torque of unseen stretches, as rad {max(0.0, 1 - as_rad):.0%}"
    )
    remedy = "--units position=deg converts them"
    return [Doubt("position", None, finding, 1.0 / _DEGREE, remedy)]


def _unexplained(q: Floats, tau: Floats) -> float:
    """Return the share of the torque's power that its position leaves, in blocks left out."""
    first, second = np.triu_indices(q.shape[1], 1)
    both = q[:, first] + q[:, second]
    direction = np.sign(np.gradient(q, axis=0))
    one = np.ones((len(q), 1))
    columns = np.hstack([one, direction, *(f(x) for x in (q, both) for f in (np.cos, np.sin))])
    block = np.arange(len(q)) * _BLOCKS // len(q)
    penalty = 1e-3 * len(q) * np.eye(columns.shape[1])
    left = 0.0 * tau
    for k in range(_BLOCKS):
        x, y = columns[block != k], tau[block != k]
        weights = np.linalg.solve(x.T @ x + penalty, x.T @ (y - y.mean(axis=0)))
        left[block == k] = tau[block == k] - y.mean(axis=0) - columns[block == k] @ weights
    spread = tau.var(axis=0)
    varies = spread > 0.0
    if not varies.any():
        return 1.0
    return float(np.mean((left[:, varies] ** 2).mean(axis=0) / spread[varies]))
