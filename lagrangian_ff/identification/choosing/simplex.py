"""Choosing hyperparameters by a simplex search, as the paper does: by folds left out or evidence.

Both come from the one factor of a fit. The search is a simplex search on logarithms within stated
ranges, first on a small subset of the samples and then on a larger one, at the cost of a few fits.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.effects import Shape
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.choosing.left_out import require_folds, validation_score
from lagrangian_ff.identification.problem import NOISE_START, Problem, Scaling
from lagrangian_ff.identification.samples import Samples
from lagrangian_ff.identification.settings import Settings
from lagrangian_ff.identification.solving.posterior import exact
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.kernels.threads import one_blas_thread
from lagrangian_ff.progress import Progress, silent

NOISE_RANGE = (1e-6, 0.5)
STAGES = ((120, 0.7), (240, 0.3))
"""Samples used and share of the evaluations spent, stage by stage."""
FAILED = 1e12


def search(
    spec: Spec,
    samples: Samples,
    scalings: Sequence[Scaling],
    settings: Settings,
    progress: Progress = silent,
) -> Problem:
    """Return the problem with the kernel's numbers, the noise and the effects' shapes searched.

    Args:
        spec: kernel family and effects.  samples: with their folds.
        scalings: the ways to normalise torques that are tried; the better one is kept.
        settings: the criterion, `validation` (blocked cross-validation, section IV-B) or
            `evidence`, and the number of points tried, for each joint if joints choose apart.
        progress: receives the share done, 0 to 1.

    Raises:
        ModelError: there is one fold only to validate on.
    """
    require_folds(samples)
    start = Problem.started(spec, samples, scalings[0])
    per_joint = spec.kernel.per_joint
    # Threads cost more than they bring on matrices as small as these.
    with one_blas_thread():
        if not per_joint:
            return _Search(settings, None, _axes(spec)).run(start, scalings, progress)
        joints = samples.x.joints
        for joint in range(joints):

            def report(share: float, label: str, done: int = joint) -> None:
                progress((done + share) / joints, label)

            one = _Search(settings, joint, _axes(spec))
            start = one.run(start, [start.prior.scaling], report)
    return start


@dataclass(frozen=True)
class _Search:
    """Simplex search of the numbers that one joint, or all together, depend on."""

    settings: Settings
    joint: int | None
    axes: "Sequence[_Axis]"

    def run(self, start: Problem, scalings: Sequence[Scaling], progress: Progress) -> Problem:
        """Return the best problem found.

        Every scaling goes through all stages: a small subset favours joints learned apart.
        """
        table = [(axis.low, axis.high, axis.start, axis.step) for axis in self.axes]
        low, high, first, step = np.array(table).T
        bounds = list(zip(low, high, strict=True))
        evaluations = self.settings.evaluations
        planned = sum(share for _, share in STAGES) * len(scalings) * evaluations
        tried = 0
        running = [(0.0, first, start.having(scaling=scaling)) for scaling in scalings]
        for samples, share in STAGES:
            finished = []
            for _, point, problem in running:
                part = problem.thinned(samples)
                groups = part.samples.groups()

                def objective(
                    values: Floats, part: Problem = part, groups: Sequence[Ints] = groups
                ) -> float:
                    nonlocal tried
                    tried += 1
                    progress(min(1.0, tried / planned), "choosing hyperparameters")
                    return self.cost(values, part, groups)

                corners = np.vstack([point, point + np.diag(step)])
                most = max(int(share * evaluations), len(self.axes) + 2)
                found = scipy.optimize.minimize(
                    objective, point, method="Nelder-Mead", bounds=bounds,
                    options={"initial_simplex": np.clip(corners, low, high), "maxfev": most,
                             "xatol": 0.03, "fatol": 1e-4},
                )  # fmt: skip
                finished.append((float(found.fun), np.asarray(found.x), problem))
            running = finished
            step = step * 0.4
        _, point, problem = min(running, key=lambda item: item[0])
        return _at(problem, self.axes, point, self.joint)

    def cost(self, values: Floats, part: Problem, groups: Sequence[Ints]) -> float:
        """Return minus the log evidence, or the log of the left-out error."""
        try:
            found = exact(_at(part, self.axes, values, self.joint), self.joint)
            if self.settings.selection == "evidence":
                return -found.log_evidence
            score = validation_score(found, groups)
        except (NotPositiveDefiniteError, np.linalg.LinAlgError):
            return FAILED
        total = float(np.nanmean(score if self.joint is None else score[self.joint]))
        return float(np.log(total)) if np.isfinite(total) and total > 0.0 else FAILED


@dataclass(frozen=True)
class _Axis:
    """One number that is searched: the logarithm of a multiple, or that of a shape."""

    kind: str
    name: str
    low: float
    high: float
    start: float
    step: float
    shape: Shape | None = None


def _axes(spec: Spec) -> list[_Axis]:
    axes = [
        _Axis("kernel", h.name, np.log(h.low), np.log(h.high), 0.0, 1.2)
        for h in spec.kernel.searched
    ]
    low, high = np.log(NOISE_RANGE)
    axes.append(_Axis("noise", "noise", low, high, float(np.log(NOISE_START)), -1.5))
    for effect in spec.effects:
        axes.extend(
            _Axis(
                effect.name,
                s.name,
                s.logarithm(s.low),
                s.logarithm(s.high),
                s.logarithm(s.start),
                0.8,
                s,
            )
            for s in effect.shapes
        )
    return axes


def _at(problem: Problem, axes: Sequence[_Axis], values: Floats, joint: int | None) -> Problem:
    """Return the problem at a point of the search, for all joints or for one of them."""
    joints, states = problem.samples.x.joints, problem.samples.states
    kernel, basis = problem.kernel, problem.basis
    for axis, value in zip(axes, values, strict=True):
        if axis.kind == "kernel":
            first = kernel.family.start(states).hyperparameters[axis.name]
            old = kernel.hyperparameters[axis.name]
            new = _set(old, first * np.exp(value), joint, joints)
            kernel = kernel.replace(**{axis.name: new})
        elif axis.shape is not None:
            shape = {axis.name: axis.shape.value(value)}
            basis = Basis(
                tuple(
                    replace(term, shape={**term.shape, **shape})
                    if term.effect.name == axis.kind and joint in (None, term.joint)
                    else term
                    for term in basis.terms
                )
            )
    relative = np.exp([values[[axis.kind for axis in axes].index("noise")]])
    problem = problem.having(kernel=kernel, basis=basis)
    fresh = problem.with_relative_noise(relative).noise
    new = _set(problem.noise, fresh if joint is None else fresh[[joint]], joint, joints)
    return problem.having(noise=new)


def _set(old: Floats, new: Floats, joint: int | None, joints: int) -> Floats:
    """Return the new value of all joints, or the old one with one joint's changed."""
    if joint is None:
        return np.asarray(new if new.shape == old.shape else np.broadcast_to(new, old.shape))
    values = np.array(np.broadcast_to(old, (joints,)))
    values[joint] = new[0]
    return values
