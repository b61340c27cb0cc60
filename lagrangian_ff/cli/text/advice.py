"""Advice on the result of an identification: one small rule each."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from lagrangian_ff.cli.text.effects import negative_friction
from lagrangian_ff.cli.text.errors import worse_than
from lagrangian_ff.words import grade

if TYPE_CHECKING:
    from lagrangian_ff.identification.records import Identified, Score

FAIR, GOOD = 0.2, 0.05
SHORT_SECONDS = 20.0
FEW_SAMPLES = 300


@dataclass(frozen=True)
class Findings:
    """The input of the rules.

    Attributes:
        identified: of the identification itself.
        outside: share of the judged motion outside the range of the training motion.
        worst: the joint and quantity farthest outside, in words.
        still: joints that did not move.
    """

    identified: "Identified"
    outside: float = 0.0
    worst: str = ""
    still: tuple[str, ...] = ()

    @property
    def weak(self) -> list[str]:
        """Return the joints that are not even fair."""
        return worse_than(self.identified.score, FAIR)

    @property
    def apart(self) -> bool:
        """Return whether the error is of motion that came after the training part."""
        return self.identified.settings.train < 1.0


def _outside(found: Findings) -> str | None:
    if found.outside <= 0.05:
        return None
    text = (
        f"{found.outside:.0%} of the held-out motion lies outside what was trained on "
        f"({found.worst}). There the model guesses"
    )
    if not worse_than(found.identified.score, GOOD):
        return f"{text}, well so far."
    return (
        f"{text}, and this alone can make the error large. Learn from the whole recording with "
        "--train 1.0 (the error is then that of blocks left out in turn), or record a motion "
        "whose first part goes everywhere the rest goes."
    )


def _changed(found: Findings) -> str | None:
    inside = found.identified.validation.mean_nmse
    if not found.apart or found.outside > 0.05 or not found.weak:
        return None
    if grade(inside) not in ("very good", "good"):
        return None
    return (
        "Blocks left out of the training part are predicted well "
        f"(nmse {inside:.2g}), the later motion is not, although it stays within the same range: "
        "did something change in between (temperature, load, contact)?"
    )


def _short(found: Findings) -> str | None:
    seconds = found.identified.training_seconds
    if not found.weak or seconds >= SHORT_SECONDS:
        return None
    more = " or use more of it with --train 1.0" if found.apart else ""
    return (
        f"{seconds:.1f} s of motion is little to learn from: record 30 s or longer through the "
        f"whole workspace{more}."
    )


def _few(found: Findings) -> str | None:
    asked, samples = found.identified.settings.samples, found.identified.samples
    if asked >= FEW_SAMPLES or samples != asked or not worse_than(found.identified.score, GOOD):
        return None
    return f"Only {samples} samples were used: --samples 500 usually lowers the error."


def _no_friction(found: Findings) -> str | None:
    if found.identified.effects or not worse_than(found.identified.score, GOOD):
        return None
    return f"The model has no friction, most arms have: try --model {found.identified.model}+fri."


def _traded(found: Findings) -> str | None:
    _, joints = negative_friction(found.identified.effects)
    if not joints:
        return None
    return (
        f"A part of the friction on {', '.join(joints)} is negative: the kernel has taken over "
        "some of it. Their sum holds on motions like those learned from; do not read its "
        "numbers one by one, nor leave the friction out there. Other speeds separate them."
    )


def _driving(found: Findings) -> str | None:
    joints, _ = negative_friction(found.identified.effects)
    if not joints:
        return None
    conditioning = found.identified.conditioning
    known = conditioning.effort_scale if conditioning else {}
    flips = " ".join(f"{joint}={-known.get(joint, 1.0):g}" for joint in joints)
    return (
        f"The friction found on {', '.join(joints)} drives the motion instead of braking it. "
        "Is the effort of the right sign, and the torque of the actuator? If the sign is "
        f"reversed: --effort-scale {flips}"
    )


def _still(found: Findings) -> str | None:
    if not found.still:
        return None
    return (
        f"{', '.join(found.still)} did not move: nothing is known of its friction and inertia. "
        "Use no feedforward on motions that move it."
    )


def _unknown_cause(found: Findings) -> str | None:
    if not found.weak or any(rule(found) for rule in (_outside, _changed, _short, _no_friction)):
        return None
    return (
        f"No cause of the error on {', '.join(found.weak)} is plain. Is the effort the torque of "
        "the actuator (--effort-scale, --effort-offset)? Did something touch the arm (--loss "
        "huber)? A kernel that assumes less, --model rbf+fri, shows whether the measurement holds "
        "more to learn."
    )


RULES: tuple[Callable[[Findings], str | None], ...] = (
    _outside,
    _changed,
    _short,
    _few,
    _no_friction,
    _driving,
    _traded,
    _still,
    _unknown_cause,
)


def usable(score: "Score") -> str:
    """Return whether feedforward with the model is recommended."""
    if weak := worse_than(score, FAIR):
        return f"Do not drive {', '.join(weak)} with it."
    if worse_than(score, GOOD):
        return "Feedforward with it helps, less on the joints that are only fair."
    return "Feedforward with it should take away most of the tracking error."


def advice(found: Findings) -> list[str]:
    """Return what to say, in the order of importance; empty if all is well."""
    return [text for rule in RULES if (text := rule(found))]
