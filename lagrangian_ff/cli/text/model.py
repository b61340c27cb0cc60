"""A model in words: its error, effects, hyperparameters and range."""

from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.cli.text.effects import say_equations
from lagrangian_ff.cli.text.errors import HALF_LEGEND, LEGEND, error_table
from lagrangian_ff.numbers import number

if TYPE_CHECKING:
    from lagrangian_ff.identification import MotionRange
    from lagrangian_ff.identification.records import Identified, KnownMechanism
    from lagrangian_ff.recording import Conditioning

KINDS = {
    "without-gravity": "effort without gravity: so are the model and its feedforward",
    "without-friction": "effort without friction that the drive compensates: so are the model and "
    "its feedforward",
}
"""The remark on an effort that does not hold all torque."""

SCALES = {
    "common": "one for all joints, whose torques derive from one Lagrangian",
    "joint": "each torque divided by its own spread",
}


def say_identified(found: "Identified", console: Console) -> None:
    """Print the errors, effects, hyperparameters and mass matrix of an identification."""
    if found.missing:
        console.note(f"the model's record has no {', '.join(found.missing)}", "  ")
        return
    console.say(
        f"model {found.model} of {found.samples} samples from "
        f"{found.training_seconds:.1f} s of motion, found in {found.seconds:.1f} s"
    )
    if found.landmarks:
        console.paragraph(
            f"all training samples were learned from, with the kernel built on "
            f"{found.landmarks} of them; --inducing-points 0 makes an exact model of --samples"
        )
    console.say(scaling(found.conditioning))
    console.say(known(found.mechanism))
    if found.settings.prismatic:
        sliding = ", ".join(found.settings.prismatic)
        console.say(f"sliding joints, all of whose numbers are in m and N: {sliding}")
    console.say(f"judged on {found.judged_on}, {found.held_out_seconds:.1f} s")
    half = None
    if found.outliers:
        console.paragraph(found.outliers.words)
        half = found.outliers.medians
    console.say(error_table(found.score, half))
    console.paragraph(f"{LEGEND} {HALF_LEGEND}" if half else LEGEND, "  ")
    if found.effects:
        say_equations("effects, torque", found.effects, console, "their")
    console.say(["", "hyperparameters"])
    console.say(hyperparameter_table(found))
    if found.scale in SCALES:
        console.paragraph(f"torque scale {found.scale}: {SCALES[found.scale]}", "  ")
    if found.mass_matrix.defined:
        console.paragraph(found.mass_matrix.words, "  ")


def scaling(conditioning: "Conditioning | None") -> list[str]:
    """Return how the effort of the recordings was scaled, and what it lacks; empty if nothing."""
    if conditioning is None:
        return []
    scaled = (
        ("effort scale in N·m per unit", conditioning.effort_scale),
        ("effort offset in N·m", conditioning.effort_offset),
    )
    return [
        *(
            f"{what}: {', '.join(f'{joint} {number(value)}' for joint, value in values.items())}"
            for what, values in scaled
            if values
        ),
        *([f"effort delay: {number(delay)} s"] if (delay := conditioning.effort_delay) else []),
        *([KINDS[conditioning.effort]] if conditioning.effort in KINDS else []),
    ]


def known(mechanism: "KnownMechanism | None") -> list[str]:
    """Return what was known of the arm before; empty if nothing was."""
    if mechanism is None or mechanism.mass is None:
        return []
    bodies = f"the bodies of {mechanism.name} are known ({number(mechanism.mass)} kg)"
    joints = (
        ("sliding joints", mechanism.prismatic),
        ("not recorded and taken to stand at zero", mechanism.still),
    )
    return [
        f"{bodies}; the kernel corrects them",
        *(f"{what}: {', '.join(names)}" for what, names in joints if names),
    ]


def hyperparameter_table(found: "Identified") -> list[str]:
    """Return name, value (one a joint if joints chose apart), unit and meaning."""
    meanings = _meanings(found.model)
    rows = [
        [name, ", ".join(map(number, values)), *meanings.get(name, ("", ""))]
        for name, values in found.hyperparameters.items()
    ]
    return table(["", "value", "unit", "meaning"], rows)


def range_table(known: "MotionRange", joints: tuple[str, ...]) -> list[str]:
    """Return the range of motion that a model knows."""
    columns = (known.q_low, known.q_high, known.qd_max, known.qdd_max, known.tau_max)
    rows = [
        [name, *map(number, values)]
        for name, *values in zip(joints, *(column.tolist() for column in columns), strict=True)
    ]
    header = ["joint", "from [rad]", "to [rad]", "speed [rad/s]", "acc. [rad/s²]", "torque [N·m]"]
    return table(header, rows)


def _meanings(model: str) -> dict[str, tuple[str, str]]:
    """Return unit and meaning of every hyperparameter by name."""
    from lagrangian_ff.errors import ModelError
    from lagrangian_ff.identification.spec import parse
    from lagrangian_ff.kernels.rigid.known import NUMBERS

    try:
        spec = parse(model)
    except ModelError:
        return {}
    found = {
        h.name: (h.unit, h.meaning) for h in (*spec.kernel.searched, *spec.kernel.further, *NUMBERS)
    }
    found["gamma"] = ("", "regularisation: how much noise the torques hold, (42)")
    for effect in spec.effects:
        found |= {f"{effect.name}.{s.name}": (s.unit, s.meaning) for s in effect.shapes}
    return found
