"""Adding to a model what its diagnosis confirmed."""

from lagrangian_ff.diagnosis.add import add
from lagrangian_ff.diagnosis.diagnose import CONFIRMED, Diagnosis
from lagrangian_ff.diagnosis.reason import reason
from lagrangian_ff.identification import Model
from lagrangian_ff.progress import Progress, silent


def apply(diagnosis: Diagnosis, progress: Progress = silent) -> Model:
    """The model with everything confirmed, one step after the other, each with its reason.

    Nothing is added on less than `confirmed`; without such findings the model comes back as it is.
    A load or a contact is of the recording, not of the arm: it is told, and not added.
    """
    model = diagnosis.model
    for finding in diagnosis.findings:
        why = reason(finding, diagnosis)
        if finding.verdict != CONFIRMED or not why:
            continue
        told = {
            "why": why,
            "verdict": finding.verdict,
            "evidence_gain": finding.step.score.gain,
            "p_value": finding.step.p_value,
        }
        model = add(model, finding.effect.name, finding.joint, finding.shape, told, progress)
    return model
