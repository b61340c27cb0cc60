"""Which torque to send now: the one place that decides, at every instant."""

import threading
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.nodes.streaming.limits import Ramp, clamp, slew
from lagrangian_ff.nodes.streaming.plan import TERMS, Plan

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


LONGEST_STEP = 0.02
"""s that ramps and rate limits move on at most in one tick: when the machine stalls, the torque
must not jump afterwards."""


class Phase(Enum):
    """Where the stream is in its reference."""

    WAITING = "no reference"
    AHEAD = "before the start"
    FOLLOWING = "following"
    HOLDING = "holding after the end"
    STREAMED = "following set-points"


@dataclass(frozen=True)
class Settings:
    """Everything about the stream that a user may change while it runs.

    Attributes:
        scale: (N,) factor of each joint, 0 to 1.
        effort_limit: (N,) N·m.
        effort_rate: (N,) N·m/s.
        switches: (4,) 1 or 0 for each of gravity, inertia, coriolis, friction.
        ramp_time: s in which the torque is brought in.
        fade_time: s in which it is faded to zero.
        reference_timeout: s without a set-point after which it fades; 0 = never.
        joint_state_timeout: s without a joint state after which it fades; 0 = never.
        tracking_tolerance: rad a joint may be away from its reference before it fades; 0 = any.
        after_end: "hold" the torque of the last point at rest, or "fade".
        lead: s by which the torque is sent ahead of its reference.
    """

    scale: Floats
    effort_limit: Floats
    effort_rate: Floats
    switches: Floats = field(default_factory=lambda: np.ones(len(TERMS)))
    ramp_time: float = 0.5
    fade_time: float = 0.5
    reference_timeout: float = 0.2
    joint_state_timeout: float = 0.5
    tracking_tolerance: float = 0.5
    after_end: str = "hold"
    lead: float = 0.0


@dataclass(frozen=True)
class Output:
    """What is sent at one instant, and why.

    Attributes:
        tau: (N,) N·m.
        gain: 0 while nothing is let through, 1 when all is.
        phase: where in the reference.
        withheld: why the torque is faded or zero; empty where it is not.
        saturated: (N,) joints at their torque limit.
        held_back: (N,) joints at their rate limit.
        q, qd: (N,) the reference now; None without one.
    """

    tau: Floats
    gain: float
    phase: Phase
    withheld: str
    saturated: Flags
    held_back: Flags
    q: Floats | None = None
    qd: Floats | None = None


class TorqueStream:
    """Plays plans, and fades to zero whenever anything is not as it should be.

    Times of the reference are ns of the node's clock, which may be simulated; the watchdogs
    count in s of a steady clock. The gain multiplies after all limits, so that fading takes
    `fade_time` whatever the rate limit is. Everything may be told in one thread while another
    ticks.
    """

    def __init__(self, joints: tuple[str, ...], settings: Settings) -> None:
        self.joints = joints
        self.settings = settings
        self.enabled = True
        self._plan: Plan | None = None
        self._start = 0
        self._next: tuple[Plan, int] | None = None
        self._lock = threading.Lock()
        self._ramp = Ramp(settings.ramp_time, settings.fade_time)
        self._limited = np.zeros(len(joints))
        self._reference_at = -np.inf
        self._joint_state_at = -np.inf
        self._state: tuple[int, Floats] | None = None
        self._refused = self._ending = ""
        self._last_tick: float | None = None

    @property
    def plan(self) -> Plan | None:
        """The plan that came last."""
        return self._next[0] if self._next else self._plan

    def play(self, plan: Plan, start: int, steady: float) -> None:
        """Follow this plan from `start` (ns) on; until then, what is followed now."""
        with self._lock:
            self._next, self._refused = (plan, start), ""
        self._reference_at = steady

    def withhold(self, reason: str) -> None:
        """Fade out until the next reference that can be followed comes."""
        self._refused = reason

    def end(self, reason: str) -> None:
        """Fade out, whatever reference may still come, until `forget`."""
        self._ending = reason

    def joint_state_came(self, steady: float, stamp: int, position: Floats) -> None:
        """The robot is alive, and its joints were here, (N,) rad, at this time in ns."""
        self._joint_state_at, self._state = steady, (stamp, position)

    def reference_age(self, steady: float) -> float:
        """Seconds since the last reference came; infinite where none did."""
        return float(steady - self._reference_at)

    def forget(self) -> None:
        """No reference, no torque."""
        with self._lock:
            self._plan = self._next = None
        self._refused = self._ending = ""
        self._ramp.value = 0.0
        self._last_tick = None

    def tick(self, now: int, steady: float) -> Output:
        """The torque to send.

        Args:
            now: ns of the node's clock.
            steady: s of the steady clock.
        """
        dt = 0.0 if self._last_tick is None else min(steady - self._last_tick, LONGEST_STEP)
        self._last_tick = steady
        self._take_over(now)
        settings, plan = self.settings, self._plan
        none = np.zeros(len(self.joints), dtype=bool)
        if plan is None:
            self._ramp.value = 0.0
            reason = self._withheld(Phase.WAITING, steady)
            return Output(np.zeros(len(self.joints)), 0.0, Phase.WAITING, reason, none, none)
        elapsed = (now - self._start) / 1e9 + settings.lead
        phase = _phase(plan, elapsed)
        withheld = self._withheld(phase, steady) or self._astray(plan)
        parts, weight = plan.at(elapsed)
        wanted = (settings.switches @ parts) * settings.scale * weight
        wanted, saturated = clamp(wanted, settings.effort_limit)
        if self._ramp.value == 0.0:
            # Nothing was sent, so there is nothing to move away from gently.
            self._limited, held_back = wanted, none
        else:
            self._limited, held_back = slew(self._limited, wanted, settings.effort_rate, dt)
        self._ramp.up, self._ramp.down = settings.ramp_time, settings.fade_time
        gain = self._ramp.move(not withheld, dt)
        q, qd, _ = plan.reference.sample(np.asarray(elapsed))
        return Output(gain * self._limited, gain, phase, withheld, saturated, held_back, q, qd)

    def _astray(self, plan: Plan) -> str:
        """Which joint was not where the reference was: its torque would be the wrong one."""
        tolerance = self.settings.tracking_tolerance
        if self._state is None or tolerance == 0.0:
            return ""
        # By the stamp, so that joint states that come late do no harm.
        stamp, position = self._state
        q, _, _ = plan.reference.sample(np.asarray((stamp - self._start) / 1e9))
        distance = np.abs(position - q)
        worst = int(np.argmax(distance))
        if distance[worst] <= tolerance:
            return ""
        return f"{self.joints[worst]} is more than {tolerance:g} rad from its reference"

    def _take_over(self, now: int) -> None:
        """Let the next plan take the place of the present one when its time has come."""
        with self._lock:
            if self._next is None:
                return
            plan, start = self._next
            moving = self._plan is not None and not self._plan.reference.is_setpoint
            if not moving or now >= start:
                self._plan, self._start, self._next = plan, start, None

    def _withheld(self, phase: Phase, steady: float) -> str:
        """Why the torque must not be sent; empty where it may."""
        settings = self.settings
        if self._ending:
            return self._ending
        if not self.enabled:
            return "disabled"
        silence = steady - self._joint_state_at
        if 0.0 < settings.joint_state_timeout < silence:
            return "no joint states" + (f" for {silence:.1f} s" if np.isfinite(silence) else "")
        if phase is Phase.WAITING:
            return "no reference"
        if self._refused:
            return self._refused
        age = self.reference_age(steady)
        if phase is Phase.STREAMED and 0.0 < settings.reference_timeout < age:
            return f"no set-point for {age:.1f} s"
        if phase is Phase.HOLDING and settings.after_end == "fade":
            return "the reference has ended"
        return ""


def _phase(plan: Plan, elapsed: float) -> Phase:
    if plan.reference.is_setpoint:
        return Phase.STREAMED
    if elapsed < 0.0:
        return Phase.AHEAD
    return Phase.FOLLOWING if elapsed <= plan.reference.duration else Phase.HOLDING
