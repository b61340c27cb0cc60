"""A diagnosis as text: the verdict first, then the evidence, what changed, and what to do."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.cli.text.effects import say_equations
from lagrangian_ff.numbers import chance, number
from lagrangian_ff.words import which

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis import Changed, Diagnosis, DiagnosisRun, Finding
    from lagrangian_ff.diagnosis.consequence import Consequence
    from lagrangian_ff.diagnosis.observable import Observability
    from lagrangian_ff.diagnosis.preflight import Check
    from lagrangian_ff.diagnosis.results import Found, NotObservable, Unexplained
    from lagrangian_ff.identification.records import FittedEffect

LEGEND = (
    "confirmed: with frozen coefficients it explains motion that was not used to find it, and "
    "adding it lowers the error of this model there. gain: log evidence won. p: how often chance "
    "gives the best of all candidates as much. "
    "error: rms on that joint, on {unseen}, of the model as it is and refitted with the effect."
)


def say_checks(checks: "Sequence[Check]", console: Console) -> None:
    """Print faults of the measurement: first those to mend before any effect is believed."""
    first = "fix first: these faults of the measurement look like missing physics"
    serious = [one for one in checks if one.serious]
    others = [one for one in checks if one.advice and not one.serious]
    for heading, faults in ((first, serious), ("about the measurement", others)):
        if faults:
            console.say(heading)
        for one in faults:
            source = f"{one.source}: " if one.source else ""
            advice = f". {one.advice}" if one.advice else ""
            console.bullet(f"{source}{one.finding}{advice}")
        if faults:
            console.say()


def say_diagnosis(
    diagnosis: "Diagnosis", console: Console, changed: "Sequence[Changed] | None" = None
) -> None:
    """Print the verdict with what changed first, the findings, and what is left."""
    from lagrangian_ff.diagnosis import verdict

    console.say()
    console.paragraph(verdict(diagnosis, changed))
    every = diagnosis.model.joints
    if diagnosis.found:
        console.say(["", "what was found"])
        header = ["effect", "joint", "verdict", "gain", "p", "error before [N·m]", "after"]
        rows = [
            [
                one.effect.name,
                one.place(every),
                one.verdict.value,
                number(one.log_bayes_factor),
                chance(one.p_value),
                *map(number, one.errors),
            ]
            for one in diagnosis.found
        ]
        console.say(table(header, rows))
        console.paragraph(LEGEND.format(unseen=diagnosis.confirmed_on), "  ")
        say_equations("as torque,", [fitted_effect(one, every) for one in diagnosis.found], console)
        doubts = [no_fall(one) or doubt(one, every) for one in diagnosis.found]
        if any(doubts):
            console.say()
        for text in filter(None, doubts):
            console.bullet(text)
    if diagnosis.contacts:
        console.say(["", "what touched the arm while it was recorded, with 90 % intervals"])
        header = [
            "from [s]",
            "to [s]",
            "joint",
            "torque [N·m]",
            "5 %",
            "95 %",
            "p",
            "verdict",
            "recording",
        ]
        console.say(table(header, touches(diagnosis)))
    if diagnosis.unexplained:
        console.say(["", "left unexplained: no effect of the catalogue fits"])
    for rest in diagnosis.unexplained:
        console.bullet(
            f"{rest.joint}: something {rest.share:.1%} the size of its torque depends on "
            f"{rest.coordinate}{_as_curve(rest)}"
        )
    if diagnosis.remainders:
        console.say(["", "more than noise is left: it changes more slowly than noise does"])
    for left in diagnosis.remainders:
        console.bullet(f"{left.joint}: {number(left.size)} N·m, {left.share:.1%} of its torque")


def _as_curve(rest: "Unexplained") -> str:
    """Return what the curve of a torque without explanation does to the error."""
    made = rest.consequence
    if made is None:
        return ""
    errors = f"{number(made.whole_before)} -> {number(made.whole_after)} N·m on unseen motion"
    return f"; as a curve: {errors}" + ("" if made.worth else ", not worth it")


def touches(diagnosis: "Diagnosis") -> list[list[str]]:
    """Return a row for each touch and joint."""
    return [
        [
            f"{one.begin:.2f}",
            f"{one.end:.2f}",
            joint,
            *map(number, (size.value, size.low, size.high)),
            chance(one.p_value),
            "sure" if one.sure else "suggested",
            one.source,
        ]
        for one in diagnosis.contacts
        for joint, size in one.sizes.items()
    ]


def fitted_effect(found: "Found", every: Sequence[str]) -> "FittedEffect":
    """Return a finding as `say_equations` takes the effects of a model."""
    from lagrangian_ff.identification.records import FittedEffect

    return FittedEffect(
        found.effect.name,
        found.place(every),
        found.effect.formula,
        found.parameters,
        found.shape,
        found.effect.shape_words(found.shape, every),
    )


def doubt(found: "Found", every: Sequence[str]) -> str:
    """Return why a finding is not confirmed, and the motion to do; empty if it is."""
    if found.confirmed:
        return ""
    text = f"{found.effect.name} on {found.place(every)}"
    if found.doubt:
        text += f" is no more than suggested: {found.doubt.words}"
    if found.rivals:
        text += f"; it may be {' or '.join(found.rivals)} too: on this motion they look the same"
    parts = [text, *found.told_apart_by]
    return f"{'; '.join(parts)}. Motion to do: {found.effect.next_motion}"


def no_fall(found: "Found") -> str:
    """Return what it may mean that adding an effect which is there does not lower the error."""
    if found.doubt is None or not found.useless:
        return ""
    return (
        f"{found.effect.name} on {', '.join(found.joints)}: {found.doubt.words}. Or the kernel has "
        "it already, as a torque over position passes for gravity in chain_rbf or vrbfs; or the "
        "recordings that the model keeps do not hold it (did it appear since? ask with --since: "
        "then identify again from these, and add it)"
    )


def fall_table(tried: "Sequence[tuple[Finding, Consequence]]") -> list[str]:
    """Return the error of all joints, and of the joint concerned, after each addition."""
    rows = [["as it was", number(tried[0][1].every_before), ""]]
    for finding, made in tried:
        own = f"{made.joint}: {number(made.whole_before)} -> {number(made.whole_after)}"
        rows.append([f"+ {finding.name}", number(made.every_after), own])
    return table(["model", "all joints", "its joint"], rows)


def say_changed(changed: "Sequence[Changed]", model: str, console: Console) -> None:
    """Print what changed since the model of a file was identified, or that nothing did."""
    console.say(["", f"what changed since {model} was identified"])
    if not changed:
        console.say("  nothing that stands out: the arm is as it was")
        return
    rows = [
        [
            one.what,
            ", ".join(one.joints),
            number(one.log_bayes_factor),
            chance(one.p_value),
            ", ".join(f"{n} by {number(by.value)} {by.unit}" for n, by in one.parameters.items())
            or "another mass: a load was attached or taken off",
            number(one.size),
        ]
        for one in changed
    ]
    console.say(table(["what", "joint", "gain", "p", "changed", "rms [N·m]"], rows))
    for one in changed:
        ranges = [
            f"{name} by {number(by.low)} to {number(by.high)} {by.unit}"
            for name, by in one.parameters.items()
            if by.bounded
        ]
        if ranges:
            console.paragraph(f"{one.what}, 90 % intervals: {', '.join(ranges)}", "  ", "    ")
        if one.note:
            console.paragraph(f"{one.what}: {one.note}", "  ", "    ")
        if one.rivals:
            alike = ", ".join(one.rivals)
            console.paragraph(f"{one.what}: {alike} would explain as much", "  ", "    ")


def say_not_observable(
    hidden: "Sequence[NotObservable]", every: Sequence[str], console: Console, model: str = ""
) -> None:
    """Print what a motion cannot show, and the motion to do.

    Args:
        every: the arm's joints.
        model: the file of a model, with which such a motion is made; empty for none.
    """
    groups: dict[tuple[str, str], list[str]] = {}
    never = []
    for one in hidden:
        if one.joint == "all":
            never.append(one.effect)
        else:
            groups.setdefault((one.effect, one.next_motion), []).append(one.joint)
    if groups:
        console.say(["", "not observable here, neither there nor absent; the motion to do"])
        for (effect, motion), joints in groups.items():
            console.bullet(f"{effect} ({which(joints, every)}): {motion}")
        if model:
            effect, joint = next((effect, joints[0]) for (effect, _), joints in groups.items())
            console.say(f"  as a trajectory: {excite(effect, joint, model)}")
    if never:
        console.say()
        console.paragraph(
            f"{', '.join(never)}: no motion of the arm alone shows these; lagrangian_ff effects "
            "EFFECT says why"
        )


def say_observability(found: "Observability", console: Console) -> None:
    """Print the least size at which each effect would be seen, and what the motion cannot show."""
    console.say(["", f"what this motion could show: {found.words}"])
    console.paragraph(
        "the size in per cent of the joint's torque from which on diagnose expects to see an "
        "effect; - where it never does",
        "  ",
    )
    rows = [
        [effect, *(f"{100.0 * one:.2g}" if one < 1.0 else "-" for one in row)]
        for effect, row in sorted(found.least.items(), key=lambda item: max(item[1]))
    ]
    console.say(table(["effect [%]", *found.joints], rows))
    say_not_observable(found.not_observable, found.joints, console)


def excite(effect: str, joint: str, model: str) -> str:
    """Return the command that makes the motion which shows an effect."""
    return f"lagrangian_ff excite {effect} --joint {joint} --model {model} --output motion.csv"


def again_from(found: "DiagnosisRun") -> str:
    """Return the command that identifies the arm as it is now."""
    recordings = " ".join([*found.sources, *found.confirm])
    return f"  lagrangian_ff identify {recordings} --train 1.0 --output NEW.npz"


def next_steps(found: "DiagnosisRun", saved: str = "") -> list[str]:
    """Return the commands to type next; `saved` is the file that holds the JSON, empty for none."""
    diagnosis, model, sources = found.diagnosis, found.model_file, " ".join(found.sources)
    again = " ".join([sources, *(["--confirm", *found.confirm] if found.confirm else [])])
    lines = []
    if found.changed:
        return ["next: identify again from recordings of the arm as it is", again_from(found)]
    if found.serious:
        lines.append("next: fix what is wrong with the measurement, see above, and diagnose again")
    sure = [one for one in diagnosis.found if one.confirmed]
    # An event, such as a load taken up, belongs to the recording: it is not to be added.
    to_add = next((one for one in sure if not one.once), None)
    if to_add is not None:
        words = to_add.effect.shape_words(to_add.shape, diagnosis.model.joints)
        values = " ".join(f"{name}={value}" for name, value in words.items())
        shape = f" --shape {values}" if values else ""
        details = f" --because {saved}" if saved else shape
        joints = " ".join(f"--joint {joint}" for joint in to_add.joints)
        return [
            *lines,
            "next: add what is confirmed",
            f"  lagrangian_ff add {model} {to_add.effect.name} {joints}{details}",
            "or all of it, and look again until nothing more is confirmed",
            f"  lagrangian_ff diagnose {model} {again} --apply --output NEW.npz",
        ]
    if sure:
        return [
            *lines,
            f"next: {sure[0].effect.name} is of this recording, not of the arm: nothing is to be "
            "added.",
            "Identify and diagnose from recordings without it, or with it from the beginning.",
        ]
    from lagrangian_ff.diagnosis.sentences import curve_command

    commands = [curve_command(rest, model) for rest in diagnosis.unexplained]
    if any(commands):
        lines.append("next: take it in as a curve, whatever it is")
        lines += [f"  {command}" for command in commands if command]
    if diagnosis.unexplained:
        joint = diagnosis.unexplained[0].joint
        lines += [
            "next: have a formula proposed for it",
            f"  lagrangian_ff propose {model} {again} --joint {joint} --output mine.json",
        ]
    if diagnosis.unexplained:
        lines += [
            "next: where is it, and do you know of an effect that looks so? Bring it:",
            f"  lagrangian_ff compare {model} {sources} --report where.html",
            f"  lagrangian_ff diagnose {model} {again} --effects-file my_effects.py",
        ]
    unsettled = [one for one in diagnosis.found if not no_fall(one)]
    if diagnosis.found and not unsettled:
        lines += ["next: identify again, from more motion or with another model, and diagnose that"]
        lines += [again_from(found)]
    if unsettled:
        first = unsettled[0]
        lines += [
            f"next: record the motion that settles {first.effect.name}, and confirm on that",
            f"  {excite(first.effect.name, first.joints[0], model)}",
            f"  lagrangian_ff diagnose {model} {sources} --confirm NEW_RECORDING",
        ]
    return lines
