"""From recordings to motion: the chain of the paper's section IV-B.

Outliers are left out; stamps are put in order; each signal is resampled onto one uniform clock,
piece by piece between the gaps; position and torque pass the same Butterworth low-pass, forward and
backward, so that they stay in step; position is differentiated twice.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from lagrangian_ff import budget
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording.bandwidth import (
    USUAL,
    WIDEST,
    Bandwidth,
    analysis_rate,
    choose,
    unchosen,
)
from lagrangian_ff.recording.filtering import REACH, Butterworth, derivatives, settling
from lagrangian_ff.recording.inspection import find_clipping, find_missing
from lagrangian_ff.recording.motion import SCALINGS, Conditioning, Motion
from lagrangian_ff.recording.outliers import without_outliers
from lagrangian_ff.recording.recording import Recording, require_times
from lagrangian_ff.recording.signals import Signals, read_signals, ticks_of, uninterrupted
from lagrangian_ff.recording.splines import interpolate
from lagrangian_ff.recording.stamps import without_resets
from lagrangian_ff.recording.units import converted, find_doubts
from lagrangian_ff.words import counted

_SLOWEST = 10.0  # Hz; an arm sampled more slowly hides its accelerations
_TOO_SLOW = 6.0  # Hz; a quarter of the rate below this leaves nothing to choose
_FASTEST = 1e6  # Hz
_LEAST = 10  # samples that must be left of a segment
_STILL = 1e-3  # rad; a joint that moves less over the whole recording stands still
_POSITION_HINT = "check the joint's driver"
_EFFORT_HINT = (
    "the driver must offer an effort state interface and joint_state_broadcaster must publish it"
)
_ZERO_HINT = f"{_EFFORT_HINT}, not fill it with zeros"


def condition(recording: Recording, conditioning: Conditioning | None = None) -> Motion:
    """Return a recording's motion, ready for identification.

    Raises:
        RecordingError: no effort or no position on a joint, nothing moves, no stretch long
            enough between gaps, or a joint in `effort_scale` or `effort_offset` is unknown.
    """
    return condition_alike([recording], conditioning)[0]


def condition_alike(
    recordings: Sequence[Recording], conditioning: Conditioning | None = None
) -> list[Motion]:
    """Return the motions of recordings that belong together: one bandwidth for all.

    Raises:
        RecordingError: as `condition`.
    """
    settings, note = conditioning or Conditioning(), ""
    sound = [_sound(recording, settings) for recording in recordings]
    if settings.bandwidth is None and recordings:
        found = _measured_bandwidth(sound, settings)
        settings, note = replace(settings, bandwidth=found.hertz), found.reason
    return [_condition(recording, settings, note) for recording in sound]


def measured_bandwidth(
    recordings: Sequence[Recording], conditioning: Conditioning | None = None
) -> Bandwidth:
    """Return the bandwidth that suits all of these recordings, with the spectra behind it.

    Raises:
        RecordingError: as `condition`.
    """
    settings = conditioning or Conditioning()
    return _measured_bandwidth([_sound(one, settings) for one in recordings], settings)


def _measured_bandwidth(recordings: Sequence[Recording], settings: Conditioning) -> Bandwidth:
    slowest = max(_slowest_period(one) for one in recordings)
    top = min(USUAL, 0.25 / slowest)
    widest = min(WIDEST, 0.25 / slowest)
    if top < _TOO_SLOW:
        return unchosen(top, f"bandwidth {top:.4g} Hz: a quarter of the sampling rate")
    wide = replace(
        settings,
        bandwidth=widest,
        rate=min(analysis_rate(widest), 1 / slowest),
        max_gap=settings.max_gap or 0.5 / top,
    )
    return choose(
        [_condition(recording, wide) for recording in recordings], widest, top, settings.order
    )


def _sound(recording: Recording, settings: Conditioning) -> Recording:
    """Return a recording in this package's units without outliers; its notes say what it lacks."""
    recording = converted(recording, settings.units)
    missing = [entry for entry in find_missing(recording) if entry.quantity != "velocity"]
    sound, outliers = without_outliers(recording)
    lacking = [f"{entry.text()}; left out" for entry in missing]
    return replace(sound, notes=(*recording.notes, *lacking, *outliers))


def _slowest_period(recording: Recording) -> float:
    """Return the longest period in s of a signal, or that of the slowest recording there may be."""
    _require_usable(recording)
    signals = read_signals(recording, "stamps", [])
    _require_timed(recording, signals)
    return signals.slowest.period


def _condition(recording: Recording, settings: Conditioning, note: str = "") -> Motion:
    """Return the motion of a recording that is sound, with a bandwidth that is given."""
    _require_known(recording, settings)
    _require_usable(recording)
    notes = list(recording.notes)
    signals = read_signals(recording, settings.clock, notes)
    _require_timed(recording, signals)
    if note:
        notes.append(note)
    filters = _Filters.design(signals, settings, notes)
    clocks = _clocks(recording, signals, filters, notes)
    pieces = [filters.output_times(ticks) for ticks in clocks]
    ends = np.cumsum([0, *(len(piece) for piece in pieces)])
    shape = (int(ends[-1]), len(recording.joints))
    q, qd, qdd, tau = (np.empty(shape) for _ in range(4))
    for ticks, first, last in zip(clocks, ends[:-1], ends[1:], strict=True):
        part = slice(first, last)
        position = signals.on_clock(recording.position, signals.position, ticks)
        effort = signals.on_clock(recording.effort, signals.effort, ticks)
        for joint, name in enumerate(recording.joints):
            states = filters.motion(position[:, joint], ticks)
            q[part, joint], qd[part, joint], qdd[part, joint] = states
            scale, offset = (
                some.get(name, usual)
                for some, usual in ((settings.effort_scale, 1.0), (settings.effort_offset, 0.0))
            )
            torque = filters.low_pass(effort[:, joint], ticks, settings.effort_delay)
            tau[part, joint] = scale * torque + offset
    _require_moving(recording, q, notes)
    notes += [doubt.text() for doubt in find_doubts(recording)]
    notes += [entry.text() for entry in find_clipping(recording)]
    time, segment = np.concatenate(pieces), np.repeat(np.arange(len(pieces)), np.diff(ends))
    temperature = _temperature(recording, time, notes)
    about = recording.source, tuple(notes), settings.record(), temperature
    return Motion(recording.joints, time, q, qd, qdd, tau, segment, *about)


def _temperature(recording: Recording, time: Floats, notes: list[str]) -> Floats | None:
    """Return (K, N) °C at these times, interpolated in line; None if none was recorded."""
    if recording.temperature is None:
        return None
    stamps, _ = without_resets(recording.time)
    out = np.full((len(time), len(recording.joints)), np.nan)
    for joint, name in enumerate(recording.joints):
        given = recording.temperature[:, joint]
        known = np.flatnonzero(np.isfinite(given))
        if not len(known):
            continue
        known = known[np.argsort(stamps[known], kind="stable")]
        out[:, joint] = np.interp(time, stamps[known], given[known])
        low, high = given[known].min(), given[known].max()
        notes.append(f"temperature of {name}: {low:.1f} to {high:.1f} °C")
    return out


@dataclass(frozen=True)
class _Filters:
    """The low-pass on its clock, and the ends of a segment that it spoils.

    Attributes:
        butterworth: the low-pass itself.
        period: s, of the clock.
        spoilt: samples cut off at each end.
        padding: samples by which a segment is extended while it is filtered.
        rate: Hz, of the result; None keeps the clock.
    """

    butterworth: Butterworth
    period: float
    spoilt: int
    padding: int
    longest_gap: float
    rate: float | None

    @staticmethod
    def design(signals: Signals, settings: Conditioning, notes: list[str]) -> "_Filters":
        period = signals.fastest.period
        slow = 1 / signals.slowest.period
        wanted = settings.bandwidth or USUAL
        bandwidth = min(wanted, slow / 4)
        if bandwidth < wanted * (1 - 1e-3):
            notes.append(
                f"sampled at {slow:.4g} Hz only: bandwidth reduced from "
                f"{wanted:g} Hz to {bandwidth:.4g} Hz"
            )
        settled = settling(settings.order, bandwidth)
        trim = settled if settings.trim is None else settings.trim
        spoilt = max(REACH, ceil(trim / period - 1e-9))
        notes.append(
            f"low-pass: Butterworth of order {settings.order}, {bandwidth:g} Hz at "
            f"{1 / period:.6g} Hz, forward and backward, on position and torque alike; qd and "
            f"qdd are central differences over {2 * REACH + 1} samples; "
            f"{spoilt * period:.3f} s cut off at both ends of each segment"
        )
        return _Filters(
            butterworth=Butterworth(settings.order, bandwidth, 1 / period),
            period=period,
            spoilt=spoilt,
            padding=ceil(settled / period),
            longest_gap=settings.max_gap or max(0.5 / bandwidth, 2.5 * period),
            rate=settings.rate,
        )

    @property
    def least(self) -> int:
        """Return the samples that a segment needs for some to be left."""
        return max(2 * self.spoilt + _LEAST, self.padding + 2)

    def low_pass(self, values: Floats, ticks: Floats, late: float) -> Floats:
        """Return (K,) filtered, at the output times.

        Args:
            late: s by which the values come late.
        """
        smooth = self.butterworth.zero_phase(values, self.padding)
        if late == 0.0:
            return self._output(smooth, ticks)
        times = np.clip(self.output_times(ticks) + late, ticks[0], ticks[-1])
        return interpolate(ticks, smooth, times)

    def motion(self, position: Floats, ticks: Floats) -> tuple[Floats, Floats, Floats]:
        """Return position, velocity and acceleration at the output times."""
        q = self.butterworth.zero_phase(position, self.padding)
        qd, qdd = (np.pad(values, REACH) for values in derivatives(q, self.period))
        return self._output(q, ticks), self._output(qd, ticks), self._output(qdd, ticks)

    def output_times(self, ticks: Floats) -> Floats:
        """Return the ticks that are not spoilt, or times between them at the rate asked for."""
        kept = ticks[self.spoilt : len(ticks) - self.spoilt]
        if self._same_clock():
            return kept
        assert self.rate is not None
        return kept[0] + np.arange(int((kept[-1] - kept[0]) * self.rate + 1e-6) + 1) / self.rate

    def _same_clock(self) -> bool:
        return self.rate is None or abs(self.rate * self.period - 1) < 1e-6

    def _output(self, values: Floats, ticks: Floats) -> Floats:
        kept = slice(self.spoilt, len(ticks) - self.spoilt)
        if self._same_clock():
            return values[kept]
        # What is left below the bandwidth varies slowly from tick to tick: a spline follows it.
        return interpolate(ticks[kept], values[kept], self.output_times(ticks))


def _clocks(
    recording: Recording, signals: Signals, filters: _Filters, notes: list[str]
) -> list[Floats]:
    """Return the ticks of each segment that is long enough; notes on gaps and resampling."""
    spans = uninterrupted(signals, filters.longest_gap)
    clocks = [ticks_of(signals.fastest, span) for span in spans]
    long = [ticks for ticks in clocks if len(ticks) >= filters.least]
    if not long:
        longest = max((float(end - begin) for begin, end in spans), default=0.0)
        raise RecordingError(
            f"{recording.source}: {len(recording)} samples in "
            f"{np.ptp(recording.time):.3f} s, the longest stretch without a gap of more than "
            f"{filters.longest_gap * 1e3:.3g} ms lasts {longest:.3f} s; "
            f"at least {filters.least * filters.period:.3f} s are needed at "
            f"{1 / filters.period:.4g} Hz; record longer"
        )
    if len(spans) > 1:
        notes.append(
            f"{counted(len(spans) - 1, 'gap')} longer than {filters.longest_gap * 1e3:.3g} ms; "
            f"{counted(len(long), 'segment')} used"
        )
    if len(long) < len(spans):
        lost = sum(len(ticks) for ticks in clocks if len(ticks) < filters.least)
        notes.append(
            f"left out {counted(len(spans) - len(long), 'piece')} between gaps, shorter "
            f"than {filters.least * filters.period:.3f} s ({counted(lost, 'sample')})"
        )
    made = signals.mended(long)
    if made.bridged:
        notes.append(
            f"interpolated {counted(made.bridged, 'lost sample')} in short gaps (up to "
            f"{made.longest * 1e3:.3g} ms)"
        )
    if made.off_clock:
        notes.append(
            f"stamps lie up to {made.off_clock * 1e3:.3g} ms off a uniform clock; resampled "
            "onto it by cubic splines"
        )
    return long


def _require_usable(recording: Recording) -> None:
    """Require position and effort of every joint."""
    source, joints, time = recording.source, recording.joints, recording.time
    if len(recording) < 2 or not joints:
        raise RecordingError(
            f"{source}: {len(recording)} samples of {len(joints)} joints; "
            "expected a recording of an arm that moves"
        )
    require_times(source, time)
    throughout = f"in all {len(recording)} samples from {time.min():.3f} s to {time.max():.3f} s"
    known = np.isfinite(recording.effort)
    for there, every, what, hint in (
        (np.isfinite(recording.position), "", "no position of {}: NaN", _POSITION_HINT),
        (known, "any joint", "no effort of {}: empty or NaN", _EFFORT_HINT),
        (known & (recording.effort != 0), "every joint", "the effort of {} is 0", _ZERO_HINT),
    ):
        lacking = [joint for k, joint in enumerate(joints) if not there[:, k].any()]
        if lacking:
            whole = bool(every) and len(lacking) == len(joints)
            who = every if whole else ", ".join(lacking)
            rest = "" if whole else ", or leave the joint out by naming the others as joints"
            raise RecordingError(f"{source}: {what.format(who)} {throughout}; {hint}{rest}")
    if (np.nanmax(recording.effort, axis=0) == np.nanmin(recording.effort, axis=0)).all():
        said = ", ".join(
            f"{value:.4g} of {joint}"
            for value, joint in zip(np.nanmax(recording.effort, axis=0), joints, strict=True)
        )
        raise RecordingError(
            f"{source}: the effort of every joint is constant ({said}) {throughout}; an arm that "
            "moves needs torque that varies: the driver must publish what its drives measure"
        )
    _require_physical(recording)


def _require_physical(recording: Recording) -> None:
    """Refuse values that no arm has, and beside which all others are lost in a sum of squares."""
    for quantity in ("position", "effort"):
        values = getattr(recording, quantity)
        wild = np.argwhere(np.abs(values) > budget.LARGEST)  # NaN compares as False
        if len(wild):
            row, k = wild[0].tolist()
            raise RecordingError(
                f"{recording.source}: {counted(len(wild), f'{quantity} value')} beyond "
                f"{budget.LARGEST:g}, first {values[row, k]:.4g} of {recording.joints[k]} in "
                f"sample {row + 1} at {recording.time[row]:.3f} s; no joint has that: cut this "
                "part out, or check the driver"
            )


def _require_known(recording: Recording, settings: Conditioning) -> None:
    """Require that the settings by joint are for known joints."""
    for setting in SCALINGS:
        values = getattr(settings, setting)
        unknown = [joint for joint in values if joint not in recording.joints]
        if unknown:
            raise RecordingError(
                f"{recording.source}: {setting} is given for {', '.join(unknown)}, but the "
                f"recording holds {', '.join(recording.joints)}"
            )


def _require_timed(recording: Recording, signals: Signals) -> None:
    slowest = signals.slowest.period
    if any(np.isnan(sampling.period) for sampling in signals.samplings):
        raise RecordingError(
            f"{recording.source}: all samples bear the same stamp, {recording.time[0]:.3f} s; "
            "the driver must stamp its messages"
        )
    if slowest > 1 / _SLOWEST or slowest < 1 / _FASTEST:
        doubts = [one.text() for one in find_doubts(recording) if one.quantity == "time"]
        raise RecordingError(
            f"{recording.source}: sampled at {1 / slowest:.3g} Hz; expected at least "
            f"{_SLOWEST:g} Hz, better 100 Hz and more, and at most {_FASTEST:g} Hz"
            f"{''.join(f'; {text}' for text in doubts)}"
        )


def _require_moving(recording: Recording, q: Floats, notes: list[str]) -> None:
    moved = np.ptp(q, axis=0)
    still = [joint for joint, span in zip(recording.joints, moved, strict=True) if span < _STILL]
    if len(still) == len(recording.joints):
        raise RecordingError(
            f"{recording.source}: no joint moves more than {_STILL:g} rad in "
            f"{np.ptp(recording.time):.3f} s; record the arm while it moves"
        )
    if still:
        notes.append(f"{', '.join(still)} stands still (less than {_STILL:g} rad)")
