"""A diagnosis as text: the verdict first, then the evidence, what changed, and what to do."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.cli.text.effects import say_equations
from lagrangian_ff.numbers import chance, number
from lagrangian_ff.words import standing, where, which

LEGEND = (
    "confirmed: with frozen coefficients it lowers the error on motion that was not used to find "
    "it. gain: log evidence won. p: how often chance gives the best of all candidates as much. "
    "error: rms on that joint, on {unseen}, of the model as it is and refitted with the effect."
)

STAYS = 0.98
"""An error that keeps at least this share of its size does not fall."""


def say_checks(checks: Sequence[Mapping[str, Any]], console: Console) -> None:
    """Print faults of the measurement: first those to mend before any effect is believed."""
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
            console.bullet(f"{source}{one['finding']}{advice}")
        if faults:
            console.say()


def say_diagnosis(record: Mapping[str, Any], console: Console) -> None:
    """Print the verdict, the findings, and what is left."""
    console.say()
    console.paragraph(record["verdict"])
    findings, every = record["findings"], record.get("joints", ())
    if findings:
        console.say(["", "what was found"])
        header = ["effect", "joint", "verdict", "gain", "p", "error before [N·m]", "after"]
        rows = [
            [
                one["effect"],
                where(one, every),
                standing(one),
                number(one["evidence_gain"]),
                chance(one["p_value"]),
                *(number(one[name]) for name in ("error_before", "error_after")),
            ]
            for one in findings
        ]
        console.say(table(header, rows))
        console.paragraph(LEGEND.format(unseen=record["confirmed_on"]), "  ")
        entries = [{**one, "joint": where(one, every)} for one in findings if one["parameters"]]
        if entries:
            say_equations("as torque,", entries, console)
        doubts = [text for one in findings for text in (doubt(one, every), no_fall(one)) if text]
        if doubts:
            console.say()
        for text in doubts:
            console.bullet(text)
    if record["unexplained"]:
        console.say(["", "left unexplained: no effect of the catalogue fits"])
        for one in record["unexplained"]:
            console.bullet(
                f"{one['joint']}: something {one['share']:.1%} the size of its torque depends on "
                f"{one['coordinate']}"
            )


def doubt(finding: Mapping[str, Any], every: Sequence[str] = ()) -> str:
    """Return why a finding is not confirmed, and the motion to do; empty if it is."""
    if standing(finding) == "confirmed":
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


def say_changed(changed: Sequence[Mapping[str, Any]], model: str, console: Console) -> None:
    """Print what changed since the model of a file was identified, or that nothing did."""
    console.say(["", f"what changed since {model} was identified"])
    if not changed:
        console.say("  nothing that stands out: the arm is as it was")
        return
    rows = [
        [
            one["what"],
            ", ".join(one["joints"]),
            number(one["evidence_gain"]),
            chance(one["p_value"]),
            ", ".join(
                f"{name} by {number(change['value'])} {change['unit']}"
                for name, change in one["change"].items()
            )
            or "another mass: a load was attached or taken off",
            number(one["size"]),
        ]
        for one in changed
    ]
    console.say(table(["what", "joint", "gain", "p", "changed", "rms [N·m]"], rows))
    for one in changed:
        ranges = [
            f"{name} by {number(change['low'])} to {number(change['high'])} {change['unit']}"
            for name, change in one["change"].items()
            if "low" in change
        ]
        if ranges:
            console.paragraph(f"{one['what']}, 90 % intervals: {', '.join(ranges)}", "  ", "    ")
        if one["rivals"]:
            alike = ", ".join(one["rivals"])
            console.paragraph(f"{one['what']}: {alike} would explain as much", "  ", "    ")


def say_not_observable(record: Mapping[str, Any], model: str, console: Console) -> None:
    """Print what the motion of a diagnosis could not have shown, and the motion to do."""
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
            console.bullet(f"{effect} ({on}): {motion}")
        effect, joint = next((effect, joints[0]) for (effect, _), joints in groups.items())
        console.say(f"  as a trajectory: {excite(effect, joint, model)}")
    if never:
        console.say()
        console.paragraph(
            f"{', '.join(never)}: no motion of the arm alone shows these; lagrangian_ff effects "
            "EFFECT says why"
        )


def no_fall(finding: Mapping[str, Any]) -> str:
    """Return what it means if the model's error does not fall with a confirmed effect."""
    before, after = finding["error_before"], finding["error_after"]
    if standing(finding) != "confirmed" or before is None or after < STAYS * before:
        return ""
    joints = ", ".join(finding["joints"])
    return (
        f"{finding['effect']} on {joints} is there, yet adding it to this model hardly changes "
        f"its error on {joints}. Its kernel may have it already, as a torque over position passes "
        "for gravity in chain_rbf or vrbfs; the recordings that the model keeps may not hold it "
        "(did it appear since? ask with --since: then identify again from these, and add it); or "
        "other errors of the model are larger"
    )


def excite(effect: str, joint: str, model: str) -> str:
    """Return the command that makes the motion which shows an effect."""
    return f"lagrangian_ff excite {effect} --joint {joint} --model {model} --output motion.csv"


def next_steps(
    record: Mapping[str, Any], model: str, sources: Sequence[str], confirm: Sequence[str] = (),
    saved: str = "",
) -> list[str]:  # fmt: skip
    """Return the commands to type next.

    Args:
        sources, confirm: the recordings, as they were named.
        saved: the file that holds the record; empty for none.
    """
    again = " ".join([*sources, *(["--confirm", *confirm] if confirm else [])])
    lines = []
    if any(one["serious"] for one in record.get("preflight", [])):
        lines.append("next: fix what is wrong with the measurement, see above, and diagnose again")
    sure = [one for one in record["findings"] if standing(one) == "confirmed"]
    # An event, such as a load taken up, belongs to the recording: it has no reason to be added.
    events = [one for one in sure if not one["why"]]
    to_add = [one for one in sure if one["why"]]
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
