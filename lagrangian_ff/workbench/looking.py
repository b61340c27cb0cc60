"""What can be known of a recording before a model is learned, each in its own process."""

from dataclasses import dataclass, field
from typing import Any

from lagrangian_ff.progress import Progress, part
from lagrangian_ff.record_json import finite
from lagrangian_ff.workbench.settings import Reading, told

BINS = 24
Record = dict[str, Any]


@dataclass(frozen=True)
class Look:
    """Read the recording at `path`, and say what it holds and what is wrong with it.

    Attributes:
        reading: how it is read.
    """

    path: str
    reading: Reading = field(default_factory=Reading)

    def work(self, progress: Progress) -> Record:
        """Return the joints, their ranges and coverage, what was repaired, and the checks."""
        import numpy as np

        from lagrangian_ff.diagnosis.preflight import kind_checks
        from lagrangian_ff.identification import joint_order
        from lagrangian_ff.identification.settings import usual_model
        from lagrangian_ff.recording import inspect, load

        recording = load(self.path, progress=part(progress, 0.0, 0.4))
        inspection = inspect(recording)
        progress(0.5, "making it ready")
        (motion,) = self.reading.ready([self.path], [recording])
        order = joint_order([motion], usual_model(motion.effort), None, part(progress, 0.6, 0.8))
        progress(0.8, "looking at what the effort holds")
        checks = kind_checks(motion.select(order.joints))
        progress(1.0, "read")

        def spread(values: Any) -> list[int]:
            counts, _ = np.histogram(values, bins=BINS)
            return [int(count) for count in counts]

        joints = [
            {
                "name": name,
                "low": float(motion.q[:, n].min()),
                "high": float(motion.q[:, n].max()),
                "fastest": float(np.abs(motion.qd[:, n]).max()),
                "positions": spread(motion.q[:, n]),
                "speeds": spread(motion.qd[:, n]),
            }
            for n, name in enumerate(motion.joints)
        ]
        at_rest = float(np.mean(np.abs(motion.qd).max(axis=1) < 0.01))
        return finite({
            "seconds": float(motion.time[-1] - motion.time[0]),
            "rate": inspection.rate,
            "gaps": len(inspection.gaps),
            "rest": at_rest,
            "joints": joints,
            "order": list(order.joints),
            "notes": list(dict.fromkeys((*inspection.notes, *motion.notes))),
            "checks": [told(one) for one in checks],
        })  # fmt: skip


@dataclass(frozen=True)
class Observe:
    """Find out which effects the recording at `path` could show.

    Attributes:
        joints: from the base to the tool.
        reading: how it is read.
    """

    path: str
    joints: tuple[str, ...]
    reading: Reading = field(default_factory=Reading)

    def work(self, progress: Progress) -> Record:
        """Return the least size of each effect on each joint, and what cannot be seen."""
        from lagrangian_ff.diagnosis.observable import observability
        from lagrangian_ff.kernels.threads import one_blas_thread
        from lagrangian_ff.recording import load

        recording = load(self.path, progress=part(progress, 0.0, 0.2)).select(self.joints)
        (motion,) = self.reading.ready([self.path], [recording])
        with one_blas_thread():
            found = observability(motion, progress=part(progress, 0.3, 1.0))
        return {"joints": list(found.joints), **found.record()}
