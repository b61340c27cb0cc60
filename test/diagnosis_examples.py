"""Findings and a run of diagnose on the double pendulum, written by hand: nothing is searched."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pendulum
import pendulum_models

from lagrangian_ff.diagnosis import Changed, Diagnosis, DiagnosisRun, Finding, Round
from lagrangian_ff.diagnosis.confidence import Doubt, HoldOut, Reason
from lagrangian_ff.diagnosis.consequence import Consequence
from lagrangian_ff.diagnosis.contacts import Contact
from lagrangian_ff.diagnosis.preflight import Check
from lagrangian_ff.diagnosis.results import (
    Change,
    NotObservable,
    PartialResidual,
    Ranked,
    Remainder,
    TakenUp,
    Unexplained,
)
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.records import Estimate

JOINTS = pendulum.JOINTS


@cache
def model() -> Model:
    """Return a small model of the pendulum."""
    return pendulum_models.fitted("vrbfs+fri", samples=30).model


def consequence(before: float = 1.5, after: float = 0.9) -> Consequence:
    """Return the consequence of an addition that helps in the first block and not in the second."""
    return Consequence(
        model(),
        "elbow",
        time=np.array([1.5, 4.5]),
        before=np.array([1.6, 1.0]),
        after=np.array([0.8, 1.1]),
        whole_before=before,
        whole_after=after,
        every_before=2.0 * before,
        every_after=2.0 * after,
        fall=1.0 - (after / before) ** 2,
    )


def doubt(words: str = "it helps in 50% only") -> Doubt:
    """Return a reason for which a finding is only suggested."""
    return Doubt(Reason.NOT_HELD_OUT, words)


def finding(effect: str = "stribeck", joint: str = "elbow", **more: Any) -> Finding:
    """Return a confirmed effect; a doubt, rivals and others may be given."""
    found = EFFECTS[effect]
    shapes = {"stribeck": {"v_s": 0.1}, "ripple": {"order": 9.0}}
    example = Finding(
        effect=found,
        joints=(joint,),
        cause=joint,
        shape=shapes.get(effect, {}),
        parameters={one.name: Estimate(1.25, 1.0, 1.5, one.unit) for one in found.parameters},
        log_bayes_factor=213.0,
        p_value=0.01,
        size=0.7,
        hold_out=HoldOut(np.full(8, 20.0), np.full(8, 25.0), ratio=1.1, p_value=0.004, doubt=None),
        ruled_out=(),
        doubt=None,
        consequence=consequence(),
        partial_residual=PartialResidual(
            "velocity",
            "rad/s",
            x=np.array([-1.0, 0.0, 1.0]),
            residual=np.array([-1.0, 0.1, 1.0]),
            low=np.array([-1.2, 0.0, 0.8]),
            high=np.array([-0.8, 0.2, 1.2]),
            effect=np.array([-1.0, 0.0, 1.0]),
        ),
    )
    return replace(example, **more)


def taken_up(**more: Any) -> TakenUp:
    """Return a load that both recordings take up and keep."""
    change = Change(7.0, np.inf, 0.1, 300.0, (6.9, 7.2))
    example = TakenUp(
        effect=change.effect,
        joints=JOINTS,
        shape={"t0": 7.0},
        parameters={"t0": Estimate(7.0, 6.9, 7.2, "s")},
        log_bayes_factor=300.0,
        doubt=None,
        change=change,
        again=change,
    )
    return replace(example, **more)


def changed(what: str, **more: Any) -> Changed:
    """Return a change of the elbow since the model was identified."""
    parameters = {"m": Estimate(0.5, 0.4, 0.6, "kg")}
    return replace(Changed(what, ("elbow",), 90.0, 0.0025, parameters, 1.5), **more)


def fault(**more: Any) -> Check:
    """Return a serious fault of the elbow's torque."""
    example = Check(
        "saturation",
        "elbow",
        "clipped at 1.2 N·m",
        serious=True,
        advice="leave these samples out",
        values={"limit": 1.2},
    )
    return replace(example, **more)


def diagnosis(**more: Any) -> Diagnosis:
    """Return a diagnosis that found nothing; findings and others may be given."""
    motion = pendulum.motion(6.0)
    example = Diagnosis(
        model=model(),
        motion=motion,
        held_out=replace(motion, source="another bag"),
        separate=True,
        findings=(),
        unexplained=(),
        taken_up=None,
        not_observable=(),
        ranking=(),
        waiting=(),
        threshold=14.0,
        noise=np.array([0.1, 0.2]),
    )
    return replace(example, **more)


def run(found: Diagnosis, **more: Any) -> DiagnosisRun:
    """Return a run of diagnose of one round."""
    example = DiagnosisRun("model.npz", ("a bag",), ("another bag",), (Round(found),))
    return replace(example, **more)


def full_run() -> DiagnosisRun:
    """Return a run with one confirmed and one ambiguous finding, and all else there may be."""
    spring = finding("spring", rivals=("counterbalance", "offset"), consequence=None)
    found = diagnosis(
        findings=(finding(), spring),
        unexplained=(Unexplained("shoulder", "position", 0.19, 40.0),),
        remainders=(Remainder("shoulder", 0.4, 0.06),),
        contacts=(
            Contact(6.4, 6.5, {"elbow": Estimate(-0.41, -0.5, -0.3, "N·m")}, 0.001, "a bag"),
        ),
        not_observable=(NotObservable("rotor_inertia", "elbow", "it cannot", "two payloads"),),
        ranking=(
            Ranked("stribeck", "elbow", 213.0, named=True, stands_out=True),
            Ranked("delay", "elbow", 3.0, named=True, stands_out=False),
        ),
    )
    return run(found, checks=(fault(),))
