"""From bags to a model."""

from pathlib import Path
from typing import Any

from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.kernels.rigid import read_urdf
from lagrangian_ff.nodes.common.own_effects import load_own_effects
from lagrangian_ff.nodes.recorder.order import Order
from lagrangian_ff.nodes.recorder.tasks.reading import read
from lagrangian_ff.progress import Progress, part
from lagrangian_ff.recording import Conditioning


def identify_bags(order: Order, progress: Progress) -> dict[str, Any]:
    """From bags to a model file, by the code the command line uses; the record.

    Raises:
        UserError: a recording or a setting cannot be used.
    """
    load_own_effects(order.effects_file)
    conditioning = Conditioning(
        bandwidth=order.bandwidth,
        effort_scale=order.effort_scale,
        effort_offset=order.effort_offset,
    )
    reading = part(progress, 0.0, 0.1)
    motions = read(order.bags, order.topic, order.joints, conditioning, reading)
    settings = Settings(
        model=order.model,
        train=order.train,
        samples=order.samples,
        landmarks=order.landmarks,
        positive=order.positive,
        loss=order.loss,
        prismatic=order.prismatic,
    )
    found = identify(
        motions,
        settings,
        part(progress, 0.1, 1.0),
        read_urdf(order.urdf) if order.urdf else None,
    )
    found.model.save(Path(order.output))
    return dict(found.record)
