"""A model with more effects, beside the one it was made from."""

from pathlib import Path
from typing import Any

from lagrangian_ff.diagnosis import add, history
from lagrangian_ff.nodes.recorder.order import Order
from lagrangian_ff.nodes.recorder.tasks.files import write_page
from lagrangian_ff.nodes.recorder.tasks.reading import open_model
from lagrangian_ff.progress import Progress, part
from lagrangian_ff.report import history_page


def add_to_model(order: Order, progress: Progress) -> dict[str, Any]:
    """Add effects one after the other; the new model's record and its steps.

    Raises:
        UserError: the model cannot be used, or has an effect or its equal already.
    """
    model = open_model(order)
    count = len(order.additions)
    for number, each in enumerate(order.additions):
        step = part(progress, number / count, (number + 1) / count)
        model = add(model, each.effect, each.joint, each.shape, each.why, step)
    output = Path(order.output)
    model.save(output)
    told = {**history(model), "model": str(output)}
    page = write_page(history_page, output, told)
    return {
        "record": dict(model.record),
        "steps": told["steps"],
        "added": [str(each) for each in order.additions],
        **page,
    }
