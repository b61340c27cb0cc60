"""From the bags of an order to motions."""

from collections.abc import Sequence
from pathlib import Path

from lagrangian_ff.identification import Model
from lagrangian_ff.nodes.common.own_effects import load_own_effects
from lagrangian_ff.nodes.common.treatment import treatment
from lagrangian_ff.nodes.recorder.order import Order
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording import Conditioning, Motion, condition, load


def read(
    bags: Sequence[str],
    topic: str,
    joints: Sequence[str],
    conditioning: Conditioning,
    progress: Progress,
) -> list[Motion]:
    """Motions of these joints, all where none is named.

    Raises:
        RecordingError: a bag cannot be read or used, or lacks a joint.
    """
    motions = []
    for number, bag in enumerate(bags):
        progress(number / len(bags), f"reading {Path(bag).name}")
        motions.append(condition(load(bag, topic=topic, joints=joints or None), conditioning))
    return motions


def read_for(model: Model, bags: Sequence[str], order: Order, progress: Progress) -> list[Motion]:
    """Motions treated as those the model was identified from.

    Raises:
        RecordingError: a bag cannot be read or used, or lacks a joint of the model.
    """
    conditioning = treatment(model, order.effort_scale, order.effort_offset)
    return read(bags, order.topic, model.joints, conditioning, progress)


def open_model(order: Order) -> Model:
    """The model of an order, with the effects of the user's own that it may have.

    Raises:
        ModelError: it cannot be read.
        EffectError: the file of effects cannot be used.
    """
    load_own_effects(order.effects_file)
    return Model.load(order.model_file)
