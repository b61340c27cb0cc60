"""The format `json`: all numbers and expressions, and states to check an evaluation with."""

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

from lagrangian_ff.export.portable import Portable, checked, portable
from lagrangian_ff.export.result import Exported, Options, exported, settled_losses, settled_torque
from lagrangian_ff.export.rigid import Form
from lagrangian_ff.identification import Model
from lagrangian_ff.record_json import by_name

NAME = "json"
SUMMARY = "all numbers and formulas, with a schema: to evaluate the model in another program"
SUFFIX = ".json"
URDF = False
FORMAT, VERSION = "lagrangian_ff export", 1
SCHEMA = Path(__file__).with_name("model.schema.json")
"""The JSON Schema of what is written."""


def write(model: Model, path: Path, options: Options) -> Exported:
    """Write a JSON file that `SCHEMA` describes; see `Format`."""
    held = portable(model, settled=options.settled)
    path.write_text(json.dumps(document(model, held), allow_nan=False) + "\n", encoding="utf-8")
    losses = settled_losses(model, held.settled)
    return exported(model, NAME, (".",), settled_torque(model), losses)


def document(model: Model, held: Portable) -> dict[str, Any]:
    """Return what is written of a model."""
    names = "q", "qd", "qdd", "tau"
    return {
        "format": FORMAT,
        "version": VERSION,
        "source": held.source,
        "joints": list(held.joints),
        "unit": held.unit.tolist(),
        "rigid": [_form(form) for form in held.forms],
        "effects": [by_name(term) for term in held.terms],
        "curves": [curve.record() for curve in held.curves],
        "range": by_name(held.range),
        "settled": dict(held.settled),
        "check": {n: v.tolist() for n, v in zip(names, checked(model), strict=True)},
    }


def _form(form: Form) -> dict[str, Any]:
    values = {one.name: getattr(form, one.name) for one in fields(form)}
    plain = {n: v.tolist() if hasattr(v, "tolist") else v for n, v in values.items()}
    return {"kind": form.kind, **plain}
