"""What time it is for a node whose loop reads joint states."""

import time

from rclpy.node import Node


class NodeTime:
    """The node's clock, and the steady seconds its watchdogs count in.

    With use_sim_time both are the simulation's: a robot whose machine is slow is not silent. The
    stamps of joint states then tell the time, too, since /clock may come less often than they do.

    Args:
        node: the node.

    Attributes:
        simulated: whether use_sim_time was set when this was made.
    """

    def __init__(self, node: Node) -> None:
        self._clock = node.get_clock()
        self.simulated = bool(node.get_parameter("use_sim_time").value)
        self._stamped = 0

    def stamped(self, at: int) -> None:
        """A joint state came that was stamped now, in ns."""
        self._stamped = at

    def now(self) -> int:
        """Ns."""
        now = int(self._clock.now().nanoseconds)
        return max(now, self._stamped) if self.simulated else now

    def steady(self) -> float:
        """s since some instant."""
        return self.now() / 1e9 if self.simulated else time.monotonic()
