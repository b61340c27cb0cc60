"""The recordings of a measured arm, read as its file of what is known says."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import RecordingError, UserError
from lagrangian_ff.recording import condition_alike, load
from lagrangian_ff.recording.motion import Conditioning, Motion
from lagrangian_ff.recording.recording import Recording, from_arrays
from lagrangian_ff.studies.measured.known import Column, Known, Part, Source

MATLAB = ".mat"
APART = 0.5
"""s; pulses that follow each other closer are one contact."""
Table = Mapping[Column, Floats]
"""Columns or tables (samples, columns) by name and, in text, by number."""


def motions(known: Known, parts: Sequence[Part], like: Motion | None = None) -> list[Motion]:
    """Return the motion of each part, conditioned as for any user.

    Args:
        known, parts: of the arm.
        like: what a model was learned from, and what other recordings are conditioned like; None
            conditions these together.

    Raises:
        UserError: a file is missing, or lacks a column; names both.
    """
    cut = [_cut(read(known, known.sources[one.recording]), one) for one in parts]
    return condition_alike(cut, Conditioning.from_record(like.conditioning) if like else None)


def read(known: Known, source: Source) -> Recording:
    """Return a whole recording.

    Raises:
        UserError: a file is missing or not as its layout says, or lacks a column; names both.
    """
    for path in source.files.values():
        if not path.exists():
            raise UserError(f"{path}: no such file, which {known.name} names as {source.name}")
    layout = source.layout
    if layout.columns is None and "" in source.files:
        held = load(source.files[""], joints=known.joints)
        time, tables = held.time, [held.position, held.velocity, held.effort]
    else:
        time, tables = _read_columns(known, source)
    first, last = source.samples
    time, (position, velocity, effort) = time[first:last], [one[first:last] for one in tables]
    if layout.degrees:
        position, velocity = np.radians(position), np.radians(velocity)
    if layout.effort_scale:
        effort = effort * np.array(layout.effort_scale)
    path = next(iter(source.files.values()))
    return from_arrays(path, list(known.joints), time, (position, velocity, effort))


def contacts(known: Known, source: Source) -> list[tuple[float, float]]:
    """Return from when to when torque was injected, s in the time of the recording."""
    columns, above = known.contact
    if not columns:
        return []
    table = _table(source.files[""], source.layout.variable)
    time = _columns(table, (source.layout.columns or {}).get("time", ("time",)), 1, source)[:, 0]
    injected = np.abs(_columns(table, columns, len(columns), source)).max(axis=1)
    inside = time[injected > above]
    if not len(inside):
        return []
    pieces = np.split(inside, np.flatnonzero(np.diff(inside) > APART) + 1)
    return [(float(one[0]), float(one[-1])) for one in pieces]


def _cut(recording: Recording, part: Part) -> Recording:
    """Return the samples in the shares of time."""
    if part.share == (0.0, 1.0):
        return recording
    begin, end = recording.time.min(), recording.time.max()
    first, last = (begin + share * (end - begin) for share in part.share)
    kept = (recording.time >= first) & (recording.time <= last)
    position, velocity, effort = (
        table[kept] for table in (recording.position, recording.velocity, recording.effort)
    )
    name = f"{recording.source} from {first - begin:.1f} to {last - begin:.1f} s"
    return Recording(
        recording.joints,
        recording.time[kept],
        position,
        velocity,
        effort,
        recording.start,
        name,
        recording.notes,
    )


def _read_columns(known: Known, source: Source) -> tuple[Floats, list[Floats]]:
    joints, layout = len(known.joints), source.layout
    wanted = layout.columns or {}
    tables = {path: _table(path, layout.variable) for path in set(source.files.values())}

    def quantity(name: str, width: int) -> Floats:
        path = source.files.get(name) or source.files.get("")
        if path is None or (name not in wanted and "" in source.files):
            if name == "velocity":
                return np.full((1, width), np.nan)
            raise UserError(f"{known.name}: nothing says where the {name} of {source.name} stands")
        columns = wanted.get(name) or tuple(key for key in tables[path] if isinstance(key, int))
        return _columns(tables[path], columns, width, source)

    time = quantity("time", 1)[:, 0]
    found = [quantity(name, joints) for name in ("position", "velocity", "effort")]
    if layout.effort_minus:
        found[2] = found[2] - _columns(
            tables[source.files[""]], layout.effort_minus, joints, source
        )
    lengths = [len(one) for one in found if len(one) > 1]
    if any(length != len(time) for length in lengths):
        raise UserError(f"{source.name} of {known.name}: {len(time)} times, but {lengths} samples")
    return time, [np.broadcast_to(one, (len(time), joints)) for one in found]


def _columns(table: Table, names: Sequence[Column], width: int, source: Source) -> Floats:
    """Return (samples, width) the columns of these names, or the one table that is so wide."""
    missing = [str(name) for name in names if name not in table]
    if missing:
        held = ", ".join(map(str, table))
        path = next(iter(source.files.values()))
        raise UserError(f"{path}: no column {', '.join(missing)}; it holds {held}")
    found = np.column_stack([table[name] for name in names])
    if found.shape[1] == 1 and width > 1 and len(found) % width == 0:
        found = found.reshape(-1, width)  # a number a line, joint after joint
    if found.shape[1] != width and found.shape[0] == width:
        found = found.T  # MATLAB's rows are joints
    if found.shape[1] != width:
        where = ", ".join(map(str, names))
        raise UserError(f"{source.name}: {where} has {found.shape[1]} columns, expected {width}")
    return np.asarray(found, dtype=np.float64)


def _table(path: Path, variable: str) -> Table:
    """Return the columns of a file of text, or the arrays of a MATLAB or NumPy file."""
    try:
        if path.suffix.lower() == MATLAB:
            return _matlab(path, variable)
        if path.suffix.lower() == ".npz":
            with np.load(path, allow_pickle=False) as archive:
                return {name: archive[name] for name in archive}
        return _text(path)
    except (OSError, ValueError, KeyError, UnicodeDecodeError) as error:
        raise RecordingError(f"{path}: cannot be read as a table: {error}") from error


def _matlab(path: Path, variable: str) -> Table:
    from scipy.io import loadmat

    held = loadmat(path, squeeze_me=True)
    if variable:
        struct = held[variable]
        return {name: np.asarray(struct[name].item()) for name in struct.dtype.names}
    return {name: values for name, values in held.items() if not name.startswith("__")}


def _text(path: Path) -> Table:
    """Return columns by number and, if there is a header, by name."""
    with path.open(encoding="utf-8") as file:
        head = file.readline().strip()
    comma = "," if "," in head else None
    words = [word.strip() for word in head.split(comma)]
    try:
        [float(word) for word in words]
        names: list[str] = []
    except ValueError:
        names = words
    values = np.loadtxt(path, delimiter=comma, skiprows=1 if names else 0, ndmin=2)
    found: dict[Column, Floats] = dict(enumerate(values.T))
    return {**found, **dict(zip(names, values.T, strict=False))}
