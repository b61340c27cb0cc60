"""The nuisances of an arm: drawn at random, most arms have several."""

from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from lagrangian_ff.arm import JOINTS, MOTIONS, ArmParameters, Driver, fine, limits
from lagrangian_ff.arm.hidden import Installed, gears
from lagrangian_ff.arrays import Floats
from lagrangian_ff.studies.hidden.verdicts import Truth

TYPICAL = np.array([6.0, 16.0, 10.0, 1.2, 1.2, 0.25])
"""N·m: the RMS torque of each joint of the arm, about."""
SECONDS = 8.0, 60.0
REST = 0.1, 0.4
PACE = 0.2, 0.6
"""Largest velocity over its limit."""
RATE = 90.0, 5000.0
GAIN = 0.15
"""Largest relative error of a drive gain."""
MASSES = 0.3
"""Largest relative error of a link's mass and inertia against those described."""
FRICTION = 0.4, 2.0
"""Coulomb and viscous friction over the usual one."""

CHANCES: Mapping[str, float] = {
    "rest": 0.6,
    "presliding": 0.5,
    "elasticity": 0.5,
    "load_friction": 0.5,
    "gains": 0.6,
    "quantised": 0.6,
    "coloured": 0.6,
    "delay": 0.5,
    "jitter": 0.5,
    "lost": 0.4,
    "without_gravity": 0.1,
}
"""How many arms have each nuisance; all that move from point to point rest."""

NAMES: Mapping[str, tuple[str, ...]] = {
    "presliding": ("hysteresis",),
    "elasticity": ("elasticity",),
    "load_friction": ("load_friction", "load_viscous"),
    "delay": ("delay",),
    "gains": ("torque_gain",),
}
"""What a diagnosis may call a nuisance, on any joint; the others have no right name."""


@dataclass(frozen=True)
class Nuisances:
    """All that is drawn for one arm, its motions and its driver; a nuisance that is absent is 0.

    Attributes:
        motion: kind of both motions.  seconds: their length, about.
        rest: share of the time at rest.  pace: largest velocity over its limit.
        masses, friction: by joint, over the usual ones.
        presliding: share of the Coulomb friction that bristles give.
        distance: rad, by joint, over which they bend.
        elasticity: rad by which a typical torque twists the gears.
        load_friction: friction over load, by joint.
        rate: Hz.
        gains: reported over true effort, by joint.
        quantised: bits that the torque's range is resolved in.
        white: noise of each sample over that of the usual current sensor.
        coloured: noise over the typical torque.  memory: s of it.
        delay: s of the effort after the position.
        position_step: rad.
        jitter: s, mean lateness of stamps.
        lost: share of samples.  burst: mean number of neighbours lost together.
        without_gravity: 1 if the driver takes gravity off the effort, or 0.
    """

    motion: str
    seconds: float
    rest: float
    pace: float
    masses: tuple[float, ...]
    friction: tuple[float, ...]
    presliding: float
    distance: tuple[float, ...]
    elasticity: float
    load_friction: tuple[float, ...]
    rate: float
    gains: tuple[float, ...]
    quantised: int
    white: float
    coloured: float
    memory: float
    delay: float
    position_step: float
    jitter: float
    lost: float
    burst: float
    without_gravity: int

    @classmethod
    def draw(cls, seed: int) -> "Nuisances":
        """Draw the nuisances of an arm, the same for the same seed."""
        random = np.random.default_rng(seed)
        has = {name: bool(random.uniform() < chance) for name, chance in CHANCES.items()}
        motion = MOTIONS[int(random.integers(len(MOTIONS)))]
        has["rest"] |= motion == "point-to-point"
        rate = _log(random, *RATE)
        return cls(
            motion=motion,
            seconds=random.uniform(*SECONDS),
            rest=random.uniform(*REST) * has["rest"],
            pace=random.uniform(*PACE),
            masses=_each(random, 1.0 - MASSES, 1.0 + MASSES),
            friction=_each(random, *FRICTION),
            presliding=random.uniform(0.3, 1.0) * has["presliding"],
            distance=_each(random, 0.7, 1.4, _log(random, 1e-3, 6e-3)),
            elasticity=_log(random, 1e-4, 6e-4) * has["elasticity"],
            load_friction=_each(random, 0.7, 1.4, _log(random, 0.02, 0.1) * has["load_friction"]),
            rate=rate,
            gains=tuple(1.0 + GAIN * has["gains"] * g for g in _each(random, -1.0, 1.0)),
            quantised=int(random.integers(10, 14)) * has["quantised"],
            white=random.uniform(0.3, 2.0),
            coloured=_log(random, 0.003, 0.03) * has["coloured"],
            memory=_log(random, 0.002, 0.1),
            delay=random.uniform(5e-4, 1e-2) * has["delay"],
            position_step=_log(random, 5e-6, 1e-4),
            jitter=min(_log(random, 1e-5, 2e-3), 0.3 / rate) * has["jitter"],
            lost=_log(random, 0.001, 0.1) * has["lost"],
            burst=_log(random, 1.0, 10.0),
            without_gravity=int(has["without_gravity"]),
        )

    @property
    def present(self) -> dict[str, bool]:
        """Return of each of `CHANCES` whether the arm has it."""
        return {
            **{name: bool(np.any(np.asarray(getattr(self, name)) != 0.0)) for name in CHANCES},
            "gains": any(gain != 1.0 for gain in self.gains),
        }

    @property
    def allowed(self) -> list[Truth]:
        """Return what may be named, and is no fault if it is not."""
        there = self.present
        return [Truth(names, JOINTS) for nuisance, names in NAMES.items() if there[nuisance]]

    @property
    def parameters(self) -> ArmParameters:
        """Return the arm; its bristles take their part from its Coulomb friction."""
        usual, friction = ArmParameters(), np.array(self.friction)
        dry = (1.0 - self.presliding) * friction * usual.coulomb
        return fine(
            ArmParameters(
                viscous=tuple(friction * usual.viscous), coulomb=tuple(dry), link_masses=self.masses
            )
        )

    def installed(self, stiff: Collection[int] = ()) -> list[Installed]:
        """Return the nuisances in all gears; those of joints in `stiff` are not elastic."""
        parts, parameters = [], self.parameters
        if self.presliding:
            slip = self.presliding * np.multiply(self.friction, ArmParameters().coulomb)
            parts.append(gears.presliding(slip, np.array(self.distance)))
        if any(self.load_friction):
            parts.append(gears.loaded_teeth(np.array(self.load_friction)))
        if self.elasticity:
            parts.append(gears.soft_gears(TYPICAL / self.elasticity, parameters, stiff))
        return parts

    @property
    def driver(self) -> Driver:
        """Return the driver that reports the arm's motion."""
        usual = ArmParameters()
        noise: Floats = self.white * np.asarray(usual.current_noise) * usual.torque_per_ampere
        step = 2.0 * limits().effort / 2**self.quantised if self.quantised else 0.0 * TYPICAL
        return Driver(
            rate=self.rate,
            gains=self.gains,
            delay=self.delay,
            white=tuple(noise),
            coloured=tuple(self.coloured * TYPICAL),
            memory=self.memory,
            effort_step=tuple(step),
            position_step=self.position_step,
            jitter=self.jitter,
            lost=self.lost,
            burst=self.burst,
            gravity=not self.without_gravity,
        )

    def record(self) -> dict[str, Any]:
        """Return them as JSON holds them."""
        return asdict(self)

    @classmethod
    def of(cls, record: Mapping[str, Any]) -> "Nuisances":
        """Return the nuisances of a record."""
        held: dict[str, Any] = {
            k: tuple(v) if isinstance(v, list) else v for k, v in record.items()
        }
        return cls(**held)


def _log(random: np.random.Generator, low: float, high: float) -> float:
    """Draw a number whose logarithm is uniform."""
    return float(low * (high / low) ** random.uniform())


def _each(
    random: np.random.Generator, low: float, high: float, unit: float = 1.0
) -> tuple[float, ...]:
    """Draw a number for each joint."""
    return tuple((unit * random.uniform(low, high, size=len(JOINTS))).tolist())
