"""rosbag2, sqlite3 and MCAP: plain, compressed in every way, with messages on several pages."""

import shutil
from pathlib import Path

import zstandard
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from fuzz.target import Target, swinging
from lagrangian_ff import recording
from lagrangian_ff.recording import Recording

TYPE = "sensor_msgs/msg/JointState"
STORE = get_typestore(Stores.ROS2_JAZZY)
SQLITE_TOKENS = (b"SQLite format 3\0", b"\x0d", b"\x05", b"\x0a", b"\x02", b"messages", b"topics")
MCAP_TOKENS = (
    b"\x89MCAP0\r\n",
    b"\x05",
    b"\x06",
    b"\x04",
    b"\x03",
    b"\x02",
    b"\x0f",
    b"\x08",
    b"zstd",
    b"lz4",
    b"\x28\xb5\x2f\xfd",
    b"\x04\x22\x4d\x18",
    b"sensor_msgs/msg/JointState",
    b"joint_1",
)


def read(path: Path) -> None:
    """Load a recording, look at it, and make a motion of it."""
    found = recording.load(path)
    recording.inspect(found).record()
    recording.condition(found)


def _messages(one: Recording) -> list[tuple[int, bytes]]:
    kinds = STORE.types
    out = []
    for time, *rows in zip(one.time, one.position, one.velocity, one.effort, strict=True):
        stamp = round((one.start + time) * 1e9)
        when = kinds["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9)
        header = kinds["std_msgs/msg/Header"](stamp=when, frame_id="")
        state = kinds[TYPE](header, list(one.joints), *rows)
        out.append((stamp, bytes(STORE.serialize_cdr(state, TYPE))))
    return out


def _bag(folder: Path, name: str, storage: str, compression: str, one: Recording) -> None:
    """Write one file into a folder, by the library `rosbags`."""
    writer = Writer(folder / "bag", version=9, storage_plugin=StoragePlugin[storage])
    if compression != "NONE":
        writer.set_compression(CompressionMode[compression], CompressionFormat.ZSTD)
    with writer:
        topic = writer.add_connection("/joint_states", TYPE, typestore=STORE)
        for received, data in _messages(one):
            writer.write(topic, received, data)
    (file,) = (one for one in (folder / "bag").iterdir() if one.name != "metadata.yaml")
    file.rename(folder / name)
    shutil.rmtree(folder / "bag")


def _sqlite(folder: Path) -> None:
    _bag(folder, "plain.db3", "SQLITE3", "NONE", swinging())
    _bag(folder, "messages.db3", "SQLITE3", "MESSAGE", swinging())
    _bag(folder, "pages.db3", "SQLITE3", "NONE", swinging(60, 100))
    content = (folder / "plain.db3").read_bytes()
    (folder / "file.db3.zstd").write_bytes(zstandard.compress(content))


def _mcap(folder: Path) -> None:
    _bag(folder, "plain.mcap", "MCAP", "NONE", swinging())
    _bag(folder, "messages.mcap", "MCAP", "MESSAGE", swinging())
    recording.write_bag(folder / "ours", swinging())
    (file,) = (folder / "ours").glob("*.mcap")
    file.rename(folder / "ours.mcap")
    shutil.rmtree(folder / "ours")
    for kind in CompressionType:
        with (folder / f"chunks_{kind.name.lower()}.mcap").open("wb") as out:
            writer = McapWriter(out, chunk_size=8_000, compression=kind)
            writer.start(profile="ros2")
            schema = writer.register_schema(TYPE, "ros2msg", b"")
            channel = writer.register_channel("/joint_states", "cdr", schema)
            for stamp, data in _messages(swinging()):
                writer.add_message(channel, stamp, data, stamp)
            writer.finish()
    content = (folder / "plain.mcap").read_bytes()
    (folder / "file.mcap.zstd").write_bytes(zstandard.compress(content))


SQLITE = Target("bag", _sqlite, read, SQLITE_TOKENS)
MCAP = Target("mcap", _mcap, read, MCAP_TOKENS)
