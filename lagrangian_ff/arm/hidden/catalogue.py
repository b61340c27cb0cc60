"""Every hidden effect, listed once; the tests and the study read this list."""

from lagrangian_ff.arm.hidden import events, friction, sensing, solid, strange
from lagrangian_ff.arm.hidden.base import HiddenEffect

KNOWN = (
    HiddenEffect(friction.stribeck, "more dry friction below a low speed"),
    HiddenEffect(friction.load_friction, "dry friction in proportion to the load",
                 start=0.1, strongest=0.6),
    HiddenEffect(friction.load_viscous, "viscous friction in proportion to the load", start=0.1),
    HiddenEffect(friction.warm_up, "friction that falls as the drive warms up"),
    HiddenEffect(friction.quadratic_drag, "drag that grows with the square of speed"),
    HiddenEffect(friction.power_law, "shear of a grease that thins"),
    HiddenEffect(friction.asymmetric_viscous, "viscous loss in one direction"),
    HiddenEffect(friction.ripple, "cogging some times a turn"),
    HiddenEffect(friction.gear_mesh, "ripple that grows with the load", start=0.1, strongest=0.6),
    HiddenEffect(friction.position_friction, "dry friction that varies once a turn"),
    HiddenEffect(solid.hysteresis, "bristles that bend before they slip"),
    HiddenEffect(solid.coupled, "friction at the sum or difference of two joints' speeds",
                 reach="pair"),
    HiddenEffect(solid.backlash, "play between rotor and link",
                 solid.backlash_torque, largest=0.1, start=1e-3, strongest=0.03),
    HiddenEffect(solid.elasticity, "a spring between rotor and link",
                 solid.elasticity_torque, largest=0.1, start=3e-3, strongest=0.03),
    HiddenEffect(sensing.delay, "effort reported late",
                 sensing.delay_torque, largest=0.05, start=5e-3, strongest=0.05),
    HiddenEffect(sensing.saturation, "effort clipped at the end of the sensor's range",
                 sensing.saturation_torque, start=0.2, strongest=0.9),
    HiddenEffect(sensing.eccentricity, "an encoder off its axis",
                 sensing.eccentricity_torque, largest=0.02, start=5e-3, strongest=0.06),
    HiddenEffect(events.payload, "a load picked up on the way",
                 events.payload_torque, reach="arm", joints=(1, 2, 3, 4), strongest=6.0),
    HiddenEffect(events.contact, "a push at the tool for some seconds",
                 reach="arm", joints=(0, 1, 2, 3, 4), start=10.0),
    HiddenEffect(solid.spring, "a hose or cable that is twisted", absorbed=True),
)  # fmt: skip

UNKNOWN = (
    HiddenEffect(
        strange.pitting, "more dry friction near one angle: a damaged bearing", known=False
    ),
    HiddenEffect(strange.shaking, "a floor that shakes at a fixed frequency", known=False),
    HiddenEffect(
        strange.capstan, "friction set by the difference of two joints' angles", known=False
    ),
    HiddenEffect(strange.pinched, "friction set by another joint's angle", known=False),
    HiddenEffect(strange.dress_pack, "hoses that the angles of three joints bend", known=False),
    HiddenEffect(strange.debris, "bursts of friction at random times", known=False),
    HiddenEffect(strange.starved, "friction that remembers acceleration", known=False),
)

HIDDEN: dict[str, HiddenEffect] = {effect.name: effect for effect in (*KNOWN, *UNKNOWN)}
"""By name: first those that a catalogue of effects can have, then those it cannot."""
