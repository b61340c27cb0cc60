"""Outputs that a running command has claimed: two commands never write one output.

A claim is a socket in Linux' abstract namespace, bound to a name made of the path. It needs no
file, is there for every user of the machine, and ends with the process however that ends. Elsewhere
nothing is claimed, and the last command to end would replace what the other wrote.
"""

import errno
import hashlib
import os
import socket
import sys
from pathlib import Path

from lagrangian_ff.errors import UserError

_held: dict[Path, socket.socket] = {}


def claim(path: Path, option: str) -> None:
    """Claim a path that this process will write, until `release` or its end.

    Args:
        option: that names it, such as --output.

    Raises:
        UserError: another command is about to write it.
    """
    whole = Path(os.path.realpath(path))
    if whole in _held or sys.platform != "linux":
        return
    digest = hashlib.sha256(str(whole).encode(errors="surrogateescape")).hexdigest()
    mark = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        mark.bind(f"\0lagrangian_ff/{digest}")
    except OSError as error:
        mark.close()
        if error.errno == errno.EADDRINUSE:
            raise UserError(
                f"{option} {path}: another command that runs now is about to write it; nothing was "
                "done. Wait for that one, or name another"
            ) from error
        return  # no such sockets here, as in some sandboxes
    _held[whole] = mark


def release() -> None:
    """Give up all claims: a command of this process has ended."""
    while _held:
        _held.popitem()[1].close()
