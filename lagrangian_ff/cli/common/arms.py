"""The arms that the workbench may investigate: the simulated one, and a robot in the graph."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from lagrangian_ff.errors import UserError
from lagrangian_ff.workbench.investigating import Ready, Wanted

UNTIL_FAST = 0.4
"""s in which a joint of the simulated arm may reach its speed."""


@dataclass(frozen=True)
class SimulatedArm:
    """The simulated arm, faster than real time.

    Attributes:
        hidden: effects in it, as `simulate --hidden` names them.
        seed: of the noise.
    """

    hidden: tuple[str, ...]
    seed: int = 0
    real = False

    @contextmanager
    def opened(self, wanted: Wanted, folder: Path) -> Iterator[Ready]:
        """Give the arm.

        Raises:
            ArmError: PyBullet is missing.
        """
        from lagrangian_ff.arm.hiding import wanted as effects
        from lagrangian_ff.cli.common.arm_motion import arm_clear
        from lagrangian_ff.cli.common.simulated_rig import SimulatedRig, simulated_limits
        from lagrangian_ff.diagnosis.excite.clearance import MARGIN

        rig = SimulatedRig(effects(self.hidden), self.seed)
        with arm_clear(rig.joints, MARGIN) as clear:
            yield Ready(rig, simulated_limits(wanted.speed, UNTIL_FAST), clear)


@dataclass(frozen=True)
class RobotArm:
    """A robot that takes trajectories from a topic.

    Attributes:
        ros: arguments of ROS, such as remappings.
    """

    ros: tuple[str, ...]
    real = True

    @contextmanager
    def opened(self, wanted: Wanted, folder: Path) -> Iterator[Ready]:
        """Give the arm once it is heard of.

        Raises:
            UserError: it is not, nobody takes its motions, or it stands outside of the limits.
        """
        from lagrangian_ff.diagnosis.excite.excite import inside
        from lagrangian_ff.investigation.allowed import allowed
        from lagrangian_ff.nodes.attached.client import Client
        from lagrangian_ff.nodes.attached.rig import connected

        client, (urdf, limits) = Client(self.ros), _files(wanted)
        with connected(client, wanted.topic, (), urdf, limits, folder) as rig:
            within = allowed(rig.joints, urdf, limits, wanted.speed)
            start = rig.pose()
            inside("the pose of the arm", start, rig.joints, within)
            clear = None
            try:
                if urdf is not None:
                    from lagrangian_ff.diagnosis.excite import Clearance

                    clear = Clearance.of(urdf, rig.joints, start[None])
            except UserError:
                pass  # said in the question
            yield Ready(
                rig,
                within,
                clear,
                lambda: client.listeners(wanted.topic),
                rig.stop,
                lambda: rig.moving,
            )


def _files(wanted: Wanted) -> tuple[Path | None, Path | None]:
    return (
        Path(wanted.urdf) if wanted.urdf else None,
        Path(wanted.limits) if wanted.limits else None,
    )
