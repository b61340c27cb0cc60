"""Touches of the arm: short bursts of residual torque that neither the model nor chance explains.

A touch of some tenths of a second shows in the residual of a model that is right before and after
it. `bursts` says what the model's own errors give; chance is judged by the largest outputs of its
filters elsewhere, in the training motion and in the rest of the recordings, with a tail that falls
as slowly as theirs (Hill 1975, Annals of Statistics 3; Weissman 1978, JASA 73).
"""

from collections.abc import Mapping, Sequence
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
"""Samples of the training motion that are looked at, and of a recording at a time."""
PIECE = 10.0
"""s, of the pieces that a long training motion is thinned by."""
TAIL = 0.25
"""Share of the blocks, from the largest output on, that shows how slowly the tail falls; and the
most that touches may take of all recordings, else the model is wrong in another way."""
FEWEST = 20, 4
"""Blocks, of the training and of the recordings beside their touches, that chance is judged by."""
NORMAL = 1.645
"""Standard deviations to both sides of 90 %."""

Peak = tuple[int, int, int]
"""The filter, the sample and the joint of a scan that see a touch best."""


@dataclass(frozen=True)
class Contact:
    """A touch of the arm.

    Attributes:
        begin, end: s, where the torque on its first joint is half its largest.
        sizes: by joint that feels it, the clearest first, the mean torque in between, N·m, with its
            90 % interval. It is what the actuators gave beyond what the motion took, so that the
            torque from outside has the other sign.
        p_value: how often chance gives as much anywhere in all recordings, at most.
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

    def words(self, *, of_several: bool) -> str:
        """Return when it was, how long it lasted, and its torques.

        Args:
            of_several: whether there are other recordings, so that its own is to be named.
        """
        sizes = [f"{size.value:.2g} {size.unit} on {name}" for name, size in self.sizes.items()]
        when = f"at {self.begin:.2f} s" + (f" of {self.source}" if of_several else "")
        return f"{when} for {self.end - self.begin:.2g} s: {listed(sizes)}"


def contacts_of(model: Model, motions: Sequence[Motion]) -> tuple[Contact, ...]:
    """Return what touched the arm for two seconds or less, motion by motion in the order of time.

    Nothing is found at rest, outside the range that the model knows, within a touch's length of the
    end of a segment, and by a model that learned from less than 20 s or was not calibrated.

    Args:
        motions: measured; their joints may be more, in any order. Chance has all of them to give
            as much in, however many parts they are in.
    """
    learned = _thinned(model.data.take(np.flatnonzero(model.trained)))
    if quick_factor(model) is None or _blocks(learned) < FEWEST[1]:
        return ()
    filters = Filters.of(model, learned)
    usual = filters.usual.largest(filters.usual.z)
    if len(usual) < FEWEST[0]:
        return ()
    looks = [
        _Look.of(filters.scan(part))
        for motion in motions
        for part in _parts(decimated(motion.select(model.joints)))
    ]
    return tuple(_beyond_chance(looks, usual))


def _parts(motion: Motion) -> list[Motion]:
    """Return a motion in parts of at most `MOST` samples."""
    count = -(-len(motion) // MOST)
    return [motion.take(part) for part in np.array_split(np.arange(len(motion)), max(1, count))]


def _blocks(motion: Motion) -> int:
    return int(motion.blocks(BLOCK)[-1]) + 1 if len(motion) else 0


def _thinned(motion: Motion) -> Motion:
    """Return the motion, or evenly spread pieces of it with about `MOST` samples."""
    every = -(-len(motion) // MOST)
    if every <= 1:
        return motion
    piece = motion.blocks(PIECE)
    return replace(motion, segment=piece).take(piece % every == 0)


@dataclass
class _Look:
    """A scan from which touches are removed one by one.

    Attributes:
        z: (F, M, N) the outputs, 0 where a touch was removed.
        blocks: the largest output of each block that still has any.
    """

    scan: Scan
    z: Floats
    blocks: Floats

    @classmethod
    def of(cls, scan: Scan) -> "_Look":
        """Return a whole scan."""
        z = scan.z
        return cls(scan, z, scan.largest(z))

    @property
    def best(self) -> float:
        """Return the largest output that is left."""
        return float(self.blocks.max(initial=0.0))

    def remove(self) -> Peak:
        """Remove the touch that stands out most, and return its peak."""
        first = np.unravel_index(int(np.argmax(self.z)), self.z.shape)
        peak = _middle(self.scan, (int(first[0]), int(first[1]), int(first[2])))
        _leave_out(self.scan, self.z, *peak[:2])
        self.blocks = self.scan.largest(self.z)
        return peak


def _beyond_chance(looks: list[_Look], usual: Floats) -> list[Contact]:
    """Return the candidates that chance hardly gives, scan by scan in the order of time.

    As many are taken as stand out from all that is not among them, so that several touches do not
    hide each other.

    Args:
        usual: the largest outputs of the blocks of the training motion.
    """
    blocks = sum(len(look.blocks) for look in looks)
    taken: list[tuple[float, int, Peak]] = []
    count, chance = 0, _Chance(0, usual, usual)
    while len(taken) < TAIL * blocks:
        k = max(range(len(looks)), key=lambda k: looks[k].best)
        value = looks[k].best
        taken.append((value, k, looks[k].remove()))
        rest = np.concatenate([look.blocks for look in looks])
        if len(rest) < FEWEST[1]:
            break
        judged = _Chance(blocks, usual, rest)
        if judged.expected(value) < thresholds.USED.level:
            count, chance = len(taken), judged
    found: list[list[Contact]] = [[] for _ in looks]
    for value, k, peak in taken[:count]:
        contact = _contact(looks[k].scan, peak, chance, value)
        # What swells and fades beside a surer touch is part of it.
        if contact and not any(contact.beside(one) for one in found[k]):
            found[k].append(contact)
    return [one for some in found for one in sorted(some, key=lambda one: one.begin)]


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
    """The largest filter outputs where nothing touched the arm.

    Attributes:
        blocks: of all recordings.
        usual, rest: the largest outputs of blocks without a touch, of the training motion and of
            the recordings.
    """

    blocks: int
    usual: Floats
    rest: Floats

    def expected(self, value: float) -> float:
        """Return the number of blocks of the recordings that reach a value, at most.

        The training motion and the rest of the recordings each say so; both together show how
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
