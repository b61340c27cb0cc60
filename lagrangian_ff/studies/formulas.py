"""Curves and proposed formulas on arms with physics outside the catalogue.

Each arm hides one torque that no effect of the catalogue is. A model learns the arm without it; a
curve over what it depends on is taken in, formulas are proposed, and the true structure is fitted.
Their errors on another recording are compared, and it is counted how often the true form is among
the formulas proposed first.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from lagrangian_ff import recording
from lagrangian_ff.arm import JOINTS, exciting_trajectory, simulate
from lagrangian_ff.arm.hiding import hidden, wanted
from lagrangian_ff.arrays import Flags, Floats
from lagrangian_ff.diagnosis import compare
from lagrangian_ff.diagnosis.adding import add
from lagrangian_ff.diagnosis.proposing.propose import propose
from lagrangian_ff.effects import Curve, Inputs
from lagrangian_ff.effects.formula import Range, formula_effect
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model, Settings, extend, identify
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import Motion, concatenate

PARTS = ((2, 20.0), (6, 40.0))
"""Speed and s of the stretches of each recording."""
USUAL = Settings(train=1.0)
FIRST = 3
"""Proposals among which the true form is looked for."""
Torque = Callable[[Inputs, int], Floats]


@dataclass(frozen=True)
class Strange:
    """An arm with physics outside the catalogue.

    Attributes:
        name: of the case.  joint: index.
        true: the formula of the torque, with ranges of its shapes.
        over, friction: the curve that can hold it.
        forms: names of proposed effects that are this form.
        torque: N·m, of any size; None for physics of the simulated arm by that name.
        physics: its name in `arm.hidden`.
        size: rms of the torque over that of the joint.
    """

    name: str
    joint: int
    true: str
    ranges: Mapping[str, Range]
    over: tuple[str, ...]
    friction: bool
    forms: tuple[str, ...]
    torque: Torque | None = None
    physics: str = ""
    size: float = 0.1


@dataclass(frozen=True)
class Judged:
    """One case, judged on the second recording.

    Attributes:
        name: of the case.
        before, curve, formula, true: N·m rms of the joint: without it, with the curve if the data
            show any, with the formula proposed first, and with the true structure; NaN where there
            is none.
        inside: share of the recording inside what the curve has seen.
        ratio_inside: the error with the curve over that with the true structure, there.
        proposed: names of the formulas proposed, best first.
        verdicts: of them.
        rank: of the true form among them, from 1; 0 if it is not there.
    """

    name: str
    before: float
    curve: float
    formula: float
    true: float
    inside: float
    ratio_inside: float
    proposed: tuple[str, ...]
    verdicts: tuple[str, ...]
    rank: int

    @property
    def ratio(self) -> float:
        """Return the error with the curve over that with the true structure."""
        return self.curve / self.true

    @property
    def named(self) -> bool:
        """Return whether the true form is among those proposed first."""
        return 0 < self.rank <= FIRST


def judged(
    case: Strange, seed: int = 0, settings: Settings = USUAL, progress: Progress = silent
) -> Judged:
    """Return one case judged.

    Args:
        seed: of motions and noise.  settings: of the models.
        progress: receives the share done, 0 to 1.
    """
    first, second = (_motion(case, 2 * seed + number) for number in (0, 1))
    name = JOINTS[case.joint]
    model = identify([first], settings).model
    progress(0.2, f"{case.name}: with a curve")
    curved = _with_curve(model, case)
    truth = formula_effect("truth", case.true, case.ranges)
    curve, true = (_missed(one, second, case) for one in (curved, extend(model, truth, name).model))
    inside = ~_outside(curved, second, case)
    found = propose(model, first, second, name, progress=part(progress, 0.4, 1.0))
    names = tuple(one.name for one in found.proposals)
    ranks = [n for n, one in enumerate(names, 1) if one in case.forms]
    errors = [one.finding.errors[1] for one in found.proposals]
    return Judged(
        case.name,
        _rms(_missed(model, second, case)),
        _rms(curve),
        errors[0] if errors and errors[0] is not None else np.nan,
        _rms(true),
        float(np.mean(inside)),
        _rms(curve[inside]) / _rms(true[inside]),
        names,
        tuple(one.finding.said for one in found.proposals),
        ranks[0] if ranks else 0,
    )


def _with_curve(model: Model, case: Strange) -> Model:
    """Return a model with the curve of a case; as it is if its data show nothing of one."""
    try:
        return add(model, "curve", JOINTS[case.joint], over=case.over, friction=case.friction)
    except ModelError:
        return model


def _missed(model: Model, motion: Motion, case: Strange) -> Floats:
    return np.asarray(compare(model, motion).residual[:, case.joint])


def _outside(model: Model, motion: Motion, case: Strange) -> Flags:
    """Return (M,) where a motion leaves what the curve of a model, if it has one, has seen."""
    curve = model.basis.terms[-1].effect
    if not isinstance(curve, Curve):
        return np.zeros(len(motion), dtype=bool)
    return curve.outside(model.inputs_of(motion), case.joint)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _motion(case: Strange, number: int) -> Motion:
    """Return a recording of the arm of a case."""
    if case.torque is None:
        asked = f"{case.physics}@{JOINTS[case.joint]}:{case.size}"
        return _driven(number, asked)
    clean = _driven(number, "")
    x = Inputs.of(States.of(clean.q, clean.qd, clean.qdd), clean.time, clean.segment)
    x = replace(x, load=clean.tau)  # friction apart, it is what the gear carries
    torque = case.torque(x, case.joint)
    tau = clean.tau.copy()
    scale = case.size * np.sqrt(np.mean(tau[:, case.joint] ** 2) / np.mean(_first(case) ** 2))
    tau[:, case.joint] += scale * torque
    return replace(clean, tau=tau)


def _first(case: Strange) -> Floats:
    """Return the torque of a case along the first recording, which sizes it on every one."""
    clean = _driven(0, "")
    x = Inputs.of(States.of(clean.q, clean.qd, clean.qdd), clean.time, clean.segment)
    assert case.torque is not None
    return case.torque(replace(x, load=clean.tau), case.joint)


@cache
def _driven(number: int, asked: str) -> Motion:
    """Return a recording of the simulated arm, with hidden physics if it is asked for."""
    runs = []
    for n, (speed, seconds) in enumerate(PARTS):
        reference = exciting_trajectory(speed, number, seconds)
        arm = hidden(wanted([asked]), 2 * number + n).arm if asked else {}
        runs.append(simulate(reference, **arm, seed=2 * number + n).recording)
    return concatenate(recording.condition_alike(runs))


def _own(function: Callable[[Floats, Floats], Floats]) -> Torque:
    """Return a torque of a joint's own position and velocity."""
    return lambda x, joint: function(x.q[:, joint], x.qd[:, joint])


def _rub(x: Inputs, joint: int) -> Floats:
    return np.tanh(x.qd[:, joint] / 0.02)


def _bump(q: Floats, centre: float, width: float) -> Floats:
    return np.asarray(np.exp(-(((q - centre) / width) ** 2)))


PLACE: dict[str, Range] = {"c": (-1.5, 1.5, 60), "w": (0.03, 1.5, 10)}
"""Ranges of a place and of a width."""
CASES = (
    Strange("cubic drag", 1, "A*qd^3", {}, ("velocity",), False,
            ("formula_friction_power_velocity",), _own(lambda q, v: v**3)),
    Strange("exponential Stribeck", 2, "A*sign(qd)*exp(-abs(qd)/s)", {"s": (0.01, 2.0, 20)},
            ("velocity",), False, ("formula_friction_decay_velocity",),
            _own(lambda q, v: np.tanh(v / 0.02) * np.exp(-np.abs(v) / 0.15))),
    Strange("hyperbolic Stribeck", 0, "A*sign(qd)/(1+(qd/s)^2)", {"s": (0.01, 2.0, 20)},
            ("velocity",), False, ("formula_friction_hyperbola_velocity",),
            _own(lambda q, v: np.tanh(v / 0.02) / (1.0 + (v / 0.15) ** 2))),
    Strange("grease (Eyring)", 3, "A*sign(qd)*log(1+abs(qd)/s)", {"s": (0.005, 2.0, 20)},
            ("velocity",), False, ("formula_friction_logarithm_velocity",),
            _own(lambda q, v: np.tanh(v / 0.02) * np.log1p(np.abs(v) / 0.05))),
    Strange("detent", 4, "A*cos(n*q)+B*sin(n*q)", {"n": (5.0, 11.0, 60)}, ("position",), False,
            ("formula_wave_position",), _own(lambda q, v: np.sin(7.5 * q + 0.4))),
    Strange("soft stop", 1, "A*(q-c+abs(q-c))", {"c": (-1.5, 1.5, 60)}, ("position",), False,
            ("formula_upper_stop_position",), _own(lambda q, v: np.maximum(q - 0.4, 0.0))),
    Strange("hardening cable", 3, "A*exp(q/w)", {"w": (0.05, 3.0, 12)}, ("position",), False,
            ("formula_growth_position",), _own(lambda q, v: np.exp(q / 0.3))),
    Strange("dry spot in grease", 0, "A*qd*exp(-((q-c)/w)^2)", PLACE,
            ("position", "velocity"), False, ("formula_viscous_bump_position",),
            _own(lambda q, v: v * _bump(q, 0.3, 0.35))),
    Strange("wave of dry friction", 2, "A*sign(qd)*cos(n*q)+B*sign(qd)*sin(n*q)",
            {"n": (2.0, 12.0, 60)}, ("position",), True, ("formula_friction_wave_position",),
            _own(lambda q, v: np.tanh(v / 0.02) * np.sin(5.3 * q))),
    Strange("square of the load", 1, "A*sign(qd)*load^2", {}, ("load",), True,
            ("formula_friction_power_load",), lambda x, j: _rub(x, j) * x.load[:, j] ** 2),
    Strange("squeezed film", 2, "A*sign(qd)*abs(qdd)", {}, ("acceleration",), True,
            ("formula_friction_power_acceleration",),
            lambda x, j: _rub(x, j) * np.abs(x.qdd[:, j])),
    Strange("after a reversal", 1, "A*sign(qd)*exp(-since/s)", {"s": (0.02, 3.0, 20)},
            ("reversal",), True, ("formula_friction_decay_reversal",),
            lambda x, j: _rub(x, j) * np.exp(-x.since_reversal(j) / 0.3)),
    Strange("pressed by another", 3, "A*sign(qd)*exp(-((q_5-c)/w)^2)", PLACE,
            ("position@joint_5",), True, ("formula_friction_bump_position5",),
            lambda x, j: _rub(x, j) * _bump(x.q[:, 4], -0.2, 0.4)),
    Strange("hose of two joints", 2, "A*cos(n*(q-q_4))+B*sin(n*(q-q_4))", {"n": (1.0, 5.0, 40)},
            ("position", "position@joint_4"), False, ("formula_wave_position_position4",),
            lambda x, j: np.cos(2.2 * (x.q[:, j] - x.q[:, 3]) + 0.5)),
    *(Strange(f"pitting, {JOINTS[j]}", j, "A*sign(qd)*exp(-((q-c)/w)^2)", PLACE, ("position",),
              True, ("formula_friction_bump_position",), physics="pitting") for j in (1, 4)),
    *(Strange(f"capstan, {JOINTS[j]}", j, f"A*sign(qd)*cos(1.6*(q-q_{k + 1}))"
              f"+B*sign(qd)*sin(1.6*(q-q_{k + 1}))", {},
              ("position", f"position@{JOINTS[k]}"), True,
              (f"formula_friction_wave_position_position{k + 1}",), physics="capstan")
      for j, k in ((1, 2), (3, 4))),
    *(Strange(f"pinched, {JOINTS[j]}", j, f"A*sign(qd)*tanh((q_{k + 1}-c)/w)", PLACE,
              (f"position@{JOINTS[k]}",), True, (f"formula_friction_step_position{k + 1}",),
              physics="pinched") for j, k in ((2, 3), (0, 1))),
)  # fmt: skip
"""Physics outside the catalogue that depends on one or two coordinates."""
