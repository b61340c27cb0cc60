"""Adding to a model what its diagnosis confirmed."""

from collections.abc import Mapping

from lagrangian_ff.diagnosis.add import add
from lagrangian_ff.diagnosis.consequence import Consequence
from lagrangian_ff.diagnosis.diagnose import Diagnosis, Finding
from lagrangian_ff.diagnosis.reason import for_history
from lagrangian_ff.identification import Model
from lagrangian_ff.progress import Progress, silent


def apply(
    diagnosis: Diagnosis,
    made: Mapping[Finding, Consequence] | None = None,
    progress: Progress = silent,
) -> Model:
    """Return the model with everything confirmed, one step after the other, each with its reason.

    Nothing is added on less than `confirmed`; without such findings the model comes back as it is.
    A load or a contact is of the recording, not of the arm: it is reported, and not added.

    Args:
        diagnosis: the diagnosis.
        made: what adding the findings does, from `consequences`; its models are not fitted again.
        progress: told the share done.
    """
    model = diagnosis.model
    lasting = [one for one in diagnosis.confirmed if not one.step.score.once]
    if made and len(lasting) == len(diagnosis.confirmed):
        ready = [one for one in lasting if one in made]
        model = made[ready[-1]].model if ready else model
        lasting = [one for one in lasting if one not in ready]
    for one in lasting:
        why = for_history(one, diagnosis)
        model = add(model, one.effect.name, one.joint, one.shape, why, progress)
    return model
