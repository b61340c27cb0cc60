"""A trajectory as trajectory_msgs/JointTrajectory in YAML, through as few points as it needs."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lagrangian_ff.arm import Trajectory
    from lagrangian_ff.arrays import Ints

CLOSE = 5e-6
"""The largest error of the quintics between the points of a message, rad."""
_DIGITS = 7


def joint_trajectory_yaml(trajectory: "Trajectory", title: str) -> str:
    """Return the message as `ros2 topic pub` takes it; the title becomes a comment.

    Controllers that get positions, velocities and accelerations follow quintics between the
    points, so that long smooth parts need few.
    """
    lines = [f"# {title}", f"joint_names: [{', '.join(trajectory.joints)}]", "points:"]
    for k in _points(trajectory).tolist():
        nanoseconds = round((trajectory.time[k] - trajectory.time[0]) * 1e9)
        seconds, rest = divmod(nanoseconds, 1_000_000_000)
        for mark, label, values in (
            ("-", "positions", trajectory.q[k]),
            (" ", "velocities", trajectory.qd[k]),
            (" ", "accelerations", trajectory.qdd[k]),
        ):
            lines.append(f"{mark} {label}: [{', '.join(map(_number, values.tolist()))}]")
        lines.append(f"  time_from_start: {{sec: {seconds}, nanosec: {rest}}}")
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    text = f"{value:.{_DIGITS}g}" if abs(value) > 1e-9 else "0.0"
    # ROS takes 1 for a whole number and refuses it; YAML takes 1e-05 for a text.
    if "e" in text:
        text = f"{value:.12f}".rstrip("0")
    return text if "." in text else f"{text}.0"


def _points(trajectory: "Trajectory") -> "Ints":
    """Return (P,) the points to keep: pieces of the motion are halved until the quintics fit."""
    import numpy as np

    kept = [0]
    waiting = [(0, len(trajectory) - 1)] if len(trajectory) > 1 else []
    while waiting:
        first, last = waiting.pop()
        if last - first > 1 and not _fits(trajectory, first, last):
            middle = (first + last) // 2
            waiting += [(middle, last), (first, middle)]
        else:
            kept.append(last)
    return np.array(kept, dtype=np.int64)


def _fits(trajectory: "Trajectory", first: int, last: int) -> bool:
    import numpy as np

    from lagrangian_ff.arm import Trajectory

    ends, inner = [first, last], slice(first, last + 1)
    t = trajectory
    quintic = Trajectory(t.time[ends], t.q[ends], t.qd[ends], t.qdd[ends], t.joints)
    q, _, _ = quintic.sample(trajectory.time[inner])
    return bool(np.abs(q - trajectory.q[inner]).max() <= CLOSE)
