"""Localisation of the error in one comparison."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np

from lagrangian_ff.diagnosis.compare import OUTSIDE, Comparison
from lagrangian_ff.diagnosis.where.bins import Bins, bins_of
from lagrangian_ff.diagnosis.where.coordinates import COORDINATES
from lagrangian_ff.diagnosis.where.orders import Spectrum, order_spectrum
from lagrangian_ff.diagnosis.where.regions import Region, find_regions
from lagrangian_ff.diagnosis.where.series import BLOCK_SECONDS, FEWEST_BLOCKS, ResidualSeries
from lagrangian_ff.identification import Model
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, silent

ERROR_BLOCK_SECONDS = 3.0


@dataclass(frozen=True)
class BlockError:
    """The error in a block of 3 s.

    Attributes:
        begin, end: s since the first sample.
        joints: the rms error of each joint by name, N·m.
    """

    begin: float
    end: float
    joints: Mapping[str, float]


@dataclass(frozen=True)
class Localisation:
    """The localisation of a model's error.

    Attributes:
        comparison: of the model with the motion.
        series: the residual with what it may depend on.
        bins: the mean residual over every coordinate and joint.
        regions: the few that hold most of the error, those of the worst joints first.
        spectra: of the joints that move far enough.
    """

    comparison: Comparison
    series: ResidualSeries
    bins: tuple[Bins, ...]
    regions: tuple[Region, ...]
    spectra: tuple[Spectrum, ...]

    @property
    def evenly(self) -> tuple[str, ...]:
        """Return the joints whose error is spread evenly; none if the motion is too short."""
        if self.series.too_short:
            return ()
        found = {region.joint for region in self.regions}
        return tuple(name for name in self.comparison.score.joints if name not in found)

    def words(self) -> list[str]:
        """Return the regions, waves and joints without either, a sentence each."""
        if self.series.too_short:
            least = FEWEST_BLOCKS * BLOCK_SECONDS
            return [
                "the motion is too short to tell where the error lies: record "
                f"{least:.0f} s or more"
            ]
        lines = [region.words for region in self.regions]
        lines += [
            f"{one.joint}: a wave of {one.named.amplitude:.2g} N·m over its angle, "
            f"{one.named.order:.3g} to a turn"
            for one in self.spectra
            if one.named
        ]
        if self.evenly:
            lines.append(f"{', '.join(self.evenly)}: the error is spread evenly")
        return lines

    @property
    def blocks(self) -> list[BlockError]:
        """Return the error of each 3 s."""
        number = self.series.motion.blocks(ERROR_BLOCK_SECONDS)
        elapsed, squared = self.series.motion.elapsed, self.series.residual**2
        found = []
        for inside in (number == k for k in np.unique(number)):
            rmse = np.sqrt(squared[inside].mean(axis=0)).tolist()
            joints = dict(zip(self.series.motion.joints, rmse, strict=True))
            time = elapsed[inside]
            found.append(BlockError(float(time[0]), float(time[-1]), joints))
        return found

    def record(self) -> dict[str, object]:
        """Return the localisation and the comparison for JSON."""
        return {
            **self.comparison.record(),
            "regions": [region.record() for region in self.regions],
            "evenly": list(self.evenly),
            "too_short": self.series.too_short,
            "words": self.words(),
            "blocks": [asdict(block) for block in self.blocks],
            "bins": [bins.record() for bins in self.bins],
            "spectra": [spectrum.record() for spectrum in self.spectra],
            "outside": self._outside(),
        }

    def _outside(self) -> dict[str, object]:
        """Return the error where the motion leaves what the model knows, and that elsewhere."""
        away = self.series.excess > OUTSIDE
        squared = self.series.residual**2
        total = squared.sum(axis=0)
        joints = {}
        for n, name in enumerate(self.series.motion.joints):
            joints[name] = {
                "share_of_error": float(squared[away, n].sum() / total[n]) if total[n] else 0.0,
                "rmse_outside": float(np.sqrt(squared[away, n].mean())) if away.any() else None,
                "rmse_inside": float(np.sqrt(squared[~away, n].mean())) if not away.all() else None,
            }
        return {"share_of_time": float(away.mean()), "joints": joints}


@dataclass(frozen=True)
class Compared:
    """A model file compared with recordings, as a page shows it and JSON holds it.

    Attributes:
        model: the file.  sources: the recordings.
        where: the error and its localisation.
    """

    model: str
    sources: tuple[str, ...]
    where: Localisation

    def record(self) -> dict[str, object]:
        """Return the files and the localisation for JSON."""
        return {"model": self.model, "sources": list(self.sources), **self.where.record()}


def locate(model: Model, comparison: Comparison, progress: Progress = silent) -> Localisation:
    """Return where a model fails; the same data give the same words.

    Args:
        model: its load and its range are coordinates.
        progress: receives the share done, 0 to 1.
    """
    motion = comparison.motion
    load = comparison.load
    if load is None:
        states = motion.q, motion.qd, motion.qdd
        load = model.inputs(*states, time=motion.time, segment=motion.segment).load
    excess = model.range.excess(States.of(motion.q, motion.qd, motion.qdd)).max(axis=1)
    static = np.zeros(len(motion.joints))
    for term, place in model.basis.slices():
        if term.effect.name == "coulomb":
            static[term.joint] = abs(float(model.coefficients[place][0]))
    series = ResidualSeries(motion, comparison.residual, load, excess, static)
    bins: list[Bins] = []
    regions: list[Region] = []
    spectra: list[Spectrum] = []
    binned = [coordinate for coordinate in COORDINATES.values() if coordinate.binned]
    for joint, name in enumerate(motion.joints):
        progress(joint / len(motion.joints), name)
        bins += [one for each in binned if (one := bins_of(series, joint, each))]
        regions += find_regions(series, joint)
        spectrum = order_spectrum(series, joint)
        spectra += [spectrum] if spectrum else []
    progress(1.0, "done")
    weight = dict(zip(motion.joints, np.nan_to_num(comparison.score.nmse), strict=True))
    regions.sort(key=lambda region: -weight[region.joint] * region.strength)
    return Localisation(comparison, series, tuple(bins), tuple(regions), tuple(spectra))
