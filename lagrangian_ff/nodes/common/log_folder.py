"""The folder of ROS' log files, where the usual one cannot be written.

rclpy ends with an error where it cannot open its log: a service account often has no home, or one
that it may only read.
"""

import os
import stat
import sys
import tempfile
from pathlib import Path

VARIABLE = "ROS_LOG_DIR"


def use_writable_log_folder() -> None:
    """Let ROS log into a temporary folder where its usual one cannot be written, and say so.

    The usual one is that of `ROS_LOG_DIR`, else `log` in that of `ROS_HOME`, else `~/.ros/log`.
    """
    given = os.environ.get(VARIABLE)
    home = os.environ.get("ROS_HOME") or "~/.ros"
    usual = Path(given or Path(home) / "log").expanduser()
    if _writable(usual):
        return
    instead = Path(tempfile.gettempdir()) / f"ros_log_of_user_{os.getuid()}"
    if not (_writable(instead) and _private(instead)):
        instead = Path(tempfile.mkdtemp(prefix="ros_log_"))
    os.environ[VARIABLE] = str(instead)
    print(f"ROS logs go to {instead}: {usual} cannot be written", file=sys.stderr, flush=True)


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except (OSError, RuntimeError):  # RuntimeError: no home
        return False


def _private(folder: Path) -> bool:
    """Return whether a folder in a place that all may write is one that only this user has."""
    found = folder.lstat()
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
