"""Why an effect is added to a model, as its history says."""

from lagrangian_ff.diagnosis.diagnose import CONFIRMED, Diagnosis, Finding


def reason(finding: Finding, diagnosis: Diagnosis) -> str:
    """What speaks for a finding, and against it where it is not confirmed.

    Args:
        finding: of what happens once there is none: it is of the recording, not of the arm.
        diagnosis: which it is of.
    """
    if finding.step.score.once:
        return ""
    where = "another recording" if diagnosis.separate else "the end of it, held back"
    text = (
        f"{finding.effect.meaning}; it gains {finding.step.score.gain:.0f} nats of evidence, "
        f"and with frozen coefficients it helps in {finding.trial.share:.0%} of {where}"
    )
    if finding.verdict == CONFIRMED:
        return text
    rivals = f"it may be {' or '.join(finding.rivals)} too" if finding.rivals else ""
    doubt = "; ".join(part for part in (finding.reason, rivals) if part)
    return f"{text}; no more than {finding.verdict}: {doubt}"


def for_history(finding: Finding, diagnosis: Diagnosis) -> dict[str, object]:
    """Return what the history of a model says of a finding that was added."""
    return {
        "why": reason(finding, diagnosis),
        "verdict": finding.verdict,
        "evidence_gain": finding.step.score.gain,
        "p_value": finding.step.p_value,
    }
