"""A diagnosis in sentences: the verdict on the model, and what speaks for a finding."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.confidence import Verdict
from lagrangian_ff.diagnosis.consequence import Consequence
from lagrangian_ff.diagnosis.lag import late
from lagrangian_ff.diagnosis.results import Diagnosis, Finding, Remainder, TakenUp, Unexplained
from lagrangian_ff.words import counted, listed, sentence, spoken, which

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis.run import Changed

MOST_TOUCHES = 3
"""Touches of the arm that the verdict names; the record and the page have all."""


def verdict(diagnosis: Diagnosis, changed: Sequence["Changed"] | None = None) -> str:
    """Return the verdict in a few sentences; it has the fall of the error if that was tried.

    Args:
        changed: since the model was identified, which is said first; None if it was not asked.
    """
    unsure = [one for one in diagnosis.findings if one.verdict is Verdict.AMBIGUOUS]
    useless = [one for one in diagnosis.findings if one.useless]
    suggested = [one for one in diagnosis.findings if one.verdict is Verdict.SUGGESTED]
    maybe = [one for one in suggested if not one.useless]
    parts = [since(changed, diagnosis.model.joints)] if changed else []
    misfit = diagnosis.misfit
    if not changed and misfit is not None and misfit.larger:
        asked = "no known change explains it" if changed is not None else "it changed since"
        parts.append(f"The arm is not as the model knows it: {misfit.words()}, and {asked}.")
    first = len(parts)
    if (lag := diagnosis.lag) is not None:
        said = late("every joint", lag.delay, lag.deviation)
        parts += [
            sentence(f"{said} ({lag.log_bayes_factor:.0f} nats)"),
            f"The findings allow for it, and {lag.option} undoes it.",
        ]
    if diagnosis.taken_up is not None:
        parts.append(_taken_up(diagnosis.taken_up, diagnosis.model.joints))
    if diagnosis.confirmed:
        causes = listed(_causes(diagnosis.confirmed, diagnosis.model.joints))
        parts.append(f"Missing and confirmed: {causes}{_fall(diagnosis)}.")
    parts += [
        f"Missing: {spoken(one.effect.name)} on {one.joint} is there ({one.log_bayes_factor:.0f} "
        f"nats), but {one.doubt.words}."
        for one in useless
        if one.doubt is not None
    ]
    for one in unsure:
        names = " or ".join(map(spoken, (one.effect.name, *one.rivals)))
        parts.append(
            f"On {one.joint} one of these is missing, this motion cannot tell which: {names}."
        )
    certain = len(parts)
    if maybe and parts[first:]:
        parts.append(f"{len(maybe)} more suggested, not confirmed.")
    elif maybe:
        parts.append(f"Nothing is confirmed; {len(maybe)} suggested.")
    parts += [
        f"On {rest.joint} {rest.share:.1%} of the torque depends on {rest.coordinate} in a way "
        "that no known effect explains."
        for rest in diagnosis.unexplained
    ]
    if not parts[first:]:
        parts.append(_nothing(diagnosis, known=first > 0))
    if diagnosis.contacts:
        parts.insert(certain, _touched(diagnosis))
    return " ".join(parts)


def headline(diagnosis: Diagnosis, changed: Sequence["Changed"] | None = None) -> str:
    """Return the verdict in a few words, the surest first, for where there is little room."""
    every = diagnosis.model.joints
    parts = [f"changed: {spoken(one.what)} on {which(one.joints, every)}" for one in changed or ()]
    if diagnosis.confirmed:
        parts.append(f"missing: {listed(_causes(diagnosis.confirmed, every))}")
    others = len(diagnosis.findings) - len(diagnosis.confirmed)
    if others:
        parts.append(f"{counted(others, 'finding')} not confirmed")
    parts += [
        f"unexplained on {rest.joint}: {rest.share:.1%} over {rest.coordinate}"
        for rest in diagnosis.unexplained
    ]
    if not parts:
        first = _nothing(diagnosis, known=False).partition(". ")[0].rstrip(".")
        parts.append(f"{first[:1].lower()}{first[1:]}")
    return "; ".join(parts)


def since(changed: Sequence["Changed"], every: Sequence[str]) -> str:
    """Return what changed since a model was identified, by how much, and what to do."""
    listed_changes = "; ".join(amount(one, every) for one in changed)
    text = f"The arm changed since the model was identified: {listed_changes}"
    one = changed[0]
    if one.error_before is not None and one.error_after is not None:
        text += (
            f". With {'it' if len(changed) == 1 else 'the first'} the error of the model on "
            f"{one.joints[0]} is {one.error_after:.3g} instead of {one.error_before:.3g} N·m"
        )
    return f"{text}. Identify again from recordings of the arm as it is."


def amount(one: "Changed", every: Sequence[str]) -> str:
    """Return a change in words, with its size."""
    where = which(one.joints, every)
    by = [f"{name} {value.value:+.3g} {value.unit}" for name, value in one.parameters.items()]
    if one.what == "torque_gain":
        (gain,) = one.parameters.values()
        ends = f" ({1.0 + gain.low:.3g} to {1.0 + gain.high:.3g})" if gain.bounded else ""
        return f"the effort of {where} is {1.0 + gain.value:.3g} times what it was{ends}"
    size = f"{one.size:.3g} N·m rms on {one.joints[0]}"
    if one.parameters:
        return f"{spoken(one.what)} on {where}, {', '.join(by)} ({size})"
    return f"other masses, as by a load attached or taken off: {size}, felt on {where}"


def no_help(made: Consequence) -> str:
    """Return that adding a finding does not lower the error, with the figures."""
    text = (
        "adding it does not lower the error of this model "
        f"({made.whole_before:.3g} → {made.whole_after:.3g} N·m on {made.joint}"
    )
    worst = made.raised
    if worst and worst != made.joint:
        before, after = made.joints_before[worst], made.joints_after[worst]
        text += f", {before:.3g} → {after:.3g} N·m on {worst}"
    return f"{text}): its other errors are larger"


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


def curve_command(rest: Unexplained, model: str) -> str:
    """Return the command that takes the curve of a torque into the model of a file; or nothing."""
    if rest.curve is None:
        return ""
    over = " ".join(one.text() for one in rest.curve.over)
    return (
        f"lagrangian_ff add {model} curve --joint {rest.joint} --over {over}"
        f"{' --friction' if rest.curve.friction else ''} --output NEW.npz"
    )


def history_of_curve(rest: Unexplained) -> dict[str, object]:
    """Return the entry of a model's history for what is unexplained and is added as a curve."""
    return {
        "why": f"no known effect explains what depends on {rest.coordinate}; it gains "
        f"{rest.log_bayes_factor:.0f} nats of evidence, and unseen motion has it too",
        "verdict": "unexplained",
        "evidence_gain": rest.log_bayes_factor,
        "p_value": None,
    }


def _taken_up(taken_up: TakenUp, every: Sequence[str]) -> str:
    change = taken_up.change
    what = (
        f"From {change.since:.1f} s on the arm carries a load that the model does not know"
        if change.lasts
        else f"Something touches the arm from {change.since:.1f} s to {change.until:.1f} s"
    )
    return f"{what}: {taken_up.verdict.value}, felt by {which(taken_up.joints, every)}."


def _touched(diagnosis: Diagnosis) -> str:
    """Return the touches that are sure, else those that are suggested; not all if they are many."""
    sure = [one for one in diagnosis.contacts if one.sure]
    named = sure or list(diagnosis.contacts)
    every = diagnosis.motion.source
    texts = [one.words(of_several=one.source != every) for one in named[:MOST_TOUCHES]]
    if len(named) > MOST_TOUCHES:
        texts.append(f"{len(named) - MOST_TOUCHES} times more")
    return f"Something {'touched' if sure else 'may have touched'} the arm {'; '.join(texts)}."


def _fall(diagnosis: Diagnosis) -> str:
    """Return the fall of the error in words: of one joint, or of all if several are concerned."""
    tried = diagnosis.tried
    if not tried:
        return ""
    (_, first), (_, last) = tried[0], tried[-1]
    if len({joint for finding, _ in tried for joint in finding.joints}) == 1:
        before, after, whose = first.whole_before, last.whole_after, "the joint's error"
    else:
        before, after, whose = first.every_before, last.every_after, "the error over all joints"
    change = "falls" if after < before else "does not fall: it goes"
    return f": {whose} {change} from {before:.3g} to {after:.3g} N·m on motion not used to find it"


def _nothing(diagnosis: Diagnosis, *, known: bool) -> str:
    """Return the sentence for no findings: nothing is left, or there is too little motion.

    Args:
        known: whether a change, or an error of the model, is named already.
    """
    best = next((one for one in diagnosis.ranking if one.named), None)
    if diagnosis.wanting:
        guesses = [
            f"{spoken(one.name)} on {one.joint} ({one.log_bayes_factor:.0f} nats)"
            for one in diagnosis.ranking[:3]
            if one.log_bayes_factor > thresholds.USED.floor
        ]
        best_are = f" The best guesses, without a verdict: {listed(guesses)}." if guesses else ""
        return (
            "This is too little motion for a verdict: so few independent stretches of it cannot "
            f"rule out chance. About {diagnosis.wanting:.0f} s more of this motion would do."
            f"{best_are}"
        )
    misfit = diagnosis.misfit
    if known:
        return "No effect of the catalogue is missing beside that."
    if misfit is not None and misfit.poor:
        n = misfit.poor[0]
        return (
            f"No effect of the catalogue explains what this model leaves: on {misfit.joints[n]} it "
            f"misses {misfit.whole[n]:.3g} N·m (nmse {misfit.nmse[n]:.2g}){misfit.where}. That is "
            "not called noise."
        )
    if best is None or best.log_bayes_factor <= thresholds.USED.promising or best.stands_out:
        if diagnosis.remainders:
            left = listed([_remainder(one) for one in diagnosis.remainders])
            return (
                f"Nothing that is known explains what is left, and it is more than noise: {left}. "
                f"Record the same motion again: what repeats is the arm's.{_missed(diagnosis)}"
            )
        return (
            "No effect of the catalogue is missing that this motion could show: what is left is "
            f"noise.{_missed(diagnosis)}"
        )
    return (
        f"Nothing stands out from chance. The best guess, {spoken(best.name)} on {best.joint}, "
        f"gains {best.log_bayes_factor:.0f} nats; on this motion chance gives "
        f"{diagnosis.threshold:.0f} once in twenty times. Record longer: the more blocks of "
        "motion, the less chance can do."
    )


def _missed(diagnosis: Diagnosis) -> str:
    """Return on which joint the model fails on unseen motion, as a sentence; empty if on none."""
    noise = dict(zip(diagnosis.model.joints, diagnosis.noise.tolist(), strict=True))
    ratios = [(missed / noise[on], on, missed) for on, missed in diagnosis.failing.items()]
    if not ratios:
        return ""
    ratio, joint, missed = max(ratios)
    return (
        f" On unseen motion, though, the model misses {missed:.2g} N·m on {joint}, {ratio:.0f} "
        "times that noise: it has not learned enough of the arm. Identify from more motion."
    )


def _remainder(one: Remainder) -> str:
    return f"{one.size:.2g} N·m on {one.joint} ({one.share:.0%} of its torque)"


def _causes(found: Sequence[Finding], every: Sequence[str]) -> list[str]:
    """Return each cause in words, once, with the joints that feel it; alike gears together."""
    felt: dict[tuple[str, str | None], list[str]] = {}
    for one in found:
        felt.setdefault((one.effect.name, one.cause), []).extend(one.joints)
    own: dict[str, list[str]] = {}
    parts = []
    for (name, cause), joints in felt.items():
        if cause is not None and joints == [cause]:
            own.setdefault(name, []).append(cause)
        else:
            parts.append(f"{spoken(name)} on {cause} (felt on {listed(joints)})")
    alike = [f"{spoken(name)} on {which(joints, every)}" for name, joints in own.items()]
    return [*alike, *parts]
