"""The motion to record next, as work of its own process."""

from dataclasses import dataclass
from pathlib import Path

from lagrangian_ff.progress import Progress
from lagrangian_ff.workbench.jobs import Record, load_model

DRAWN = 300
"""Points of a motion that its picture has, at most."""


@dataclass(frozen=True)
class Move:
    """Make the motion that shows an effect, within what a model has seen.

    Attributes:
        output: the trajectory to write, a CSV.
        model: its file.
        effect: the one to be shown.
        joint: the one to look at; empty for all.
        effects: the file of the user's formulas; empty for none.
    """

    output: str
    model: str
    effect: str
    joint: str = ""
    effects: str = ""

    def work(self, progress: Progress) -> Record:
        """Write the trajectory; return what it is, what to do, and its picture."""
        from lagrangian_ff.arm import Trajectory, write_trajectory
        from lagrangian_ff.diagnosis.excite import NEXT_MOTIONS, Limits, excite, seen_pose
        from lagrangian_ff.effects import EFFECTS

        progress(0.0, "finding a motion within limits")
        model = load_model(self.model, self.effects)
        name, joint = EFFECTS[self.effect].motion, self.joint or None
        limits = Limits.within(model.range, model.joints)
        pose = seen_pose(model, joint, limits)
        found = excite(name, model.joints, limits, joint=joint, start=pose)
        trajectory = Trajectory(found.time, found.q, found.qd, found.qdd, model.joints)
        write_trajectory(Path(self.output), trajectory)
        every = max(1, len(found.time) // DRAWN)
        return {
            "motion": name,
            "meaning": NEXT_MOTIONS[name].meaning,
            "by_hand": NEXT_MOTIONS[name].by_hand,
            "joints": list(model.joints),
            "seconds": float(found.time[-1]),
            "start": found.q[0].tolist(),
            "time": found.time[::every].tolist(),
            "q": found.q[::every].T.round(4).tolist(),
        }
