"""What identification found, as JSON holds it."""

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.certainty.intervals import reach
from lagrangian_ff.identification.choice import Choice
from lagrangian_ff.identification.solving.fit import Fit
from lagrangian_ff.kernels import CoupledKernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def hyperparameter_record(choice: Choice, basis: Basis, samples: int) -> dict[str, object]:
    """By name: a number common to all joints, or a list with one for each."""

    def plain(values: Floats) -> object:
        return float(values[0]) if np.all(values == values[0]) else [float(v) for v in values]

    kernel = {name: plain(v) for name, v in choice.kernel.hyperparameters.items()}
    gamma = choice.noise / samples
    if isinstance(choice.kernel, CoupledKernel):
        gamma = gamma[:1]
    shapes: dict[str, object] = {}
    for term in basis.terms:
        for name in term.shape:
            alike = [t for t in basis.terms if t.effect.name == term.effect.name]
            values = np.array([t.shape[name] for t in alike])
            shapes[f"{term.effect.name}.{name}"] = plain(values)
    return {**kernel, "gamma": plain(gamma), **shapes}


def effect_records(
    fitted: Fit, value: Floats, joints: tuple[str, ...], block: Ints
) -> list[dict[str, object]]:
    """Every effect on every joint, its parameters with 90 % intervals.

    Args:
        fitted: the fit that intervals are made from.
        value: (B,) the parameters found, which a constraint or another loss may have moved.
        joints: names.
        block: (M,) the block of time each training sample lies in.
    """
    away = reach(fitted, block)
    low, high = value - away, value + away
    found: list[dict[str, object]] = []
    for term, place in fitted.basis.slices():
        parameters = {
            parameter.name: {
                "value": float(value[i]),
                "low": float(low[i]),
                "high": float(high[i]),
                "unit": parameter.unit,
            }
            for parameter, i in zip(
                term.effect.parameters, range(place.start, place.stop), strict=True
            )
        }
        found.append(
            {
                "effect": term.effect.name,
                "joint": joints[term.joint],
                "formula": term.effect.formula,
                "parameters": parameters,
                "shape": dict(term.shape),
                "shape_words": term.effect.shape_words(term.shape, joints),
            }
        )
    return found
