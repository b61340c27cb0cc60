"""Choosing hyperparameters: blocked cross-validation, as the paper does, or the evidence.

Both come from the one factor of a fit. The search is a simplex search on logarithms within stated
ranges, on few samples first and on more then, so that it costs little more than a few fits.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.choice import Choice, Scaling, with_noise
from lagrangian_ff.identification.choosing.training import TrainingSet
from lagrangian_ff.identification.solving.equations import fit
from lagrangian_ff.identification.solving.fit import Fit
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.kernels import IndependentKernel, Kernel, States
from lagrangian_ff.progress import Progress, silent

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NOISE_RANGE = (1e-6, 0.5)
NOISE_START = 1e-2
STAGES = ((120, 0.7), (240, 0.3))
"""Samples used and share of the evaluations spent, stage by stage."""
FAILED = 1e12


def validation_score(fitted: Fit, groups: Sequence[Ints]) -> Floats:
    """(N,) mean squared error of each joint on left-out folds, over its torque's variance.

    Each torque counts as much as the fit trusts it. NaN for a joint that was not fitted.
    """
    residual, _ = fitted.left_out(groups)
    errors = fitted.trust * (residual / fitted.scaling.spread) ** 2
    seen = np.isfinite(errors)
    counted = np.sum(fitted.trust, axis=0, where=seen)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sum(errors, axis=0, where=seen) / counted)


def starting_choice(spec: Spec, states: States) -> Choice:
    """The hyperparameters before any search."""
    shapes = {
        effect.name: {s.name: np.full(states.joints, s.start) for s in effect.shapes}
        for effect in spec.effects
        if effect.shapes
    }
    kernel = spec.kernel.start(states)
    if spec.sliding:
        slides = np.isin(np.arange(states.joints), spec.sliding)
        kernel = kernel.replace(prismatic=slides.astype(np.float64))
    choice = Choice(kernel, np.ones(states.joints), shapes)
    return with_noise(choice, np.array([NOISE_START]), states)


def choose(
    spec: Spec,
    data: TrainingSet,
    scalings: Sequence[Scaling],
    criterion: str = "validation",
    evaluations: int = 90,
    progress: Progress = silent,
) -> tuple[Choice, Scaling]:
    """Search the kernel's hyperparameters, the noise, and the effects' shape parameters.

    Args:
        spec: kernel family and effects.
        data: training samples with their folds.
        scalings: the ways to normalise torques that are tried; the better one is kept.
        criterion: `validation` (blocked cross-validation, section IV-B) or `evidence`.
        evaluations: how many settings are tried, a joint where joints choose apart.
        progress: told the share done.

    Raises:
        ModelError: there is one fold only to validate on.
    """
    require_folds(data)
    start = starting_choice(spec, data.states)
    per_joint = issubclass(spec.kernel, IndependentKernel) and spec.kernel.per_joint
    if not per_joint:
        search = _Search(spec, criterion, None, _axes(spec, start))
        # Threads cost more than they bring on matrices as small as these.
        with threadpool_limits(1):
            return search.run(data, start, scalings, evaluations, progress)
    chosen, scaling = start, scalings[0]
    for joint in range(data.states.joints):

        def told(share: float, label: str, done: int = joint) -> None:
            progress((done + share) / data.states.joints, label)

        search = _Search(spec, criterion, joint, _axes(spec, start))
        with threadpool_limits(1):
            chosen, scaling = search.run(data, chosen, [scaling], evaluations, told)
    return chosen, scaling


def require_folds(data: TrainingSet) -> None:
    """Refuse motion of which no part can be left out.

    Raises:
        ModelError: says what to do.
    """
    if len(np.unique(data.fold)) < 2:
        raise ModelError(
            "a model is judged on blocks of its training motion left out in turn, which needs at "
            "least two of them, got one: record longer, use a larger --train, or a shorter --block"
        )


@dataclass(frozen=True)
class _Search:
    """Simplex search of the numbers that one joint, or all together, depend on."""

    spec: Spec
    criterion: str
    joint: int | None
    axes: "Sequence[_Axis]"

    def run(
        self,
        data: TrainingSet,
        start: Choice,
        scalings: Sequence[Scaling],
        evaluations: int,
        progress: Progress,
    ) -> tuple[Choice, Scaling]:
        """The best choice found, and the scaling it was found with.

        Every scaling goes to the end: few samples favour joints that are learned apart.
        """
        step = np.array([axis.step for axis in self.axes])
        first = np.array([axis.start for axis in self.axes])
        planned = sum(share for _, share in STAGES) * len(scalings)
        tried = 0
        running = [(0.0, first, scaling) for scaling in scalings]
        for samples, share in STAGES:
            part = data.thinned(samples)
            groups = part.groups()
            finished = []
            for _, point, scaling in running:

                def objective(
                    values: Floats,
                    part: TrainingSet = part,
                    groups: Sequence[Ints] = groups,
                    scaling: Scaling = scaling,
                ) -> float:
                    nonlocal tried
                    tried += 1
                    progress(min(1.0, tried / (planned * evaluations)), "choosing hyperparameters")
                    return self.cost(values, part, groups, start, scaling)

                cost, found = _simplex(objective, point, step, self.axes, int(share * evaluations))
                finished.append((cost, found, scaling))
            running = finished
            step = step * 0.4
        _, found, scaling = min(running, key=lambda item: item[0])
        return _at(start, self.axes, found, self.joint, data.states), scaling

    def cost(
        self,
        values: Floats,
        part: TrainingSet,
        groups: Sequence[Ints],
        start: Choice,
        scaling: Scaling,
    ) -> float:
        """What is made small: minus the log evidence, or the log of the left-out error."""
        choice = _at(start, self.axes, values, self.joint, part.states)
        joint = self.joint
        try:
            fitted = fit(self.spec, choice, part.x, part.tau, scaling, part.trust, only=joint)
            if self.criterion == "evidence":
                return -fitted.log_evidence
            score = validation_score(fitted, groups)
        except (NotPositiveDefiniteError, np.linalg.LinAlgError):
            return FAILED
        total = float(np.nanmean(score if joint is None else score[joint]))
        return float(np.log(total)) if np.isfinite(total) and total > 0.0 else FAILED


@dataclass(frozen=True)
class _Axis:
    """One number that is searched: the logarithm of a multiple, or of the number itself."""

    kind: str
    name: str
    low: float
    high: float
    start: float
    step: float


def _axes(spec: Spec, start: Choice) -> list[_Axis]:
    axes = [
        _Axis("kernel", h.name, np.log(h.low), np.log(h.high), 0.0, 1.2)
        for h in spec.kernel.searched
    ]
    low, high = np.log(NOISE_RANGE)
    axes.append(_Axis("noise", "noise", low, high, float(np.log(NOISE_START)), -1.5))
    for effect in spec.effects:
        axes.extend(
            _Axis(effect.name, s.name, np.log(s.low), np.log(s.high), np.log(s.start), 0.8)
            for s in effect.shapes
        )
    return axes


def _at(
    start: Choice, axes: Sequence[_Axis], values: Floats, joint: int | None, states: States
) -> Choice:
    """The choice at a point of the search, for all joints or for one of them."""
    joints = states.joints
    kernel: Kernel = start.kernel
    shapes = {effect: dict(named) for effect, named in start.shapes.items()}
    noise = start.noise
    for axis, value in zip(axes, values, strict=True):
        if axis.kind == "kernel":
            first = type(kernel).start(states).hyperparameters[axis.name]
            kernel = kernel.replace(
                **{axis.name: _set(kernel.hyperparameters[axis.name], first * np.exp(value),
                                   joint, joints)}
            )  # fmt: skip
        elif axis.kind != "noise":
            old = shapes[axis.kind][axis.name]
            shapes[axis.kind][axis.name] = _set(old, np.exp([value]), joint, joints)
    choice = Choice(kernel, noise, shapes)
    relative = np.exp([values[[axis.kind for axis in axes].index("noise")]])
    fresh = with_noise(choice, relative, states).noise
    return replace(choice, noise=_set(noise, fresh if joint is None else fresh[[joint]],
                                      joint, joints))  # fmt: skip


def _set(old: Floats, new: Floats, joint: int | None, joints: int) -> Floats:
    """All joints' value, or one joint's with the others kept."""
    if joint is None:
        return np.asarray(new if new.shape == old.shape else np.broadcast_to(new, old.shape))
    values = np.array(np.broadcast_to(old, (joints,)))
    values[joint] = new[0]
    return values


def _simplex(
    objective: Callable[[Floats], float],
    point: Floats,
    step: Floats,
    axes: Sequence[_Axis],
    evaluations: int,
) -> tuple[float, Floats]:
    low = np.array([axis.low for axis in axes])
    high = np.array([axis.high for axis in axes])
    corners = np.vstack([point, point + np.diag(step)])
    found = scipy.optimize.minimize(
        objective,
        point,
        method="Nelder-Mead",
        bounds=list(zip(low, high, strict=True)),
        options={
            "initial_simplex": np.clip(corners, low, high),
            "maxfev": max(evaluations, len(axes) + 2),
            "xatol": 0.03,
            "fatol": 1e-4,
        },
    )
    return float(found.fun), np.asarray(found.x)
