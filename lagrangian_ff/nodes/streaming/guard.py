"""A torque that is passed on, and fades to zero when it stops coming. Free of rclpy."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.nodes.streaming.stream import clamp, moved, slew

NO_LIMIT = 1e12  # N·m; not infinite, because of its products with zero


@dataclass(frozen=True)
class GuardSettings:
    """The settings of a guard.

    Attributes:
        effort_limit: (N,) N·m; (1,) for any number of joints.
        effort_rate: (N,) or (1,) N·m/s.
        timeout: s without a usable message after which the torque fades.
        fade_time: s in which it is faded to zero.
        ramp_time: s in which it is brought in, also when it comes again.
        longest: s that one tick makes up for at most.
    """

    effort_limit: Floats
    effort_rate: Floats
    timeout: float = 0.1
    fade_time: float = 0.5
    ramp_time: float = 0.1
    longest: float = 0.006


class Guard:
    """Passes torques on within their limits, and fades to zero when none come.

    Args:
        joints: how many torques a message has; 0 = as many as the first one.

    Attributes:
        sent: (N,) N·m, the last torque; None before the first message.
        silent: whether the torque fades or is zero because none comes.
        refused: messages that were not passed on, by reason.
    """

    def __init__(self, settings: GuardSettings, joints: int = 0) -> None:
        self.settings = settings
        self.sent: Floats | None = None
        self.silent = True
        self.refused: Counter[str] = Counter()
        self._joints = joints
        self._wanted, self._new = np.zeros(0), False
        self._came = self._ticked = -np.inf
        self._gain = 0.0
        self._ended = False

    def take(self, tau: Floats, steady: float) -> str:
        """Take a message (N,) N·m; return why it is not passed on, or "".

        Args:
            steady: s of a steady clock.
        """
        expected = self._joints or len(tau)
        fault = ""
        if len(tau) != expected or len(tau) == 0:
            fault = f"{len(tau)} torques; expected {expected or 'some'}"
        elif not np.isfinite(tau).all():
            fault = f"torque {int(np.isfinite(tau).argmin())} is not finite"
        if fault:
            self.refused[fault] += 1
            return fault
        if self.sent is None:
            self._joints, self.sent = len(tau), np.zeros(len(tau))
        self._wanted, self._came, self._new = np.array(tau), steady, True
        return ""

    def end(self) -> None:
        """Fade out, whatever comes."""
        self._ended = True

    def tick(self, steady: float) -> Floats | None:
        """Return the torque (N,) N·m to send now.

        Return None before the first message, and where the last torque still holds: a torque that
        moves is sent even between messages, as the next one would jump otherwise.
        """
        now = self.settings
        dt = min(max(0.0, steady - self._ticked), now.longest)
        self._ticked = steady
        if self.sent is None:
            return None
        # A simulated clock that was set back counts as silence.
        self.silent = self._ended or not 0.0 <= steady - self._came <= now.timeout
        seconds = now.fade_time if self.silent else now.ramp_time
        self._gain = moved(self._gain, 0.0 if self.silent else 1.0, dt, seconds)
        most = now.effort_rate
        if self.silent:
            most = np.maximum(most, now.effort_limit / max(now.fade_time, 1e-9))
        wanted, _ = clamp(self._wanted, now.effort_limit)
        before, new, self._new = self.sent, self._new, False
        self.sent, _ = slew(before, self._gain * wanted, most, dt)
        moves = not np.array_equal(self.sent, before)
        return self.sent if new or moves or self.silent else None

    @property
    def resting(self) -> bool:
        """Return whether nothing but zeros is sent."""
        return self.sent is None or not self.sent.any()
