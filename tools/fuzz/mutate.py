"""Damage: flipped bits, lengths, tokens, parts moved, doubled, lost or taken from another file."""

import re
import struct
from contextlib import suppress
from random import Random

from fuzz.target import Target, members, packed

NUMBERS = (
    *(0, 1, 2, 4, 7, 8, 16, 100, 127, 128, 255, 256, 1000, 4096, 32767, 65535, 65536, 2**24),
    *(2**31 - 1, 2**31, 2**32 - 1, 2**32, 2**36, 2**40, 2**62, 2**63 - 1, 2**63, 2**64 - 1),
)
VALUES = (0.0, -1.0, 1.0, 1e-320, 1e9, 1e100, -1e100, 1e308, -1e308, *map(float, ("nan", "inf")))
TEXTS = (
    *(b"1e308", b"-1e308", b"1e400", b"nan", b"inf", b"-1", b"0", b"1e9", b"1e-320", b"0x10", b""),
    *(b",", b",,,,,,,,", b'"', b"\n", b"\r", b"\0", b"\xff", b"9" * 400, b"'", "π".encode()),
    *(b"[" * 200, b"{}", b"[]", b"null", b"true", b'""', b"&a;", b"<a>", b"</a>", b"(" * 90),
)
_WORD = re.compile(rb"[\w.+/-]+")


def mutated(data: bytes, other: bytes, target: Target, random: Random) -> bytes:
    """Return a damaged copy of a file.

    Args:
        data: the file.
        other: another file of the target, from which parts are taken.
        target: whose tokens are put in.
        random: decides.
    """
    if target.deeper is not None and random.random() < 0.4:
        with suppress(Exception):  # a search damages what is damaged already
            return target.deeper(data, random)
    files = members(data) if target.archive and random.random() < 0.7 else None
    if not files:
        return _damaged(data, other, target, random)
    for _ in range(random.choice((1, 1, 2, 4))):
        name = random.choice(sorted(files))
        chance = random.random()
        if chance < 0.05:
            files[random.choice(sorted(files))] = files[name]
        elif chance < 0.08 and len(files) > 1:
            del files[name]
        else:
            files[name] = _damaged(files[name], other, target, random)
    return packed(files)


def _damaged(data: bytes, other: bytes, target: Target, random: Random) -> bytes:
    content = bytearray(data)
    if random.random() < 0.5:  # one small thing, so that the reader gets far
        random.choice((_flip, _number, _value, _word, _word))(content, target, random)
        return bytes(content)
    for _ in range(random.choice((1, 1, 1, 2, 3, 8))):
        how = random.choice((_flip, _number, _value, _word, _token, _lose, _double, _random, None))
        if how is not None:
            how(content, target, random)
        elif other:
            at, begin = _place(content, random), random.randrange(len(other))
            part = other[begin : begin + _length(len(other), random)]
            content[at : at + random.choice((0, len(part)))] = part
        del content[4 * len(data) + 65536 :]
    return bytes(content)


def _flip(content: bytearray, target: Target, random: Random) -> None:
    for _ in range(random.choice((1, 1, 4, 32))):
        if content:
            content[random.randrange(len(content))] ^= 1 << random.randrange(8)


def _number(content: bytearray, target: Target, random: Random) -> None:
    """Put a number in place of bytes: a length, a count, an offset."""
    width = random.choice((1, 2, 4, 8))
    number = (random.choice(NUMBERS) + random.choice((-1, 0, 0, 1))) % 256**width
    at = _place(content, random)
    content[at : at + width] = number.to_bytes(width, "little" if random.random() < 0.5 else "big")


def _value(content: bytearray, target: Target, random: Random) -> None:
    at = _place(content, random) // 4 * 4
    content[at : at + 8] = struct.pack("<d", random.choice(VALUES))


def _word(content: bytearray, target: Target, random: Random) -> None:
    """Put another word in the place of one."""
    at = _place(content, random)
    here = _WORD.search(content, max(0, at - 20), at + 200)
    beside = _place(content, random)
    there = _WORD.search(content, beside, beside + 200)
    if here is not None:
        words = [*target.tokens, *TEXTS, *([there[0]] * 8 if there else [])]
        content[here.start() : here.end()] = random.choice(words)


def _token(content: bytearray, target: Target, random: Random) -> None:
    token = random.choice((*target.tokens, *TEXTS))
    at = _place(content, random)
    content[at : at + random.choice((0, len(token), 1, 8))] = token


def _lose(content: bytearray, target: Target, random: Random) -> None:
    at, size = _place(content, random), len(content)
    del content[at : size if random.random() < 0.3 else at + _length(size, random)]


def _double(content: bytearray, target: Target, random: Random) -> None:
    at, to = _place(content, random), _place(content, random)
    part = content[at : at + _length(len(content), random)]
    content[to:to] = part * random.choice((1, 1, 2, 50))


def _random(content: bytearray, target: Target, random: Random) -> None:
    at = _place(content, random)
    length = min(_length(64, random), len(content) - at)
    content[at : at + length] = random.randbytes(length)


def _place(content: bytearray, random: Random) -> int:
    """Return a place: anywhere, or near one of the ends, where heads and indices are."""
    size = len(content)
    near = min(size, 200)
    return random.choice(
        (random.randint(0, size), random.randint(0, near), size - random.randint(0, near))
    )


def _length(size: int, random: Random) -> int:
    return random.choice((1, 4, 16, 64, random.randint(0, max(1, size // 4))))
