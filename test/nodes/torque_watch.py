"""A process that watches torques at 1 kHz, as a controller would, and writes them down.

python torque_watch.py FILE TOPIC...

Each message is a record of `RECORD` doubles: when it came (s, monotonic: one clock for all
processes), the index of its topic, how many torques it has, and the first two of them. A pause of
this process is one, too: when it ended, `PAUSED`, and the s it lasted.
"""

import sys
import time
from pathlib import Path

import numpy as np
import rclpy
from numpy.typing import NDArray
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64MultiArray

from lagrangian_ff.nodes.common.topics import PolledSubscription

RECORD = 5
PERIOD = 0.001
PAUSED = -1.0
PAUSE = 0.02
"""s that this process stands still; the machine is too busy then to judge others by times."""
DEEP = QoSProfile(depth=5000, reliability=ReliabilityPolicy.RELIABLE)


def watch(path: Path, topics: list[str]) -> None:
    """Watch until this process is killed."""
    rclpy.init()
    node = rclpy.create_node("torque_watch")
    subscriptions = [PolledSubscription(node, Float64MultiArray, topic, DEEP) for topic in topics]
    last = time.monotonic()
    with path.open("ab", buffering=0) as file:
        while True:
            came = time.monotonic()
            if came - last > PAUSE:
                pause = [came, PAUSED, came - last, np.nan, np.nan]
                file.write(np.array(pause, dtype=np.float64).tobytes())
            last = came
            for index, subscription in enumerate(subscriptions):
                for message, _ in subscription.take():
                    first = [*message.data, np.nan, np.nan][:2]
                    record = [came, index, len(message.data), *first]
                    file.write(np.array(record, dtype=np.float64).tobytes())
            time.sleep(max(0.0, came + PERIOD - time.monotonic()))


class Records:
    """What the process writes to a file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._read = 0

    def read(self) -> NDArray[np.float64]:
        """Return the records since the last call, (K, RECORD)."""
        data = b""
        if self.path.exists():
            with self.path.open("rb") as file:
                file.seek(self._read)
                data = file.read()
        size = len(data) // (8 * RECORD) * 8 * RECORD
        self._read += size
        return np.frombuffer(data[:size], np.float64).reshape(-1, RECORD)


if __name__ == "__main__":
    watch(Path(sys.argv[1]), sys.argv[2:])
