"""The service ~/diagnose: which effects the model lacks."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.recorder.jobs import base
from lagrangian_ff.nodes.recorder.session import Result, new_path
from lagrangian_ff.progress import Progress, part
from lagrangian_ff.words import sentence

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis import Diagnosis, DiagnosisRun
    from lagrangian_ff.diagnosis.preflight import Check
    from lagrangian_ff.diagnosis.results import Found

LONGEST = 120
"""Characters of a status: `ros2 topic echo` shows 128 of a text."""


@dataclass(frozen=True)
class Addition:
    """An effect to add to a model.

    Attributes:
        effect: a name of the catalogue.  joint: where it acts.
        shape: nonlinear parameters; the others are searched.
        why: the reason for the model's history.
    """

    effect: str
    joint: str
    shape: Mapping[str, float] | None = None
    why: Mapping[str, object] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.effect} on {self.joint}"


@dataclass(frozen=True)
class Diagnosed(Result):
    """The result of a diagnosis.

    Attributes:
        confirmed: the effects that the model lacks.
    """

    confirmed: tuple[Addition, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Diagnose(base.Job):
    """Diagnose a model.

    Attributes:
        confirm: recordings that confirm the diagnosis; empty for the end of `bags`.
    """

    service, doing, title = "diagnose", "diagnosing", "diagnosis"

    confirm: tuple[str, ...] = ()

    @classmethod
    def request(cls, given: base.Situation) -> "Diagnose":
        """Return the request for all recordings; the last one confirms, a single one by its end."""
        bags = tuple(map(str, given.session.bags))
        first, last = (bags[:-1], bags[-1:]) if len(bags) > 1 else (bags, ())
        stem = f"{given.session.bags[-1].name}_{cls.service}"
        return cls(
            **given.common,
            model_file=str(given.present_model),
            bags=first,
            confirm=last,
            output=str(new_path(given.directory, stem, ".json")),
        )

    def summary(self) -> str:
        said = f"started to diagnose {Path(self.model_file).name} on {base.names_of(self.bags)}; "
        if self.confirm:
            return f"{said}{base.names_of(self.confirm)} confirms"
        return f"{said}its last third is held back and confirms"

    def work(self, progress: Progress) -> Diagnosed:
        """Write JSON and page, and return the verdict, the findings and what is to be added."""
        from lagrangian_ff.diagnosis import (
            DiagnosisRun,
            Round,
            believed,
            changed_if_misfit,
            compare,
            diagnose,
            run_record,
            with_consequences,
        )
        from lagrangian_ff.diagnosis.preflight import preflight
        from lagrangian_ff.diagnosis.where import locate
        from lagrangian_ff.recording import concatenate
        from lagrangian_ff.report import diagnose_page

        model = self.open_model()
        motions = self.read_for(model, self.bags, part(progress, 0.0, 0.05))
        unseen = self.read_for(model, self.confirm, part(progress, 0.05, 0.1))
        progress(0.1, "checking the measurement")
        checks = preflight(model, concatenate(motions), unseen)
        asked = part(progress, 0.12, 0.3)
        changed = changed_if_misfit(model, concatenate(motions), progress=asked)
        diagnosis = diagnose(model, motions, unseen, progress=part(progress, 0.3, 0.7))
        diagnosis = with_consequences(diagnosis, part(progress, 0.7, 0.85))
        comparison = compare(model, concatenate(motions), intervals=True)
        found = DiagnosisRun(
            model_file=self.model_file,
            sources=self.bags,
            confirm=self.confirm,
            checks=believed(checks, changed),
            changed=changed,
            rounds=(Round(diagnosis),),
            where=locate(model, comparison, progress=part(progress, 0.85, 0.95)),
        )
        progress(0.95, "writing the page")
        files = base.write_findings(self.output, run_record(found), diagnose_page, found)
        return self.result(found, files)

    def result(self, run: "DiagnosisRun", files: Mapping[str, str]) -> Diagnosed:
        """Return what is shown of a diagnosis and of the files that were written."""
        from lagrangian_ff.diagnosis.adding import for_history

        diagnosis = run.diagnosis
        findings = [
            (f"{one.effect.name} on {', '.join(one.joints)}", _finding(one))
            for one in diagnosis.found
        ]
        verdict = _verdict(run, files)
        log = (
            str(verdict.values["verdict"]),
            *(f"  {name}: {status.message}" for name, status in findings),
            *base.lines_of(files),
        )
        confirmed = tuple(
            Addition(one.effect.name, one.joint, dict(one.shape), for_history(one, diagnosis))
            for one in diagnosis.confirmed
            if not one.once
        )
        changes = _changes(run)
        statuses = {self.title: verdict, **changes, **dict(findings), **_unexplained(diagnosis)}
        return Diagnosed(log, statuses, report=files.get("JSON", ""), confirmed=confirmed)


def _verdict(run: "DiagnosisRun", files: Mapping[str, str]) -> Status:
    """Return the verdict, after serious faults of the measurement.

    Those come first because they look like missing physics. A warning if there are any, or if
    something is missing in the model.
    """
    from lagrangian_ff.diagnosis.sentences import headline, verdict

    diagnosis, serious = run.diagnosis, [_check(one) for one in run.serious]
    said = [*(f"Fix first: {text}" for text in serious), verdict(diagnosis, run.changed)]
    values: dict[str, object] = {
        "verdict": " ".join(said),
        "model": run.model_file,
        "recordings": ", ".join([*run.sources, *run.confirm]),
        "confirmed on": diagnosis.confirmed_on,
        "findings": len(diagnosis.found),
        "unexplained": len(diagnosis.unexplained),
        **{f"fix first {number}": text for number, text in enumerate(serious, 1)},
        "not observable": ", ".join(
            f"{one.effect} on {one.joint}" for one in diagnosis.not_observable
        ),
        **files,
    }
    first = [f"fix first: {one.joint or 'all joints'}: {one.check}" for one in run.serious]
    message = "; ".join([*first, headline(diagnosis, run.changed)])
    message = message if len(message) <= LONGEST else f"{message[: LONGEST - 1]}…"
    misfit = diagnosis.misfit is not None and diagnosis.misfit.larger
    missing = diagnosis.found or diagnosis.unexplained or run.changed or misfit
    return Status(Level.WARN if missing or serious else Level.OK, message, values)


def _changes(run: "DiagnosisRun") -> dict[str, Status]:
    """Return a status for each change since the model was identified."""
    from lagrangian_ff.diagnosis.sentences import amount

    every = run.diagnosis.model.joints
    return {
        f"changed: {one.what} on {', '.join(one.joints)}": Status(
            Level.WARN,
            amount(one, every),
            {
                "evidence gain [nats]": float(one.log_bayes_factor),
                "size [N·m]": one.size,
                **{
                    f"{name} by": f"{by.value:.4g} {by.unit} ({by.low:.4g} to {by.high:.4g})"
                    for name, by in one.parameters.items()
                },
            },
        )
        for one in run.changed or ()
    }


def _unexplained(diagnosis: "Diagnosis") -> dict[str, Status]:
    """Return a status for each dependence that no known effect explains."""
    return {
        f"unexplained on {one.joint}: {one.coordinate}": Status(
            Level.WARN,
            f"the torque depends on {one.coordinate} in a way that no known effect explains",
            {"joint": one.joint, "share of the torque": one.share},
        )
        for one in diagnosis.unexplained
    }


def _finding(found: "Found") -> Status:
    """Return the verdict on a finding with its numbers; those that it does not have are absent."""
    before, after = found.errors
    numbers = {"p value": found.p_value, "error before [N·m]": before, "error after [N·m]": after}
    values: dict[str, object] = {
        "effect": found.effect.name,
        "joints": ", ".join(found.joints),
        "verdict": found.said,
        "evidence gain [nats]": float(found.log_bayes_factor),
        **{name: float(value) for name, value in numbers.items() if value is not None},
        **{
            name: f"{one.value:.4g} {one.unit} ({one.low:.4g} to {one.high:.4g})"
            for name, one in found.parameters.items()
        },
        **{f"shape {name}": float(value) for name, value in found.shape.items()},
    }
    if found.doubt:
        values["not confirmed because"] = found.doubt.words
    if found.told_apart_by:
        values["told apart by"] = "; ".join(found.told_apart_by)
    values["next motion"] = found.effect.next_motion
    message = f"{found.said}: {found.effect.meaning}"
    if found.confirmed and after is not None:
        message += f"; error {before:.3g} to {after:.3g} N·m when added"
    return Status(Level.OK if found.doubt else Level.WARN, message, values)


def _check(check: "Check") -> str:
    where = f"{check.joint}: " if check.joint else ""
    return " ".join(sentence(text) for text in (f"{where}{check.finding}", check.advice) if text)
