"""The model to stream from."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model


def load_model(file: str, joints: tuple[str, ...]) -> tuple[Model, NDArray[np.int64]]:
    """Load a model and try it on one state.

    Args:
        file: a model file.
        joints: in which order torques are sent; empty for the order of the model.

    Returns:
        The model, and which of its columns each torque is.

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
    middle = 0.5 * (model.range.q_low + model.range.q_high)[None]
    still = np.zeros_like(middle)
    if not np.isfinite(model.terms(middle, still, still).total).all():
        raise ModelError(f"{file}: the model gives no finite torque in the middle of its range")
    return model, np.array([model.joints.index(joint) for joint in wanted])
