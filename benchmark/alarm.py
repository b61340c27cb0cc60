"""The delay of the monitor's alarm when the simulated arm is touched, and its false alarms.

    python benchmark/alarm.py [--arms 4] [--minutes 5] [--cycle 60] [--new-motion] [--plain]

Each arm is drawn with its nuisances as in `lagrangian_ff study nuisances` (`--plain`: the usual
arm and its sensors). A model is identified from one cycle of its work. Then it repeats that cycle,
with other noise, losses and stamps each time, or with `--new-motion` makes motions that it never
made; every alarm in it is false. At last it is touched on one joint after the other, for 0.6 s
each, by 10 to 100 % of the joint's rms torque. What is fed and timed is the monitor's own path,
message by message; the 10 ms of its looking and the time of DDS come on top.

Prints the false alarms in the hours judged, and by size the touches that were noticed within 90 ms
of the first stamp, and at all, with the median delay.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arm import ArmParameters, Driver, Run, fine, reported, simulate, working_motion
from lagrangian_ff.arm.hidden.base import Installed, recorded, together
from lagrangian_ff.arm.joint_effect import JointEffect, JointMoment
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateView, MessageError
from lagrangian_ff.nodes.common.models import conditioning_for
from lagrangian_ff.nodes.watching.chance import LEARNING
from lagrangian_ff.nodes.watching.live import LivePrediction
from lagrangian_ff.nodes.watching.states import LiveStates
from lagrangian_ff.nodes.watching.touch import SETTLING, Touch, TouchAlarm
from lagrangian_ff.recording import Recording, condition
from lagrangian_ff.studies.nuisances.drawn import Nuisances

Floats = NDArray[np.float64]
RATE = 100.0  # Hz of the monitor
LOOK = 0.01  # s between its looks
IN_TIME = 0.1 - LOOK
SIZES = 0.1, 0.25, 0.5, 1.0
LONG, APART = 0.6, 2.5  # s, of a touch and from one to the next
EDGE = 0.005  # s in which it rises
PAUSE = 5.0  # s between recordings


@dataclass(frozen=True)
class Planned:
    """A touch: s when it begins, joint, N·m."""

    begin: float
    joint: int
    torque: float


class Touches(JointEffect):
    """Torques on joints at times of the recording."""

    def __init__(self, planned: list[Planned]) -> None:
        self._planned = planned

    def torque(self, moment: JointMoment) -> tuple[Floats, Floats]:
        """Return the torque (6,) N·m that the motors must give more, and no slope."""
        now, out = recorded(moment), np.zeros(6)
        for one in self._planned:
            inside = min(now - one.begin, one.begin + LONG - now)
            if inside > 0.0:
                out[one.joint] += one.torque * min(inside / EDGE, 1.0)
        return out, np.zeros(6)


class SimulatedArm:
    """One arm at work.

    Args:
        seed: of its nuisances, its motions and its noise.  plain: without nuisances.
        cycle: s of its work.
    """

    def __init__(self, seed: int, cycle: float, *, plain: bool) -> None:
        self.seed, self.cycle = seed, cycle
        self.drawn = None if plain else Nuisances.draw(seed)
        self.driver = usual_driver() if self.drawn is None else self.drawn.driver
        usual = fine(ArmParameters())
        self.parameters = usual if self.drawn is None else self.drawn.parameters

    def run(self, motion: int, planned: list[Planned]) -> Run:
        """Return a run of one of its motions."""
        kind, rest, pace = "spline", 0.0, 0.4
        parts = [Installed((Touches(planned),))] if planned else []
        if self.drawn is not None:
            kind, rest, pace = self.drawn.motion, self.drawn.rest, self.drawn.pace
            parts += self.drawn.installed([])
        seed = 1000 * self.seed + motion
        path = working_motion(kind, self.cycle, rest, pace, seed, self.parameters)
        return simulate(path, parameters=self.parameters, seed=seed, **together(parts))

    def recording(self, run: Run, noise: int) -> Recording:
        """Return what its driver reports of a run, with other noise each time."""
        seed = 1000 * self.seed + noise
        return reported(run, self.driver, self.parameters, seed)


def usual_driver() -> Driver:
    """Return the driver of the usual arm: its current sensors and encoders at 500 Hz."""
    usual = ArmParameters()
    noise = np.asarray(usual.current_noise) * usual.torque_per_ampere
    return Driver(500.0, white=tuple(noise.tolist()), position_step=2e-5)


class Watched:
    """The monitor's path from messages to touches."""

    def __init__(self, model: Model) -> None:
        self.states = LiveStates(model.joints, conditioning_for(model, {}, {}), RATE)
        self.prediction, self.alarm = LivePrediction(model), TouchAlarm(model, 1.0 / RATE)
        self.now = PAUSE

    def watch(self, recording: Recording) -> Iterator[tuple[float, Touch]]:
        """Yield each touch with the stamp, s of the recording, of the message that showed it."""
        for k, time in enumerate(recording.time):
            at = round((self.now + time) * 1e9)
            row = recording.position[k], recording.velocity[k], recording.effort[k]
            try:
                state = self.states.take(JointStateView(at, recording.joints, *row), at)
            except MessageError:
                continue
            for judged in self.prediction.take([state] if state else []):
                touch = self.alarm.add(judged, 0.25)
                if touch is not None:
                    yield float(time), touch
        self.now += float(recording.time[-1]) + PAUSE


@dataclass(frozen=True)
class Found:
    """What was found on one arm.

    Attributes:
        false: alarms without a touch.  hours: judged in it, after learning.
        delays: by size, s until each touch was noticed; infinite if it was not.
    """

    false: int
    hours: float
    delays: dict[float, list[float]]


def planned_touches(model: Model, cycle: float, seed: int) -> list[Planned]:
    """Return touches of every size on every joint in turn."""
    random = np.random.default_rng(seed)
    rms = np.sqrt(np.mean(model.data.tau**2, axis=0))
    begins = np.arange(3.0, cycle - 2.0, APART)
    return [
        Planned(
            float(begin + random.uniform(0.0, 0.5)),
            k % 6,
            float(random.choice([-1.0, 1.0]) * SIZES[(k + k // 6) % len(SIZES)] * rms[k % 6]),
        )
        for k, begin in enumerate(begins)
    ]


def measure(arm: SimulatedArm, minutes: float, *, new_motion: bool) -> Found:
    """Identify a model of an arm, watch its normal motion, then touch it."""
    work = arm.run(0, [])
    settings = Settings(train=1.0)
    model = identify(condition(arm.recording(work, 0)), settings).model
    watched, false = Watched(model), 0
    cycles = max(1, round((60.0 * minutes + LEARNING + SETTLING) / arm.cycle))
    for k in range(1, cycles + 1):
        run = arm.run(k, []) if new_motion else work
        false += sum(1 for _ in watched.watch(arm.recording(run, k)))
    hours = max(watched.alarm.judged - LEARNING - SETTLING, 0.0) / 3600.0
    delays: dict[float, list[float]] = {size: [] for size in SIZES}
    rms = np.sqrt(np.mean(model.data.tau**2, axis=0))
    planned = planned_touches(model, arm.cycle, arm.seed)
    touched = arm.recording(arm.run(0, planned), cycles + 1)
    seen = [when for when, _ in watched.watch(touched)]
    for one in planned:
        size = min(SIZES, key=lambda s: abs(s - abs(one.torque) / rms[one.joint]))
        after = [when - one.begin for when in seen if one.begin <= when < one.begin + LONG]
        delays[size].append(min(after, default=np.inf))
    return Found(false, hours, delays)


def main() -> None:
    """Measure some arms and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--arms", type=int, default=4)
    parser.add_argument("--first", type=int, default=0, help="number of the first arm")
    parser.add_argument("--minutes", type=float, default=5.0, help="of normal motion, each arm")
    parser.add_argument("--cycle", type=float, default=60.0, help="s of an arm's work")
    parser.add_argument("--new-motion", action="store_true", help="no motion comes twice")
    parser.add_argument("--plain", action="store_true", help="the usual arm, without nuisances")
    given = parser.parse_args()
    every = []
    for seed in range(given.first, given.first + given.arms):
        arm = SimulatedArm(seed, given.cycle, plain=given.plain)
        every.append(measure(arm, given.minutes, new_motion=given.new_motion))
        print(f"arm {seed}: {said([every[-1]])}", flush=True)
    print(f"all: {said(every)}")


def said(every: list[Found]) -> str:
    """Return the figures of some arms."""
    words = [f"{sum(f.false for f in every)} false in {sum(f.hours for f in every):.2f} h"]
    for size in SIZES:
        delays = np.array([delay for found in every for delay in found.delays[size]])
        noticed = delays[np.isfinite(delays)]
        middle = f", median {1e3 * np.median(noticed):.0f} ms" if len(noticed) else ""
        in_time = int((noticed <= IN_TIME).sum())
        words.append(f"{size:.0%}: {in_time} of {len(delays)} in time, {len(noticed)} ever{middle}")
    return "; ".join(words)


if __name__ == "__main__":
    main()
