"""How well the model predicts torque, in numbers and over time."""

from lagrangian_ff.diagnosis import Comparison
from lagrangian_ff.report import html
from lagrangian_ff.report.numbers import number, percent
from lagrangian_ff.report.section import Section


def torque_section(comparison: Comparison, picture: bytes, title: str, lead: str) -> Section:
    """Table and figure of measured and predicted torque.

    Args:
        comparison: of a model with a motion.
        picture: PNG of `torque_figure`.
        title: of the section.
        lead: which motion it is, and whether the model has seen it.
    """
    score, tau, interval = comparison.score, comparison.motion.tau, comparison.interval
    spread = tau.std(axis=0)
    rows = [
        [
            joint,
            number(float(spread[n])),
            number(float(score.rmse[n])),
            percent(float(score.rmse[n] / spread[n])) if spread[n] > 0.0 else "–",
            number(float(score.nmse[n])),
            *([percent(float(interval.covered[n]))] if interval else []),
        ]
        for n, joint in enumerate(score.joints)
    ]
    header = [
        "joint",
        "torque's spread [N·m]",
        "RMS error [N·m]",
        "error / spread",
        "nMSE",
        *(["inside its interval"] if interval else []),
    ]
    shown = html.figure(
        picture,
        "measured and predicted torque of each joint over time, with the residual",
        "Upper plots: measured torque (grey) and the model's prediction (blue). Lower plots: what "
        "is left between them, on the same scale."
        + (" Shaded: where 90 % of the measured torques should be." if interval else ""),
    )
    small = html.note(
        "Spread is the standard deviation of the measured torque. nMSE is the mean squared error "
        "over its square: 0 is perfect, 1 is no better than the mean. "
        f"{percent(comparison.outside)} of the samples lie outside the range of motion the model "
        "was identified on."
    )
    return Section(title, lead, html.table(header, rows, strong=3) + shown + small)
