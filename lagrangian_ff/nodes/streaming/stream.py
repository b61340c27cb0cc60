"""The torque to send at every instant: limits, ramps, watchdogs, and a monitor of all this."""

import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from xml.etree import ElementTree

import numpy as np

from lagrangian_ff.arrays import Flags, Floats
from lagrangian_ff.nodes.common.joint_state_bytes import MessageError
from lagrangian_ff.nodes.common.pacing import RateMeter
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.streaming.plan import TERMS, Plan

JUMP = 0.5
"""s by which the clock of the references may differ from the steady one between two ticks."""
FAREWELL = 3  # number of zero commands at the end
LIMITS_PER_SECOND = 20.0
"""Default rate limit: a joint goes from zero to its torque limit in a twentieth of a second."""
LATE = 3.0  # periods that one tick makes up for at most: after a stall the torque must not jump
LONGEST_STEP = 0.02  # s of simulated time that one tick makes up for all the same
FEW = 0.9  # of the wanted rate


def clamp(tau: Floats, limit: Floats) -> tuple[Floats, Flags]:
    """Return the torques clipped to ±limit, and which were clipped."""
    return np.minimum(np.maximum(tau, -limit), limit), np.abs(tau) > limit


def slew(previous: Floats, wanted: Floats, rate: Floats, dt: float) -> tuple[Floats, Flags]:
    """Move from `previous` towards `wanted` by at most rate·dt; also return who was held back."""
    step, flagged = clamp(wanted - previous, rate * dt)
    return previous + step, flagged


def moved(share: float, goal: float, dt: float, seconds: float) -> float:
    """Return a share dt s later on its way to the goal, 0 or 1, which takes `seconds`."""
    step = dt / seconds if seconds > 0.0 else 1.0
    return min(goal, share + step) if goal > share else max(goal, share - step)


def effort_limits(urdf: str) -> dict[str, float]:
    """Return the torque limits of a robot description: N·m by joint (N for prismatic ones).

    Joints without a positive limit are left out.

    Raises:
        MessageError: the text is not a URDF.
    """
    try:
        root = ElementTree.fromstring(urdf)
    except ElementTree.ParseError as error:
        raise MessageError(f"robot_description is not XML: {error}") from None
    found = {}
    for joint in root.iter("joint"):
        limit = joint.find("limit")
        try:
            effort = float(limit.get("effort", "0")) if limit is not None else 0.0
        except ValueError:
            raise MessageError(
                f"robot_description: the effort limit of {joint.get('name')} is no number"
            ) from None
        if 0.0 < effort < float("inf"):
            found[joint.get("name", "")] = effort
    return found


class Phase(Enum):
    """The position of the stream in its reference."""

    WAITING = "no reference"
    AHEAD = "before the start"
    FOLLOWING = "following"
    HOLDING = "holding after the end"
    STREAMED = "following set-points"


@dataclass(frozen=True)
class Settings:
    """The settings that a user may change while the stream runs.

    Attributes:
        scale: (N,) factor of each joint, 0 to 1.
        effort_limit: (N,) N·m.
        effort_rate: (N,) N·m/s that the torque moves at most; a fade may need more, see `quickest`.
        switches: (4,) 1 or 0 for each of gravity, inertia, coriolis, friction.
        ramp_time: s in which the torque is brought in.
        fade_time: s in which it is faded to zero.
        reference_timeout: s without a set-point after which it fades; 0 = never.
        joint_state_timeout: s without a joint state after which it fades; 0 = never.
        tracking_tolerance: rad a joint may be away from its reference before it fades; 0 = any.
        after_end: "hold" the torque of the last point at rest, or "fade".
        lead: s by which the torque is sent ahead of its reference.
        longest: s that one tick makes up for at most: after a stall the torque must not jump.
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
    longest: float = 0.006

    def quickest(self, fading: bool) -> Floats:
        """Return the N·m/s (N,) of the torque at most: the rate limit, or what the fade needs."""
        if not fading:
            return self.effort_rate
        return np.maximum(self.effort_rate, self.effort_limit / max(self.fade_time, 1e-9))


@dataclass(frozen=True)
class Output:
    """The torque sent at one instant, and why.

    Attributes:
        tau: (N,) N·m.
        gain: 0 while the torque is withheld, 1 when all of it is sent.
        phase: position in the reference.
        withheld: why the torque is faded or zero; empty if it is sent.
        silent: whether that is because messages do not come.
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
    silent: bool = False


class TorqueStream:
    """Plays plans, and fades to zero whenever something is wrong.

    Times of the reference are ns of the node's clock, which may be simulated; the watchdogs
    count in s of a steady clock. Whatever happens, one tick moves a torque by at most
    `Settings.quickest` times the s since the last tick, or times `Settings.longest` if that is
    less. One thread may call `tick` while others call the rest.

    Attributes:
        enabled: whether the user wants torque.
        forbidden: why no torque may be sent, whatever comes; "" if it may.
    """

    def __init__(self, joints: tuple[str, ...], settings: Settings) -> None:
        self.joints = joints
        self.settings = settings
        self.enabled, self.forbidden = True, ""
        self._plan: Plan | None = None
        self._start = 0
        self._next: tuple[Plan, int] | None = None
        self._lock = threading.Lock()
        self._gain = 0.0
        self._sent = np.zeros(len(joints))
        self._bump, self._share = np.zeros(len(joints)), 0.0
        self._reference_at = -np.inf
        self._joint_state_at = -np.inf
        self._state: tuple[int, Floats] | None = None
        self._refused = self._ending = ""
        self._last_tick: tuple[int, float] | None = None

    @property
    def plan(self) -> Plan | None:
        """Return the newest plan."""
        return self._next[0] if self._next else self._plan

    def play(self, plan: Plan, start: int, steady: float) -> None:
        """Follow this plan from `start` (ns) on; until then, the present one."""
        with self._lock:
            self._next, self._refused = (plan, start), ""
        self._reference_at = steady

    def exchange(self, plan: Plan) -> None:
        """Use the torques of another model for a reference that is followed or comes next."""
        with self._lock:
            present, coming = self._plan, self._next
            if coming is not None and coming[0].reference is plan.reference:
                self._next = plan, coming[1]
            elif coming is None and present is not None and present.reference is plan.reference:
                self._next = plan, self._start

    def withhold(self, reason: str) -> None:
        """Fade out until the next usable reference comes."""
        self._refused = reason

    def end(self, reason: str) -> None:
        """Fade out until `forget`, whatever references come."""
        self._ending = reason

    def joint_state_came(self, steady: float, stamp: int, position: Floats) -> None:
        """Take a sign of life: the joints' position (N,) rad at the time `stamp` in ns."""
        self._joint_state_at, self._state = steady, (stamp, position)

    def reference_age(self, steady: float) -> float:
        """Return the s since the last reference; infinite before the first."""
        return float(steady - self._reference_at)

    def drop(self) -> None:
        """Drop the reference; the torque goes to zero as quickly as it may."""
        with self._lock:
            self._plan = self._next = None

    def forget(self) -> None:
        """Drop the reference and the torque, of which nothing is sent any more."""
        self.drop()
        self._refused = self._ending = ""
        self._gain = 0.0
        self._sent = np.zeros(len(self.joints))
        self._share = 0.0
        self._last_tick = None

    def tick(self, now: int, steady: float) -> Output:
        """Return the torque to send at `now` (ns, node's clock) and `steady` (s, steady clock)."""
        settings, dt = self.settings, self._elapsed(now, steady)
        self._take_over(now)
        plan = self._plan
        none = np.zeros(len(self.joints), dtype=bool)
        if plan is None:
            self._gain = 0.0
            withheld, silent = self._withheld(Phase.WAITING, steady)
            self._sent, _ = slew(self._sent, 0.0 * self._sent, settings.quickest(True), dt)
            return Output(self._sent, 0.0, Phase.WAITING, withheld, none, none, silent=silent)
        elapsed = (now - self._start) / 1e9 + settings.lead
        phase = _phase(plan, elapsed)
        withheld, silent = self._withheld(phase, steady)
        withheld = withheld or self._astray(plan)
        self._share = moved(self._share, 0.0, dt, settings.ramp_time)
        wanted = self._torque(plan, elapsed) + self._share * self._bump
        wanted, saturated = clamp(wanted, settings.effort_limit)
        seconds = settings.fade_time if withheld else settings.ramp_time
        self._gain = moved(self._gain, 0.0 if withheld else 1.0, dt, seconds)
        most = settings.quickest(bool(withheld))
        self._sent, held_back = slew(self._sent, self._gain * wanted, most, dt)
        q, qd, _ = plan.reference.sample(np.asarray(elapsed))
        return Output(self._sent, self._gain, phase, withheld, saturated, held_back, q, qd, silent)

    def _elapsed(self, now: int, steady: float) -> float:
        """Return the s that this tick makes up for; fade if the clock jumped since the last."""
        last, self._last_tick = self._last_tick, (now, steady)
        if last is None:
            return 0.0
        dt = max(0.0, steady - last[1])  # simulated seconds may be set back
        jump = now - last[0] - round(dt * 1e9)
        if abs(jump) > JUMP * 1e9:
            with self._lock:
                # It fades along the motion that goes on, and not at another place of it.
                self._start, self._next = self._start + jump, None
            self._reference_at = min(self._reference_at, steady)
            self._joint_state_at, self._state = min(self._joint_state_at, steady), None
            way = "forward" if jump > 0 else "back"
            self._refused = (
                f"the clock was set {way} by {abs(jump) / 1e9:.1f} s: send a new reference"
            )
        return min(dt, self.settings.longest)

    def _torque(self, plan: Plan, elapsed: float) -> Floats:
        """Return the torque (N,) N·m that a plan asks for."""
        parts, weight = plan.at(elapsed)
        return np.asarray((self.settings.switches @ parts) * self.settings.scale * weight)

    def _astray(self, plan: Plan) -> str:
        """Return which joint is away from its reference, where the torque would be wrong, or ""."""
        tolerance = self.settings.tracking_tolerance
        if self._state is None or tolerance == 0.0:
            return ""
        # By the stamp, so that late joint states do no harm.
        stamp, position = self._state
        q, _, _ = plan.reference.sample(np.asarray((stamp - self._start) / 1e9))
        distance = np.abs(position - q)
        worst = int(np.argmax(distance))
        if distance[worst] <= tolerance:
            return ""
        return f"{self.joints[worst]} is more than {tolerance:g} rad from its reference"

    def _take_over(self, now: int) -> None:
        """Replace the present plan by the next one when its time has come."""
        with self._lock:
            if self._next is None:
                return
            plan, start = self._next
            present, began = self._plan, self._start
            moving = present is not None and not present.reference.is_setpoint
            if moving and now < start:
                return
            self._plan, self._start, self._next = plan, start, None
        if present is None or self._gain == 0.0:
            self._share = 0.0
        elif present.known is not plan.known:
            # What another model would change at once is taken back over the ramp.
            lead = self.settings.lead
            before = self._torque(present, (now - began) / 1e9 + lead) + self._share * self._bump
            self._bump = before - self._torque(plan, (now - start) / 1e9 + lead)
            self._share = 1.0

    def _withheld(self, phase: Phase, steady: float) -> tuple[str, bool]:
        """Return why the torque must not be sent, or "", and whether messages do not come."""
        settings = self.settings
        if self._ending or not self.enabled:
            return self._ending or "disabled", False
        if self.forbidden:
            return self.forbidden, False
        silence, age = steady - self._joint_state_at, self.reference_age(steady)
        if 0.0 < settings.joint_state_timeout < silence:
            # Without the seconds so far: each number would be a new reason.
            limit = settings.joint_state_timeout
            lasting = f" for more than {limit:g} s" if np.isfinite(silence) else ""
            return f"no joint states{lasting}", True
        if phase is Phase.WAITING:
            return "no reference", True
        if self._refused:
            return self._refused, False
        if phase is Phase.STREAMED and 0.0 < settings.reference_timeout < age:
            return f"no set-point for more than {settings.reference_timeout:g} s", True
        ended = phase is Phase.HOLDING and settings.after_end == "fade"
        return "the reference has ended" if ended else "", False


def _phase(plan: Plan, elapsed: float) -> Phase:
    if plan.reference.is_setpoint:
        return Phase.STREAMED
    if elapsed < 0.0:
        return Phase.AHEAD
    return Phase.FOLLOWING if elapsed <= plan.reference.duration else Phase.HOLDING


class StreamMonitor:
    """Summarises the outputs of a stream, once a second.

    Attributes:
        last: the newest output.
    """

    def __init__(self) -> None:
        self.last: Output | None = None
        self._meter = RateMeter()
        self._saturated = 0
        self._held_back = 0

    def note(self, output: Output) -> str:
        """Take an output and return why the torque begins to fade with it, or ""."""
        before = "" if self.last is None else self.last.withheld
        self.last = output
        self._meter.add()
        self._saturated += bool(output.saturated.any())
        self._held_back += bool(output.held_back.any())
        begins = output.withheld != before and output.phase is not Phase.WAITING
        return output.withheld if begins else ""

    def status(self, wanted_rate: float, more: Mapping[str, object]) -> Status:
        """Return the state since the last call, with more values; `wanted_rate` in Hz."""
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
            level, message = (Level.STALE if output.silent else Level.WARN), output.withheld
        elif saturated:
            level, message = Level.WARN, f"torque limit reached in {saturated} ticks"
        if rate < FEW * wanted_rate:
            slow = f"{rate:.0f} Hz instead of {wanted_rate:g} Hz"
            # A stall is often the cause of what is said besides.
            message = slow if level is Level.OK else f"{message}; {slow}"
            level = max(level, Level.WARN)
        return Status(level, message, values)
