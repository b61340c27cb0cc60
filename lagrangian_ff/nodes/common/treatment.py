"""How measurements are treated so that a model may be held against them."""

from collections.abc import Mapping
from dataclasses import replace

from lagrangian_ff.identification import Model
from lagrangian_ff.recording import Conditioning


def treatment(
    model: Model, effort_scale: Mapping[str, float], effort_offset: Mapping[str, float]
) -> Conditioning:
    """The treatment of the recordings the model was identified from.

    Args:
        model: tells it in its record.
        effort_scale: N·m per unit of effort by joint; others than 1 go before the model's.
        effort_offset: N·m by joint; others than 0 go before the model's.
    """
    usual = Conditioning.from_record(model.record.get("conditioning")) or Conditioning()

    def of_model(
        known: Mapping[str, float], given: Mapping[str, float], nothing: float
    ) -> dict[str, float]:
        said = {joint: value for joint, value in given.items() if value != nothing}
        return {joint: v for joint, v in {**known, **said}.items() if joint in model.joints}

    return replace(
        usual,
        effort_scale=of_model(usual.effort_scale, effort_scale, 1.0),
        effort_offset=of_model(usual.effort_offset, effort_offset, 0.0),
    )
