"""The parameters of the node that watches a model."""

from lagrangian_ff.nodes.common.parameters import Parameters
from lagrangian_ff.nodes.watching.health import Limits


def declare(parameters: Parameters) -> None:
    """Declare all that does not depend on the joints of the model."""
    add = parameters.declare
    add("model_file", "", "the identified model to watch", read_only=True)
    add("effects_file", "", "Python that defines effects of your own; empty = none",
        read_only=True)  # fmt: skip
    add("rate", 100.0, "Hz of prediction and residual, at most that of the joint states",
        low=1.0, high=1000.0, read_only=True)  # fmt: skip
    add("window", 5.0, "s over which the residual is judged", low=0.5, high=600.0)
    add("warn_ratio", 2.0, "times the error when identified from which on it is warned of",
        low=1.0, high=1000.0)  # fmt: skip
    add("error_ratio", 4.0, "times the error when identified that is an error",
        low=1.0, high=1000.0)  # fmt: skip
    add("still_speed", 0.01, "rad/s; a joint that is slower is not judged, as friction may hold it "
        "at any torque", low=0.0, high=10.0)  # fmt: skip
    add("range_margin", 0.25, "how far outside the identified range still counts as inside, as a "
        "fraction of the range", low=0.0, high=10.0)  # fmt: skip


def limits(parameters: Parameters) -> Limits:
    """When to judge and when to warn, by now."""
    value = parameters.value
    return Limits(
        window=value("window"),
        still=value("still_speed"),
        margin=value("range_margin"),
        warn=value("warn_ratio"),
        error=value("error_ratio"),
    )
