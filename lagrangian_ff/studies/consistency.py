"""Theorem 2 of the paper, measured: error against the number of samples."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lagrangian_ff.arrays import Floats
from lagrangian_ff.report.colours import FAINT
from lagrangian_ff.studies.curves import DOTTED, Curve, Stroke, curves_figure, stroke_of
from lagrangian_ff.studies.dof import Learning, RobotStudy, error_of
from lagrangian_ff.studies.learning import learn, model_of
from lagrangian_ff.studies.paper import friction_columns
from lagrangian_ff.studies.robots import Samples, Scene, draw_samples
from lagrangian_ff.studies.study import Finding, Line, Results, cells, done, grouped, row

JOINTS = 2
COUNTS, QUICK_COUNTS = (25, 50, 100, 200, 400, 800, 1600), (25, 100)
SCENE = Scene(friction=True, noise=0.05)
NEAR = 1.05
"""Measured errors are at the noise floor where they are within this of the noise alone."""
SHARP = 1e-3
"""σ_f in rad/s at which the basis (51), of those searched, comes nearest to a sharp sign."""
BOUND = Stroke(FAINT, DOTTED)


class Growing(Learning):
    """A case: one model learns one robot from a number of samples."""

    @property
    def name(self) -> str:
        """Return a name such as `m0400-robot03-vrbfs+fri`."""
        return f"m{self.scene.training:04d}-robot{self.robot:02d}-{self.model}"

    def run(self) -> Mapping[str, Any]:
        """Learn and validate.

        Returns:
            In the robot's unit of torque, over validation samples and joints: `error`, that of the
            torques without noise; `bound`, the right side of (50): the friction that the model's
            friction basis cannot be; what was chosen.
        """
        spec = model_of(self.model)
        samples = draw_samples(self.scene, self.seed, self.joints, self.robot)
        learned = learn(spec, samples.x, samples.tau, samples.fold, self.gamma)
        return {
            "samples": self.scene.training,
            "robot": self.robot,
            "model": self.model,
            "error": error_of(learned, samples, samples.truth),
            "bound": bound(samples, with_basis=bool(spec.effects)),
            **learned.record(),
        }


def bound(samples: Samples, *, with_basis: bool) -> float:
    """Return the friction that is left when the friction basis (51) has taken all it can, eq. (50).

    It is the root of the mean squared torque of all joints, over the validation samples.
    """
    left = samples.asked_friction
    if with_basis:
        joints = range(samples.asked.joints)
        columns = friction_columns(samples.asked, samples.x, np.full(len(joints), SHARP))
        left = np.stack([_residual(columns[:, n], left[:, n]) for n in joints], axis=1)
    return float(np.sqrt(np.mean(left**2)))


def _residual(columns: Floats, values: Floats) -> Floats:
    return np.asarray(values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0])


@dataclass(frozen=True)
class Growth:
    """Means over robots of one model, by rising number of samples; torques in the robots' unit.

    Attributes:
        samples: their numbers.
        error: of torques without noise.
        measured: of torques with their noise.
        robots: the number of robots at each number of samples.
        bound: the right side of (50).
    """

    samples: list[int]
    error: list[float]
    measured: list[float]
    robots: list[int]
    bound: float

    @classmethod
    def of(cls, lines: Sequence[Line]) -> "Growth":
        """Return the means of the lines of one model."""
        groups = dict(sorted(grouped(lines, "samples").items()))
        error = [_rms(group, "error") for group in groups.values()]
        measured = [float(np.hypot(value, SCENE.noise)) for value in error]
        robots = list(map(len, groups.values()))
        return cls(list(groups), error, measured, robots, _rms(groups[max(groups)], "bound"))


def _rms(lines: Sequence[Line], what: str) -> float:
    return float(np.sqrt(np.mean([line[what] ** 2 for line in lines])))


@dataclass(frozen=True)
class ConsistencyResults(Results):
    """Errors over the number of samples, by model."""

    models: Mapping[str, Growth]

    def numbers(self) -> dict[str, Any]:
        models = {name: asdict(growth) for name, growth in self.models.items()}
        return {"noise": SCENE.noise, "models": models}

    def text(self) -> list[str]:
        counts = self._counts()
        text = [
            f"{len(self.lines)} cases; mean error of torque without its noise, of the largest one "
            f"in training, by the number of samples; noise {SCENE.noise:g}",
            "",
            row("", [*map(str, counts), f"{'bound (50)':>12}"], 14),
        ]
        for model, growth in self.models.items():
            errors = dict(zip(growth.samples, growth.error, strict=True))
            last = f"{growth.bound:>12.2g}"
            text.append(row(model, [*cells(counts, errors, "{:.4f}".format), last], 14))
        return text

    def _counts(self) -> list[int]:
        return sorted({count for growth in self.models.values() for count in growth.samples})

    def figure(self) -> Figure:
        """Draw the error without noise, and that of measured torques, which ends at the noise."""
        clean, noisy = "error of torques without noise", "error of measured torques"
        panels: dict[str, dict[str, Curve]] = {clean: {}, noisy: {}}
        for model, growth in self.models.items():
            stroke = stroke_of(model)
            panels[clean][model] = Curve(growth.samples, growth.error, stroke, stroke.ours)
            panels[noisy][model] = Curve(growth.samples, growth.measured, stroke, stroke.ours)
        if self.models:
            counts = self._counts()
            ends = [counts[0], counts[-1]]
            panels[noisy]["noise"] = Curve(ends, [SCENE.noise] * 2, BOUND)
            bounds = [growth.bound for m, growth in self.models.items() if "+fri" not in m]
            if bounds:
                panels[clean]["(50), no fri"] = Curve(ends, [max(bounds)] * 2, BOUND)
        return curves_figure(
            panels, "training samples", "error [of the largest torque]", logarithmic=True
        )


class ConsistencyStudy(RobotStudy):
    """More samples for the same robots, of two joints each: where does the error end?"""

    name = "consistency"
    robots = 8
    usual = ("rbfs+fri", "srbfs+fri", "vrbfs+fri", "chain+fri", "vrbfs", "chain")
    quick_usual = ("rbfs+fri", "chain+fri", "chain")

    def every_case(self) -> Sequence[Growing]:
        """Return cases robot by robot, few samples first."""
        quick, seed = self.request.quick, self.request.seed
        scene = replace(SCENE, validation=500) if quick else SCENE
        return [
            Growing(replace(scene, training=count), None, seed, JOINTS, robot, model)
            for robot in self.drawn
            for count in (QUICK_COUNTS if quick else COUNTS)
            for model in self.models
        ]

    def results(self, lines: Sequence[Line]) -> ConsistencyResults:
        models = {model: Growth.of(some) for model, some in grouped(done(lines), "model").items()}
        findings = {model: _finding(model, growth) for model, growth in models.items()}
        return ConsistencyResults(lines, findings, models)


def _finding(model: str, growth: Growth) -> Finding:
    """Return whether the error ends where Theorem 2 says."""
    error, first = growth.error[-1], growth.error[0]
    if "+fri" in model:
        falls = len(growth.error) > 1 and error < first
        floor = growth.measured[-1] / SCENE.noise
        return Finding(
            falls and floor < NEAR,
            f"{model}: {first:.3g} with {growth.samples[0]} samples, {error:.3g} with "
            f"{growth.samples[-1]}; the error of measured torques is then {floor:.3f} of the noise",
            {"error": error, "floor": floor},
        )
    return Finding(
        error <= growth.bound,
        f"{model}, which has no friction, ends at {error:.3g}: eq. (50) allows {growth.bound:.3g}",
        {"error": error, "bound": growth.bound},
    )
