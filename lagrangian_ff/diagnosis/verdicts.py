"""The verdict on each effect that a search found: confirmed, suggested, or no finding at all."""

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.confidence import Doubt, HoldOut, Reason
from lagrangian_ff.diagnosis.intervals import widened
from lagrangian_ff.diagnosis.partial_residual import partial_residual
from lagrangian_ff.diagnosis.results import Change, Finding, sorted_findings
from lagrangian_ff.diagnosis.search.candidates import at_end
from lagrangian_ff.diagnosis.search.forward import Search, Step, beside_others
from lagrangian_ff.diagnosis.search.hold_out import HoldOutMotion, frozen, judge_hold_out
from lagrangian_ff.diagnosis.search.significance import rivals
from lagrangian_ff.diagnosis.search.signs import unnatural
from lagrangian_ff.effects import EFFECTS, Effect, look_alikes
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.recording.motion import WITHOUT_GRAVITY, Motion


def findings_of(
    found: Search, motion: Motion, model: Model, change: Change | None
) -> tuple[Finding, ...]:
    """Return the findings of a search, each with its verdict, best first.

    What shows only where outliers count less, and not on unseen motion, is none: what a form that
    is not quite the true one leaves shows as well between them.

    Args:
        found, motion: the search and the hold-out motion.
        change: where the hold-out motion takes up a load, if the first one did.
    """
    views, parameters = judge_hold_out(found, motion, change), frozen(found)
    named = [number for number, step in enumerate(found.steps) if step.named]
    findings = [_finding(found, model, n, *views[n], parameters[n]) for n in named]
    pairs = zip(findings, named, strict=True)
    return sorted_findings([one for one, n in pairs if _may_be(one, found.steps[n])])


def _may_be(one: Finding, step: Step) -> bool:
    """Return whether a finding counts that was found late, or is known of other motion."""
    if step.stands and not one.stands and step.score.log_bf <= thresholds.USED.floor:
        return False
    if not step.late:
        return True
    doubt = one.hold_out.doubt
    return doubt is None or doubt.reason not in (Reason.NOT_HELD_OUT, Reason.OTHER_SIZE)


def _finding(
    found: Search,
    model: Model,
    number: int,
    motion: HoldOutMotion,
    hold_out: HoldOut,
    parameters: tuple[Floats, Floats, Floats],
) -> Finding:
    step = found.steps[number]
    candidate, (values, low, high) = step.score.candidate, parameters
    half = widened(values, high - values, hold_out.gained, hold_out.expected)
    low, high = values - half, values + half
    effect, joint = candidate.effect, candidate.joint
    mine = motion.rival(step.score, number, candidate)
    others = [(mine, motion.rival(score, number, candidate)) for score in step.rivals]
    left = [one.candidate.source.name for one in rivals(step.score, step.rivals, others)]
    if found.whitened.motion.effort == WITHOUT_GRAVITY:
        left += [name for name in of_unseen_load(effect) if name not in left]
    alike = [one.candidate.source.name for one in step.rivals]
    other_size = hold_out.doubt is not None and hold_out.doubt.reason is Reason.OTHER_SIZE
    stands = step.stands and not left and not other_size
    return Finding(
        effect=effect,
        joints=tuple(model.joints[n] for n in (joint, *candidate.others)),
        cause=model.joints[effect.cause(joint, candidate.shape)],
        shape=effect.transferable(candidate.shape),
        parameters={
            one.name: Estimate(float(value), float(low), float(high), one.unit)
            for one, value, low, high in zip(effect.parameters, values, low, high, strict=True)
        },
        log_bayes_factor=step.score.log_bf,
        p_value=step.p_value,
        size=step.score.size,
        hold_out=hold_out,
        rivals=tuple(left),
        ruled_out=tuple(name for name in alike if name not in left),
        doubt=None if stands else hold_out.doubt or doubt_of(found, step, model),
        stands=stands,
        partial_residual=partial_residual(found.whitened, candidate, values),
    )


def of_unseen_load(effect: Effect) -> list[str]:
    """Return the look-alikes of friction over position that follow a load without its gravity.

    A gear carries the arm's weight, which depends on the position, even if the effort lacks it.
    """
    if effect.kind != "friction" or effect.coordinate != "position":
        return []
    return [name for name in look_alikes(effect) if "load" in EFFECTS[name].uses]


def doubt_of(found: Search, step: Step, model: Model) -> Doubt | None:
    """Return why an effect that holds on other motion is only suggested; None if it is not.

    Args:
        step: the step of the search that found the effect.
    """
    candidate = step.score.candidate
    if doubt := _of_large_rest(found, step):
        return doubt
    if candidate.effect.absorbed and model.kernel.free:
        words = (
            f"gravity of {model.kernel.name} may be any smooth function of the positions and "
            "has this torque already: the effect may be there, but the model does not lack it"
        )
        return Doubt(Reason.ABSORBED, words)
    if ends := at_end(found.whitened.x, candidate):
        return Doubt(Reason.AT_END, ends)
    objection = unnatural(found.whitened, step.score)
    return Doubt(Reason.IMPOSSIBLE, objection) if objection else None


def _of_large_rest(found: Search, step: Step) -> Doubt | None:
    """Return the doubt that curves on the joint explain nearly as much as an effect; None if not.

    Early steps score low, since what is found later is still noise. So where curves seem large by
    the scores of their steps, all are scored again with the noise that is left in the end.
    """
    share, joint = thresholds.USED.large_rest, step.score.candidate.joint
    scores = (s for s in found.last if not s.candidate.named and s.candidate.joint == joint)
    left = max((score.log_bf for score in scores), default=0.0)
    curves = [s for s in found.steps if not s.named and s.score.candidate.joint == joint]
    own = step.score.log_bf
    rest = left + sum(one.score.log_bf for one in curves)
    if rest > share * own and curves:
        own = beside_others(found, step)
        rest = left + sum(beside_others(found, one) for one in curves)
    if rest <= share * own:
        return None
    return Doubt(
        Reason.LARGE_REST,
        f"a torque that no effect of the catalogue describes gains {rest:.0f} nats on the same "
        f"joint, this effect {own:.0f}",
    )
