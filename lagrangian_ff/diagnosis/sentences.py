"""A diagnosis in sentences: the verdict on the model, and what speaks for a finding."""

from collections.abc import Sequence

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.results import Diagnosis, Finding, TakenUp, Verdict
from lagrangian_ff.words import listed, spoken, which


def verdict(diagnosis: Diagnosis) -> str:
    """Return the verdict in a few sentences; it has the fall of the error if that was tried."""
    unsure = [one for one in diagnosis.findings if one.verdict is Verdict.AMBIGUOUS]
    maybe = [one for one in diagnosis.findings if one.verdict is Verdict.SUGGESTED]
    parts = []
    if diagnosis.taken_up is not None:
        parts.append(_taken_up(diagnosis.taken_up, diagnosis.model.joints))
    if diagnosis.confirmed:
        causes = listed(_causes(diagnosis.confirmed))
        parts.append(f"Missing and confirmed: {causes}{_fall(diagnosis)}.")
    for one in unsure:
        names = " or ".join(map(spoken, (one.effect.name, *one.rivals)))
        parts.append(
            f"On {one.joint} one of these is missing, this motion cannot tell which: {names}."
        )
    if maybe and parts:
        parts.append(f"{len(maybe)} more suggested, not confirmed.")
    elif maybe:
        parts.append(f"Nothing is confirmed; {len(maybe)} suggested.")
    parts += [
        f"On {rest.joint} the torque depends on {rest.coordinate} in a way that no known effect "
        "explains."
        for rest in diagnosis.unexplained
    ]
    return " ".join(parts) or _nothing(diagnosis)


def reason(finding: Finding, diagnosis: Diagnosis) -> str:
    """Return what speaks for a finding, and against it if not confirmed; empty for an event."""
    if finding.once:
        return ""
    where = "another recording" if diagnosis.separate else "the end of it, held back"
    text = (
        f"{finding.effect.meaning}; it gains {finding.log_bayes_factor:.0f} nats of evidence, "
        f"and with frozen coefficients it helps in {finding.hold_out.share:.0%} of {where}"
    )
    if finding.confirmed:
        return text
    doubts = [finding.doubt.words] if finding.doubt else []
    if finding.rivals:
        doubts.append(f"it may be {' or '.join(finding.rivals)} too")
    return f"{text}; no more than {finding.verdict.value}: {'; '.join(doubts)}"


def _taken_up(taken_up: TakenUp, every: Sequence[str]) -> str:
    change = taken_up.change
    what = (
        f"From {change.since:.1f} s on the arm carries a load that the model does not know"
        if change.lasts
        else f"Something touches the arm from {change.since:.1f} s to {change.until:.1f} s"
    )
    return f"{what}: {taken_up.verdict.value}, felt by {which(taken_up.joints, every)}."


def _fall(diagnosis: Diagnosis) -> str:
    """Return the fall of the error in words: of one joint, or of all if several are concerned."""
    tried = diagnosis.tried
    if not tried:
        return ""
    (_, first), (_, last) = tried[0], tried[-1]
    if len({finding.joint for finding, _ in tried}) == 1:
        before, after, whose = first.whole_before, last.whole_after, "the joint's error"
    else:
        before, after, whose = first.every_before, last.every_after, "the error over all joints"
    change = "falls" if after < before else "does not fall: it goes"
    return f": {whose} {change} from {before:.3g} to {after:.3g} N·m on motion not used to find it"


def _nothing(diagnosis: Diagnosis) -> str:
    """Return the sentence for no findings: nothing is left, or the motion is too short."""
    best = next((one for one in diagnosis.ranking if one.named), None)
    if best is None or best.log_bayes_factor <= thresholds.USED.promising or best.stands_out:
        return (
            "No effect of the catalogue is missing that this motion could show: what is left is "
            "noise."
        )
    return (
        f"Nothing stands out from chance. The best guess, {spoken(best.name)} on {best.joint}, "
        f"gains {best.log_bayes_factor:.0f} nats; on this motion chance gives "
        f"{diagnosis.threshold:.0f} once in twenty times. Record longer: the more blocks of "
        "motion, the less chance can do."
    )


def _causes(found: Sequence[Finding]) -> list[str]:
    """Return each cause in words, once, with the joints that feel it."""
    felt: dict[tuple[str, str | None], list[str]] = {}
    for one in found:
        felt.setdefault((one.effect.name, one.cause), []).append(one.joint)
    return [
        f"{spoken(name)} on {cause}" + (f" (felt on {listed(joints)})" if joints != [cause] else "")
        for (name, cause), joints in felt.items()
    ]
