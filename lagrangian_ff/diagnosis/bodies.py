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
from lagrangian_ff.diagnosis.causes import Linear, linear
from lagrangian_ff.diagnosis.intervals import GAIN
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.kernels.rigid import Robot
from lagrangian_ff.kernels.rigid.known import Known
from lagrangian_ff.recording.motion import Conditioning

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
        evidence: nats, with the noise that suits it, to compare causes.
    """

    what: str
    log_bayes_factor: float
    parameters: Mapping[str, Estimate]
    torque: Floats
    rivals: tuple[str, ...] = ()
    evidence: float = -np.inf


def changed_bodies(model: Model, whitened: Whitened, boundary: float) -> BodyChange | None:
    """Return the change that explains most from a boundary in s on; None without a URDF."""
    if not isinstance(model.kernel, Known):
        return None
    later = (whitened.x.time >= boundary)[:, None, None]
    tried = [(one, linear(whitened, one.columns * later)) for one in _candidates(model, whitened)]
    tried.sort(key=lambda pair: -pair[1].log_bf)
    (best, fitted), *others = tried
    least = fitted.log_bf - thresholds.USED.alike
    rivals = tuple(one.what for one, other in others if other.log_bf > least)
    # The columns of a tilt are torques that this drive measured: another gain changes both.
    unknown = np.zeros(len(model.joints)) if best.what == TILT else unknown_gains(model)
    half = fitted.half(whitened, best.columns * later, unknown)
    parameters = _estimates(best, fitted, half)
    torque, evidence = fitted.torque, fitted.evidence
    return BodyChange(best.what, fitted.log_bf, parameters, torque, rivals, evidence)


def unknown_gains(model: Model) -> Floats:
    """Return (N,) how wrong the gain of each joint's drive may be, relatively.

    A joint whose N·m per unit of effort was given counts as measured.
    """
    given = Conditioning.from_record(model.data.conditioning)
    known = given.effort_scale if given else {}
    return np.array([0.0 if name in known else GAIN for name in model.joints])


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
    if strength > 0.0:  # it is not where the effort holds none
        down = robot.tree.gravity / strength
        turned = [
            replace(robot.tree, gravity=strength * np.cross(down, axis)).regressor(x.at_rest())
            @ masses
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


def _estimates(candidate: _Candidate, fitted: Linear, half: Floats) -> dict[str, Estimate]:
    """Return what the motion says of the parameters of a change."""
    each = zip(candidate.parameters, fitted.values.tolist(), half.tolist(), strict=True)
    seen = [one for one, learned in zip(each, fitted.learned, strict=True) if learned]
    parameters = {name: (value, reach, unit) for (name, unit), value, reach in seen if name != "I"}
    if candidate.what == PAYLOAD:
        parameters = _centre(parameters)
    return {
        name: Estimate(value, value - reach, value + reach, unit)
        for name, (value, reach, unit) in parameters.items()
    }


def _centre(parameters: dict[str, tuple[float, float, str]]) -> dict[str, tuple[float, float, str]]:
    """Return the parameters with a payload's centre of mass, in the frame of the last joint."""
    if "m" not in parameters:
        return parameters
    mass, half, _ = parameters["m"]
    out = {"m": parameters["m"]}
    for axis in "xyz":
        if f"m{axis}" in parameters:
            moment, reach, _ = parameters[f"m{axis}"]
            centre = moment / mass
            out[axis] = centre, float(np.hypot(reach, centre * half)) / abs(mass), "m"
    return out
