"""Recordings of a simulated arm that hides an effect, to try the workbench with."""

from pathlib import Path

from lagrangian_ff.cli.common.console import progress_bar

HIDDEN = (
    "quadratic_drag@joint_2:0.2",
    "stribeck@joint_3:0.15",
    "load_friction@joint_2:0.15",
    "position_friction@joint_1:0.2",
    "ripple@joint_2:0.1",
    "pitting@joint_2:0.2",
)
"""By seed; the last is in no catalogue."""
MOTIONS = {
    "first motion": (6, 0, 60.0),
    "second motion": (4, 1, 30.0),
    "third motion": (4, 2, 30.0),
}
"""Speed, seed and s of each recording; the first goes where the others go."""


def hidden_by(seed: int) -> tuple[str, ...]:
    """Return what the arm of a seed hides, as `simulate --hidden` names it."""
    return (HIDDEN[seed % len(HIDDEN)],)


def record(folder: Path, seed: int) -> list[Path]:
    """Write the recordings below a folder, and return them.

    Raises:
        ArmError: PyBullet is missing.
    """
    from lagrangian_ff.arm import exciting_trajectory, simulate
    from lagrangian_ff.arm.hiding import hidden, wanted
    from lagrangian_ff.progress import part
    from lagrangian_ff.recording import write_bag

    place = folder / "arm"
    place.mkdir(exist_ok=True)
    made = []
    asked = wanted(hidden_by(seed))
    with progress_bar("moving the simulated arm") as progress:
        for number, (name, (speed, motion, seconds)) in enumerate(MOTIONS.items()):
            reported = part(progress, number / len(MOTIONS), (number + 1) / len(MOTIONS))
            inside = hidden(asked, motion, part(reported, 0.0, 0.3))
            path = exciting_trajectory(speed, seed=motion, duration=seconds)
            done = simulate(path, **inside.arm, seed=motion, progress=part(reported, 0.3, 1.0))
            made.append(write_bag(place / name, done.recording))
    return made
