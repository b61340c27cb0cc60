"""Localisation of the error in one comparison."""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.diagnosis.compare import Comparison, every
from lagrangian_ff.diagnosis.where.bins import Bins, bins_of
from lagrangian_ff.diagnosis.where.coordinates import COORDINATES, OUTSIDE
from lagrangian_ff.diagnosis.where.orders import NAMED_SHARE, Spectrum, order_spectrum
from lagrangian_ff.diagnosis.where.regions import Region, find_regions
from lagrangian_ff.diagnosis.where.series import BLOCK_SECONDS, FEWEST_BLOCKS, ResidualSeries
from lagrangian_ff.identification import Model
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, silent

ERROR_BLOCK_SECONDS = 3.0


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
        """The joints whose error is spread evenly; none if the motion is too short."""
        if self.series.too_short:
            return ()
        found = {region.joint for region in self.regions}
        return tuple(name for name in self.comparison.score.joints if name not in found)

    def words(self) -> list[str]:
        """Return it in words, one sentence each."""
        if self.series.too_short:
            least = FEWEST_BLOCKS * BLOCK_SECONDS
            return [
                "the motion is too short to tell where the error lies: record "
                f"{least:.0f} s or more"
            ]
        lines = [region.words for region in self.regions]
        for spectrum in self.spectra:
            lines += [
                f"{spectrum.joint}: a wave of {line.amplitude:.2g} N·m over its angle, "
                f"{line.order:.3g} to a turn"
                for line in spectrum.lines[:1]
                if spectrum.share(line) >= NAMED_SHARE
            ]
        if self.evenly:
            lines.append(f"{', '.join(self.evenly)}: the error is spread evenly")
        return lines

    def record(self, *, series: bool = False) -> dict[str, object]:
        """Return it for JSON.

        Args:
            series: with the torques over time, thinned, for a page to draw.
        """
        found: dict[str, object] = {
            **self.comparison.record(),
            "regions": [region.record() for region in self.regions],
            "evenly": list(self.evenly),
            "too_short": self.series.too_short,
            "words": self.words(),
            "blocks": self._blocks(),
            "bins": [bins.record() for bins in self.bins],
            "spectra": [spectrum.record() for spectrum in self.spectra],
            "outside": self._outside(),
        }
        if series:
            found["series"] = self._series()
        return found

    def _blocks(self) -> list[dict[str, object]]:
        """Return the error of each 3 s."""
        number = self.series.motion.blocks(ERROR_BLOCK_SECONDS)
        elapsed, squared = self.series.motion.elapsed, self.series.residual**2
        rows = []
        for k in np.unique(number):
            inside = number == k
            rmse = np.sqrt(squared[inside].mean(axis=0))
            begin, end = float(elapsed[inside][0]), float(elapsed[inside][-1])
            joints = dict(zip(self.series.motion.joints, rmse.tolist(), strict=True))
            rows.append({"begin": begin, "end": end, "joints": joints})
        return rows

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

    def _series(self) -> dict[str, object]:
        interval = self.comparison.interval
        part = every(self.series.motion) if interval is None else interval.at
        motion, predicted = self.series.motion.take(part), self.comparison.predicted[part]
        return {
            "time": self.series.motion.elapsed[part].tolist(),
            "segment": motion.segment.tolist(),
            "joints": {
                name: {
                    "measured": motion.tau[:, n].tolist(),
                    "predicted": predicted[:, n].tolist(),
                    **({"reach": interval.reach[:, n].tolist()} if interval else {}),
                }
                for n, name in enumerate(motion.joints)
            },
        }


def locate(
    model: Model, comparison: Comparison, seed: int = 0, progress: Progress = silent
) -> Localisation:
    """Return where a model fails.

    Args:
        model: the model; its load and its range are coordinates.
        comparison: of the model with a motion.
        seed: of everything drawn at random, so that the same data give the same words.
        progress: receives the share done, 0 to 1.
    """
    motion = comparison.motion
    load = comparison.load
    if load is None:
        states = motion.q, motion.qd, motion.qdd
        load = model.inputs(*states, time=motion.time, segment=motion.segment).load
    excess = model.range.excess(States.of(motion.q, motion.qd, motion.qdd)).max(axis=1)
    series = ResidualSeries(motion, comparison.residual, load, excess)
    bins: list[Bins | None] = []
    regions: list[Region] = []
    spectra: list[Spectrum | None] = []
    binned = [coordinate for coordinate in COORDINATES.values() if coordinate.binned]
    for joint, name in enumerate(motion.joints):
        progress(joint / len(motion.joints), name)
        bins += [bins_of(series, joint, coordinate, seed=seed) for coordinate in binned]
        regions += find_regions(series, joint, seed)
        spectra.append(order_spectrum(series, joint, seed))
    progress(1.0, "done")
    weight = dict(zip(motion.joints, np.nan_to_num(comparison.score.nmse), strict=True))
    regions.sort(key=lambda region: -weight[region.joint] * region.strength)
    return Localisation(
        comparison, series, tuple(one for one in bins if one is not None), tuple(regions),
        tuple(one for one in spectra if one is not None),
    )  # fmt: skip
