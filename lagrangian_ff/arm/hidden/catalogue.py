"""Every hidden effect, listed once; the tests and the study read this list."""

from lagrangian_ff.arm.hidden import events, friction, sensing, solid, strange
from lagrangian_ff.arm.hidden.base import HiddenEffect

KNOWN = (
    HiddenEffect("stribeck", "more dry friction below a low speed", friction.stribeck),
    HiddenEffect(
        "load_friction",
        "dry friction in proportion to the load",
        friction.load_friction,
        start=0.1,
        strongest=0.6,
    ),
    HiddenEffect(
        "load_viscous",
        "viscous friction in proportion to the load",
        friction.load_viscous,
        start=0.1,
    ),
    HiddenEffect("warm_up", "friction that falls as the drive warms up", friction.warm_up),
    HiddenEffect(
        "quadratic_drag", "drag that grows with the square of speed", friction.quadratic_drag
    ),
    HiddenEffect("power_law", "shear of a grease that thins", friction.power_law),
    HiddenEffect(
        "asymmetric_viscous", "viscous loss in one direction", friction.asymmetric_viscous
    ),
    HiddenEffect("ripple", "cogging some times a turn", friction.ripple),
    HiddenEffect(
        "gear_mesh", "ripple that grows with the load", friction.gear_mesh, start=0.1, strongest=0.6
    ),
    HiddenEffect(
        "position_friction", "dry friction that varies once a turn", friction.position_friction
    ),
    HiddenEffect("hysteresis", "bristles that bend before they slip", solid.hysteresis),
    HiddenEffect(
        "coupled",
        "friction at the sum or difference of two joints' speeds",
        solid.coupled,
        reach="pair",
    ),
    HiddenEffect(
        "backlash",
        "play between rotor and link",
        solid.backlash,
        solid.backlash_torque,
        largest=0.1,
        start=1e-3,
        strongest=0.03,
    ),
    HiddenEffect(
        "elasticity",
        "a spring between rotor and link",
        solid.elasticity,
        solid.elasticity_torque,
        largest=0.1,
        start=3e-3,
        strongest=0.03,
    ),
    HiddenEffect(
        "delay",
        "effort reported late",
        sensing.delay,
        sensing.delay_torque,
        largest=0.05,
        start=5e-3,
        strongest=0.05,
    ),
    HiddenEffect(
        "saturation",
        "effort clipped at the end of the sensor's range",
        sensing.saturation,
        sensing.saturation_torque,
        start=0.2,
        strongest=0.9,
    ),
    HiddenEffect(
        "eccentricity",
        "an encoder off its axis",
        sensing.eccentricity,
        sensing.eccentricity_torque,
        largest=0.02,
        start=5e-3,
        strongest=0.06,
    ),
    HiddenEffect(
        "payload",
        "a load picked up on the way",
        events.payload,
        events.payload_torque,
        reach="arm",
        joints=(1, 2, 3, 4),
        strongest=6.0,
    ),
    HiddenEffect(
        "contact",
        "a push at the tool for some seconds",
        events.contact,
        reach="arm",
        joints=(0, 1, 2, 3, 4),
        start=10.0,
    ),
    HiddenEffect("spring", "a hose or cable that is twisted", solid.spring, absorbed=True),
)

UNKNOWN = (
    HiddenEffect(
        "pitting",
        "more dry friction near one angle: a damaged bearing",
        strange.pitting,
        known=False,
    ),
    HiddenEffect(
        "shaking", "a floor that shakes at a fixed frequency", strange.shaking, known=False
    ),
    HiddenEffect(
        "capstan",
        "friction set by the difference of two joints' angles",
        strange.capstan,
        known=False,
    ),
    HiddenEffect("pinched", "friction set by another joint's angle", strange.pinched, known=False),
    HiddenEffect("debris", "bursts of friction at random times", strange.debris, known=False),
    HiddenEffect("starved", "friction that remembers acceleration", strange.starved, known=False),
)

HIDDEN: dict[str, HiddenEffect] = {effect.name: effect for effect in (*KNOWN, *UNKNOWN)}
"""By name: first those that a catalogue of effects can have, then those it cannot."""
