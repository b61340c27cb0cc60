"""Everything about where a model fails, for one comparison."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.compare import Comparison
from lagrangian_ff.diagnosis.interval import every
from lagrangian_ff.diagnosis.where.bins import Bins, bins_of
from lagrangian_ff.diagnosis.where.coordinates import COORDINATES, OUTSIDE
from lagrangian_ff.diagnosis.where.course import Course
from lagrangian_ff.diagnosis.where.orders import NAMED_SHARE, Spectrum, order_spectrum
from lagrangian_ff.diagnosis.where.regions import Region, find_regions
from lagrangian_ff.diagnosis.where.resampling import BLOCK_SECONDS, FEWEST_BLOCKS
from lagrangian_ff.identification import Model
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, silent

Floats = NDArray[np.float64]

ERROR_BLOCK_SECONDS = 3.0


@dataclass(frozen=True)
class Whereabouts:
    """Where a model fails.

    Attributes:
        comparison: the model held against the motion.
        course: the same with what the error is looked at against.
        bins: the mean residual over every coordinate and joint.
        regions: the few that hold most of the error, those of the worst joints first.
        spectra: of the joints that move far enough.
    """

    comparison: Comparison
    course: Course
    bins: tuple[Bins, ...]
    regions: tuple[Region, ...]
    spectra: tuple[Spectrum, ...]

    @property
    def evenly(self) -> tuple[str, ...]:
        """The joints whose error is spread evenly; none where that cannot be told."""
        if self.course.too_short:
            return ()
        found = {region.joint for region in self.regions}
        return tuple(name for name in self.comparison.score.joints if name not in found)

    def words(self) -> list[str]:
        """What to tell a person, one sentence each."""
        if self.course.too_short:
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
        """For JSON.

        Args:
            series: with the torques over time, thinned, for a page to draw.
        """
        found: dict[str, object] = {
            **self.comparison.record(),
            "regions": [region.record() for region in self.regions],
            "evenly": list(self.evenly),
            "too_short": self.course.too_short,
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
        """The error of each 3 s."""
        number = self.course.motion.blocks(ERROR_BLOCK_SECONDS)
        elapsed, squared = self.course.motion.elapsed, self.course.residual**2
        rows = []
        for k in np.unique(number):
            inside = number == k
            rmse = np.sqrt(squared[inside].mean(axis=0))
            rows.append(
                {
                    "begin": float(elapsed[inside][0]),
                    "end": float(elapsed[inside][-1]),
                    "joints": dict(zip(self.course.motion.joints, map(float, rmse), strict=True)),
                }
            )
        return rows

    def _outside(self) -> dict[str, object]:
        """The error where the motion leaves what the model knows, beside that where it does not."""
        away = self.course.excess > OUTSIDE
        squared = self.course.residual**2
        total = squared.sum(axis=0)
        joints = {}
        for n, name in enumerate(self.course.motion.joints):
            joints[name] = {
                "share_of_error": float(squared[away, n].sum() / total[n]) if total[n] else 0.0,
                "rmse_outside": float(np.sqrt(squared[away, n].mean())) if away.any() else None,
                "rmse_inside": float(np.sqrt(squared[~away, n].mean())) if not away.all() else None,
            }
        return {"share_of_time": float(away.mean()), "joints": joints}

    def _series(self) -> dict[str, object]:
        interval = self.comparison.interval
        part = every(self.course.motion) if interval is None else interval.at
        motion, predicted = self.course.motion.take(part), self.comparison.predicted[part]
        return {
            "time": [float(v) for v in self.course.motion.elapsed[part]],
            "segment": [int(v) for v in motion.segment],
            "joints": {
                name: {
                    "measured": [float(v) for v in motion.tau[:, n]],
                    "predicted": [float(v) for v in predicted[:, n]],
                    **({"reach": interval.reach[:, n].tolist()} if interval else {}),
                }
                for n, name in enumerate(motion.joints)
            },
        }


def locate(
    model: Model, comparison: Comparison, seed: int = 0, progress: Progress = silent
) -> Whereabouts:
    """Find where a model fails.

    Args:
        model: that was compared; it tells the load, and what it knows.
        comparison: of the model with a motion.
        seed: of everything drawn at random, so that the same data give the same words.
        progress: told the share done.
    """
    motion = comparison.motion
    load = comparison.load
    if load is None:
        states = motion.q, motion.qd, motion.qdd
        load = model.inputs(*states, time=motion.time, segment=motion.segment).load
    excess = model.range.excess(States.of(motion.q, motion.qd, motion.qdd)).max(axis=1)
    course = Course(motion, comparison.residual, load, excess)
    bins: list[Bins] = []
    regions: list[Region] = []
    spectra: list[Spectrum] = []
    for joint, name in enumerate(motion.joints):
        progress(joint / len(motion.joints), name)
        bins += [
            found
            for coordinate in COORDINATES.values()
            if coordinate.binned
            and (found := bins_of(course, joint, coordinate, seed=seed)) is not None
        ]
        regions += find_regions(course, joint, seed)
        spectrum = order_spectrum(course, joint, seed)
        spectra += [spectrum] if spectrum is not None else []
    progress(1.0, "done")
    weight = dict(zip(motion.joints, np.nan_to_num(comparison.score.nmse), strict=True))
    regions.sort(key=lambda region: -weight[region.joint] * region.strength)
    return Whereabouts(comparison, course, tuple(bins), tuple(regions), tuple(spectra))
