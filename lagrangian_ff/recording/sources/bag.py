"""rosbag2: a directory, or one of its files, sqlite3 or MCAP, compressed or not, whole or cut off.

What SQLite refuses (a recording that was killed, a file cut off) is read page by page.
"""

import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import TypeAlias

import numpy as np

from lagrangian_ff import budget
from lagrangian_ff.errors import RecordingError, TopicError
from lagrangian_ff.progress import Progress, part
from lagrangian_ff.recording.joint_state import MESSAGE_TYPE, JointStateTable
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.recording.sources import rosbag2, temperature
from lagrangian_ff.recording.sources.mcap_file import McapFile
from lagrangian_ff.recording.sources.packing import Allowance, MissingLibraryError, unpack_file
from lagrangian_ff.recording.sources.rosbag2 import Rosbag2
from lagrangian_ff.recording.sources.sqlite_file import SqliteFile, UnreadableError
from lagrangian_ff.recording.sources.sqlite_salvage import SqliteSalvage
from lagrangian_ff.words import counted

NAME = "a rosbag2 directory, .db3 or .mcap (also .zstd)"
_SUFFIXES = (".db3", ".mcap")
_DATA = (*_SUFFIXES, ".zstd")
_LONGEST = 4096  # bytes of a message with a temperature
_LIST = "relative_file_paths:"
_EPOCH_NS = 10**17  # stamps above are dates (1973 and later), not seconds since start-up


StorageFile: TypeAlias = "McapFile | SqliteFile | SqliteSalvage | Rosbag2"
"""One file of a bag, or all of it as ROS reads it: its topics (message type and number of
messages, 0 if unknown), its damage in words, complete only after `messages` has ended, and the
messages of one topic."""


def recognises(path: Path) -> bool:
    """Return whether it is a directory, or named as rosbag2 names files."""
    return path.is_dir() or _kind(path) is not None


def is_bag(path: Path) -> bool:
    """Return whether a folder holds only a bag's files, so that it may be replaced."""
    return all(
        file.name.startswith("metadata.yaml") or file.suffix in _DATA for file in path.iterdir()
    )


def _kind(path: Path) -> str | None:
    name = path.name.removesuffix(".zstd")
    return next((suffix for suffix in _SUFFIXES if name.endswith(suffix)), None)


@dataclass(frozen=True)
class _Source:
    """A file at `path`, which the user knows by its `name`; or a bag that rosbag2 reads."""

    path: Path
    name: Path
    by_rosbag2: bool = False

    def opened(self) -> StorageFile:
        """Return what reads it.

        Raises:
            UnreadableError: SQLite cannot read it, or not to its end; also while messages are read.
        """
        if self.by_rosbag2:
            return Rosbag2(self.path)
        return (
            McapFile(self.path, self.name) if _kind(self.path) == ".mcap" else SqliteFile(self.path)
        )

    def salvaged(self) -> StorageFile:
        """Return what reads it page by page."""
        return SqliteSalvage(self.path, self.name)


def read(path: Path, topic: str | None, progress: Progress) -> Recording:
    """Return the joint states of one topic."""
    notes: list[str] = []
    try:
        with tempfile.TemporaryDirectory(prefix="bag-") as workplace:
            paths = _files(path, notes)
            sources = [_Source(_prepare(file, Path(workplace), notes), file) for file in paths]
            return _read(path, sources, topic, notes, progress)
    except MissingLibraryError as missing:
        if not rosbag2.is_installed():
            raise RecordingError(
                f"{path}: {missing}; nor is ROS' own reader ({rosbag2.INSTALL})"
            ) from missing
    return _read(path, [_Source(path, path, by_rosbag2=True)], topic, [], progress)


def _read(
    path: Path, sources: list[_Source], topic: str | None, notes: list[str], progress: Progress
) -> Recording:
    topics = _topics(path, sources)
    chosen = _choose_topic(path, topics, topic, notes)
    table = JointStateTable(str(path))
    for index, source in enumerate(sources):
        report = part(progress, index / len(sources), (index + 1) / len(sources))
        _read_file(source, chosen, table, notes, report)
    recording = _as_recording(f"{path} ({chosen})", table, notes)
    warm = [name for name, kind in topics.items() if _is_kind(kind, temperature.MESSAGE_TYPE)]
    if not warm:
        return recording
    messages = (one for source in sources for name in warm for one in _messages(source, name))
    return temperature.with_temperatures(recording, messages)


def _messages(source: _Source, topic: str) -> Iterator[tuple[str, int, bytes]]:
    """Yield topic, time received in ns and message of one file, what can be read of it."""
    allowance = Allowance(source.name)

    def read(file: StorageFile) -> list[tuple[str, int, bytes]]:
        # What is longer than any temperature is cut, and so malformed.
        found = ((received, allowance.unpacked(data)) for received, data in file.messages(topic))
        return [(topic, received, data[:_LONGEST]) for received, data in found]

    try:
        found = read(source.opened())
    except UnreadableError:
        found = read(source.salvaged())
    yield from found


def _files(path: Path, notes: list[str]) -> list[Path]:
    """Return the files of the bag in the order they were recorded."""
    if path.is_file():
        return [path]
    files = [file for file in path.iterdir() if file.is_file() and _kind(file)]
    # A compressor that was killed leaves the whole file beside the part it has compressed.
    halves = {f"{file.name}.zstd" for file in files}
    found = [file for file in files if file.name not in halves]
    if not found:
        raise RecordingError(f"{path}: not a bag; it holds no .db3 or .mcap file")
    metadata = path / "metadata.yaml"
    if not metadata.exists():
        notes.append(f"{path}: metadata.yaml is missing (recording interrupted?); read without it")
    else:
        stems = {file.name.removesuffix(".zstd") for file in found}
        for name in _promised(metadata):
            if name.removesuffix(".zstd") not in stems:
                notes.append(f"{path}: metadata.yaml names {name}, which is not there")
    return sorted(found, key=lambda file: [int(n) for n in re.findall(r"\d+", file.name)])


def _promised(metadata: Path) -> list[str]:
    """Return the names of the bag's files, which rosbag2 lists one a line.

    Nothing else is read of the file: a reader of all YAML would follow references and depth.
    """
    lines = budget.text_of(metadata, RecordingError, errors="replace").splitlines()
    listed = next((k for k, line in enumerate(lines) if line.strip() == _LIST), len(lines))
    items = takewhile(lambda line: line.startswith("-"), map(str.strip, lines[listed + 1 :]))
    return [Path(item[1:].strip().strip("'\"")).name for item in items]


def _prepare(path: Path, workplace: Path, notes: list[str]) -> Path:
    """Return a file that can be opened: decompressed, its write-ahead log merged."""
    sidecars = [
        log
        for end in ("-wal", "-journal")
        if (log := path.with_name(path.name + end)).exists() and log.stat().st_size
    ]
    if path.suffix == ".zstd":
        target = workplace / path.name.removesuffix(".zstd")
        if not unpack_file(path, target):
            notes.append(f"{path}: its compression ends early; what could be unpacked is used")
        return target
    if sidecars:
        target = workplace / path.name
        shutil.copy(path, target)
        for log in sidecars:
            shutil.copy(log, workplace / log.name)
        notes.append(f"{path}: the recorder left an open transaction; recovered from its log")
        SqliteSalvage.settle(target)
        return target
    return path


def _topics(bag: Path, sources: list[_Source]) -> dict[str, str]:
    """Return the type of every topic that has messages, or of all if none has.

    Raises:
        RecordingError: there is no topic at all.
    """
    types: dict[str, str] = {}
    empty: dict[str, str] = {}
    damage = ""
    for source in sources:
        try:
            file = source.opened()
            topics = file.topics
        except UnreadableError:
            file = source.salvaged()
            topics = file.topics
        damage = damage or file.damage
        for name, (kind, count) in topics.items():
            (types if count else empty)[name] = kind
    if not (types or empty):
        why = f" ({damage})" if damage else ""
        raise RecordingError(f"{bag}: no joint states; it holds no topics{why}")
    return types or empty


def _choose_topic(
    path: Path, topics: Mapping[str, str], wanted: str | None, notes: list[str]
) -> str:
    joint_states = [name for name, kind in topics.items() if _is_kind(kind, MESSAGE_TYPE)]
    if wanted is not None:
        names = [name for name in joint_states if name.lstrip("/") == wanted.lstrip("/")]
        if names:
            return names[0]
        if any(name.lstrip("/") == wanted.lstrip("/") for name in topics):
            raise RecordingError(f"{path}: topic {wanted} is not of type {MESSAGE_TYPE}")
        raise TopicError(f"{path}: no topic {wanted}; {_listed(topics, joint_states)}")
    if len(joint_states) == 1:
        return joint_states[0]
    preferred = [name for name in joint_states if name.split("/")[-1] == "joint_states"]
    if len(preferred) == 1:
        others = ", ".join(name for name in joint_states if name != preferred[0])
        notes.append(f"{path}: {preferred[0]} is read; it also holds joint states on {others}")
        return preferred[0]
    if not joint_states:
        raise RecordingError(f"{path}: no joint states; {_listed(topics, joint_states)}")
    raise RecordingError(
        f"{path}: joint states on several topics, name one of them: {', '.join(joint_states)}"
    )


def _is_kind(kind: str, expected: str) -> bool:
    """Return whether a message type is the expected one, written with or without /msg/."""
    return kind.replace("/msg/", "/") == expected.replace("/msg/", "/")


def _listed(topics: Mapping[str, str], joint_states: list[str]) -> str:
    if joint_states:
        return f"joint states are on {', '.join(joint_states)}"
    found = ", ".join(f"{name} [{kind}]" for name, kind in topics.items())
    return f"expected a topic of type {MESSAGE_TYPE}, found {found}"


def _read_file(
    source: _Source, topic: str, table: JointStateTable, notes: list[str], progress: Progress
) -> None:
    """Add the messages of one file; one that breaks half-way is read again by salvage."""
    mark = table.mark()
    before = len(table)
    reason = ""
    try:
        file = source.opened()
        _append(file, source.name, topic, table, progress)
    except UnreadableError as error:
        reason = str(error)
        table.rewind(mark)
        file = source.salvaged()
        _append(file, source.name, topic, table, progress)
    if not file.damage and not reason:
        return
    what = f"cut off or damaged ({file.damage})" if file.damage else f"read by pages ({reason})"
    notes.append(f"{source.name}: {what}; {counted(len(table) - before, 'message')} could be read")


def _append(
    file: StorageFile, name: Path, topic: str, table: JointStateTable, progress: Progress
) -> None:
    _, expected = file.topics.get(topic, ("", 0))
    allowance = Allowance(name)
    for number, (received, data) in enumerate(file.messages(topic)):
        table.add(received, allowance.unpacked(data))
        if number % 8192 == 0:
            progress(min(1.0, number / expected) if expected else 0.0, f"read {name.name}")


def _as_recording(source: str, table: JointStateTable, notes: list[str]) -> Recording:
    malformed = table.malformed
    joints, stamps, received, position, velocity, effort = table.finish()
    if malformed:
        lost = counted(malformed, "message")
        notes.append(f"{source}: left out {lost} without joints or malformed")
    if stamps.size == 0:
        raise RecordingError("; ".join([f"{source}: no joint state can be read", *notes]))
    unset = stamps == 0
    if unset.all() or (unset.any() and stamps[~unset].min() > _EPOCH_NS):
        notes.append(
            f"{source}: {int(unset.sum())} of {unset.size} messages have no header stamp; "
            "the time at which the recorder received them is used"
        )
        stamps = np.where(unset, received, stamps)
    time, start = (stamps - stamps[0]) / 1e9, float(stamps[0]) / 1e9
    return Recording(joints, time, position, velocity, effort, start, source, tuple(notes))
