"""Touches of the arm: short bursts of residual torque that neither the model nor chance explains.

A touch of some tenths of a second shows in the residual of a model that is right before and after
it. `bursts` says what the model's own errors give; chance is judged by the largest outputs of its
filters elsewhere, in the training motion and in the rest of the recording, with a tail that falls
as slowly as theirs (Hill 1975, Annals of Statistics 3; Weissman 1978, JASA 73).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.bursts import BLOCK, Filters, Scan
from lagrangian_ff.identification import Model, decimated
from lagrangian_ff.identification.certainty.uncertainty import quick_factor
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.words import listed

MOST = 6000
"""Samples that are looked at together: of the training motion, and of a recording at a time."""
PIECE = 10.0
"""s, of the pieces that a long training motion is thinned by."""
TAIL = 0.25
"""Share of the blocks, from the largest output on, that shows how slowly the tail falls; and the
most that touches may take of a recording, else the model is wrong in another way."""
FEWEST = 20, 4
"""Blocks, of the training and of the recording beside its touches, that chance is judged by."""
NORMAL = 1.645
"""Standard deviations to both sides of 90 %."""

Peak = tuple[int, int, int]
"""The filter, the sample and the joint that see a touch best."""


@dataclass(frozen=True)
class Contact:
    """A touch of the arm.

    Attributes:
        begin, end: s, where the torque on its first joint is half its largest.
        sizes: by joint that feels it, the clearest first, the mean torque in between, N·m, with its
            90 % interval. It is what the actuators gave beyond what the motion took, so that the
            torque from outside has the other sign.
        p_value: how often chance gives as much anywhere in such a recording, at most.
        source: the recording.
    """

    begin: float
    end: float
    sizes: Mapping[str, Estimate]
    p_value: float
    source: str = ""

    @property
    def sure(self) -> bool:
        """Return whether chance hardly gives as much; else it is no more than suggested."""
        return self.p_value < thresholds.USED.touch_level

    def beside(self, other: "Contact") -> bool:
        """Return whether no more lies between two touches than the longer one lasts."""
        long = max(self.end - self.begin, other.end - other.begin)
        return self.begin <= other.end + long and other.begin <= self.end + long

    @property
    def words(self) -> str:
        """Return when it was, how long it lasted, and its torques."""
        sizes = [f"{size.value:.2g} {size.unit} on {name}" for name, size in self.sizes.items()]
        return f"at {self.begin:.2f} s for {self.end - self.begin:.2g} s: {listed(sizes)}"


def contacts_of(model: Model, motion: Motion) -> tuple[Contact, ...]:
    """Return what touched the arm for two seconds or less, in the order of time.

    Nothing is found at rest, outside the range that the model knows, within a touch's length of the
    end of a segment, and by a model that learned from less than 20 s or was not calibrated.

    Args:
        motion: measured; its joints may be more, in any order.
    """
    motion = decimated(motion.select(model.joints))
    learned = _thinned(model.data.take(np.flatnonzero(model.trained)))
    if quick_factor(model) is None or min(_blocks(motion), _blocks(learned)) < FEWEST[1]:
        return ()
    filters = Filters.of(model, learned)
    usual = filters.usual.largest(filters.usual.z)
    if len(usual) < FEWEST[0]:
        return ()
    pieces = -(-len(motion) // MOST)
    parts = np.array_split(np.arange(len(motion)), pieces)
    scans = [filters.scan(motion.take(part)) for part in parts]
    found = [contact for scan in scans for contact in _beyond_chance(scan, usual, pieces)]
    return tuple(sorted(found, key=lambda one: one.begin))


def _blocks(motion: Motion) -> int:
    return int(motion.blocks(BLOCK)[-1]) + 1 if len(motion) else 0


def _thinned(motion: Motion) -> Motion:
    """Return the motion, or evenly spread pieces of it with about `MOST` samples."""
    every = -(-len(motion) // MOST)
    if every <= 1:
        return motion
    piece = motion.blocks(PIECE)
    return replace(motion, segment=piece).take(piece % every == 0)


def _beyond_chance(scan: Scan, usual: Floats, pieces: int) -> list[Contact]:
    """Return the candidates that chance hardly gives.

    As many are taken as stand out from all that is not among them, so that several touches do not
    hide each other.

    Args:
        usual: the largest outputs of the blocks of the training motion.
        pieces: of this length that the recording consists of.
    """
    z = scan.z
    blocks = len(scan.largest(z))
    values: list[float] = []
    peaks: list[Peak] = []
    count, chance = 0, _Chance(0, usual, usual)
    while len(peaks) < TAIL * blocks:
        f, m, n = map(int, np.unravel_index(int(np.argmax(z)), z.shape))
        values.append(float(z[f, m, n]))
        peaks.append(_middle(scan, (f, m, n)))
        _leave_out(scan, z, *peaks[-1][:2])
        rest = scan.largest(z)
        if len(rest) < FEWEST[1]:
            break
        judged = _Chance(blocks * pieces, usual, rest)
        if judged.expected(values[-1]) < thresholds.USED.level:
            count, chance = len(peaks), judged
    found: list[Contact] = []
    for value, peak in zip(values[:count], peaks[:count], strict=True):
        contact = _contact(scan, peak, chance, value)
        # What swells and fades beside a surer touch is part of it.
        if contact and not any(contact.beside(one) for one in found):
            found.append(contact)
    return found


def _middle(scan: Scan, peak: Peak) -> Peak:
    """Return the filter and the sample in the middle of the touch that a filter sees.

    Beside a large touch, where little is expected, it may stand out more than in its middle; and
    a short filter may be the first to see a long one. The largest output is in its middle.
    """
    f, m, n = peak
    size = np.where(np.isfinite(scan.scale[..., n]), np.abs(scan.output[..., n]), 0.0)
    while True:
        reach = int(1.5 * scan.counts[f])
        low, first = max(f - 1, 0), max(m - reach, 0)
        near = size[low : f + 2, first : m + reach + 1]
        k, at = np.unravel_index(int(np.argmax(near)), near.shape)
        if near[k, at] <= size[f, m]:
            return f, m, n
        f, m = low + int(k), first + int(at)


def _leave_out(scan: Scan, z: Floats, f: int, m: int) -> None:
    """Set to 0 the outputs that see the touch in whose middle, sample `m`, filter `f` sees it.

    To either side of its middle it takes as long as the filter's window to fade.
    """
    away = np.abs(np.arange(z.shape[1]) - m) - scan.counts[f]
    for k, count in enumerate(scan.counts.tolist()):
        z[k, away <= 1.5 * count] = 0.0


@dataclass(frozen=True)
class _Chance:
    """What chance gives in a recording.

    Attributes:
        blocks: of the recording.
        usual, rest: the largest outputs of blocks without a touch, of the training motion and of
            the recording.
    """

    blocks: int
    usual: Floats
    rest: Floats

    def expected(self, value: float) -> float:
        """Return the number of blocks of the recording that reach a value, at most.

        The training motion and the rest of the recording each say so; both together show how
        slowly the tail falls.
        """
        pool = np.sort(np.concatenate([self.usual, self.rest]))[::-1]
        many = max(2, round(TAIL * len(pool)))
        fall = 1.0 / max(float(np.mean(np.log(pool[:many] / pool[many]))), 1e-3)
        shares = []
        for some in (self.usual, self.rest):
            many = max(2, round(TAIL * len(some)))
            level = np.sort(some)[-many]
            shares.append(many / (len(some) + 1) * (level / value) ** fall)
        return float(self.blocks * max(shares))

    def felt(self, value: float) -> bool:
        """Return whether a joint feels a touch that another joint shows."""
        return value > float(np.quantile(self.usual, 1.0 - thresholds.USED.level))


def _contact(scan: Scan, peak: Peak, chance: _Chance, value: float) -> Contact | None:
    """Return the touch that a filter sees; None if it does not begin and end there.

    Args:
        value: the largest output about it.
    """
    f, m, n = peak
    half = (int(scan.counts[f]) - 1) // 2
    window = slice(m - 3 * half - 1, m + 3 * half + 2)
    part, time = scan.residual[window], scan.motion.time[window]
    middle = np.abs(np.arange(len(part)) - len(part) // 2) <= half
    part = part - part[~middle].mean(axis=0)
    course = np.sign(scan.output[peak]) * part[:, n]
    smooth = np.ones(2 * (half // 2) + 1)
    course = np.convolve(course, smooth / len(smooth), mode="same")
    top = int(np.argmax(np.where(middle, course, -np.inf)))
    low = np.flatnonzero(course < 0.5 * course[top])
    if not len(low) or not low[0] < top < low[-1]:
        return None
    first, last = int(low[low < top][-1]) + 1, int(low[low > top][0]) - 1
    at, error = scan.z[f, m], (NORMAL * scan.scale[f, m]).tolist()
    size = part[first : last + 1].mean(axis=0).tolist()
    felt = [k for k in np.argsort(-at).tolist() if k == n or chance.felt(at[k])]
    sizes = {
        scan.motion.joints[k]: Estimate(size[k], size[k] - error[k], size[k] + error[k], "N·m")
        for k in felt
    }
    p_value = -float(np.expm1(-chance.expected(value)))
    return Contact(float(time[first]), float(time[last]), sizes, p_value, scan.motion.source)
