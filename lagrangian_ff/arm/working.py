"""Motions as arms make them at work and in tests: with rests, slow or fast, short or long."""

from contextlib import ExitStack, closing

import numpy as np

from lagrangian_ff.arm.body import Surroundings
from lagrangian_ff.arm.description import HOME, JOINTS, limits
from lagrangian_ff.arm.exciting import (
    GRID,
    MARGIN,
    SPEEDS,
    exciting_trajectory,
    failed_checks,
    usable_range,
)
from lagrangian_ff.arm.parameters import ArmParameters
from lagrangian_ff.arm.plant import Plant
from lagrangian_ff.arm.trajectory import Trajectory
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ArmError

MOTIONS = ("point-to-point", "fourier", "spline")
MOVES = 0.8
"""Probability that a joint takes part in a move from point to point."""
HARMONICS = 5
BASE = (0.2, 0.4)
"""Hz of the lowest harmonic at a pace of 1."""
BLEND = 0.3
"""s in which a motion that pauses comes to rest, and in which it goes on."""
PAUSE = 2.0
"""s, the usual pause."""
REPAIRS = 200


def working_motion(
    kind: str,
    seconds: float,
    rest: float,
    pace: float,
    seed: int,
    parameters: ArmParameters | None = None,
) -> Trajectory:
    """Return a motion of the arm at work, within its limits and free of collision.

    Args:
        kind: "point-to-point": moves from pose to pose, all joints in step, some joints not taking
            part; trapezoids or quintics over time, and stops of random length. "fourier": five
            harmonics a joint (Swevers et al., IEEE Trans. Robotics and Automation 13, 1997).
            "spline": see `exciting_trajectory`.
        seconds: its length, about.
        rest: share of the time in which all joints rest, 0 to 0.9; fourier and spline motions
            pause in the middle of the way.
        pace: largest velocity over its limit, about, 0.1 to 0.7.
        seed: the same arguments give the same motion.
        parameters: of the arm whose torque limits it keeps.

    Raises:
        ArmError: no such kind, or no admissible motion was found.
    """
    if kind not in MOTIONS:
        raise ArmError(f"motion: expected {', '.join(MOTIONS)}, got {kind!r}")
    random = np.random.default_rng([seed, MOTIONS.index(kind)])
    moving = seconds * (1.0 - rest)
    with ExitStack() as stack:
        check = _Check(
            stack.enter_context(closing(Plant(parameters))),
            stack.enter_context(Surroundings(margin=MARGIN)),
        )
        if kind == "point-to-point":
            return _point_to_point(moving, seconds - moving, pace, random, check)
        for _ in range(REPAIRS):
            if kind == "spline":
                speed = int(np.clip(round(pace * SPEEDS[-1]), SPEEDS[0], SPEEDS[-1]))
                path = exciting_trajectory(speed, int(random.integers(2**31)), moving)
            else:
                path = _fourier(moving, pace, random)
            if check.passes(path):
                return _with_pauses(path, seconds - moving, random)
    raise ArmError(f"no admissible {kind} motion of {seconds:g} s was found from seed {seed}")


class _Check:
    """The limits of the arm and its distance from itself and the floor."""

    def __init__(self, plant: Plant, surroundings: Surroundings) -> None:
        self._plant, self._surroundings = plant, surroundings

    def passes(self, path: Trajectory) -> bool:
        return not len(failed_checks(path, [self._plant], self._surroundings))


def _point_to_point(
    moving: float, resting: float, pace: float, random: np.random.Generator, check: _Check
) -> Trajectory:
    trapezoid = bool(random.integers(2))
    low, high = usable_range()
    q, moves, spent = np.array(HOME), [], 0.0
    while spent < moving:
        for _ in range(REPAIRS):
            goal = np.where(random.uniform(size=len(q)) < MOVES, random.uniform(low, high), q)
            seconds = max(0.5, 1.6 * float(np.max(np.abs(goal - q) / (pace * limits().velocity))))
            move = _move(q, goal, seconds, trapezoid)
            if np.any(goal != q) and check.passes(move):
                break
        else:
            raise ArmError("no admissible move from point to point was found")
        moves.append(move)
        q, spent = goal, spent + move.duration
    stops = resting * random.dirichlet(np.full(len(moves) + 1, 2.0))
    return _joined(moves, stops)


def _move(start: Floats, goal: Floats, seconds: float, trapezoid: bool) -> Trajectory:
    """Return a move from rest to rest: a quintic over time, or a trapezoid of velocity."""
    time: Floats = GRID * np.arange(max(2, round(seconds / GRID)) + 1, dtype=np.float64)
    s = time / time[-1]
    if trapezoid:
        # Velocity rises and falls over a quarter of the time, as a cubic: qdd is continuous.
        ramp, top = 0.25, 1.0 / 0.75
        place = [_run_up(x, ramp) for x in (s, s[::-1])]
        along = np.where(s < 0.5, top * place[0][0], 1.0 - top * place[1][0])
        pace = top * np.minimum(place[0][1], place[1][1])
        push = top * (place[0][2] - place[1][2])
    else:
        along = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        pace = 30.0 * s**2 * (1.0 - s) ** 2
        push = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)
    way = goal - start
    rates = [along, pace / time[-1], push / time[-1] ** 2]
    q, qd, qdd = (rate[:, None] * way for rate in rates)
    return Trajectory(time, start + q, qd, qdd)


def _run_up(x: Floats, ramp: float) -> tuple[Floats, Floats, Floats]:
    """Return way, velocity and acceleration of a velocity that rises to 1 over a ramp, and stays.

    It rises as 3 u² - 2 u³ with u = x / ramp.
    """
    u = np.clip(x / ramp, 0.0, 1.0)
    way = ramp * (u**3 - 0.5 * u**4) + np.maximum(x - ramp, 0.0)
    return way, u**2 * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / ramp


def _joined(moves: list[Trajectory], stops: Floats) -> Trajectory:
    """Return moves after each other, with a stop of some s before each and at the end."""
    times, rows, now = [], [], 0.0
    for move, stop in zip(moves, stops[:-1], strict=True):
        now += round(stop / GRID) * GRID + GRID
        times.append(now + move.time)
        rows.append((move.q, move.qd, move.qdd))
        now = float(times[-1][-1])
    end = now + round(stops[-1] / GRID) * GRID + GRID
    still = np.zeros((1, len(JOINTS)))
    first, last = moves[0].q[:1], moves[-1].q[-1:]
    rows = [(first, still, still), *rows, (last, still, still)]
    q, qd, qdd = (np.concatenate(column) for column in zip(*rows, strict=True))
    return Trajectory(np.concatenate([[0.0], *times, [end]]), q, qd, qdd)


def _fourier(seconds: float, share: float, random: np.random.Generator) -> Trajectory:
    """Return harmonics about a pose, swelling from rest within a second and fading to rest."""
    time: Floats = GRID * np.arange(round(seconds / GRID) + 1, dtype=np.float64)
    low, high = usable_range()
    middle = np.array(HOME) + 0.2 * random.uniform(low - HOME, high - np.array(HOME))
    pace = 2.0 * np.pi * share * random.uniform(*BASE) * np.arange(1, HARMONICS + 1)
    size = (
        random.normal(size=(2, HARMONICS, len(JOINTS)))
        / np.sqrt(np.arange(1, HARMONICS + 1))[:, None]
    )
    wave = np.stack([np.sin(pace * time[:, None]), np.cos(pace * time[:, None])])
    turned = np.stack([wave[1], -wave[0]])
    swing, swing_d, swing_dd = (
        np.einsum("atk,akj->tj", part, size) for part in (wave, pace * turned, -(pace**2) * wave)
    )
    up, rate, rate_d = (part[:, None] for part in _envelope(time, 1.5))
    q = up * swing
    qd = rate * swing + up * swing_d
    qdd = rate_d * swing + 2.0 * rate * swing_d + up * swing_dd
    room = np.minimum(high - middle, middle - low) * random.uniform(0.5, 1.0, size=len(JOINTS))
    speed = share * limits().velocity
    scale = np.minimum(room / np.abs(q).max(axis=0), speed / np.abs(qd).max(axis=0))
    return Trajectory(time, middle + scale * q, scale * qd, scale * qdd)


def _envelope(time: Floats, ramp: float) -> tuple[Floats, Floats, Floats]:
    """Return a quintic rise from 0 to 1 within `ramp` s, the fall at the end, and derivatives."""
    begins, ends = (np.clip(x / ramp, 0.0, 1.0) for x in (time, time[-1] - time))
    s = np.minimum(begins, ends)
    way = np.where(begins < ends, 1.0, -1.0) / ramp
    value = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    rate = way * 30.0 * s**2 * (1.0 - s) ** 2
    return value, rate, 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / ramp**2


def _with_pauses(path: Trajectory, resting: float, random: np.random.Generator) -> Trajectory:
    """Return the same way over another time, at rest for a while at some places of it.

    With s the time along the path, q(t) = p(s(t)), qd = p' ds/dt, qdd = p'' (ds/dt)² + p' d²s/dt².
    """
    count = round(resting / PAUSE)
    if not count:
        return path
    pauses = resting * random.dirichlet(np.full(count, 4.0))
    # Each stop takes BLEND of the path, half of it to come to rest.
    free = path.duration - count * BLEND
    places = np.sort(random.uniform(0.05, 0.95, size=count)) * free
    rows, s, now = [(0.0, 0.0, 1.0, 0.0)], 0.0, 0.0
    for place, pause in zip(np.diff([0.0, *places]), pauses, strict=True):
        run = round(place / GRID)
        steps = GRID * np.arange(1, run + 1)
        rows += [(now + x, s + x, 1.0, 0.0) for x in steps]
        now, s = rows[-1][0], rows[-1][1]
        x = np.arange(GRID, BLEND + 0.5 * GRID, GRID)
        way, rate, push = (part * 1.0 for part in _run_up(x, BLEND))
        back, falling, slowing = _run_up(BLEND - x, BLEND)
        half = 0.5 * BLEND
        rows += list(zip(now + x, s + half - back, falling, -slowing, strict=True))
        held = now + BLEND + pause
        rows += [(held, s + half, 0.0, 0.0)]
        rows += list(zip(held + x, s + half + way, rate, push, strict=True))
        now, s = rows[-1][0], rows[-1][1]
    left = np.arange(GRID, path.duration - s + 0.5 * GRID, GRID)
    rows += [(now + x, s + x, 1.0, 0.0) for x in left]
    time, along, pace, push = np.array(rows).T
    p, slope, bend = path.sample(np.minimum(path.time[0] + along, path.time[-1]))
    pace, push = pace[:, None], push[:, None]
    return Trajectory(time, p, slope * pace, bend * pace**2 + slope * push)
