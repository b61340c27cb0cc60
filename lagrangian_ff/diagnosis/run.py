"""All that one run of `diagnose` found: the type that text, page, node and JSON read."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from lagrangian_ff.diagnosis.consequence import Consequence
from lagrangian_ff.diagnosis.preflight.base import Check
from lagrangian_ff.diagnosis.results import Diagnosis, Finding
from lagrangian_ff.diagnosis.where.locate import Localisation
from lagrangian_ff.effects.usual import usual_words
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.records import Estimate


@dataclass(frozen=True)
class Changed:
    """A change since the model was identified.

    Attributes:
        what: the effect, or in words the bodies that changed.
        joints: those that feel it.
        log_bayes_factor: nats.
        p_value: how often the null of the maximum reaches it; None if there is no null.
        parameters: by how much each changed, by name.
        size: N·m, root mean square of the added torque on the first of the joints.
        rivals: changes of a known robot's bodies that explain as much.
        error_before, error_after: N·m rms of the model on the recording, on the first of the joints
            inside the range it knows, with the changes before this one explained, and with this
            one too; None if the recording is hardly inside that range.
        note: what its intervals allow for, in words; empty for nothing but the motion.
    """

    what: str
    joints: tuple[str, ...]
    log_bayes_factor: float
    p_value: float | None
    parameters: Mapping[str, Estimate]
    size: float
    rivals: tuple[str, ...] = ()
    error_before: float | None = None
    error_after: float | None = None
    note: str = ""


BY_MODEL = ("effort unit", "effort sign", "delay")
"""Checks that compare the torque with what the model expects: a change of the arm misleads them."""


def believed(checks: Sequence[Check], changed: Sequence[Changed] | None) -> tuple[Check, ...]:
    """Return the checks, those that a change of the arm misleads no longer serious.

    Another unit of a joint whose gain changed is no mistake: it is that change.
    """
    if not changed:
        return tuple(checks)
    words = "Since the arm changed, this may be part of it: identify again before you look at it"
    scaled = {joint for one in changed if one.what == "torque_gain" for joint in one.joints}

    def misled(one: Check) -> bool:
        right = one.check == "effort unit" and one.joint in scaled
        return bool(one.advice) and one.check in BY_MODEL and not right

    return tuple(
        replace(one, serious=False, advice=words) if misled(one) else one for one in checks
    )


@dataclass(frozen=True, eq=False)
class Round:
    """One diagnosis, and the model that it led to.

    Attributes:
        diagnosis: with the consequences of adding its findings.
        after: the model with what was confirmed; None if nothing was, or was to be, added.
    """

    diagnosis: Diagnosis
    after: Model | None = None

    @property
    def added(self) -> tuple[str, ...]:
        """Return the names of what was added."""
        if self.after is None:
            return ()
        new = self.after.steps[len(self.diagnosis.model.steps) :]
        return tuple(str(step["added"]) for step in new)


@dataclass(frozen=True, eq=False)
class DiagnosisRun:
    """All that one run of `diagnose` found.

    Attributes:
        model_file: of the diagnosed model.
        sources, confirm: the recordings that were searched, and those that confirm; as given.
        rounds: one; or several, if what was confirmed was added and the search went on.
        checks: of the measurement, serious ones first.
        changed: since the model was identified; None if that was neither asked nor to be seen.
        where: where the model fails; None if that was not looked for.
        output: the file of the model with what is confirmed; empty if nothing was to be added.
        gears: by joint, the kind of its gear as `effects.usual` knows it, where the user said so.
    """

    model_file: str
    sources: tuple[str, ...]
    confirm: tuple[str, ...]
    rounds: tuple[Round, ...]
    checks: tuple[Check, ...] = ()
    changed: tuple[Changed, ...] | None = None
    where: Localisation | None = None
    output: str = ""
    gears: Mapping[str, str] = field(default_factory=dict)

    @property
    def diagnosis(self) -> Diagnosis:
        """Return the diagnosis of the model as it was given."""
        return self.rounds[0].diagnosis

    @property
    def serious(self) -> tuple[Check, ...]:
        """Return the faults of the measurement that must be mended first."""
        return tuple(check for check in self.checks if check.serious)

    @property
    def usual(self) -> dict[str, str]:
        """Return what is known of the findings and their rivals in the gears of their joints.

        Returns:
            By effect and joint, a sentence; those of which nothing is known are left out.
        """
        said = {
            f"{name} on {one.joint}": usual_words(name, self.gears.get(one.joint))
            for each in self.rounds
            for one in each.diagnosis.findings
            for name in (one.effect.name, *one.rivals)
        }
        return {name: words for name, words in said.items() if words}

    @property
    def tried(self) -> tuple[tuple[Finding, Consequence], ...]:
        """Return the confirmed findings of all rounds, each with what it did to the error."""
        return tuple(pair for one in self.rounds for pair in one.diagnosis.tried)
