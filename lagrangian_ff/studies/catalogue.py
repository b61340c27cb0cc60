"""The studies, listed once; a new one is a class of `Study` and a line here."""

from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

from lagrangian_ff.errors import UserError

if TYPE_CHECKING:
    from lagrangian_ff.studies.study import Study


@dataclass(frozen=True)
class Entry:
    """A study whose code is not loaded yet.

    Attributes:
        about: its subject, in a line.
        module: the one below `lagrangian_ff.studies` with its class, such as `IdealStudy`.
        arm: whether it needs the simulated arm.
    """

    about: str
    module: str
    arm: bool = False


STUDIES = {
    "ideal": Entry("Fig. 2 of the paper: which kernel learns ideal robots best?", "dof"),
    "friction": Entry(
        "Fig. 3: the same robots with friction and noise, kernels with and without fri", "friction"
    ),
    "speeds": Entry("Fig. 5: error of predicted torque over speed, model by model", "speeds", True),
    "tracking": Entry(
        "Fig. 6: tracking error over speed with precomputed torque", "tracking", True
    ),
    "loaded": Entry("Fig. 7: as speeds, with masses on the arm", "speeds", True),
    "consistency": Entry(
        "Theorem 2: what is left of the error with more and more samples", "consistency"
    ),
    "sparsity": Entry(
        "section V: error and time with fewer centres than samples", "sparsity", True
    ),
    "hidden": Entry(
        "effects hidden in the arm's physics: found, missed, or invented?", "hidden.study", True
    ),
    "nuisances": Entry(
        "as hidden, in arms with rests, soft gears, late effort and more that real ones have",
        "nuisances.study",
        True,
    ),
    "decide": Entry(
        "designed motions and investigations: do they decide what usual motion leaves open?",
        "decide.study",
        True,
    ),
    "measured": Entry(
        "measured recordings: models beside the standard way, and verdicts on what is known",
        "measured.study",
    ),
}


def study_class(name: str) -> "type[Study]":
    """Return the class of a study.

    Raises:
        UserError: there is no study of the name, or PyBullet is missing.
    """
    if name not in STUDIES:
        raise UserError(f"there is no study '{name}'; there are {', '.join(STUDIES)}")
    entry = STUDIES[name]
    if entry.arm and find_spec("pybullet") is None:
        raise UserError(f"study {name} drives the simulated arm: pip install pybullet")
    module = import_module(f"lagrangian_ff.studies.{entry.module}")
    kind: type[Study] = getattr(module, f"{name.capitalize()}Study")
    return kind
