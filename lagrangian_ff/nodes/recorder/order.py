"""What is to be identified, as handed from the node to the process that does it."""

import json
from dataclasses import asdict, dataclass, field


@dataclass(frozen=True)
class Order:
    """One identification.

    Attributes:
        bags: recordings used together.
        topic: of the joint states in them.
        joints: which, in which order; empty for all that were recorded.
        model: name of the model, such as "vrbfs+fri".
        train: fraction of the motion to train on.
        samples: how many samples to train on.
        bandwidth: Hz of the low-pass.
        effort_scale, effort_offset: by joint, N·m per unit of effort and N·m.
        output: the model file to write.
    """

    bags: tuple[str, ...]
    output: str
    topic: str = "joint_states"
    joints: tuple[str, ...] = ()
    model: str = "vrbfs+fri"
    train: float = 2.0 / 3.0
    samples: int = 500
    bandwidth: float = 25.0
    effort_scale: dict[str, float] = field(default_factory=dict)
    effort_offset: dict[str, float] = field(default_factory=dict)

    def to_json(self) -> str:
        """One line of JSON."""
        return json.dumps(asdict(self))

    @staticmethod
    def from_json(text: str) -> "Order":
        """The order that `to_json` wrote."""
        fields = json.loads(text)
        return Order(**{**fields, "bags": tuple(fields["bags"]), "joints": tuple(fields["joints"])})
