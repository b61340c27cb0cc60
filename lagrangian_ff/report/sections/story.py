"""The story of an investigation: each question, its motion, the answer, and the error's fall."""

from typing import TYPE_CHECKING

from lagrangian_ff.numbers import DASH, typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.colours import of_joint
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.plot import Plot, axis, embed, line
from lagrangian_ff.report.sections.findings import evidence
from lagrangian_ff.report.sections.history import fall_plot, joints_fall_plot
from lagrangian_ff.words import sentence, spoken

if TYPE_CHECKING:
    from lagrangian_ff.investigation import Investigation, Turn

DRAWN = 400
"""Points of a motion that its figure has, at most."""


def turns_section(story: "Investigation") -> Section:
    """Return each question with the motion that answers it."""
    rows = [
        [
            str(number),
            turn.asked,
            ", ".join(spoken(one.name) for one in turn.confirmed) or DASH,
            typeset(turn.seconds),
            DASH if turn.expected is None else typeset(turn.expected),
            DASH if turn.gained is None else typeset(turn.gained),
        ]
        for number, turn in enumerate(story.turns, 1)
    ]
    header = ["", "question", "confirmed after it", "motion [s]", "nats expected", "nats now"]
    parts = [html.table(header, rows, words=3, strong=2)]
    for number, turn in enumerate(story.turns, 1):
        parts.append(html.paragraph(f"{number}. {turn.asked} {sentence(turn.answer)}"))
        parts.append(embed(motion_plot(turn), f"positions of the motion for question {number}"))
    return Section(
        "Question by question",
        "Every motion is designed to decide the question above it. The nats expected were computed "
        "before the arm moved; between two rivals they tell these apart. The nats now are those of "
        "what was found of it against its absence, from all motions so far.",
        "".join(parts),
    )


def staircase_section(story: "Investigation") -> Section | None:
    """Return the error after each question, on motion that no model learned from."""
    if not story.turns:
        return None
    models = [(f"question {n}", turn.total, turn.errors) for n, turn in enumerate(story.turns, 1)]
    if story.curves:
        models.append(("with curves", story.total, story.errors))
    names = [name for name, _, _ in models]
    errors = [total for _, total, _ in models]
    joints = {joint: [by_joint[joint] for _, _, by_joint in models] for joint in story.joints}
    falls = bool(story.confirmed or story.curves)
    columns = [*joints.items()]
    if falls:
        columns = [(joint, [story.before[joint], *values]) for joint, values in columns]
    rows = [[joint, *map(typeset, values)] for joint, values in columns]
    header = ["RMS error [N·m]", *(["without what was found"] if falls else []), *names]
    total, each = (story.before_total, story.before) if falls else (None, None)
    return Section(
        "The error falls" if falls else "The error",
        "Each model is judged on the same motion: the last part of every few seconds of every "
        "recording, from which none of them learned.",
        embed(fall_plot(names, errors, total), "error after each question")
        + embed(joints_fall_plot(names, joints, each), "each joint's error after each question")
        + html.table(header, rows, strong=len(header) - 1),
    )


def ended_section(story: "Investigation") -> Section:
    """Return why it ended, and what is left."""
    ended = f"It ended after {story.seconds:.0f} s of motion: {story.words}."
    return Section("What is left", "", html.bullets([ended, *story.left]))


def unlisted_section(story: "Investigation") -> Section | None:
    """Return the curves that the model holds, and formulas for what no effect fits."""
    if story.unlisted is None or not (story.curves or story.unlisted.proposals):
        return None
    last = story.turns[-1]
    texts = [
        f"{one.joint}, over {one.coordinate}: {100 * one.share:.0f} % of its torque. With the "
        f"curve its error falls from {typeset(last.errors[one.joint])} to "
        f"{typeset(story.errors[one.joint])} N·m."
        for one in story.curves
    ]
    parts = [html.bullets(texts)] if texts else []
    header = ["formula", "it might be", "verdict", "nats", "error before [N·m]", "after"]
    added = [one.name for one in story.formulas]
    for found in story.unlisted.proposals:
        rows = [
            [
                f"τ = {one.formula}",
                one.words,
                "added" if one.finding.name in added else one.finding.verdict.value,
                typeset(one.finding.log_bayes_factor),
                *(DASH if error is None else typeset(error) for error in one.finding.errors),
            ]
            for one in found.proposals
        ]
        if rows:
            parts.append(html.paragraph(f"{found.joint}: {found.tried} formulas competed."))
            parts.append(html.table(header, rows, words=3))
            first = found.proposals[0]
            if first.finding.name not in added:
                parts.append(evidence(first.finding, story.joints, first.words))
    return Section(
        "What nobody listed",
        "No effect of the catalogue fits this. Where a curve lowers the error, the model holds it, "
        "without a name. A formula says how a torque looks, not what causes it; one that unseen "
        "motion confirms is added.",
        "".join(parts),
    )


def motion_plot(turn: "Turn") -> Plot:
    """Draw the positions of the joints that move, from their place at the start."""
    motion = turn.motion
    every = max(1, len(motion.time) // DRAWN)
    time, q = motion.time[::every], motion.q[::every] - motion.q[0]
    moving = [n for n in range(q.shape[1]) if abs(q[:, n]).max() > 1e-3]
    joints = turn.model.joints
    data = [
        line(time.tolist(), q[:, n].tolist(), joints[n], of_joint(n), width=1.4) for n in moving
    ]
    layout = {
        "xaxis": axis("time [s]"),
        "yaxis": axis("from the start [rad]"),
        "showlegend": True,
        "hovermode": "x unified",
    }
    return Plot(data, layout, 240)
