"""The service ~/diagnose: which effects the model lacks."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.recorder.jobs import base
from lagrangian_ff.nodes.recorder.session import Session, new_path
from lagrangian_ff.progress import Progress, part

CONFIRMED, SUGGESTED = "confirmed", "suggested"
SHOWN = (
    "model", "sources", "confirm", "confirmed_on", "verdict", "unexplained", "not_observable",
    "preflight",
)  # fmt: skip
SHOWN_OF_FINDING = (
    "effect", "joints", "verdict", "reason", "why", "evidence_gain", "p_value",
    "error_before", "error_after", "parameters", "shape", "meaning", "told_apart_by",
    "next_motion", "trial",
)  # fmt: skip


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
            **given.common, model_file=str(given.present_model), bags=first, confirm=last,
            output=str(new_path(given.directory, stem, ".json")),
        )  # fmt: skip

    def summary(self) -> str:
        said = f"started to diagnose {Path(self.model_file).name} on {base.names_of(self.bags)}; "
        if self.confirm:
            return f"{said}{base.names_of(self.confirm)} confirms"
        return f"{said}its last third is held back and confirms"

    def work(self, progress: Progress) -> dict[str, Any]:
        """Write JSON and page, and return what the node shows of them."""
        from lagrangian_ff.diagnosis import compare, consequences, diagnose, diagnosis_record
        from lagrangian_ff.diagnosis.preflight import preflight
        from lagrangian_ff.diagnosis.where import locate
        from lagrangian_ff.recording import concatenate
        from lagrangian_ff.report import diagnose_page

        model = self.open_model()
        motions = self.read_for(model, self.bags, part(progress, 0.0, 0.05))
        unseen = self.read_for(model, self.confirm, part(progress, 0.05, 0.1))
        progress(0.1, "checking the measurement")
        checks = [check.record() for check in preflight(model, concatenate(motions), unseen)]
        diagnosis = diagnose(model, motions, unseen, progress=part(progress, 0.12, 0.7))
        found: dict[str, Any] = diagnosis_record(
            diagnosis, consequences(diagnosis, part(progress, 0.7, 0.85))
        )
        names = {
            "model": self.model_file,
            "sources": list(self.bags),
            "confirm": list(self.confirm),
        }
        record = {**found, "model_name": found["model"], **names, "preflight": checks}
        comparison = compare(model, concatenate(motions), intervals=True)
        where = locate(model, comparison, progress=part(progress, 0.85, 0.95))
        output = Path(self.output)
        base.write_json(output, {**record, "compare": where.record()})
        progress(0.95, "writing the page")
        compared = {**names, **where.record(series=True)}
        page = base.write_page(diagnose_page, output, {**record, "compare": compared})
        findings = [
            {name: one[name] for name in SHOWN_OF_FINDING if name in one}
            for one in found["findings"]
        ]
        shown = {name: record[name] for name in SHOWN}
        return {**shown, "findings": findings, "json": str(output), **page}

    @classmethod
    def status(cls, record: Mapping[str, Any]) -> Status:
        """Return the verdict, after serious faults of the measurement.

        Those come first because they look like missing physics. A warning if there are any, or if
        something is missing in the model.
        """
        missing = record["findings"] or record["unexplained"]
        serious = [_check(one) for one in record["preflight"] if one["serious"]]
        values: dict[str, object] = {
            "model": record["model"],
            "recordings": ", ".join([*record["sources"], *record["confirm"]]),
            "confirmed on": record["confirmed_on"],
            "findings": len(record["findings"]),
            "unexplained": len(record["unexplained"]),
            **{f"fix first {number}": text for number, text in enumerate(serious, 1)},
            "not observable": ", ".join(
                f"{one['effect']} on {one['joint']}" for one in record["not_observable"]
            ),
            **base.files_of(record),
        }
        message = " ".join([*(f"Fix first: {text}" for text in serious), record["verdict"]])
        return Status(Level.WARN if missing or serious else Level.OK, message, values)

    @classmethod
    def statuses(cls, session: Session) -> dict[str, Status]:
        found = super().statuses(session)
        record = session.found.get(cls.service)
        if record is None:
            return found
        found |= {_name(one): _finding(one) for one in record["findings"]}
        for one in record["unexplained"]:
            found[f"unexplained on {one['joint']}: {one['coordinate']}"] = Status(
                Level.WARN,
                f"the torque depends on {one['coordinate']} in a way that no known effect explains",
                {"joint": one["joint"], "share of the torque": one["share"]},
            )
        return found

    def details(self, record: Mapping[str, Any]) -> list[str]:
        return [f"  {_name(one)}: {_finding(one).message}" for one in record["findings"]]


def _finding(one: Mapping[str, Any]) -> Status:
    values: dict[str, object] = {
        "effect": one["effect"],
        "joints": ", ".join(one["joints"]),
        "verdict": one["verdict"],
        "evidence gain [nats]": float(one["evidence_gain"]),
    }
    for label, name in (
        ("p value", "p_value"),  # None for what happens once: it is not tested against chance
        ("error before [N·m]", "error_before"),
        ("error after [N·m]", "error_after"),
    ):
        if one[name] is not None:
            values[label] = float(one[name])
    for name, value in one["parameters"].items():
        values[name] = (
            f"{value['value']:.4g} {value['unit']} ({value['low']:.4g} to {value['high']:.4g})"
        )
    values |= {f"shape {name}": float(value) for name, value in one["shape"].items()}
    if one.get("reason"):
        values["not confirmed because"] = one["reason"]
    if one.get("told_apart_by"):
        values["told apart by"] = "; ".join(one["told_apart_by"])
    values["next motion"] = one["next_motion"]
    message = f"{one['verdict']}: {one['meaning']}"
    if one["verdict"] == CONFIRMED and one["error_after"] is not None:
        message += f"; error {one['error_before']:.3g} to {one['error_after']:.3g} N·m when added"
    return Status(Level.OK if one["verdict"] == SUGGESTED else Level.WARN, message, values)


def _check(one: Mapping[str, Any]) -> str:
    where = f"{one['joint']}: " if one["joint"] else ""
    return f"{where}{one['finding']}. {one['advice']}".strip()


def _name(one: Mapping[str, Any]) -> str:
    return f"{one['effect']} on {', '.join(one['joints'])}"
