"""Which effect a model lacks, by bags."""

from pathlib import Path
from typing import Any

from lagrangian_ff.diagnosis import compare, diagnose
from lagrangian_ff.diagnosis.preflight import preflight
from lagrangian_ff.diagnosis.record import diagnosis_record
from lagrangian_ff.diagnosis.where import locate
from lagrangian_ff.nodes.recorder.order import Order
from lagrangian_ff.nodes.recorder.tasks.files import write_json, write_page
from lagrangian_ff.nodes.recorder.tasks.reading import open_model, read_for
from lagrangian_ff.progress import Progress, part
from lagrangian_ff.recording import concatenate
from lagrangian_ff.report import diagnose_page

SHOWN = (
    "model", "sources", "confirm", "confirmed_on", "verdict", "unexplained", "not_observable",
    "preflight",
)  # fmt: skip
SHOWN_OF_FINDING = (
    "effect", "joints", "verdict", "reason", "why", "evidence_gain", "p_value",
    "error_before", "error_after", "parameters", "shape", "meaning", "told_apart_by",
    "next_motion", "trial",
)  # fmt: skip


def diagnose_bags(order: Order, progress: Progress) -> dict[str, Any]:
    """Find out what a model lacks; JSON and page, and what the node shows of them.

    Raises:
        UserError: the model or a recording cannot be used.
    """
    model = open_model(order)
    motions = read_for(model, order.bags, order, part(progress, 0.0, 0.05))
    unseen = read_for(model, order.confirm, order, part(progress, 0.05, 0.1))
    progress(0.1, "checking the measurement")
    checks = [check.record() for check in preflight(model, concatenate(motions), unseen)]
    diagnosis = diagnose(model, motions, unseen, progress=part(progress, 0.12, 0.7))
    found = diagnosis_record(diagnosis, progress=part(progress, 0.7, 0.85))
    names = {"model": order.model_file, "sources": list(order.bags), "confirm": list(order.confirm)}
    record: dict[str, Any] = {**found, "model_name": found["model"], **names, "preflight": checks}
    comparison = compare(model, concatenate(motions), intervals=True)
    where = locate(model, comparison, progress=part(progress, 0.85, 0.95))
    output = Path(order.output)
    write_json(output, {**record, "compare": where.record()})
    progress(0.95, "writing the page")
    compared = {**names, **where.record(series=True)}
    page = write_page(diagnose_page, output, {**record, "compare": compared})
    return {
        **{name: record[name] for name in SHOWN},
        "findings": [
            {name: one[name] for name in SHOWN_OF_FINDING if name in one}
            for one in record["findings"]
        ],
        "json": str(output),
        **page,
    }
