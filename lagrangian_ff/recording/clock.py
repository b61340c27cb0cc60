"""The clock of a recording: steps undone, late stamps moved, by the motion and with a note each."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.recording.late import FEWEST, Ticks, ticks_of_motion
from lagrangian_ff.recording.recording import Publisher, Recording, publishers
from lagrangian_ff.recording.stamps import least_distance, without_resets
from lagrangian_ff.recording.steps import without_steps
from lagrangian_ff.words import counted

_PAUSE = 0.5  # s; what follows a longer pause is judged as another stretch
_SLOWEST = 0.1  # s, period; slower recordings are refused later
_WINDOW = 50  # samples by which the rate of a stretch is seen
_REGULAR = 0.6  # of the steps must agree for a rate
_AGREE = 0.1  # of a step: agreement
_NEGLIGIBLE = 1e-6  # s
_BESIDE = 10  # samples to each side, over which a joint's speed is seen
_RESOLVED = 2.0  # steps of the encoder in a period, from which on a moving joint never repeats
_STRAIGHTER = 0.9  # of the way that the joints go in order of stamps


def retime(recording: Recording, mode: str, notes: list[str]) -> Floats:
    """Return the times (M,) of the samples, s: the stamps, repaired where the motion says so.

    Args:
        mode: "auto" decides by the motion, "stamps" keeps them but for steps back, "steady"
            takes all samples for evenly taken.
    """
    sources = publishers(recording)
    time, joints = recording.time, np.empty(0, dtype=np.int64)
    if mode != "stamps" and len(sources) == 1:
        time, joints = _undo_steps(recording, sources[0], notes)
    time, resets = without_resets(time)
    if resets.size:
        when = ", ".join(f"{recording.time[at - 1]:.3f} s" for at in resets[:3])
        notes.append(
            f"the clock was set back {counted(resets.size, 'time')} (after {when}); what "
            "follows is treated as another stretch of time"
        )
    if mode == "stamps":
        return time
    corrected = time.copy()
    for publisher in sources:
        corrected[publisher.rows] = _steadied(recording, publisher, time, joints, mode, notes)
    return corrected


def _known(recording: Recording, publisher: Publisher) -> Ints:
    """Return the samples of a publisher that have all positions."""
    rows = publisher.rows
    positions = recording.position[np.ix_(rows, publisher.joints)]
    return np.asarray(rows[np.isfinite(positions).all(axis=1)])


def _undo_steps(
    recording: Recording, publisher: Publisher, notes: list[str]
) -> tuple[Floats, Ints]:
    """Return stamps of a clock that never stepped, and the rows before which steps were undone."""
    rows = _known(recording, publisher)
    time, none = recording.time, np.empty(0, dtype=np.int64)
    if len(rows) < FEWEST:
        return time, none
    positions = recording.position[np.ix_(rows, publisher.joints)]
    mended, steps = without_steps(time[rows], positions)
    for step in steps:
        when = f"{time[rows[step.at - 1]]:.3f} s"
        size = f"{abs(step.size):.4g} s"
        way = "forward" if step.size > 0 else "back"
        notes.append(
            f"the clock stepped {way} by {size} after {when}: the motion goes on without a break; "
            "later stamps are moved by as much"
            if step.joined
            else f"the clock was set back by {size} after {when}; what follows is treated as "
            "another stretch of time"
        )
    if not steps:
        return time, none
    shift = np.zeros(len(time))
    for step, last in zip(steps, [*(s.at for s in steps[1:]), len(rows)], strict=True):
        begin = rows[step.at]
        end = rows[last] if last < len(rows) else len(time)
        shift[begin:end] = mended[step.at] - time[rows[step.at]]
    return time + shift, rows[[step.at for step in steps if step.joined]]


@dataclass(frozen=True)
class _Stretch:
    rows: Ints
    ticks: Ticks


def _steadied(
    recording: Recording,
    publisher: Publisher,
    time: Floats,
    joints: Ints,
    mode: str,
    notes: list[str],
) -> Floats:
    """Return the times of all of a publisher's samples."""
    rows = publisher.rows
    known = _known(recording, publisher)
    if len(known) < FEWEST:
        return time[rows]
    positions = recording.position[:, publisher.joints]
    order = known[_order(time[known], positions[known])]
    same = np.concatenate([[False], _repeats(recording, publisher, order)])
    found = []
    for part in _stretches(time[order]):
        if part.stop - part.start < FEWEST:
            continue
        inside = order[part]
        if np.ptp(time[inside]) > _SLOWEST * len(inside):
            continue
        breaks = np.flatnonzero(np.isin(inside, joints))
        ticks = ticks_of_motion(
            time[inside], positions[inside], same[part], breaks, mode != "steady"
        )
        if ticks is not None:
            found.append(_Stretch(inside, ticks))
    moved = np.zeros(len(time))
    taken = [s for s in found if mode == "steady" or _right(s.ticks, found)]
    for stretch in taken:
        moved[stretch.rows] = stretch.ticks.time - time[stretch.rows]
    if not taken:
        return time[rows]
    notes.append(_said(np.concatenate([moved[each.rows] for each in taken]), len(known), mode))
    # Samples without some of the positions go with those before and after them.
    return np.asarray(time[rows] + np.interp(rows, np.sort(known), moved[np.sort(known)]))


def _said(shifts: Floats, samples: int, mode: str) -> str:
    """Return a note on samples that were moved by these times, s."""
    share = np.count_nonzero(np.abs(shifts) > _NEGLIGIBLE) / samples
    most, usual = np.abs(shifts).max() * 1e3, np.sqrt(np.mean(shifts**2)) * 1e3
    why = (
        "over which the motion is smooth, as it is not over the stamps"
        if mode == "auto"
        else "as the setting of the clock says"
    )
    return (
        f"stamps of {100 * share:.3g} % of the samples moved by up to {most:.3g} ms "
        f"({usual:.2g} ms rms) to the ticks of a steady clock, {why}"
    )


def _right(ticks: Ticks, all_found: list[_Stretch]) -> bool:
    if ticks.right:
        return True
    # The same driver stamped the other stretches: they say what this one cannot.
    clear = [s.ticks for s in all_found if np.isfinite(s.ticks.error)]
    if not clear or not ticks.smooth:
        return False
    weights = np.array([1 / t.error**2 for t in clear])
    slope = float(weights @ [t.follows for t in clear]) / weights.sum()
    against = np.isfinite(ticks.error) and ticks.follows - 2 * ticks.error > 0.5
    return bool(slope + 3 / np.sqrt(weights.sum()) < 0.5 and not against)


def _order(time: Floats, position: Floats) -> Ints:
    """Return the order in which samples were taken.

    That of arrival, where the joints go a clearly shorter way in it than in the order of the
    stamps; else that of the stamps.
    """
    arrival = np.arange(len(time))
    stamped = np.argsort(time, kind="stable")
    if np.array_equal(arrival, stamped):
        return arrival
    other = arrival != stamped
    here = other[1:] | other[:-1]
    size = np.ptp(position, axis=0) + 1e-12
    ways = [
        float(np.sum(np.abs(np.diff(position[order], axis=0))[here] / size))
        for order in (arrival, stamped)
    ]
    return arrival if ways[0] < _STRAIGHTER * ways[1] else stamped


def _repeats(recording: Recording, publisher: Publisher, order: Ints) -> Flags:
    """Return (K - 1,) samples that say what the one before said, while a joint moves on."""
    positions = recording.position[np.ix_(order, publisher.joints)]
    change = np.abs(np.diff(positions, axis=0))
    wide = np.ones(2 * _BESIDE + 1) / (2 * _BESIDE + 1)
    usual = np.stack([np.convolve(one, wide, mode="same") for one in change.T], axis=1)
    # A joint slower than its encoder resolves repeats its position, and is sampled all the same.
    same = np.any(usual > _RESOLVED * least_distance(positions), axis=1)
    for table in (recording.position, recording.effort):
        for joint in publisher.joints:
            values = table[order, joint]
            missing = np.isnan(values)
            same &= (values[1:] == values[:-1]) | (missing[1:] & missing[:-1])
    return same


def _stretches(time: Floats) -> list[slice]:
    """Return parts without a long pause, of one rate each."""
    edges = [0, *(np.flatnonzero(np.diff(time) > _PAUSE) + 1), len(time)]
    parts = []
    for begin, end in pairwise(edges):
        inner = [begin, *(begin + at for at in _rate_changes(time[begin:end])), end]
        parts += [slice(*pair) for pair in pairwise(inner)]
    return parts


def _rate_changes(time: Floats) -> list[int]:
    """Return the samples from which on stamps are regularly at another distance."""
    step = np.diff(time)
    windows = len(step) // _WINDOW
    if windows < 4:
        return []
    table = step[: windows * _WINDOW].reshape(windows, _WINDOW)
    usual = np.median(table, axis=1)
    agree = np.abs(table - usual[:, np.newaxis]) < _AGREE * np.abs(usual)[:, np.newaxis]
    regular = np.flatnonzero((agree.mean(axis=1) >= _REGULAR) & (usual > 0))
    found: list[int] = []
    for left, right in pairwise(regular):
        # One odd window is no other rate.
        ahead = regular[regular >= right][:2]
        behind = regular[regular <= left][-2:]
        one, two = usual[behind], usual[ahead]
        if max(one.max() / two.min(), two.max() / one.min()) < 1 + _AGREE:
            continue
        if np.ptp(one) > _AGREE * one.min() or np.ptp(two) > _AGREE * two.min():
            continue
        inside = step[left * _WINDOW : (right + 1) * _WINDOW]
        nearer = np.abs(inside - usual[left]) - np.abs(inside - usual[right])
        found.append(int(left * _WINDOW + np.argmin(np.cumsum(nearer)) + 1))
    return found
