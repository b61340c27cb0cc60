"""The robot's signs of life: which joint states are news, and when they were true."""

from collections import Counter

from lagrangian_ff.nodes.common.pacing import BACK
from lagrangian_ff.nodes.common.status import Level, Status

REPEATED, DISORDERED, SET_BACK = "repeated", "out of order", "set back"
ADVICE = {
    REPEATED: "carry the same stamp: the driver repeats an old state; restart it",
    DISORDERED: "are not in the order of their stamps: let one publisher send these joints",
    SET_BACK: "went back in time: was the driver restarted, or do two send these joints?",
}
"""What a kind of bad stamp means, worst last."""


class SignsOfLife:
    """Judges joint states by their stamps; for one thread, another may ask for the status.

    A state that is not newer than the last one is no sign of life. A stamp far from the node's
    clock says nothing of when the state was true, so the time of arrival stands for it.
    """

    def __init__(self) -> None:
        self._last = self._off = self._received = self._new = 0
        self._recent: Counter[str] = Counter()

    def news(self, stamp: int, now: int) -> int | None:
        """Return when the state was true by the node's clock, ns; None if it is no news.

        Args:
            stamp: ns of its header; 0 = not stamped.
            now: ns of the node's clock.
        """
        self._received += 1
        if stamp == 0:
            self._new += 1
            return now
        last, self._last = self._last, stamp
        if stamp == last:
            self._recent[REPEATED] += 1
            return None
        if last - BACK < stamp < last:
            self._recent[DISORDERED] += 1
            self._last = last
            return None
        if stamp < last:
            self._recent[SET_BACK] += 1
        self._new += 1
        self._off = stamp - now if abs(stamp - now) > BACK else 0
        return now if self._off else stamp

    def status(self, publishers: int) -> Status:
        """Return the state of the joint states since the last call.

        Args:
            publishers: how many nodes publish on the topic.
        """
        recent, self._recent = self._recent, Counter()
        received, self._received = self._received, 0
        new, self._new = self._new, 0
        values: dict[str, object] = {
            "joint states": received,
            "of them new": new,
            "publishers": publishers,
            "stamps ahead of the clock [s]": self._off / 1e9,
            **recent,
        }
        for kind in reversed(ADVICE):
            # A driver may well send each state twice.
            if recent[kind] and not (kind == REPEATED and new):
                said = f"{recent[kind]} of {received} joint states {ADVICE[kind]}"
                return Status(Level.WARN, f"{said} ({publishers} publish there)", values)
        if received and self._off:
            side = "ahead of" if self._off > 0 else "behind"
            said = (
                f"joint states are stamped {abs(self._off) / 1e9:.1f} s {side} this node's clock: "
                "set the clocks of both machines by NTP, or use_sim_time if it is a simulation; "
                "until then the time of arrival counts"
            )
            return Status(Level.WARN, said, values)
        if not received:
            return Status(
                Level.STALE,
                f"no joint states of the model's joints, though {publishers} publish there"
                if publishers
                else "nobody publishes joint states",
                values,
            )
        return Status(Level.OK, f"{new} joint states in the last second", values)
