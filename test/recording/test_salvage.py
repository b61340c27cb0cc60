"""Bags that were cut off: what is readable is used, and nothing that is wrong."""

import os
import shutil
import sqlite3
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer
from recording_examples import STORE, TYPE, assert_same, equal, foreign_bag, messages_of, swinging

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording import Recording, load, write_bag

WHOLE = swinging(1500)
KINDS = [
    ("mcap", "none"),
    ("mcap", "storage"),
    ("mcap", "message"),
    ("mcap", "file"),
    ("mcap", "ours"),
    ("mcap", "zstd_chunks"),
    ("mcap", "lz4_chunks"),
    ("sqlite3", "none"),
    ("sqlite3", "message"),
    ("sqlite3", "file"),
]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], Path]:
    """A whole file of each kind."""
    folder = tmp_path_factory.mktemp("whole")
    found = {}
    for storage, compression in KINDS:
        bag = folder / f"{storage}_{compression}"
        if compression == "ours":
            write_bag(bag, WHOLE)
        elif compression.endswith("_chunks"):
            chunked_bag(bag, CompressionType[compression.removesuffix("_chunks").upper()])
        else:
            foreign_bag(bag, messages_of(WHOLE), storage, compression)
        (file,) = (file for file in bag.iterdir() if file.name != "metadata.yaml")
        found[storage, compression] = file
    return found


def chunked_bag(path: Path, compression: CompressionType) -> None:
    """A file of the library `mcap`, in small compressed chunks as rosbag2 makes them."""
    path.mkdir()
    with (path / "bag.mcap").open("wb") as file:
        writer = Writer(file, chunk_size=20_000, compression=compression)
        writer.start(profile="ros2")
        definition, _ = STORE.generate_msgdef(TYPE, ros_version=2)
        schema = writer.register_schema(TYPE, "ros2msg", definition.encode())
        channel = writer.register_channel("/joint_states", "cdr", schema)
        for stamp, data in messages_of(WHOLE):
            writer.add_message(channel, stamp, data, stamp)
        writer.finish()


def name_of(storage: str, compression: str) -> str:
    suffix = ".mcap" if storage == "mcap" else ".db3"
    return f"cut{suffix}" + (".zstd" if compression == "file" else "")


def assert_prefix(found: Recording) -> None:
    part = slice(0, len(found))
    assert np.array_equal(found.time, WHOLE.time[part])
    for quantity in ("position", "velocity", "effort"):
        assert equal(getattr(found, quantity), getattr(WHOLE, quantity)[part])


@pytest.mark.parametrize("kind", KINDS, ids="-".join)
@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(share=st.floats(0, 1))
def test_a_file_cut_anywhere_gives_the_beginning_or_a_clear_error(
    files: dict[tuple[str, str], Path], tmp_path: Path, kind: tuple[str, str], share: float
) -> None:
    content = files[kind].read_bytes()
    cut = tmp_path / name_of(*kind)
    cut.write_bytes(content[: int(share * len(content))])
    try:
        found = load(cut)
    except RecordingError as error:
        assert str(cut) in str(error)  # noqa: PT017
        return
    assert_prefix(found)
    if len(found) < len(WHOLE):
        assert found.notes


@pytest.mark.parametrize("kind", [k for k in KINDS if k[1] != "file"], ids="-".join)
def test_half_a_file_gives_about_half_of_the_samples(
    files: dict[tuple[str, str], Path], tmp_path: Path, kind: tuple[str, str]
) -> None:
    content = files[kind].read_bytes()
    cut = tmp_path / name_of(*kind)
    cut.write_bytes(content[: len(content) // 2])
    found = load(cut)
    assert_prefix(found)
    assert len(found) > 0.4 * len(WHOLE)
    assert any("cut off or damaged" in note and str(cut) in note for note in found.notes)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(position=st.floats(0, 1, exclude_max=True), noise=st.binary(min_size=1, max_size=64))
def test_overwritten_bytes_never_raise_anything_else(
    files: dict[tuple[str, str], Path], tmp_path: Path, storage: str, position: float, noise: bytes
) -> None:
    content = bytearray(files[storage, "none"].read_bytes())
    at = int(position * len(content))
    content[at : at + len(noise)] = noise
    damaged = tmp_path / name_of(storage, "none")
    damaged.write_bytes(bytes(content))
    try:
        load(damaged)
    except RecordingError as error:
        assert str(damaged) in str(error)  # noqa: PT017


WRITER = """
import os, sqlite3, sys
target, journal, source = sys.argv[1:]
rows = sqlite3.connect(source).execute("SELECT * FROM messages ORDER BY id").fetchall()
shutil = __import__("shutil")
shutil.copy(source, target)
bag = sqlite3.connect(target, isolation_level=None)
bag.execute("DELETE FROM messages")
bag.execute("VACUUM")
bag.execute(f"PRAGMA journal_mode={journal}")
bag.execute("PRAGMA wal_autocheckpoint=0")
bag.execute("PRAGMA cache_size=10")
for first in (0, 500):
    bag.execute("BEGIN")
    bag.executemany("INSERT INTO messages VALUES (?,?,?,?)", rows[first : first + 500])
    if first == 0:
        bag.execute("COMMIT")
sys.stdout.flush()
os.kill(os.getpid(), 9)
"""


@pytest.mark.parametrize("journal", ["wal", "delete"])
def test_an_open_transaction_is_recovered_from_its_log(tmp_path: Path, journal: str) -> None:
    source = foreign_bag(tmp_path / "bag", messages_of(swinging(1000)), "sqlite3") / "bag.db3"
    target = tmp_path / "killed.db3"
    subprocess.run([sys.executable, "-c", WRITER, target, journal, source], check=False)
    log = target.with_name(target.name + ("-wal" if journal == "wal" else "-journal"))
    assert log.exists()
    before = {file.name: file.read_bytes() for file in (target, log)}
    found = load(target)
    assert_same(found, swinging(500))
    assert "recovered from its log" in found.notes[0]
    assert {file.name: file.read_bytes() for file in (target, log)} == before


def test_a_file_compressed_in_several_frames_is_read_to_the_end(
    files: dict[tuple[str, str], Path], tmp_path: Path
) -> None:
    content = files["mcap", "none"].read_bytes()
    half = len(content) // 2
    path = tmp_path / "bag.mcap.zstd"
    path.write_bytes(zstandard.compress(content[:half]) + zstandard.compress(content[half:]))
    found = load(path)
    assert_same(found, WHOLE)
    assert found.notes == ()


def test_large_messages_on_overflow_pages_are_salvaged(tmp_path: Path) -> None:
    joints = tuple(f"joint_{number:04d}" for number in range(300))
    expected = swinging(60, joints=joints)
    bag = foreign_bag(tmp_path / "bag", messages_of(expected), "sqlite3") / "bag.db3"
    content = bag.read_bytes()
    assert (
        sqlite3.connect(bag).execute("SELECT max(length(data)) FROM messages").fetchone()[0] > 8192
    )
    cut = tmp_path / "cut.db3"
    cut.write_bytes(content[: len(content) // 2])
    found = load(cut)
    assert 20 < len(found) < 60
    assert equal(found.effort, expected.effort[: len(found)])


def test_a_cut_file_in_a_split_bag_keeps_the_others(tmp_path: Path) -> None:
    messages = messages_of(WHOLE)
    bag = tmp_path / "bag"
    bag.mkdir()
    for number, part in enumerate((messages[:750], messages[750:])):
        piece = foreign_bag(tmp_path / f"piece_{number}", part)
        shutil.move(piece / f"piece_{number}.mcap", bag / f"bag_{number}.mcap")
    os.truncate(bag / "bag_1.mcap", (bag / "bag_1.mcap").stat().st_size // 2)
    found = load(bag)
    assert 900 < len(found) < 1500
    assert_prefix(found)
