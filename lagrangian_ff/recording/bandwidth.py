"""The bandwidth of the low-pass: as wide as noise allows, chosen from the motion and its torque.

Two noises pass the low-pass. That of the torque averages out over many samples, and counts for a
quarter. That of the position is differentiated twice and grows with the fourth power of frequency:
inertia times noisy acceleration is torque that was never there, and a fit shrinks the inertia to
avoid it. Both are what is left of coherence: of the torque that a regression on the motion
predicts, in blocks that it has not seen, with the torque that was measured.

The regression is linear: gravity of up to two joints, friction, and a constant inertia. It is
fitted below four times the motion's own bandwidth, where acceleration has little noise, and
predicts up to `WIDEST`. What falls with frequency may be physics that the regression lacks, noise
of sensors does not fall: noise is taken to be no more at one frequency than at any above.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.numbers import percent
from lagrangian_ff.recording.filtering import settling
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.sampling import stretches

USUAL = 25.0
"""Hz, the paper's bandwidth (section IV-B): the widest that is chosen."""
WIDEST = 40.0
"""Hz, bandwidth of the motion that is analysed."""
NOISE = 0.05
"""Most noise that counts, rms over the rms of the torque, averaged over the joints."""

AVERAGED = 0.25
"""Share of the noise of torque that counts: what sixteen independent samples a parameter leave."""

_RATE = 3.125  # times the bandwidth: samples per second that are analysed
_SEEN = 0.8  # of that bandwidth: beyond, too little is left to judge
_WINDOW = 4.0  # s of one spectrum
_PIECE = 15.0  # s in one piece
_PIECES = 8
_LEAST = 5.0  # s below which nothing is chosen
_FOLDS = 5
_RIDGES = (1e-5, 1e-3)  # of a column's power
_STEP = 0.05  # of a joint's rms speed: half the width of the smoothed step of dry friction
_WITHIN = 0.9  # share of a joint's velocity (power) inside its own bandwidth
_TIMES = 4.0  # times that bandwidth the low-pass must pass
_ENDS = 0.1  # of the longest stretch, the most that the filter may spoil at its ends
_STILL = 1e-3  # rad, as in conditioning


@dataclass(frozen=True)
class Bandwidth:
    """The bandwidth that was chosen, and the spectra behind it.

    Attributes:
        hertz: Hz, of the low-pass.
        reason: why, in words; begins with the number.
        joints: J names of joints that move; the columns of the spectra follow them.
        edges: (F + 1,) Hz, of the bands. No band: nothing was measured.
        torque: (F, J) N·m/√Hz, amplitude density of the measured torque.
        related: (F, J) the part of it that the motion explains.
        noise: (F, J) likewise what noise of acceleration and of torque adds.
        size: (J,) N·m, rms of the torque about its mean.
    """

    hertz: float
    reason: str
    joints: tuple[str, ...]
    edges: Floats
    torque: Floats
    related: Floats
    noise: Floats
    size: Floats


@dataclass(frozen=True)
class _Spectra:
    """Densities in N·m²/Hz and (rad/s)²/Hz by band and joint, summed over `windows`.

    Attributes:
        torque, predicted, inertial, speed: (F, J), of measured torque, of that predicted, of its
            part from acceleration, and of velocity.
        cross, cross_inertial: (F, J) complex, with the measured torque.
        windows: their number.
        bins: (F,) frequencies in each band.
    """

    torque: Floats
    predicted: Floats
    inertial: Floats
    speed: Floats
    cross: Floats
    cross_inertial: Floats
    windows: float
    bins: Ints

    def __add__(self, other: "_Spectra") -> "_Spectra":
        return _Spectra(
            self.torque + other.torque,
            self.predicted + other.predicted,
            self.inertial + other.inertial,
            self.speed + other.speed,
            self.cross + other.cross,
            self.cross_inertial + other.cross_inertial,
            self.windows + other.windows,
            self.bins,
        )

    def coherence(self, cross: Floats, other: Floats) -> Floats:
        """Return (F, J) squared coherence with the measured torque, less what chance gives."""
        # Of windows that overlap by half, four count as three.
        chance = 1.0 / np.maximum(0.75 * self.bins * self.windows, 2.0)[:, None]
        found = np.abs(cross) ** 2 / np.maximum(self.torque * other, 1e-300)
        return np.asarray(np.clip((found - chance) / (1.0 - chance), 0.0, 1.0))


def analysis_rate(widest: float) -> float:
    """Return the rate in Hz at which a motion of this bandwidth is analysed."""
    return _RATE * widest


def unchosen(hertz: float, reason: str) -> Bandwidth:
    """Return a bandwidth for which nothing was measured."""
    none = np.empty((0, 0))
    return Bandwidth(hertz, reason, (), np.empty(0), none, none, none, np.empty(0))


def choose(motions: Sequence[Motion], widest: float, top: float, order: int) -> Bandwidth:
    """Return one bandwidth for all of these motions.

    Args:
        motions: conditioned with the bandwidth `widest` (Hz) at about `analysis_rate(widest)`.
        top: Hz, the widest that may be chosen.
        order: of the low-pass.
    """
    joints = motions[0].joints
    motions = [motion.select(joints) for motion in motions]
    moved = np.max([np.ptp(motion.q, axis=0) for motion in motions], axis=0) > _STILL
    mean = np.concatenate([motion.tau for motion in motions]).mean(axis=0)
    size = np.sqrt(np.mean(np.concatenate([(m.tau - mean) ** 2 for m in motions]), axis=0))
    used = np.flatnonzero(moved & (size > 1e-9 * np.abs(mean)))
    pieces = [(motion, _pieces(motion)) for motion in motions]
    seconds = [sum(map(_seconds, found)) for _, found in pieces]
    if not used.size or sum(seconds) < _LEAST:
        return unchosen(
            top,
            f"bandwidth {top:.3g} Hz: {sum(seconds):.1f} s of motion are too short to choose one",
        )
    edges = _edges(widest)
    found = [_spectra(found, used, edges) for _, found in pieces if found]
    spectra = found[0]
    for other in found[1:]:
        spectra = spectra + other
    names = tuple(joints[n] for n in used)
    longest = max(_seconds(piece) for motion in motions for piece in _segments(motion))
    return _chosen(spectra, names, size[used], edges, (widest, top, order, longest))


def _chosen(
    spectra: _Spectra,
    joints: tuple[str, ...],
    size: Floats,
    edges: Floats,
    limits: tuple[float, float, int, float],
) -> Bandwidth:
    widest, top, order, longest = limits
    middle, width = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)[:, None]
    # The motion was low-passed at its widest; undo it.
    lost = ((1.0 + (middle / widest) ** (2 * order)) ** 2)[:, None] / spectra.windows
    torque = spectra.torque * lost
    related = spectra.coherence(spectra.cross, spectra.predicted) * torque
    with_acceleration = spectra.coherence(spectra.cross_inertial, spectra.inertial)
    of_acceleration = _floor((1.0 - with_acceleration) * spectra.inertial * lost)
    of_torque = _floor(torque - related)
    noise = of_acceleration + of_torque
    noises = of_acceleration, AVERAGED**2 * of_torque
    counted = noises[0] + noises[1]

    def passed(hertz: float, density: Floats = noise) -> Floats:
        """Return (J,) rms that passes a low-pass, over that of the torque."""
        gain = 1.0 / (1.0 + (middle / hertz) ** (2 * order))
        return np.asarray(np.sqrt((gain[:, None] ** 2 * density * width).sum(axis=0)) / size)

    low = min(top, max(_own(spectra.speed, edges) * _TIMES, 2 * settling(order, _ENDS * longest)))
    tried = np.geomspace(low, top, 60)
    fits = np.array([float(passed(hertz, counted).mean()) <= NOISE for hertz in tried])
    hertz = float(f"{tried[np.flatnonzero(fits)[-1]] if fits.any() else low:.2g}")
    worst = int(np.argmax(passed(top, counted)))
    above = middle >= min(hertz, middle[-1])  # bands are coarse where samples are few
    reason = f"bandwidth {hertz:g} Hz: "
    if fits[-1]:
        limit = "the widest that is chosen" if top == USUAL else "a quarter of the sampling rate"
        share = percent(float(passed(hertz).mean()))
        reason += f"{limit}; noise in it is {share} of the torque"
    elif passed(top, noises[0])[worst] > passed(top, noises[1])[worst]:
        share = percent(float(passed(top, noises[0])[worst]))
        reason += (
            f"at {top:.3g} Hz noise of the acceleration would add a torque to {joints[worst]} that "
            f"was never there, {share} the size of the measured one"
        )
    else:
        unrelated = 1.0 - (related * width)[above].sum(0) / (torque * width)[above].sum(0)
        share = percent(float(unrelated[worst]))
        reason += f"above it {share} of {joints[worst]}'s torque is unrelated to the motion"
    if not fits.any():
        left = percent(float(passed(hertz).mean()))
        reason += f"; noise left in it is {left} of the torque, but the motion needs this much"
    torque, related, noise = np.sqrt(torque), np.sqrt(related), np.sqrt(noise)
    return Bandwidth(hertz, reason, joints, edges, torque, related, noise, size)


def _floor(density: Floats) -> Floats:
    """Return (F, J) the least density at a frequency or any above."""
    return np.asarray(np.minimum.accumulate(density[::-1], axis=0)[::-1])


def _own(speed: Floats, edges: Floats) -> float:
    """Return the frequency in Hz below which every joint has most of its velocity."""
    squared = (0.5 * (edges[1:] + edges[:-1]))[:, None] ** 2
    position = speed / squared
    # Less the noise of position, which scatters about three times its least.
    moved = np.maximum(position - 3.0 * _floor(position), 0.0) * squared
    power = np.cumsum(moved * np.diff(edges)[:, None], axis=0)
    reached = np.argmax(power >= _WITHIN * power[-1], axis=0)
    return float(edges[1 + int(reached.max())])


def _edges(widest: float) -> Floats:
    """Return the edges of the bands in Hz: half a hertz wide, then an eighth of an octave."""
    top = _SEEN * widest
    fine = np.arange(0.0, min(4.0, top) + 1e-9, 0.5)
    count = max(1, round(8 * np.log2(top / fine[-1])))
    return np.unique(np.concatenate([fine, np.geomspace(fine[-1], top, count + 1)]))


def _segments(motion: Motion) -> list[Motion]:
    return [motion.take(slice(begin, end)) for begin, end in stretches(motion.segment)]


def _pieces(motion: Motion) -> list[Motion]:
    """Return stretches without a gap, long enough for a window, at most two minutes in all."""
    found = []
    for segment in _segments(motion):
        parts = max(1, round(_seconds(segment) / _PIECE))
        cuts = np.linspace(0, len(segment), parts + 1).astype(int)
        found += [segment.take(slice(a, b)) for a, b in pairwise(cuts)]
    found = [piece for piece in found if _seconds(piece) >= 0.5 * _WINDOW]
    chosen = np.unique(np.linspace(0, len(found) - 1, min(_PIECES, len(found))).astype(int))
    return [found[k] for k in chosen]


def _seconds(motion: Motion) -> float:
    return float(motion.time[-1] - motion.time[0]) if len(motion) > 1 else 0.0


def _spectra(pieces: Sequence[Motion], used: Ints, edges: Floats) -> _Spectra:
    """Return the spectra of one recording, its regression predicting blocks left out."""
    time = pieces[0].time
    rate = (len(time) - 1) / float(time[-1] - time[0])
    speed = np.concatenate([piece.qd[:, used] for piece in pieces])
    scale = _STEP * np.sqrt((speed**2).mean(axis=0)) + 1e-12
    columns = [_regressors(piece, used, scale) for piece in pieces]
    mean = np.concatenate([piece.tau[:, used] for piece in pieces]).mean(axis=0)
    torques = [piece.tau[:, used] - mean for piece in pieces]
    speeds = [piece.qd[:, used] for piece in pieces]
    own = _own(_power(speeds, speeds, rate, edges)[0].real, edges)
    cut = max(_TIMES * own, 3.0)
    weights, fold = _left_out(
        np.concatenate([_low_pass(one, cut, rate) for one in columns]),
        np.concatenate([_low_pass(one, cut, rate) for one in torques]),
    )
    every = np.concatenate(columns)
    predicted, inertial = np.empty((2, len(every), used.size))
    for k, one in enumerate(weights):
        inside = fold == k
        predicted[inside] = every[inside] @ one
        inertial[inside] = every[inside, : used.size] @ one[: used.size]
    cuts = np.cumsum([len(one) for one in torques])[:-1]
    guesses, inertials = np.split(predicted, cuts), np.split(inertial, cuts)
    measured, bins, windows = _power(torques, torques, rate, edges)
    return _Spectra(
        measured.real,
        _power(guesses, guesses, rate, edges)[0].real,
        _power(inertials, inertials, rate, edges)[0].real,
        _power(speeds, speeds, rate, edges)[0].real,
        _power(guesses, torques, rate, edges)[0],
        _power(inertials, torques, rate, edges)[0],
        windows,
        bins,
    )


def _regressors(motion: Motion, used: Ints, scale: Floats) -> Floats:
    """Return (M, K) columns, those of acceleration first."""
    q, qd, qdd = (table[:, used] for table in (motion.q, motion.qd, motion.qdd))
    first, second = np.triu_indices(used.size, 1)
    both = q[:, first] + q[:, second]
    one = np.ones((len(q), 1))
    gravity = [np.cos(q), np.sin(q), np.cos(both), np.sin(both)]
    return np.hstack([qdd, one, qd, np.tanh(qd / scale), *gravity])


def _left_out(columns: Floats, torque: Floats) -> tuple[list[Floats], Ints]:
    """Return (K, J) coefficients without each fold, and the fold (M,) of every sample."""
    size = np.sqrt((columns**2).mean(axis=0)) + 1e-300
    columns = columns / size
    count = len(columns)
    fold = (np.arange(count) * 3 * _FOLDS // count) % _FOLDS
    parts = [(columns[fold == k], torque[fold == k]) for k in range(_FOLDS)]
    grams = [(x.T @ x, x.T @ y) for x, y in parts]
    whole, right = (np.sum(one, axis=0) for one in zip(*grams, strict=True))
    best: list[Floats] = []
    least = np.inf
    for ridge in _RIDGES:
        penalty = ridge * count * np.eye(len(size))
        found = [np.linalg.solve(whole - a + penalty, right - b) for a, b in grams]
        left = sum(((y - x @ w) ** 2).sum(0) for (x, y), w in zip(parts, found, strict=True))
        missed = float(np.mean(left / np.maximum((torque**2).sum(axis=0), 1e-300)))
        if missed < least:
            least, best = missed, [one / size[:, None] for one in found]
    return best, fold


def _low_pass(values: Floats, hertz: float, rate: float) -> Floats:
    """Return (M, K) columns low-passed, less a line through their ends that is added again."""
    ends = np.linspace(values[0], values[-1], len(values))
    count = len(values) + round(1.5 * rate / hertz)
    # Lengths of small factors transform many times faster.
    count += -count % (1 << max(0, count.bit_length() - 6))
    padded = np.pad(values - ends, ((0, count - len(values)), (0, 0)))
    waves = np.fft.rfft(padded, axis=0)
    waves /= (1.0 + (np.fft.rfftfreq(len(padded), 1.0 / rate) / hertz) ** 6)[:, None]
    return np.asarray(np.fft.irfft(waves, len(padded), axis=0)[: len(values)] + ends)


def _power(
    ones: Sequence[Floats], others: Sequence[Floats], rate: float, edges: Floats
) -> tuple[Floats, Ints, float]:
    """Return the cross density (F, J), summed over windows, the bins of each band, the windows.

    Welch's method: windows of von Hann, overlapping by half.
    """
    length = round(_WINDOW * rate)
    if max(map(len, ones)) < length:
        length //= 2
    window = np.hanning(length)[:, None]
    frequency = np.fft.rfftfreq(length, 1.0 / rate)
    band = np.searchsorted(edges, frequency, side="right") - 1
    inside = (band >= 0) & (band < len(edges) - 1)
    total = np.zeros((len(frequency), ones[0].shape[1]), dtype=complex)
    windows = 0
    for one, other in zip(ones, others, strict=True):
        for begin in range(0, len(one) - length + 1, max(1, length // 2)):
            a, b = one[begin : begin + length], other[begin : begin + length]
            first = np.fft.rfft((a - a.mean(axis=0)) * window, axis=0)
            second = first if one is other else np.fft.rfft((b - b.mean(axis=0)) * window, axis=0)
            total += np.conj(first) * second
            windows += 1
    total *= 2.0 / (rate * float((window**2).sum()))
    bins = np.bincount(band[inside], minlength=len(edges) - 1)
    found = np.zeros((len(edges) - 1, total.shape[1]), dtype=complex)
    np.add.at(found, band[inside], total[inside])
    found /= np.maximum(bins, 1)[:, None]
    return found, bins, float(windows)
