"""Losses and ripple that follow the torque through the gear."""

from math import cos, pi

from lagrangian_ff.arm.hidden.base import Installed, OneJoint, Site, dry
from lagrangian_ff.arm.joint_effect import JointMoment


class LoadedTeeth(OneJoint):
    """Teeth pressed together by the load rub: μ |load| sign(v), or μ |load| v in the lubricant.

    The load is the torque that went on into the links in the step before (Wernholt and
    Gunnarsson; Hamon et al., IROS 2010, for friction that is proportional to load).
    """

    def __init__(self, joint: int, share: float, *, viscous: bool) -> None:
        super().__init__(joint)
        self._share, self._viscous = share, viscous

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        pressed = self._share * abs(float(moment.load[self.joint]))
        chord = pressed if self._viscous else pressed * dry(v)[1]
        return chord * v, chord


def load_friction(site: Site, strength: float) -> Installed:
    """Of strength times the load."""
    return Installed(
        (LoadedTeeth(site.joint, strength, viscous=False),), facts={"share of load": strength}
    )


def load_viscous(site: Site, strength: float) -> Installed:
    """Of strength s/rad times the load."""
    return Installed(
        (LoadedTeeth(site.joint, strength, viscous=True),),
        facts={"share of load [s/rad]": strength},
    )


class Ripple(OneJoint):
    """Teeth or poles k times a turn of the joint: A cos(k q + phase), A constant or A |load|.

    Cogging of poles against slots is there without load; the error of meshing teeth scales with
    the torque they carry (Tuttle and Seering, IEEE Trans. Robotics and Automation 12, 1996).
    """

    def __init__(
        self, joint: int, height: float, harmonic: int, phase: float, *, loaded: bool
    ) -> None:
        super().__init__(joint)
        self._height, self._harmonic, self._phase = height, harmonic, phase
        self._loaded = loaded

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        wave = cos(self._harmonic * float(moment.q[self.joint]) + self._phase)
        carried = abs(float(moment.load[self.joint])) if self._loaded else 1.0
        return self._height * carried * wave, 0.0


def _ripple(site: Site, strength: float, *, loaded: bool) -> Installed:
    random = site.random
    # Spread evenly over the ratios, 5 to 17 times a turn.
    harmonic = round(5.0 * (17.0 / 5.0) ** random.uniform())
    phase = random.uniform(0.0, 2.0 * pi)
    facts = {
        "height, of the load" if loaded else "height [N·m]": strength,
        "times a turn": float(harmonic),
        "phase [rad]": phase,
    }
    return Installed((Ripple(site.joint, strength, harmonic, phase, loaded=loaded),), facts=facts)


def ripple(site: Site, strength: float) -> Installed:
    """Of strength N·m."""
    return _ripple(site, strength, loaded=False)


def gear_mesh(site: Site, strength: float) -> Installed:
    """Of strength times the load."""
    return _ripple(site, strength, loaded=True)
