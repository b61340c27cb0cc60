"""What changed of a known robot's bodies: a payload, a tilted base, another mass of one link.

The regressor of a robot that a URDF describes gives the torque of such a change on all joints at
once, linear in physical parameters. Each is a candidate from a boundary of time on, held against
the whitened residual as effects of single joints are (see `search.gain`).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.ground import Ground
from lagrangian_ff.diagnosis.search.gain import PRIOR_SHARE, tempered_gain
from lagrangian_ff.identification import Model
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.rigid import Robot
from lagrangian_ff.kernels.rigid.known import Known

Floats = NDArray[np.float64]

PAYLOAD, TILT, MASS = "payload", "tilted base", "mass"
LEARNED = 0.5
"""Of a parameter's variance a priori: with more left, the motion says nothing of it."""
ALIKE = 3.0
"""Nats within which another change is as good."""


@dataclass(frozen=True)
class BodyChange:
    """A change of a robot's bodies.

    Attributes:
        what: `payload`, `tilted base`, or `mass of` the link that a joint moves.
        gain: nats of log evidence, tempered.
        parameters: by name the change and its standard deviation, and the unit.
        torque: (S, N) N·m that it adds, on the samples of the ground.
        rivals: other changes that explain as much.
    """

    what: str
    gain: float
    parameters: dict[str, tuple[float, float, str]]
    torque: Floats
    rivals: tuple[str, ...] = ()


def changed_bodies(model: Model, ground: Ground, boundary: float) -> BodyChange | None:
    """The change that explains most from a boundary on; None where no robot is known.

    Args:
        model: identified with a URDF, or not.
        ground: of the motion before and after.
        boundary: s.
    """
    if not isinstance(model.kernel, Known):
        return None
    found = sorted(
        (_judged(ground, one, boundary) for one in _candidates(model, ground)),
        key=lambda change: -change.gain,
    )
    best = found[0]
    rivals = tuple(one.what for one in found[1:] if best.gain - one.gain < ALIKE)
    return replace(best, rivals=rivals)


@dataclass(frozen=True)
class _Candidate:
    """A change: its name, its parameters as (name, unit), and their columns (S, N, P)."""

    what: str
    parameters: tuple[tuple[str, str], ...]
    columns: Floats


def _candidates(model: Model, ground: Ground) -> Iterator[_Candidate]:
    kernel, robot = model.kernel, model.kernel.mechanism
    assert isinstance(kernel, Known)
    assert isinstance(robot, Robot)
    seen = ground.seen
    x = States(seen.q, seen.qd, seen.qdd)
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


def _judged(ground: Ground, candidate: _Candidate, boundary: float) -> BodyChange:
    columns = candidate.columns * (ground.seen.time >= boundary)[:, None, None]
    share = np.sqrt(np.mean(columns**2, axis=0)) / ground.spread[:, None]
    largest = share.max(axis=0)
    scale = PRIOR_SHARE / np.where(largest > 0.0, largest, np.inf)
    scaled = columns * scale
    whitened = sum(ground.whiten(scaled[:, n], n) for n in range(ground.joints))
    z, w = ground.project(np.asarray(whitened)), ground.residual
    information, sums = z.T @ z, z.T @ w
    fitted = np.linalg.solve(information + np.eye(len(sums)), sums)
    rest = np.add.reduceat(z * (w - z @ fitted)[:, None], ground.starts, axis=0)
    trace = float(np.trace(information))
    inflation = max(1.0, float(np.sum(rest**2)) / trace) if trace > 0.0 else 1.0
    gain = float(tempered_gain(sums[None, :], information, inflation)[0])
    covariance = np.linalg.inv(information / inflation + np.eye(len(sums)))
    variance = np.diag(covariance)
    parameters = {
        name: (float(value), float(deviation), unit)
        for (name, unit), value, deviation, left in zip(
            candidate.parameters, fitted * scale, np.sqrt(variance) * scale, variance, strict=True
        )
        if left < LEARNED and name != "I"
    }
    if candidate.what == PAYLOAD:
        parameters = _centre(parameters)
    return BodyChange(candidate.what, gain, parameters, scaled @ fitted)


def _centre(parameters: dict[str, tuple[float, float, str]]) -> dict[str, tuple[float, float, str]]:
    """The first moments of a payload as its centre of mass, in the frame of the last joint."""
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
