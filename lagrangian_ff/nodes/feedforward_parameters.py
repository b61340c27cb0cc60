"""The parameters of the feedforward node, and what they mean for the stream."""

from collections.abc import Mapping

import numpy as np

from lagrangian_ff.nodes.common.parameters import Parameters
from lagrangian_ff.nodes.streaming.plan import TERMS, Policy
from lagrangian_ff.nodes.streaming.ranges import Range
from lagrangian_ff.nodes.streaming.stream import Settings

LIMITS_PER_SECOND = 20.0
"""Default rate limit: a joint goes from zero to its torque limit in a twentieth of a second."""


def declare(parameters: Parameters) -> None:
    """Declare all that does not depend on the joints of the model."""
    add = parameters.declare
    add("model_file", "", "the identified model to load when configured")
    add("effects_file", "", "Python that defines effects of your own; empty = none")
    add("joints", [""], 'order of ~/commands; [""] = the order of the model')
    add("autostart", True, "configure and activate at the start", read_only=True)
    add("rate", 500.0, "Hz of the stream; taken up when activated", low=1.0, high=2000.0)
    add("start_delay", 0.6, "s from the plan being ready to the start of a reference that says "
        "'now' (header.stamp 0); longer than ramp_time, so that the torque is there when the "
        "motion begins", low=0.0, high=10.0)  # fmt: skip
    add("lead_time", 0.0, "s by which the torque is sent ahead of its reference, to make up for "
        "what it takes to arrive", low=0.0, high=0.1)  # fmt: skip
    add("max_points", 20_000, "longest trajectory that is taken", low=1, high=200_000)
    for term in TERMS:
        add(f"terms.{term}", True, f"whether the {term} part is sent; off where the robot "
            "compensates it already")  # fmt: skip
    add("out_of_range", "fade", "a reference outside the identified range: refuse it, fade its "
        "torque to zero there, or allow it", choices=("refuse", "fade", "allow"))  # fmt: skip
    add("range_margin", 0.25, "how far outside still counts as inside, as a fraction of the "
        "range", low=0.0, high=10.0)  # fmt: skip
    add("doubt_limit", 0.0, "half of the 90 % interval of a torque, as a share of the largest "
        "torque identified on its joint, above which the reference counts as outside the "
        "identified range; 0 = never", low=0.0, high=100.0)  # fmt: skip
    add("ramp_time", 0.5, "s in which the torque is brought in", low=0.0, high=10.0)
    add("fade_time", 0.5, "s in which the torque is faded to zero", low=0.0, high=3.0)
    add("reference_timeout", 0.2, "s without a set-point after which the torque fades; 0 = off. "
        "Trajectories do not time out", low=0.0, high=10.0)  # fmt: skip
    add("joint_state_timeout", 0.5, "s without a joint state after which the torque fades; "
        "0 = off", low=0.0, high=10.0)  # fmt: skip
    add("tracking_tolerance", 0.5, "rad a joint may be away from its reference before the torque "
        "fades, as where the robot refused the trajectory; 0 = off",
        low=0.0, high=100.0)  # fmt: skip
    add("after_end", "hold", "after the end of a trajectory: hold the torque of its last point "
        "at rest, or fade", choices=("hold", "fade"))  # fmt: skip


def declare_joints(parameters: Parameters, joints: tuple[str, ...]) -> None:
    """Declare what each joint of the model has."""
    for joint in joints:
        parameters.declare(
            f"scale.{joint}", 1.0, "factor of the torque", low=0.0, high=1.0
        )  # fmt: skip
        parameters.declare(
            f"limits.{joint}.effort", 0.0,
            "N·m at most; 0 = of the robot description, or without one the largest identified",
            low=0.0, high=1e6,
        )  # fmt: skip
        parameters.declare(
            f"limits.{joint}.effort_rate", 0.0,
            f"N·m/s at most; 0 = {LIMITS_PER_SECOND:g} torque limits a second",
            low=0.0, high=1e8,
        )  # fmt: skip


def policy(parameters: Parameters) -> Policy:
    """How references outside the identified range are met."""
    value = parameters.value
    return Policy(
        value("out_of_range"), value("range_margin"), value("fade_time"), value("doubt_limit")
    )


def settings(
    parameters: Parameters,
    joints: tuple[str, ...],
    known: Range,
    described: Mapping[str, float],
) -> Settings:
    """The stream's settings for the model's joints.

    Args:
        parameters: all declared.
        joints: N names.
        known: the identified range.
        described: effort limits of the robot description.
    """
    value = parameters.value
    limit = np.array(
        [
            value(f"limits.{joint}.effort") or described.get(joint) or float(largest)
            for joint, largest in zip(joints, known.tau_max, strict=True)
        ]
    )
    rate = np.array([value(f"limits.{joint}.effort_rate") for joint in joints])
    return Settings(
        scale=np.array([value(f"scale.{joint}") for joint in joints]),
        effort_limit=limit,
        effort_rate=np.where(rate > 0.0, rate, LIMITS_PER_SECOND * limit),
        switches=np.array([float(value(f"terms.{term}")) for term in TERMS]),
        ramp_time=value("ramp_time"),
        fade_time=value("fade_time"),
        reference_timeout=value("reference_timeout"),
        joint_state_timeout=value("joint_state_timeout"),
        tracking_tolerance=value("tracking_tolerance"),
        after_end=value("after_end"),
        lead=value("lead_time"),
    )
