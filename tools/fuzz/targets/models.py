"""Model files: exact, on inducing points, and with an effect that was added."""

import io
import json
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from fuzz.target import Target, swinging
from fuzz.targets.tables import NPZ_TOKENS
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Model, Settings, extend, identify
from lagrangian_ff.identification.history import History
from lagrangian_ff.recording import condition

TOKENS = (
    *NPZ_TOKENS,
    b'"hyperparameters"',
    b'"record"',
    b'"steps"',
    b'"joints"',
    b'"basis"',
    b'"range"',
    b'"uncertainty"',
    b'"quick"',
    b'"conditioning"',
    b'"mechanism"',
    b'"version"',
    b"NaN",
    b"Infinity",
)

NEWER = "which this version does not know"
"""What is said, when it is used, of a file that a newer version wrote."""
_NUMBERS = (0, 1, -1, 0.5, 7, 1e9, 1e-320, 1e100, -1e100, 1e308, float("nan"), float("inf"))
_VALUES: tuple[Any, ...] = (
    *_NUMBERS,
    None,
    True,
    "",
    "joint_1",
    "x",
    [],
    {},
    [[]],
    10**400,
    "total",
    "stribeck",
    -5,
    10**12,
)


def _seeds(folder: Path) -> None:
    motion = condition(swinging(1200, 2))
    settings = Settings("vrbfs+fri", samples=25, evaluations=3, train=1.0, block_seconds=0.5)
    model = identify(motion, settings).model
    model.save(folder / "exact.npz")
    extend(model, EFFECTS["stribeck"], "joint_1").model.save(folder / "added.npz")


def _deeper(data: bytes, random: Random) -> bytes:
    """Return a model with one entry of its JSON, or one number of an array, replaced."""
    with np.load(io.BytesIO(data)) as file:
        arrays: dict[str, Any] = {name: file[name] for name in file.files}
    if random.random() < 0.25:
        name = random.choice(sorted(set(arrays) - {"header"}))
        array = arrays[name]
        if array.size:
            whole = array.dtype.kind == "i"
            number = random.randrange(-2, 120) if whole else random.choice(_NUMBERS)
            array.flat[random.randrange(array.size)] = number
        if random.random() < 0.2:
            arrays[name] = random.choice((array[:-1], array[:0], array.T, array[:, None]))
    else:
        header = json.loads(arrays["header"].tobytes())
        _replace(header, random)
        arrays["header"] = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    out = io.BytesIO()
    np.savez(out, **arrays)
    return out.getvalue()


def _replace(node: Any, random: Random) -> None:
    """Replace, remove or add one entry, anywhere below a node."""
    keys: list[Any] = list(node) if isinstance(node, dict) else list(range(len(node)))
    if not keys:
        return
    key = random.choice(keys)
    if isinstance(node[key], dict | list) and node[key] and random.random() < 0.8:
        _replace(node[key], random)
    elif random.random() < 0.15:
        del node[key]
    elif isinstance(node, dict) and random.random() < 0.1:
        node[random.choice(("joint_9", "", "x"))] = node[key]
    else:
        other = node[random.choice(keys)]
        node[key] = random.choice((*_VALUES, other, [other], [other] * 3, {"joint_1": other}))


def _read(path: Path) -> None:
    """Read a model, tell its history and predict, with intervals."""
    model = Model.load(path)
    try:
        History(path.name, model.name, model.history).record()
        model.identified.record()
        some = model.data.take(model.seen[:3])
        model.predict(some.q, some.qd, some.qdd)
        model.quick_uncertainty.interval(some.q, some.qd, some.qdd)
    except UserError as error:
        if NEWER not in str(error):
            raise AssertionError("it could be read and not be used") from error


MODEL = Target("model", _seeds, _read, TOKENS, archive=True, deeper=_deeper)
