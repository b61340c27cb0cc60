"""How the stream is doing, once a second."""

from collections.abc import Mapping

from lagrangian_ff.nodes.common.pacing import RateMeter
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.streaming.stream import Output, Phase

FEW = 0.9  # of the wanted rate


class Monitor:
    """Watches the outputs of a stream.

    Attributes:
        last: the newest output.
    """

    def __init__(self) -> None:
        self.last: Output | None = None
        self._meter = RateMeter()
        self._saturated = 0
        self._held_back = 0

    def note(self, output: Output) -> str:
        """Take an output; why the torque begins to fade with it, empty where it does not."""
        before = "" if self.last is None else self.last.withheld
        self.last = output
        self._meter.add()
        self._saturated += bool(output.saturated.any())
        self._held_back += bool(output.held_back.any())
        begins = output.withheld != before and output.phase is not Phase.WAITING
        return output.withheld if begins else ""

    def status(self, wanted_rate: float, more: Mapping[str, object]) -> Status:
        """What happened since the last call.

        Args:
            wanted_rate: Hz.
            more: further values to show.
        """
        output, rate = self.last, self._meter.take()
        saturated, self._saturated = self._saturated, 0
        held_back, self._held_back = self._held_back, 0
        values: dict[str, object] = {
            "publish rate [Hz]": rate,
            "phase": output.phase.value if output else "",
            "gain": output.gain if output else 0.0,
            "ticks at the torque limit": saturated,
            "ticks at the rate limit": held_back,
            **more,
        }
        level, message = Level.OK, output.phase.value if output else "starting"
        if output is not None and output.phase is not Phase.WAITING and output.withheld:
            silent = output.withheld.startswith("no ")
            level, message = (Level.STALE if silent else Level.WARN), output.withheld
        elif saturated:
            level, message = Level.WARN, f"torque limit reached in {saturated} ticks"
        elif rate < FEW * wanted_rate:
            level, message = Level.WARN, f"{rate:.0f} Hz instead of {wanted_rate:g} Hz"
        return Status(level, message, values)
