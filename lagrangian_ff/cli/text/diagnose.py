"""What is missing in a model, as text: the verdict first, then the evidence, then what to do."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.text.effects import equations, parameter_table
from lagrangian_ff.cli.text.layout import number, table
from lagrangian_ff.words import where, which

LEGEND = (
    "confirmed: with frozen coefficients it lowers the error on motion that was not used to find "
    "it. gain: log evidence won. p: how often chance gives the best of all candidates as much. "
    "error: rms on that joint, on {unseen}, of the model as it is and refitted with the effect."
)

STAYS = 0.98
"""An error that falls to no less than this share of what it was is said to stay."""


def say_checks(checks: Sequence[Mapping[str, Any]], console: Console) -> None:
    """Faults of the measurement: those to mend before any effect is believed, then the others.

    Args:
        checks: records of the preflight.
        console: to tell it to.
    """
    for heading, faults in (
        ("fix first: these faults of the measurement look like missing physics",
         [one for one in checks if one["serious"]]),
        ("about the measurement",
         [one for one in checks if one["advice"] and not one["serious"]]),
    ):  # fmt: skip
        if faults:
            console.say(heading)
        for one in faults:
            source = f"{one['source']}: " if one.get("source") else ""
            advice = f". {one['advice']}" if one["advice"] else ""
            console.paragraph(f"{source}{one['finding']}{advice}", "  - ", "    ")
        if faults:
            console.say()


def say_diagnosis(record: Mapping[str, Any], console: Console) -> None:
    """The verdict, the findings, and what is left.

    Args:
        record: of diagnose.
        console: to tell it to.
    """
    console.say()
    console.paragraph(record["verdict"])
    findings, every = record["findings"], record.get("joints", ())
    if findings:
        console.say(["", "what was found"])
        console.say(finding_table(findings, every))
        console.paragraph(LEGEND.format(unseen=record["confirmed_on"]), "  ")
        say_parameters(findings, every, console)
        doubts = [text for one in findings for text in (doubt(one, every), no_fall(one)) if text]
        if doubts:
            console.say()
        for text in doubts:
            console.paragraph(text, "  - ", "    ")
    if record["unexplained"]:
        console.say(["", "left unexplained: no effect of the catalogue fits"])
        for one in record["unexplained"]:
            console.paragraph(
                f"{one['joint']}: something {one['share']:.1%} the size of its torque depends on "
                f"{one['coordinate']}",
                "  - ",
                "    ",
            )


def say_parameters(
    findings: Sequence[Mapping[str, Any]], every: Sequence[str], console: Console
) -> None:
    """The torque of each finding as an equation, and its parameters."""
    entries = [{**one, "joint": where(one, every)} for one in findings if one["parameters"]]
    if entries:
        console.say(["", "as torque, in N·m with qd in rad/s"])
        console.say(equations(entries))
        console.say(["", "its parameters with 90 % intervals"])
        console.say(parameter_table(entries))


def is_event(finding: Mapping[str, Any]) -> bool:
    """Whether it is of the recording, as a load taken up, not of the arm: nothing to add."""
    return not finding["why"]


def finding_table(findings: Sequence[Mapping[str, Any]], every: Sequence[str]) -> list[str]:
    """One line a finding."""
    rows = [
        [
            one["effect"],
            where(one, every),
            one["verdict"].split()[0],
            number(one["evidence_gain"]),
            chance(one["p_value"]),
            number(one["error_before"]),
            number(one["error_after"]),
        ]
        for one in findings
    ]
    header = ["effect", "joint", "verdict", "gain", "p", "error before [N·m]", "after"]
    return table(header, rows)


def doubt(finding: Mapping[str, Any], every: Sequence[str] = ()) -> str:
    """Why a finding is no more than it is; empty where it is confirmed."""
    if finding["verdict"] == "confirmed":
        return ""
    text = f"{finding['effect']} on {where(finding, every)}"
    if finding.get("reason"):
        text += f" is no more than suggested: {finding['reason']}"
    if finding["ambiguous_with"]:
        others = " or ".join(finding["ambiguous_with"])
        text += f"; it may be {others} too: on this motion they look the same"
        for apart in finding.get("told_apart_by") or []:
            text += f"; {apart}"
    return f"{text}. Motion to do: {finding['next_motion']}"


def say_not_observable(record: Mapping[str, Any], model: str, console: Console) -> None:
    """What the motion could not have shown, by effect, and the motion to do.

    Args:
        record: of diagnose.
        model: the model file.
        console: to tell it to.
    """
    groups: dict[tuple[str, str], list[str]] = {}
    never = []
    for one in record["not_observable"]:
        if one["joint"] == "all":
            never.append(one["effect"])
        else:
            groups.setdefault((one["effect"], one["next_motion"]), []).append(one["joint"])
    if groups:
        console.say(["", "not observable here, neither there nor absent; the motion to do"])
        for (effect, motion), joints in groups.items():
            on = which(joints, record.get("joints", ()))
            console.paragraph(f"{effect} ({on}): {motion}", "  - ", "    ")
        effect, joint = next((effect, joints[0]) for (effect, _), joints in groups.items())
        console.say(f"  as a trajectory: {excite(effect, joint, model)}")
    if never:
        console.say()
        console.paragraph(
            f"{', '.join(never)}: no motion of the arm alone shows these; lagrangian_ff effects "
            "EFFECT says why"
        )


def no_fall(finding: Mapping[str, Any]) -> str:
    """What it means that the model's own error does not fall with a confirmed effect."""
    before, after = finding["error_before"], finding["error_after"]
    if finding["verdict"] != "confirmed" or before is None or after < STAYS * before:
        return ""
    joints = ", ".join(finding["joints"])
    return (
        f"{finding['effect']} on {joints} is there, yet adding it to this model hardly changes "
        f"its error on {joints}. Its kernel may have it already, as a torque over position passes "
        "for gravity in chain_rbf or vrbfs; the recordings that the model keeps may not hold it "
        "(did it appear since? ask with --since: then identify anew from these, and add it); or "
        "other errors of the model are larger"
    )


def excite(effect: str, joint: str, model: str) -> str:
    """The command that makes the motion which shows an effect."""
    return f"lagrangian_ff excite {effect} --joint {joint} --model {model} --output motion.csv"


def chance(p: float | None) -> str:
    """A probability, as a finite number of draws knows it."""
    return "-" if p is None else f"{p:.2g}"


def next_steps(
    record: Mapping[str, Any],
    model: str,
    sources: Sequence[str],
    confirm: Sequence[str] = (),
    saved: str = "",
) -> list[str]:
    """The commands to type next.

    Args:
        record: of diagnose.
        model: the model file.
        sources, confirm: the recordings, as they were named.
        saved: the file that the record is in; empty for none.
    """
    again = " ".join([*sources, *(["--confirm", *confirm] if confirm else [])])
    lines = []
    if any(one["serious"] for one in record.get("preflight", [])):
        lines.append("next: fix what is wrong with the measurement, see above, and diagnose again")
    sure = [one for one in record["findings"] if one["verdict"] == "confirmed"]
    events = [one for one in sure if is_event(one)]
    to_add = [one for one in sure if not is_event(one)]
    if to_add:
        first = to_add[0]
        joints = " ".join(f"--joint {joint}" for joint in first["joints"])
        values = " ".join(f"{name}={value}" for name, value in first["shape_words"].items())
        shape = f" --shape {values}" if values else ""
        details = f" --because {saved}" if saved else shape
        return [
            *lines,
            "next: add what is confirmed",
            f"  lagrangian_ff add {model} {first['effect']} {joints}{details}",
            "or all of it, and look again until nothing more is confirmed",
            f"  lagrangian_ff diagnose {model} {again} --apply --output NEW.npz",
        ]
    if events:
        return [
            *lines,
            f"next: {events[0]['effect']} is of this recording, not of the arm: nothing is to be "
            "added.",
            "Identify and diagnose from recordings without it, or with it from the beginning.",
        ]
    if record["unexplained"]:
        lines += [
            "next: where is it, and do you know of an effect that looks so? Bring it:",
            f"  lagrangian_ff compare {model} {' '.join(sources)} --report where.html",
            f"  lagrangian_ff diagnose {model} {again} --effects-file my_effects.py",
        ]
    if record["findings"]:
        first = record["findings"][0]
        lines += [
            f"next: record the motion that settles {first['effect']}, and confirm on that",
            f"  {excite(first['effect'], first['joints'][0], model)}",
            f"  lagrangian_ff diagnose {model} {' '.join(sources)} --confirm NEW_RECORDING",
        ]
    return lines
