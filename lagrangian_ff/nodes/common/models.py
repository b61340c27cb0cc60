"""Models for the nodes: loaded and tried, asked one state at a time, and their conditioning."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.effects import load_effects, load_installed
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model, Terms
from lagrangian_ff.identification.pointwise import Pointwise
from lagrangian_ff.recording import Conditioning


def load_own_effects(file: str) -> None:
    """Add the effects of installed packages and of a Python file, "" for none, to the catalogue.

    Raises:
        EffectError: the file cannot be used.
    """
    load_installed()
    if file:
        load_effects(Path(file).expanduser())


def load_model(file: str, joints: tuple[str, ...] = ()) -> tuple[Model, Ints]:
    """Load a model and try it on one state.

    Args:
        joints: in which order torques are sent; empty for the order of the model.

    Returns:
        The model, and for each torque its column in the model.

    Raises:
        ModelError: no file given, not a model, of other joints, or one that gives no number.
    """
    if not file:
        raise ModelError("parameter model_file is empty; name the file of an identified model")
    model = Model.load(Path(file).expanduser())
    wanted = joints or model.joints
    if sorted(wanted) != sorted(model.joints):
        raise ModelError(
            f"{file} is a model of {', '.join(model.joints)}, but parameter joints asks for "
            f"{', '.join(wanted)}"
        )
    middle = _middle(model)
    if not np.isfinite(model.terms(middle, 0.0 * middle, 0.0 * middle).total).all():
        raise ModelError(f"{file}: the model gives no finite torque in the middle of its range")
    return model, np.array([model.joints.index(joint) for joint in wanted])


def conditioning_for(
    model: Model, effort_scale: Mapping[str, float], effort_offset: Mapping[str, float]
) -> Conditioning:
    """Return the conditioning of the recordings that the model was identified from.

    Args:
        effort_scale: N·m per unit of effort by joint; others than 1 override the model's.
        effort_offset: N·m by joint; others than 0 override the model's.
    """
    usual = model.identified.conditioning or Conditioning()

    def of_model(
        known: Mapping[str, float], given: Mapping[str, float], neutral: float
    ) -> dict[str, float]:
        changed = {joint: value for joint, value in given.items() if value != neutral}
        return {joint: v for joint, v in {**known, **changed}.items() if joint in model.joints}

    return replace(
        usual,
        effort_scale=of_model(usual.effort_scale, effort_scale, 1.0),
        effort_offset=of_model(usual.effort_offset, effort_offset, 0.0),
    )


class OneStateModel:
    """A model in the form that is fastest for one state; see `plan.InverseDynamics`.

    For one thread.
    """

    def __init__(self, model: Model) -> None:
        self.joints, self.range = model.joints, model.range
        self._pointwise = Pointwise(model)
        middle = _middle(model)
        self.terms(middle, 0.0 * middle, 0.0 * middle)  # builds what is built on first use

    def terms(self, q: Floats, qd: Floats, qdd: Floats) -> Terms:
        """Return the parts at one state, (1, N) each."""
        found = self._pointwise.terms(q[0], qd[0], qdd[0])
        effects = {name: torque[None] for name, torque in found.effects.items()}
        return Terms(found.gravity[None], found.inertia[None], found.coriolis[None], effects)


def _middle(model: Model) -> Floats:
    """Return the middle of the identified positions, (1, N) rad."""
    return np.asarray(0.5 * (model.range.q_low + model.range.q_high)[None])
