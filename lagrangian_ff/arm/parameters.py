"""The parameters of the drives, the sensors and the servo."""

from dataclasses import dataclass, fields

import numpy as np

from lagrangian_ff.arm.description import JOINTS
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ArmError

PerJoint = tuple[float, ...]


@dataclass(frozen=True)
class ArmParameters:
    """Drives of DC motors behind high gears, their servo and sensors; one value a joint.

    Motor quantities are on the motor's side of the gear, the others on the link's.

    Attributes:
        gear_ratio: turns of the motor in a turn of the joint.
        rotor_inertia: kg·m², of rotor and gear input; gear_ratio² times it adds to the joint.
        torque_constant: N·m/A, and V·s/rad of back-EMF.
        resistance: Ω of the winding.  inductance: H of the winding.
        viscous: N·m·s/rad.  coulomb: N·m.
        coulomb_velocity: rad/s, where the smoothed sign tanh(qd / coulomb_velocity) turns over.
        stiffness: N·m/rad of the position loop (P).  damping: N·m·s/rad (D).
        current_bandwidth: rad/s of the closed current loop; its PI gains follow from it.
        encoder_counts: in a turn of the motor.
        current_noise: A, standard deviation of a current sample.
        velocity_measured: whether the driver reports the difference quotient of its encoder;
            if not, it reports NaN.
        link_masses: mass and inertia of each link, relative to those described in the URDF.
        physics_rate, current_rate, position_rate, sample_rate: Hz of the integration of the
            links, the PI current loop, the PD position loop and the measurements.
    """

    gear_ratio: PerJoint = (160.0, 160.0, 140.0, 120.0, 100.0, 100.0)
    rotor_inertia: PerJoint = (5.4e-5, 5.4e-5, 1.4e-5, 7.0e-6, 3.3e-6, 3.3e-6)
    torque_constant: PerJoint = (0.0385, 0.0385, 0.0302, 0.0295, 0.0259, 0.0259)
    resistance: PerJoint = (0.10, 0.10, 0.30, 0.58, 0.61, 0.61)
    inductance: PerJoint = (7.0e-5, 7.0e-5, 8.0e-5, 1.9e-4, 1.2e-4, 1.2e-4)
    viscous: PerJoint = (2.5, 6.5, 3.0, 0.35, 0.30, 0.10)
    coulomb: PerJoint = (3.0, 9.0, 4.5, 0.55, 0.60, 0.15)
    coulomb_velocity: PerJoint = (0.02,) * 6
    stiffness: PerJoint = (700.0, 900.0, 380.0, 90.0, 50.0, 25.0)
    damping: PerJoint = (63.0, 83.0, 24.0, 5.0, 2.4, 1.5)
    current_bandwidth: float = 2000.0
    encoder_counts: int = 2048
    current_noise: PerJoint = (0.12, 0.12, 0.09, 0.04, 0.035, 0.025)
    velocity_measured: bool = True
    link_masses: PerJoint = (1.0,) * 6
    physics_rate: int = 1000
    current_rate: int = 10_000
    position_rate: int = 250
    sample_rate: int = 500

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, tuple) and len(value) != len(JOINTS):
                raise ArmError(
                    f"{field.name}: expected {len(JOINTS)} values, one a joint, got {len(value)}"
                )
            least = 0.0 if field.name in _MAY_BE_ZERO else np.nextafter(0.0, 1.0)
            if not np.all(np.isfinite(value)) or np.any(np.asarray(value) < least):
                bound = "not negative" if least == 0.0 else "positive"
                raise ArmError(f"{field.name}: expected {bound} finite values, got {value}")
        for fast, slow in (
            ("current_rate", "physics_rate"),
            ("physics_rate", "sample_rate"),
            ("sample_rate", "position_rate"),
        ):
            if getattr(self, fast) % getattr(self, slow):
                raise ArmError(
                    f"{fast} ({getattr(self, fast)} Hz) must be a multiple of "
                    f"{slow} ({getattr(self, slow)} Hz)"
                )

    @property
    def tick(self) -> float:
        """Return the time between two measurements, s."""
        return 1.0 / self.sample_rate

    @property
    def reflected_inertia(self) -> Floats:
        """Return (6,) kg·m², the rotors' inertia at the joints: g²J."""
        return np.square(self.gear_ratio) * np.asarray(self.rotor_inertia)

    @property
    def torque_per_ampere(self) -> Floats:
        """Return (6,) N·m/A at the joint."""
        return np.multiply(self.gear_ratio, self.torque_constant)

    @property
    def encoder_step(self) -> Floats:
        """Return (6,) rad of the joint between two counts."""
        return 2.0 * np.pi / (self.encoder_counts * np.asarray(self.gear_ratio))


_MAY_BE_ZERO = {
    "rotor_inertia",
    "viscous",
    "coulomb",
    "stiffness",
    "damping",
    "current_noise",
    "velocity_measured",
}
