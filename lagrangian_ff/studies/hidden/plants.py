"""From a case to two recordings of its plant."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arm import JOINTS, Run, Trajectory, exciting_trajectory, simulate
from lagrangian_ff.arm.hidden import HIDDEN, Installed, Reference, Site, size, sized
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.studies.hidden.cases import Case, Hidden

Floats = NDArray[np.float64]

RECORDINGS = 2


@dataclass(frozen=True)
class Stretches:
    """What each recording is made of: (speed of the exciting trajectory, s) one after the other.

    The slow stretch shows what happens near rest, the fast one inertia and drag.
    """

    parts: tuple[tuple[int, float], ...] = ((2, 20.0), (6, 40.0))


FULL = Stretches()


def motion(pair: int, recording: int, stretches: Stretches = FULL) -> Trajectory:
    """The reference of one recording.

    Args:
        pair: which pair of motions.  recording: 0 or 1 of the pair.
        stretches: what it is made of.
    """
    seed = 100 + RECORDINGS * pair + recording
    parts = [exciting_trajectory(speed, seed, seconds) for speed, seconds in stretches.parts]
    return joined(parts)


def joined(parts: list[Trajectory]) -> Trajectory:
    """Motions one after the other, each at rest where the next begins."""
    time, columns, begin = [], [], 0.0
    for k, part in enumerate(parts):
        rows = slice(1 if k else 0, None)
        time.append(begin + part.time[rows] - part.time[0])
        columns.append((part.q[rows], part.qd[rows], part.qdd[rows]))
        begin = float(time[-1][-1])
    q, qd, qdd = (np.concatenate(column) for column in zip(*columns, strict=True))
    return Trajectory(np.concatenate(time), q, qd, qdd)


def record(
    case: Case, folder: Path, stretches: Stretches = FULL, progress: Progress = silent
) -> tuple[Recording, Recording, dict[str, Any]]:
    """Hide the case's effects in the arm and record it twice.

    Args:
        case: what is hidden.
        folder: where runs of the arm without effects are kept between cases.
        stretches: what the recordings are made of.
        progress: told the fraction done.

    Returns:
        Both recordings, and what is known of the plant: the case itself, and for each hidden
        effect its facts, the size wanted, the size `reached` in each recording, and how much of
        it is `visible`: what friction of the joint's own kind (viscous, Coulomb, constant) cannot
        stand in for.
    """
    along = _along(case.motion, folder, stretches) if case.hidden else None
    runs, reached = [], []
    facts: list[dict[str, float]] = []
    strengths: list[float] = []
    for number in range(RECORDINGS):
        # One arm: both recordings are of what was built and sized along the first motion.
        sites = [
            Site(JOINTS.index(hidden.joint), case.seed + 7919 * n, number, along)
            for n, hidden in enumerate(case.hidden)
            if along is not None
        ]
        placed = list(zip(case.hidden, sites, strict=True))
        strengths = strengths or [
            sized(hidden.kind, site, hidden.size)[1] for hidden, site in placed
        ]
        parts = [
            hidden.kind.install(site, strength)
            for (hidden, site), strength in zip(placed, strengths, strict=True)
        ]
        done = _simulate(case, number, parts, stretches, _part(progress, number))
        facts = facts or [dict(part.facts) for part in parts]
        runs.append(done)
        reached.append(
            [
                _measured(hidden, part, site, done)
                for (hidden, site), part in zip(placed, parts, strict=True)
            ]
        )
    info = {
        **asdict(case),
        "group": case.group,
        "hidden": [
            {
                **asdict(hidden),
                "catalogue": list(hidden.kind.catalogue),
                "joints": [JOINTS[j] for j in hidden.kind.acts_on(JOINTS.index(hidden.joint))],
                "absorbed": hidden.kind.absorbed,
                "physics": hidden.kind.physics,
                "strength": strengths[n],
                "facts": facts[n],
                "reached": [row[n][0] for row in reached],
                "visible": [row[n][1] for row in reached],
            }
            for n, hidden in enumerate(case.hidden)
        ],
        "saturated": [float(run.saturated.mean()) for run in runs],
        "tracking_rms": [float(np.sqrt(np.mean(run.tracking_error**2))) for run in runs],
        "torque_rms": [np.sqrt(np.mean(run.motor_torque**2, axis=0)).tolist() for run in runs],
    }
    return runs[0].recording, runs[1].recording, info


def _along(pair: int, folder: Path, stretches: Stretches) -> Reference:
    """The run of the first motion without effects, from the folder or made and kept there."""
    name = "_".join(f"{speed}x{seconds:g}" for speed, seconds in stretches.parts)
    path = folder / "motions" / f"{pair}_{name}.npz"
    if not path.is_file():
        reference = Reference.of(simulate(motion(pair, 0, stretches)))
        path.parent.mkdir(parents=True, exist_ok=True)
        # Several processes may make it at once: each whole, the last one stays.
        part = path.with_name(f"{path.stem}.{np.random.default_rng().integers(2**62)}.part")
        with part.open("wb") as file:
            np.savez(file, **vars(reference))
        part.replace(path)
    with np.load(path, allow_pickle=False) as held:
        return Reference(**{key: held[key] for key in held})


def _simulate(
    case: Case, number: int, parts: list[Installed], stretches: Stretches, progress: Progress
) -> Run:
    attached = [part.attached for part in parts if part.attached is not None]
    return simulate(
        motion(case.motion, number, stretches),
        effects=[effect for part in parts for effect in part.effects],
        sensors=[sensor for part in parts for sensor in part.sensors],
        gears=[gear for part in parts for gear in part.gears],
        attached=attached[0] if attached else None,
        seed=case.seed + number,
        progress=progress,
    )


def _measured(hidden: Hidden, part: Installed, site: Site, run: Run) -> tuple[float, float]:
    """The size of an effect in a run, and the size of what is left of it beside plain friction."""
    here = Site(site.joint, site.seed, site.recording, Reference.of(run))
    torque = HIDDEN[hidden.effect].torque(part, here)[:, site.joint]
    v = run.velocity[:, site.joint]
    plain = np.stack([v, np.tanh(v / 0.02), np.ones_like(v)], axis=1)
    left = torque - plain @ np.linalg.lstsq(plain, torque, rcond=None)[0]
    whole = np.sqrt(np.mean(run.motor_torque[:, site.joint] ** 2))
    return size(hidden.kind, part, here), float(np.sqrt(np.mean(left**2)) / whole)


def _part(progress: Progress, number: int) -> Callable[[float, str], None]:
    return lambda fraction, label: progress((number + fraction) / RECORDINGS, label)
