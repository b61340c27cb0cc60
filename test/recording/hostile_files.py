"""Files made to exhaust whoever reads them; each is small."""

import os
import pickle
import socket
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import zstandard
from recording_examples import foreign_bag, message, messages_of, swinging

MIB = 1 << 20
MCAP = b"\x89MCAP0\r\n"
NAMES = ("a", "b")
CLAIMING = b"\x28\xb5\x2f\xfd\xe0" + (2**36).to_bytes(8, "little") + b"\x01\x00\x00"
"""A frame of zstd that claims to hold 64 GiB."""


def zeros(mebibytes: int, begin: bytes = b"") -> bytes:
    """Return a frame of zstd that unpacks to zeros."""
    packer = zstandard.ZstdCompressor(1).compressobj()
    parts = [packer.compress(begin), *(packer.compress(bytes(MIB)) for _ in range(mebibytes))]
    return b"".join([*parts, packer.flush()])


def written(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


def overflow_in_a_circle(folder: Path) -> Path:
    """A row of 1 TiB whose second page is followed by itself."""
    head = bytearray(512)
    head[:18] = b"SQLite format 3\0" + (512).to_bytes(2, "big")
    leaf = bytearray(512)
    leaf[:10] = b"\x0d\x00\x00\x00\x01\x00\x00\x00\x00\x64"
    row = b"\xa0\x80\x80\x80\x80\x00\x01"  # its length, 2^40, and its key
    local = 39 + (2**40 - 39) % 508
    local = local if local <= 477 else 39
    leaf[100 : 100 + len(row)] = row
    leaf[107 + local : 111 + local] = (3).to_bytes(4, "big")
    circle = (3).to_bytes(4, "big") + bytes(508)
    return written(folder / "circle.db3", bytes(head) + bytes(leaf) + circle)


def file_of_zeros(folder: Path, mebibytes: int = 80) -> Path:
    return written(folder / "zeros.mcap.zstd", zeros(mebibytes, MCAP))


def chunk(packed: bytes, size: int, compression: bytes = b"zstd") -> bytes:
    """Return an MCAP chunk of compressed records."""
    body = struct.pack("<QQQII", 0, 0, size, 0, len(compression)) + compression
    body += struct.pack("<Q", len(packed)) + packed
    return struct.pack("<BQ", 6, len(body)) + body


def chunk_of_zeros(folder: Path, mebibytes: int = 300) -> Path:
    content = MCAP + chunk(zeros(mebibytes), mebibytes * MIB)
    return written(folder / "chunk.mcap", content)


def many_chunks(folder: Path, number: int = 4) -> Path:
    content = MCAP + chunk(zeros(40), 40 * MIB) * number
    return written(folder / "chunks.mcap", content)


def packed_twice(folder: Path) -> Path:
    """A small file that unpacks to many chunks, each of which unpacks."""
    content = MCAP + chunk(zeros(1), MIB) * 2000
    return written(folder / "twice.mcap.zstd", zstandard.compress(content))


def messages_of_zeros(folder: Path, number: int = 20) -> Path:
    """A bag of which most messages unpack to 12 MiB."""
    good = [(k, message(k * 10**7, NAMES, (k, k), (), (k, k))) for k in range(1, 6)]
    bombs = [(k, zeros(12)) for k in range(6, 6 + number)]
    return foreign_bag(folder / "messages", [*good, *bombs])


def message_that_claims(folder: Path) -> Path:
    good = messages_of(swinging(300))
    return foreign_bag(folder / "claims", [*good, (good[-1][0] + 1, CLAIMING)])


def metadata(folder: Path, text: str) -> Path:
    bag = foreign_bag(folder / "described", messages_of(swinging(300)))
    (bag / "metadata.yaml").write_text(text)
    return bag


def aliases(folder: Path) -> Path:
    lines = ["a0: &a0 [x, x]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]" for k in range(1, 12)]
    lines += ["rosbag2_bagfile_information:", "  relative_file_paths: *a11"]
    return metadata(folder, "\n".join(lines))


def depth(folder: Path) -> Path:
    return metadata(folder, "rosbag2_bagfile_information: " + "[" * 100_000)


def archive(path: Path, members: dict[str, bytes]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in members.items():
            file.writestr(name, content)
    return path


def npy(shape: str, content: bytes = b"", kind: str = "<f8") -> bytes:
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode() + content


def archive_of_zeros(folder: Path, mebibytes: int = 128) -> Path:
    rows = mebibytes * MIB // 8
    content = npy(f"({rows},)", bytes(8 * rows))
    return archive(folder / "zeros.npz", {"time.npy": content, "position.npy": content})


def archive_that_claims(folder: Path) -> Path:
    few = npy("(1000000000000,)", bytes(80))
    return archive(folder / "claims.npz", {"time.npy": few, "position.npy": few})


def empty_texts(folder: Path) -> Path:
    """Texts without length take no bytes, however many there are."""
    few = npy("(1000000000000,)", b"", "<U0")
    return archive(folder / "texts.npz", {"time.npy": few, "position.npy": few})


def pickled(folder: Path) -> Path:
    return written(folder / "pickled.npz", pickle.dumps({"time": np.arange(3.0)}))


def many_columns(folder: Path) -> Path:
    names = [f"{kind}/{n}" for n in range(13_334) for kind in ("position", "velocity", "effort")]
    row = ",".join(["0"] * (1 + len(names)))
    return written(folder / "wide.csv", "\n".join([",".join(["time", *names]), row]).encode())


def long_cell(folder: Path) -> Path:
    return written(folder / "cell.csv", b"time,position/a\n0," + b"1" * 200_000 + b"\n1,\n")


def quote(folder: Path) -> Path:
    rows = b"".join(b"%d,1\n" % k for k in range(100_000))
    return written(folder / "quote.csv", b'time,position/a\n,"1\n' + rows)


def pipe(folder: Path) -> Path:
    os.mkfifo(folder / "pipe.csv")
    return folder / "pipe.csv"


def device(folder: Path) -> Path:
    (folder / "device.csv").symlink_to("/dev/zero")
    return folder / "device.csv"


def plug(folder: Path) -> Path:
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(str(folder / "s.csv"))
    return folder / "s.csv"


def device_in_a_bag(folder: Path) -> Path:
    bag = foreign_bag(folder / "linked", messages_of(swinging(300)))
    (bag / "metadata.yaml").unlink()
    (bag / "metadata.yaml").symlink_to("/dev/zero")
    return bag


def names_of_their_own(folder: Path, number: int = 1500) -> Path:
    """Messages of which each names other joints: a table that is nearly empty."""
    found = [(k, message(k, (f"a{k}", f"b{k}"), (0.0, 0.0))) for k in range(1, number)]
    return foreign_bag(folder / "names", found)


REFUSED: tuple[Callable[[Path], Path], ...] = (
    overflow_in_a_circle, file_of_zeros, chunk_of_zeros, many_chunks, packed_twice,
    messages_of_zeros,
    archive_of_zeros, archive_that_claims, empty_texts, pickled, many_columns, long_cell, quote,
    pipe, device, plug, device_in_a_bag, names_of_their_own,
)  # fmt: skip
READ = (message_that_claims, aliases, depth)
"""Of these, what is sound is read."""
