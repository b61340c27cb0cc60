"""Every effect by its name, and the groups that have a name of their own."""

from lagrangian_ff.effects.asymmetric_coulomb import AsymmetricCoulomb
from lagrangian_ff.effects.asymmetric_viscous import AsymmetricViscous
from lagrangian_ff.effects.backlash import Backlash
from lagrangian_ff.effects.base import Effect
from lagrangian_ff.effects.contact import Contact
from lagrangian_ff.effects.coulomb import Coulomb
from lagrangian_ff.effects.counterbalance import Counterbalance
from lagrangian_ff.effects.coupled import Coupled
from lagrangian_ff.effects.delay import Delay
from lagrangian_ff.effects.drag import PowerLaw, QuadraticDrag
from lagrangian_ff.effects.drift import Drift
from lagrangian_ff.effects.eccentricity import Eccentricity
from lagrangian_ff.effects.elasticity import Elasticity
from lagrangian_ff.effects.hysteresis import Hysteresis
from lagrangian_ff.effects.load_friction import LoadFriction, LoadViscous
from lagrangian_ff.effects.offset import Offset
from lagrangian_ff.effects.payload import Payload
from lagrangian_ff.effects.position_friction import PositionFriction
from lagrangian_ff.effects.ripple import GearMesh, Ripple
from lagrangian_ff.effects.rotor_inertia import RotorInertia
from lagrangian_ff.effects.saturation import Saturation
from lagrangian_ff.effects.spring import Spring
from lagrangian_ff.effects.stribeck import Stribeck
from lagrangian_ff.effects.torque_gain import TorqueGain
from lagrangian_ff.effects.viscous import Viscous
from lagrangian_ff.effects.warm_up import WarmUp

_ALL: tuple[Effect, ...] = (
    Offset(),
    TorqueGain(),
    Saturation(),
    Delay(),
    Drift(),
    Eccentricity(),
    Viscous(),
    Coulomb(),
    AsymmetricCoulomb(),
    AsymmetricViscous(),
    Stribeck(),
    PowerLaw(),
    QuadraticDrag(),
    LoadFriction(),
    LoadViscous(),
    PositionFriction(),
    WarmUp(),
    Hysteresis(),
    Ripple(),
    GearMesh(),
    Backlash(),
    Elasticity(),
    Coupled(),
    RotorInertia(),
    Spring(),
    Counterbalance(),
    Payload(),
    Contact(),
)

EFFECTS: dict[str, Effect] = {effect.name: effect for effect in _ALL}
"""Every effect by its name; a new one joins here and in its own file: the tests read this list."""

GROUPS: dict[str, tuple[str, ...]] = {"fri": ("viscous", "coulomb", "offset")}
"""Names that stand for several effects: `fri` is the friction basis (51) of the paper."""
