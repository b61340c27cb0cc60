"""Adding effects to a model, and telling how a model came to be what it is."""

from collections.abc import Mapping

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import EffectError
from lagrangian_ff.identification import Model, extend
from lagrangian_ff.progress import Progress, silent


def add(
    model: Model,
    effect: str,
    joint: str,
    shape: Mapping[str, float] | None = None,
    why: Mapping[str, object] | None = None,
    progress: Progress = silent,
) -> Model:
    """The model with one more effect, refitted from the data that it keeps.

    Args:
        model: with its data.
        effect: a name of the catalogue.  joint: where it acts.
        shape: nonlinear parameters; what is not given is searched.
        why: what the history shall tell: `why`, `verdict`, `evidence_gain`, `p_value`.
        progress: told the share done.

    Raises:
        EffectError: there is no such effect.
        ModelError: there is no such joint, or the model has the effect or its equal already.
    """
    if effect not in EFFECTS:
        raise EffectError(
            f"there is no effect '{effect}'; there are {', '.join(EFFECTS)} "
            "(lagrangian_ff effects lists them)"
        )
    return extend(model, EFFECTS[effect], joint, shape, why, progress).model


def history(model: Model) -> dict[str, object]:
    """The steps of a model, for JSON: what was added, why, and the error before and after."""
    return {"model": model.name, "steps": [dict(step) for step in model.steps]}
