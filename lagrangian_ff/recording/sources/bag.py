"""rosbag2: a directory, or one of its files, sqlite3 or MCAP, compressed or not, whole or cut off.

Files are read with the library `rosbags`; what it refuses (a recording that was killed, a file
cut off) is read record by record up to the damage.
"""

import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import zstandard

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.progress import Progress, part
from lagrangian_ff.recording.joint_state import MESSAGE_TYPE, JointStateTable
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.recording.sources import temperature
from lagrangian_ff.recording.sources.sqlite_salvage import SqliteSalvage, shortfall
from lagrangian_ff.words import counted

if TYPE_CHECKING:
    from rosbags.rosbag2 import Reader

    from lagrangian_ff.recording.sources.mcap_salvage import McapSalvage

NAME = "a rosbag2 directory, .db3 or .mcap (also .zstd)"
_SUFFIXES = (".db3", ".mcap")
_DATA = (*_SUFFIXES, ".zstd")
_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
_EPOCH_NS = 10**17  # stamps above are dates (1973 and later), not seconds since start-up


class UnreadableError(Exception):
    """`rosbags` cannot read the file, or not to its end; the text says why."""


class IntactFile:
    """A sqlite3 or MCAP file without damage.

    Raises:
        UnreadableError: also while messages are read.
    """

    damage = ""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.topics: dict[str, tuple[str, int]] = {}
        if path.suffix == ".db3" and (damage := shortfall(path)):
            raise UnreadableError(damage)
        with _opened(path) as reader:
            for one in reader.connections:
                _, before = self.topics.get(one.topic, ("", 0))
                self.topics[one.topic] = (one.msgtype, before + one.msgcount)

    def messages(self, topic: str) -> Iterator[tuple[int, bytes]]:
        """Yield the time received in ns and the serialized message, in order of arrival."""
        with _opened(self._path) as reader:
            connections = [c for c in reader.connections if c.topic == topic]
            if not connections:
                return
            for _, received, data in reader.messages(connections):
                if not isinstance(received, int):  # sqlite does not check types
                    raise UnreadableError(f"a message was received at {received!r}")
                yield received, bytes(data)


@contextmanager
def _opened(path: Path) -> "Iterator[Reader]":
    from rosbags.rosbag2 import Reader  # slow to import, and only bags need it

    # On damaged input the library raises struct, index, type, database and compression errors
    # as well as its own.
    try:
        with Reader(path) as reader:
            yield reader
    except Exception as error:
        raise UnreadableError(str(error) or type(error).__name__) from error


StorageFile: TypeAlias = "IntactFile | McapSalvage | SqliteSalvage"
"""One file of a bag: its topics (message type and number of messages, 0 if unknown), its damage
in words, complete only after `messages` has ended, and the messages of one topic."""


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


def read(path: Path, topic: str | None, progress: Progress) -> Recording:
    """Return the joint states of one topic."""
    notes: list[str] = []
    paths = _files(path, notes)
    with ExitStack() as stack:
        workplace = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="bag-")))
        local = [_prepare(file, workplace, notes) for file in paths]
        topics = _topics(local, paths)
        chosen = _choose_topic(path, topics, topic, notes)
        table = JointStateTable()
        for index, (file, original) in enumerate(zip(local, paths, strict=True)):
            report = part(progress, index / len(local), (index + 1) / len(local))
            _read_file(file, original, chosen, table, notes, report)
        recording = _as_recording(f"{path} ({chosen})", table, notes)
        warm = [name for name, kind in topics.items() if _is_kind(kind, temperature.MESSAGE_TYPE)]
        if not warm:
            return recording
        pairs = zip(local, paths, strict=True)
        messages = (one for pair in pairs for name in warm for one in _messages(*pair, name))
        return temperature.with_temperatures(recording, messages)


def _messages(path: Path, name: Path, topic: str) -> Iterator[tuple[str, int, bytes]]:
    """Yield topic, time received in ns and message of one file, what can be read of it."""
    try:
        found = list(IntactFile(path).messages(topic))
    except UnreadableError:
        found = list(_salvage(path, name).messages(topic))
    unpack = zstandard.ZstdDecompressor()
    for received, data in found:
        yield topic, received, _unpacked(unpack, data)


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
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        content = YAML(typ="safe").load(metadata.read_text(encoding="utf-8", errors="replace"))
        names = content["rosbag2_bagfile_information"]["relative_file_paths"]
        return [Path(str(name)).name for name in names]
    except (YAMLError, KeyError, TypeError):
        return []


def _prepare(path: Path, workplace: Path, notes: list[str]) -> Path:
    """Return a file that can be opened: decompressed, its write-ahead log merged."""
    sidecars = [
        log
        for end in ("-wal", "-journal")
        if (log := path.with_name(path.name + end)).exists() and log.stat().st_size
    ]
    if path.suffix == ".zstd":
        target = workplace / path.name.removesuffix(".zstd")
        if not _decompress(path, target):
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


def _decompress(path: Path, target: Path) -> bool:
    """Unpack up to the damage; return whether that is the end."""
    frame = zstandard.ZstdDecompressor().decompressobj()
    begun = False
    with path.open("rb") as packed, target.open("wb") as unpacked:
        while part := packed.read(1 << 20):
            while part:
                begun = True
                try:
                    unpacked.write(frame.decompress(part))
                except zstandard.ZstdError:
                    return False
                part = frame.unused_data if frame.eof else b""
                if frame.eof:
                    frame = zstandard.ZstdDecompressor().decompressobj()
                    begun = False
    return not begun


def _salvage(path: Path, name: Path) -> StorageFile:
    if _kind(path) != ".mcap":
        return SqliteSalvage(path, name)
    # The library `mcap` is slow to import, and only damaged files need it.
    from lagrangian_ff.recording.sources.mcap_salvage import McapSalvage

    return McapSalvage(path, name)


def _topics(paths: list[Path], names: list[Path]) -> dict[str, str]:
    """Return the type of every topic that has messages, or of all if none has."""
    types: dict[str, str] = {}
    empty: dict[str, str] = {}
    for path, original in zip(paths, names, strict=True):
        try:
            topics = IntactFile(path).topics
        except UnreadableError:
            topics = _salvage(path, original).topics
        for name, (kind, count) in topics.items():
            (types if count else empty)[name] = kind
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
        raise RecordingError(f"{path}: no topic {wanted}; {_listed(topics, joint_states)}")
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
    if not topics:
        return "it holds no topics"
    found = ", ".join(f"{name} [{kind}]" for name, kind in topics.items())
    return f"expected a topic of type {MESSAGE_TYPE}, found {found}"


def _read_file(
    path: Path, name: Path, topic: str, table: JointStateTable, notes: list[str], progress: Progress
) -> None:
    """Add the messages of the file at `path`, which the user knows by this name.

    A file that breaks half-way is read again by salvage.
    """
    mark = table.mark()
    before = len(table)
    try:
        _append(IntactFile(path), name, topic, table, progress)
        return
    except UnreadableError as error:
        reason = str(error)
    table.rewind(mark)
    salvaged = _salvage(path, name)
    _append(salvaged, name, topic, table, progress)
    damage = salvaged.damage
    what = f"cut off or damaged ({damage})" if damage else f"read record by record ({reason})"
    notes.append(f"{name}: {what}; {counted(len(table) - before, 'message')} could be read")


def _append(
    file: StorageFile, name: Path, topic: str, table: JointStateTable, progress: Progress
) -> None:
    _, expected = file.topics.get(topic, ("", 0))
    unpack = zstandard.ZstdDecompressor()
    for number, (received, data) in enumerate(file.messages(topic)):
        table.add(received, _unpacked(unpack, data))
        if number % 8192 == 0:
            progress(min(1.0, number / expected) if expected else 0.0, f"read {name.name}")


def _unpacked(unpack: zstandard.ZstdDecompressor, data: bytes) -> bytes:
    """Return a message without its compression; nothing if that is damaged."""
    if data[:4] != _ZSTD_MAGIC:
        return data
    try:
        return unpack.decompress(data)
    except zstandard.ZstdError:
        return b""


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
