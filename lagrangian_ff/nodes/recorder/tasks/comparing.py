"""Where a model fails on bags."""

from pathlib import Path
from typing import Any

from lagrangian_ff.diagnosis import compare
from lagrangian_ff.diagnosis.where import locate
from lagrangian_ff.nodes.recorder.order import Order
from lagrangian_ff.nodes.recorder.tasks.files import write_json, write_page
from lagrangian_ff.nodes.recorder.tasks.reading import open_model, read_for
from lagrangian_ff.progress import Progress, part
from lagrangian_ff.recording import concatenate
from lagrangian_ff.report import compare_page

SHOWN = ("model", "sources", "joints", "rmse", "nmse", "outside_range", "words")


def compare_bags(order: Order, progress: Progress) -> dict[str, Any]:
    """Hold a model against bags; JSON and page, and what the node shows of them.

    Raises:
        UserError: the model or a recording cannot be used.
    """
    model = open_model(order)
    motions = read_for(model, order.bags, order, part(progress, 0.0, 0.1))
    whole, share = concatenate(motions), part(progress, 0.1, 0.5)
    comparison = compare(model, whole, progress=share, intervals=True)
    where = locate(model, comparison, progress=part(progress, 0.5, 0.95))
    names = {"model": order.model_file, "sources": list(order.bags)}
    record = {**names, **where.record()}
    output = Path(order.output)
    write_json(output, record)
    progress(0.95, "writing the page")
    page = write_page(compare_page, output, {**names, **where.record(series=True)})
    return {**{name: record[name] for name in SHOWN}, "json": str(output), **page}
