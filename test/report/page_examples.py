"""What the pages of compare, diagnose and history show, small."""

from dataclasses import replace

import numpy as np
from diagnosis_examples import diagnosis, finding, full_run, model

from lagrangian_ff.diagnosis import Comparison, DiagnosisRun, Round
from lagrangian_ff.diagnosis.excite import For, Reference, Suspect
from lagrangian_ff.diagnosis.where import (
    COORDINATES,
    Bins,
    Compared,
    Condition,
    Localisation,
    Region,
    ResidualSeries,
    Spectrum,
)
from lagrangian_ff.diagnosis.where.orders import Line
from lagrangian_ff.effects.stribeck import Stribeck
from lagrangian_ff.identification import Score
from lagrangian_ff.identification.history import ErrorChange, History, Reason, Step
from lagrangian_ff.investigation import Ended, Investigation, Turn
from lagrangian_ff.recording import Motion

JOINTS = ("shoulder", "elbow")
SCRIPT = "</script><b>"
"""What a careless page would take for its own."""


def bins(joint: str, coordinate: str) -> Bins:
    """A residual that grows with the coordinate."""
    known = COORDINATES[coordinate]
    edges = np.linspace(-1.0, 1.0, 7)
    low = np.array(list(known.levels) or edges[:-1])
    high = np.array(list(known.levels) or edges[1:])
    mean, even = 0.5 * low, np.full(len(low), 1.0 / len(low))
    rms = np.full(len(low), 0.5)
    return Bins(known, joint, low, high, mean, mean - 0.1, mean + 0.1, rms, even, even, 0.3)


def motion(joints: tuple[str, ...] = JOINTS, step: float = 0.1, samples: int = 60) -> Motion:
    """Torques that grow with time, in two segments."""
    time = step * np.arange(samples, dtype=np.float64)
    tau = np.repeat(2.0 * time[:, None], len(joints), axis=1)
    segment = np.repeat([0, 1], samples // 2)
    return Motion(joints, time, 0.0 * tau, 0.0 * tau, 0.0 * tau, tau, segment, "a bag")


def comparison(measured: Motion | None = None) -> Comparison:
    """A model that predicts three quarters of each torque."""
    measured = measured or motion()
    ones = np.ones(len(measured.joints))
    score = Score(measured.joints, ones * [0.5, 1.5], ones * [0.01, 0.09])
    return Comparison(measured, 0.75 * measured.tau, score, outside=0.125)


def compared() -> Compared:
    """Elbow fails at low speed."""
    found = comparison()
    series = ResidualSeries(found.motion, found.residual, found.motion.tau, np.zeros(60))
    slow = Condition("velocity", -0.1, 0.1, "below 0.10 rad/s")
    spectrum = Spectrum(
        "elbow",
        2.0,
        order=np.array([2.0, 3.0, 20.0]),
        amplitude=np.array([0.1, 0.1, 0.8]),
        noise=np.full(3, 0.2),
        lines=(Line(20.0, 0.8),),
        spread=1.25,
    )
    where = Localisation(
        found,
        series,
        tuple(bins(joint, name) for joint in JOINTS for name in ("velocity", "direction")),
        (Region("elbow", (slow,), 0.41, (0.3, 0.5), 0.06, 2.0),),
        (spectrum,),
    )
    return Compared(f"model{SCRIPT}.npz", ("a bag",), where)


class Scripted(Stribeck):
    """Stribeck friction of somebody who writes HTML."""

    formula = f"F_s sign(qd) {SCRIPT}"


def diagnosed() -> DiagnosisRun:
    """Return a run of diagnose that has all there is to show, a formula with HTML too."""
    found = full_run()
    first, *rest = found.diagnosis.findings
    findings = (replace(first, effect=Scripted()), *rest)
    rounds = (Round(replace(found.diagnosis, findings=findings)),)
    return replace(found, rounds=rounds, where=compared().where)


def lineage() -> History:
    """Return a history with one step."""
    steps = (
        Step(
            "identified",
            "2026-01-02T03:04:05",
            None,
            2.0,
            {"shoulder": ErrorChange(None, 0.5), "elbow": ErrorChange(None, 2.0)},
            "a bag",
        ),
        Step(
            "torque_ripple on joint_2",
            "2026-01-02T04:04:05",
            2.0,
            1.0,
            {"shoulder": ErrorChange(0.5, 0.5), "elbow": ErrorChange(2.0, 1.0)},
            "another bag",
            Reason("a wave of 20 to a turn", "confirmed", 41.0, 0.0),
        ),
    )
    return History("model.npz", "chain+fri", steps)


def investigated() -> Investigation:
    """A story of two motions, the second of which confirms an effect."""
    time = np.arange(0.0, 20.01, 0.01)
    q = np.sin(time)[:, None] * np.ones(2)
    path = Reference(time, q, 0.0 * q, 0.0 * q)
    question = For(Suspect("stribeck", "elbow"))
    errors = {"shoulder": 0.3, "elbow": 0.4}
    first = Turn(None, path, 20.0, None, diagnosis(), model(), SCRIPT, errors, 0.5)
    found = diagnosis(findings=(finding(),))
    second = Turn(question, path, 20.0, None, found, model(), SCRIPT, errors, 0.2)
    return Investigation(
        JOINTS, (first, second), Ended.NOTHING_LEFT, SCRIPT, 40.0, dict(errors), 0.5
    )
