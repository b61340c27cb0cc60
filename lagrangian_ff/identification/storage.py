"""Models on disk: a zip of plain arrays and one JSON text (.npz). Reading executes nothing."""

import json
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from lagrangian_ff import budget
from lagrangian_ff.arrays import Flags, Floats
from lagrangian_ff.effects import EFFECTS, Effect
from lagrangian_ff.effects.curve import Curve, from_stored
from lagrangian_ff.effects.formula import Formula, formula_of
from lagrangian_ff.effects.user import check
from lagrangian_ff.errors import ModelError, UserError
from lagrangian_ff.files import whole
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.history import Step
from lagrangian_ff.identification.predicting import MotionRange, TorqueModel
from lagrangian_ff.identification.problem import Prior, Scaling
from lagrangian_ff.identification.records import Identified
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.kernels import Family, Kernel, States
from lagrangian_ff.kernels.constrained import KIND as LINKAGE
from lagrangian_ff.kernels.constrained import Linkage
from lagrangian_ff.kernels.rigid.robot import KIND as ROBOT
from lagrangian_ff.kernels.rigid.robot import Robot
from lagrangian_ff.record_json import by_name
from lagrangian_ff.recording.archive import read_archive
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.recording.recording import TEMPERATURE

Loaded = TypeVar("Loaded", bound=TorqueModel)

FORMAT = "lagrangian_ff model"
VERSION = 4
SHARING = 4
"""Version since which an effect may act on several joints."""
ARRAYS = {
    "q": 2, "qd": 2, "qdd": 2, "tau": 2, "time": 1, "segment": 1, "trained": 1, "index": 1,
    "seen": 1, "weights": 2, "coefficients": 1, "unit": 1, "noise": 1, "noise_share": 1,
    "more_q": 2, "more_qd": 2, "more_qdd": 2,
}  # fmt: skip
"""Every array of the file and its number of dimensions."""
MORE = ("more_q", "more_qd", "more_qdd")
"""Centres that are no samples of the data."""
GRAVITY = "potential"
"""The hyperparameter that is 0 where the effort holds no gravity."""
DAMAGED = (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RecursionError)
"""Errors of contents that do not fit each other."""
MOST = 1e60
"""Largest number of a model, in any unit: products of several must not overflow."""
PROBES = 20
"""Samples at which a model that was saved must predict as it did before."""
TRUST = "trust"
"""The array of IRLS weights, one for each torque learned from; absent for the square loss."""

CURVE, FORMULA = "curve", "formula"
"""The keys that hold the definition of a curve or a formula: a model needs no other file for it."""

HELD = ("header", TEMPERATURE, TRUST, *ARRAYS)
"""All that is read of a file."""


def save(model: TorqueModel, path: Path) -> None:
    """Write the model; an existing file is replaced only once the new one was read back.

    Raises:
        ModelError: the folder does not exist or cannot be written, or what was written does not
            read back as a model that predicts the same.
    """
    header = {
        "format": FORMAT,
        "version": VERSION,
        "joints": list(model.joints),
        "units": {"q": "rad", "qd": "rad/s", "qdd": "rad/s²", "tau": "N·m", "time": "s"},
        "name": model.name,
        "hyperparameters": {k: v.tolist() for k, v in model.kernel.hyperparameters.items()},
        "basis": [_term_record(term) for term in model.basis.terms],
        "range": by_name(model.range),
        "record": dict(model.record),
        "steps": [dict(step) for step in model.steps],
        "mechanism": model.kernel.mechanism.stored() if model.kernel.mechanism else None,
        "source": model.data.source,
        "notes": list(model.data.notes),
        "conditioning": dict(model.data.conditioning),
    }
    data, more = model.data, model.centres.take(slice(len(model.index), None))
    arrays: dict[str, Any] = {
        **{name: getattr(data, name) for name in ("q", "qd", "qdd", "tau", "time", "segment")},
        "trained": model.trained.astype(np.int8),
        "index": model.index,
        "seen": model.seen,
        "weights": model.weights,
        "coefficients": model.coefficients,
        "unit": model.unit,
        "noise": model.prior.noise,
        "noise_share": model.prior.scaling.noise,
        **dict(zip(MORE, (more.q, more.qd, more.qdd), strict=True)),
    }
    if data.temperature is not None:
        arrays[TEMPERATURE] = data.temperature
    if model.irls_weight is not None:
        arrays[TRUST] = model.irls_weight
    text = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    try:
        with whole(path) as made:
            with made.open("wb") as file:
                np.savez_compressed(file, header=text, **arrays)
            _require_sound(model, made)
    except OSError as error:
        raise ModelError(f"cannot write the model to {path}: {error.strerror}") from error


def _require_sound(model: TorqueModel, path: Path) -> None:
    """Require that a model's file reads back, and predicts finite torques as the model does."""
    mechanism = model.kernel.mechanism
    try:
        held = load(type(model), path, mechanism if isinstance(mechanism, Linkage) else None)
    except ModelError as error:
        raise ModelError(
            f"the model is not sound, and was not saved: it does not read back: {error}"
        ) from error
    data = model.data
    some = np.linspace(0, len(data) - 1, min(len(data), PROBES)).astype(np.int64)
    state = data.q[some], data.qd[some], data.qdd[some]
    expected, found = model.predict(*state), held.predict(*state)
    if not np.isfinite(expected).all():
        worst = model.joints[int(np.argmin(np.isfinite(expected).all(axis=0)))]
        raise ModelError(
            f"the model is not sound, and was not saved: its torque of {worst} is not finite on "
            "the motion that it was learned from; look for wild efforts with `lagrangian_ff info`"
        )
    if not np.allclose(found, expected, rtol=1e-6, atol=1e-9 * np.abs(expected).max(initial=0.0)):
        raise ModelError("the model was not saved: read back, it predicts other torques")


def load(kind: type[Loaded], path: Path, linkage: Linkage | None = None) -> Loaded:
    """Read a model of some kind; see `Model.load`."""
    header, arrays = _read(path)
    if header.get("format") != FORMAT:
        raise ModelError(f"{path} is not a model of lagrangian_ff")
    version = header.get("version")
    if version == 1:
        raise ModelError(
            f"{path} is a model of version 1, which did not keep its data: identify it again"
        )
    if not isinstance(version, int) or version > VERSION:
        raise ModelError(
            f"{path} is a model of version {version}, this program reads up to {VERSION}: "
            "update lagrangian_ff, or identify the model again"
        )
    try:
        model = _build(kind, header, arrays, path, linkage)
        _require_usable(model)
    except ModelError as error:
        raise error if str(path) in str(error) else ModelError(f"{path}: {error}") from error
    except (*DAMAGED, UserError) as error:
        what = f"no {error}" if isinstance(error, KeyError) else str(error)
        raise ModelError(f"{path} is damaged: {what}; identify the model again") from error
    return model


def _read(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return header and arrays of a file, both empty for a file that is no model."""
    try:
        arrays = read_archive(path, HELD, ModelError, "a model of lagrangian_ff").arrays
        header = json.loads(bytes(arrays.pop("header")).decode()) if "header" in arrays else None
        json.dumps(header, ensure_ascii=False).encode()  # half a character could not be printed
    except FileNotFoundError as error:
        raise ModelError(f"no model file {path}") from error
    except (OSError, ValueError, TypeError, RecursionError) as error:
        raise ModelError(f"{path} is damaged or no model file: {error}") from error
    return (header, arrays) if isinstance(header, dict) else ({}, {})


def _build(
    kind: type[Loaded],
    header: dict[str, Any],
    arrays: dict[str, Any],
    path: Path,
    linkage: Linkage | None,
) -> Loaded:
    joints = tuple(str(name) for name in header["joints"])
    if header["version"] == 2:  # made exactly, of samples alone
        none = np.empty((0, len(joints)))
        arrays = {**arrays, "seen": arrays["index"], **dict.fromkeys(MORE, none)}
    for name, dimensions in ARRAYS.items():
        found = arrays[name]
        if found.ndim != dimensions or found.dtype.kind not in "fi":
            raise ValueError(f"array {name} has shape {found.shape} and type {found.dtype}")
        if not np.isfinite(found).all():
            raise ValueError(f"array {name} holds values that are not finite")
        if name in ("qd", "qdd", "tau") and found.shape != arrays["q"].shape:
            raise ValueError(f"array {name} has shape {found.shape}, not {arrays['q'].shape}")
        if name in ("time", "segment", "trained") and len(found) != len(arrays["q"]):
            raise ValueError(f"array {name} has {len(found)} entries, not {len(arrays['q'])}")
        if name in ("unit", "noise", "noise_share") and found.shape != (len(joints),):
            raise ValueError(f"array {name} has shape {found.shape} for {len(joints)} joints")
        if name in ("unit", "noise", "noise_share") and not _positive(found).all():
            raise ValueError(f"array {name} holds {found.tolist()}, expected above 0")
        if name in ("weights", "coefficients") and not (np.abs(found) <= MOST).all():
            raise ValueError(f"array {name} holds values beyond {MOST:g}")
    index, seen = (arrays[name].astype(np.int64) for name in ("index", "seen"))
    more = [arrays[name] for name in MORE]
    if len({one.shape for one in more}) != 1:
        raise ValueError(f"arrays {', '.join(MORE)} have shapes {[one.shape for one in more]}")
    centred = len(index) + len(more[0])
    if arrays["q"].shape[1] != len(joints) or arrays["weights"].shape != (centred, len(joints)):
        raise ValueError(f"arrays of {arrays['q'].shape[1]} joints for {len(joints)} names")
    data = Motion(
        joints=joints,
        **{name: arrays[name] for name in ("time", "q", "qd", "qdd", "tau")},
        segment=arrays["segment"].astype(np.int64),
        source=str(header["source"]),
        notes=tuple(header["notes"]),
        conditioning=dict(header["conditioning"]),
        temperature=arrays.get(TEMPERATURE),
    )
    for chosen in (index, seen):
        if len(chosen) and not (chosen.min() >= 0 and chosen.max() < len(data)):
            raise ValueError("samples that it was made from lie outside the data")
    sampled = data.q[index], data.qd[index], data.qdd[index]
    centres = States.of(*(np.vstack(both) for both in zip(sampled, more, strict=True)))
    weight = arrays.get(TRUST)
    if weight is not None:
        _require_weight(weight, (len(seen), len(joints)))
    basis = Basis(
        tuple(
            Term(_effect(entry, joints, path), int(entry["joint"]), dict(entry["shape"]))
            for entry in header["basis"]
        )
    )
    if header["version"] < SHARING and any(term.others for term in basis.terms):
        raise ModelError(
            f"{path} is of version {header['version']}, in which an effect of a shared shaft acted "
            "on one joint alone: identify the model again"
        )
    if any(not 0 <= term.joint < len(joints) for term in basis.terms):
        raise ValueError("an effect acts on a joint that is not there")
    if arrays["coefficients"].shape != (basis.size,):
        raise ValueError(f"{arrays['coefficients'].shape} coefficients for {basis.size} columns")
    return kind(
        joints=joints,
        name=str(header["name"]),
        prior=Prior(
            _kernel(header, _family(header, path, linkage), centres),
            arrays["noise"],
            Scaling(arrays["unit"], arrays["noise_share"]),
            basis,
        ),
        centres=centres,
        weights=arrays["weights"],
        coefficients=arrays["coefficients"],
        range=MotionRange.from_record(header["range"]),
        record=header["record"],
        data=data,
        trained=arrays["trained"].astype(bool),
        index=index,
        seen=seen,
        steps=tuple(header["steps"]),
        irls_weight=weight,
    )


def _require_usable(model: TorqueModel) -> None:
    """Refuse a model that could not be used: what it says of itself is read, and it predicts."""
    Identified.from_record(model.record)
    for step in model.steps:
        Step.from_record(step)
    data = model.data
    if not len(model.seen):
        raise ValueError("it was learned from no samples")
    if len(data) > 1 and (np.diff(data.segment) < 0).any():
        raise ValueError("the segments of its data are not in order")
    for name in ("q", "qd", "qdd", "tau"):
        if np.abs(getattr(data, name)).max() > budget.LARGEST:
            raise ValueError(f"array {name} holds values beyond {budget.LARGEST:g}")
    first = data.take(model.seen[:1])
    with np.errstate(all="ignore"):
        torque = model.torque(model.inputs_of(first))
    if not np.isfinite(torque).all():
        raise ValueError("its torques are not finite")


def _family(header: dict[str, Any], path: Path, given: Linkage | None) -> Family:
    # Effects at joints come last in a model's name, and a joint's own may hold a +.
    without_joints, at, _ = header["name"].partition("@")
    basic = without_joints.rpartition("+")[0] if at else without_joints
    formulas = {entry["effect"] for entry in header["basis"] if FORMULA in entry}
    known = "+".join(part for part in basic.split("+") if part not in formulas)
    family, held = parse(known or "none").kernel, header.get("mechanism")
    if held is None:
        return family
    if held["kind"] == ROBOT:
        return Robot.from_stored(held).around(family)
    if held["kind"] != LINKAGE:
        raise ValueError(f"the mechanism is of unknown kind {held['kind']}")
    if given is None:
        raise ModelError(
            f"{path} is a model of the linkage {held['name']}, whose code is not in the file: read "
            "it in Python, with Model.load(path, linkage=...)"
        )
    return given.of_joints(tuple(header["joints"]), str(path)).around(family)


def _kernel(header: dict[str, Any], family: Family, centres: States) -> Kernel:
    """Return the kernel with the hyperparameters in the file."""
    start = family.start(centres)
    values = {k: np.array(v, dtype=np.float64) for k, v in header["hyperparameters"].items()}
    searched = {h.name for h in start.searched}
    for name, value in values.items():
        usual = np.shape(start.hyperparameters[name])
        if value.shape not in (usual, (1,), (centres.joints,)):
            raise ValueError(f"hyperparameter {name} has shape {value.shape}, expected {usual}")
        # What is not searched may be 0, as the mark of a joint that turns; so may gravity.
        least = 1.0 / MOST if name in searched and name != GRAVITY else 0.0
        if not ((value <= MOST) & (value >= least)).all():
            raise ValueError(f"hyperparameter {name} is {value.tolist()}, out of range")
    return start.replace(**values)


def _positive(values: Floats) -> Flags:
    """Return where values are above 0, and neither so small nor so large that squares overflow."""
    return np.asarray((values >= 1.0 / MOST) & (values <= MOST))


def _require_weight(weight: Floats, shape: tuple[int, ...]) -> None:
    if weight.shape != shape or weight.dtype.kind != "f":
        raise ValueError(f"array {TRUST} has shape {weight.shape} and type {weight.dtype}")
    if not ((weight > 0.0) & (weight <= 1.0)).all():
        raise ValueError(f"array {TRUST} holds values outside 0 to 1")


def _term_record(term: Term) -> dict[str, Any]:
    record = {"effect": term.effect.name, "joint": term.joint, "shape": dict(term.shape)}
    if isinstance(term.effect, Curve):
        return record | {CURVE: term.effect.stored()}
    return record | ({FORMULA: term.effect.stored()} if isinstance(term.effect, Formula) else {})


def _effect(entry: dict[str, Any], joints: tuple[str, ...], path: Path) -> Effect:
    name = entry["effect"]
    if CURVE in entry:
        return from_stored(entry[CURVE], joints)
    if FORMULA in entry:
        found = formula_of(entry[FORMULA])
        check(found)
        return found
    if name not in EFFECTS:
        raise ModelError(
            f"{path} has the effect '{name}', which is not in the catalogue; if it is one of "
            "your own, name its file with --effects-file"
        )
    return EFFECTS[name]
