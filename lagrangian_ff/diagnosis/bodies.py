"""Changes of a known robot's bodies: a payload, a tilted base, another mass of one link.

The regressor of a robot that a URDF describes gives the torque of such a change on all joints at
once, linear in physical parameters. Each change is a candidate from a boundary of time on and gets
a log Bayes factor as effects of single joints do (see `search.bayes_factor`).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.search.bayes_factor import PRIOR_SHARE, tempered_log_bf
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.kernels.rigid import Robot
from lagrangian_ff.kernels.rigid.known import Known

PAYLOAD, TILT, MASS = "payload", "tilted base", "mass"


@dataclass(frozen=True)
class BodyChange:
    """A change of a robot's bodies.

    Attributes:
        what: `payload`, `tilted base`, or `mass of` the link that a joint moves.
        log_bayes_factor: nats, tempered.
        parameters: by how much each changed.
        torque: (S, N) N·m that it adds, at the samples of the whitened motion.
        rivals: other changes that explain as much.
    """

    what: str
    log_bayes_factor: float
    parameters: Mapping[str, Estimate]
    torque: Floats
    rivals: tuple[str, ...] = ()


def changed_bodies(model: Model, whitened: Whitened, boundary: float) -> BodyChange | None:
    """Return the change that explains most from a boundary in s on; None without a URDF."""
    if not isinstance(model.kernel, Known):
        return None
    found = sorted(
        (_judged(whitened, one, boundary) for one in _candidates(model, whitened)),
        key=lambda change: -change.log_bayes_factor,
    )
    best = found[0]
    least = best.log_bayes_factor - thresholds.USED.alike
    rivals = tuple(one.what for one in found[1:] if one.log_bayes_factor > least)
    return replace(best, rivals=rivals)


@dataclass(frozen=True)
class _Candidate:
    """A change: its name, its parameters as (name, unit), and their columns (S, N, P)."""

    what: str
    parameters: tuple[tuple[str, str], ...]
    columns: Floats


def _candidates(model: Model, whitened: Whitened) -> Iterator[_Candidate]:
    kernel, robot = model.kernel, model.kernel.mechanism
    assert isinstance(kernel, Known)
    assert isinstance(robot, Robot)
    x = whitened.problem.samples.states
    by_body = robot.tree.regressor(x).reshape(len(x), x.joints, robot.tree.bodies, 10)
    inertia = [("I", "kg·m²")] * 6
    moments = [("mx", "kg·m"), ("my", "kg·m"), ("mz", "kg·m")]
    yield _Candidate(PAYLOAD, (("m", "kg"), *moments, *inertia), by_body[:, :, robot.tool])
    masses = kernel.inertial(model.centres, model.weights).ravel() * model.unit[0]
    strength = float(np.linalg.norm(robot.tree.gravity))
    down = robot.tree.gravity / strength
    turned = [
        replace(robot.tree, gravity=strength * np.cross(down, axis)).regressor(x.at_rest()) @ masses
        for axis in np.eye(3)[:2]
    ]
    about = (("about x", "rad"), ("about y", "rad"))
    yield _Candidate(TILT, about, np.stack(turned, axis=2))
    for body, name in enumerate(robot.movable):
        column = by_body[:, :, body] @ robot.tree.inertial[body]
        mass = float(robot.tree.inertial[body, 0])
        if mass > 0.0:
            yield _Candidate(
                f"{MASS} of the link of {name}", (("m", "kg"),), column[..., None] / mass
            )


def _judged(whitened: Whitened, candidate: _Candidate, boundary: float) -> BodyChange:
    """Return a candidate fitted and judged from the boundary on."""
    columns = candidate.columns * (whitened.x.time >= boundary)[:, None, None]
    share = np.sqrt(np.mean(columns**2, axis=0)) / whitened.spread[:, None]
    largest = share.max(axis=0)
    scale = PRIOR_SHARE / np.where(largest > 0.0, largest, np.inf)
    scaled = columns * scale
    white = sum(whitened.whitened(scaled[:, n], n) for n in range(whitened.joints))
    z, w = whitened.project(np.asarray(white)), whitened.residual
    information, sums = z.T @ z, z.T @ w
    fitted = np.linalg.solve(information + np.eye(len(sums)), sums)
    rest = np.add.reduceat(z * (w - z @ fitted)[:, None], whitened.starts, axis=0)
    trace = float(np.trace(information))
    variance_inflation = max(1.0, float(np.sum(rest**2)) / trace) if trace > 0.0 else 1.0
    log_bf = float(tempered_log_bf(sums[None, :], information, variance_inflation)[0])
    covariance = np.linalg.inv(information / variance_inflation + np.eye(len(sums)))
    variance = np.diag(covariance)
    parameters = {
        name: (float(value), float(deviation), unit)
        for (name, unit), value, deviation, left in zip(
            candidate.parameters, fitted * scale, np.sqrt(variance) * scale, variance, strict=True
        )
        if left < thresholds.USED.learned and name != "I"
    }
    if candidate.what == PAYLOAD:
        parameters = _centre(parameters)
    estimates = {
        name: Estimate(value, value - 1.645 * deviation, value + 1.645 * deviation, unit)
        for name, (value, deviation, unit) in parameters.items()
    }
    return BodyChange(candidate.what, log_bf, estimates, scaled @ fitted)


def _centre(parameters: dict[str, tuple[float, float, str]]) -> dict[str, tuple[float, float, str]]:
    """Return the parameters with a payload's centre of mass, in the frame of the last joint."""
    if "m" not in parameters:
        return parameters
    mass, deviation, _ = parameters["m"]
    out = {"m": parameters["m"]}
    for axis in "xyz":
        if f"m{axis}" in parameters:
            moment, spread, _ = parameters[f"m{axis}"]
            centre = moment / mass
            out[axis] = centre, float(np.hypot(spread, centre * deviation)) / abs(mass), "m"
    return out
