"""A model in words: its error, effects, hyperparameters and range."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.cli.text.effects import say_equations
from lagrangian_ff.cli.text.errors import HALF_LEGEND, LEGEND, error_table, medians
from lagrangian_ff.numbers import number

if TYPE_CHECKING:
    from lagrangian_ff.identification import MotionRange


NEEDED = (
    "model", "samples", "training_seconds", "seconds", "judged_on", "held_out_seconds", "joints",
    "rmse", "nmse", "effects", "hyperparameters",
)  # fmt: skip

SCALES = {
    "common": "one for all joints, whose torques derive from one Lagrangian",
    "joint": "each torque divided by its own spread",
}


def say_record(record: Mapping[str, Any], console: Console) -> None:
    """Print the errors, effects, hyperparameters and mass matrix of an identification."""
    missing = [name for name in NEEDED if name not in record]
    if missing:
        console.note(f"the model's record has no {', '.join(missing)}", "  ")
        return
    console.say(
        f"model {record['model']} of {record['samples']} samples from "
        f"{record['training_seconds']:.1f} s of motion, found in {record['seconds']:.1f} s"
    )
    if record.get("landmarks"):
        console.paragraph(
            f"all training samples were learned from, with the kernel built on "
            f"{record['landmarks']} of them; --landmarks 0 makes an exact model of --samples"
        )
    for text in scaling(record.get("conditioning")):
        console.say(text)
    console.say(known(record.get("mechanism")))
    sliding = record.get("settings", {}).get("prismatic")
    if sliding:
        console.say(f"sliding joints, all of whose numbers are in m and N: {', '.join(sliding)}")
    console.say(f"judged on {record['judged_on']}, {record['held_out_seconds']:.1f} s")
    outliers = record.get("outliers")
    if outliers:
        console.paragraph(outliers["words"])
    console.say(error_table(record))
    console.paragraph(f"{LEGEND} {HALF_LEGEND}" if medians(record) else LEGEND, "  ")
    if record["effects"]:
        say_equations("effects, torque", record["effects"], console, "their")
    console.say(["", "hyperparameters"])
    console.say(hyperparameter_table(record))
    if record.get("scale") in SCALES:
        console.paragraph(f"torque scale {record['scale']}: {SCALES[record['scale']]}", "  ")
    mass = record.get("mass_matrix", {})
    if mass.get("defined"):
        console.paragraph(mass["words"], "  ")


def scaling(conditioning: Mapping[str, Any] | None) -> list[str]:
    """Return how the effort of the recordings was scaled; empty if it was not."""
    lines = []
    for name, unit in (("effort_scale", "N·m per unit"), ("effort_offset", "N·m")):
        values = (conditioning or {}).get(name)
        if values:
            shown = ", ".join(f"{joint} {number(value)}" for joint, value in values.items())
            lines.append(f"{name.replace('_', ' ')} in {unit}: {shown}")
    return lines


def known(mechanism: Mapping[str, Any] | None) -> list[str]:
    """Return what was known of the arm before; empty if nothing was."""
    if not mechanism or mechanism.get("kind") != "urdf":
        return []
    lines = [
        f"the bodies of {mechanism['name']} are known ({number(mechanism['mass'])} kg); "
        "the kernel corrects them"
    ]
    for what, key in (
        ("sliding joints", "prismatic"),
        ("not recorded and taken to stand at zero", "still"),
    ):
        lines += [f"{what}: {', '.join(mechanism[key])}"] if mechanism[key] else []
    return lines


def hyperparameter_table(record: Mapping[str, Any]) -> list[str]:
    """Return name, value (one a joint if joints chose apart), unit and meaning."""
    meanings = _meanings(str(record["model"]))
    rows = []
    for name, value in record["hyperparameters"].items():
        values = value if isinstance(value, list) else [value]
        unit, meaning = meanings.get(name, ("", ""))
        rows.append([name, ", ".join(map(number, values)), unit, meaning])
    return table(["", "value", "unit", "meaning"], rows)


def range_table(known: "MotionRange", joints: tuple[str, ...]) -> list[str]:
    """Return the range of motion that a model knows."""
    rows = [
        [name, *(number(float(values[n])) for values in (
            known.q_low, known.q_high, known.qd_max, known.qdd_max, known.tau_max))]
        for n, name in enumerate(joints)
    ]  # fmt: skip
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
