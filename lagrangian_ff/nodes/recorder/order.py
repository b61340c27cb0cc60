"""What is to be done with recordings, as handed from the node to the process that does it."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from enum import Enum


class Task(Enum):
    """What the process can do; the values are the names of the services."""

    IDENTIFY = "identify"
    COMPARE = "compare"
    DIAGNOSE = "diagnose"
    ADD = "add"


@dataclass(frozen=True)
class Addition:
    """An effect to add to a model.

    Attributes:
        effect: a name of the catalogue.  joint: where it acts.
        shape: nonlinear parameters; what is not given is searched.
        why: what the model's history shall tell of the reason.
    """

    effect: str
    joint: str
    shape: Mapping[str, float] | None = None
    why: Mapping[str, object] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.effect} on {self.joint}"


@dataclass(frozen=True)
class Order:
    """One piece of work; what its task has no use for stays empty.

    Attributes:
        task: what to do.
        output: the file to write, a model or the findings as JSON; a page of the same name with
            the ending .html comes beside it.
        bags: recordings used together.
        confirm: recordings that confirm a diagnosis; empty for the end of `bags`.
        topic: of the joint states in them.
        model_file: the model to compare, diagnose or add to.
        effects_file: Python that defines effects of the user's own; empty for none.
        joints: which to identify, in which order; empty for all that were recorded.
        model: name of the model to identify, such as "auto+fri".
        urdf: file of the robot's description; empty where nothing is known of it.
        prismatic: joints that slide, where no description says it.
        train: fraction of the motion to train on.
        samples: how many samples to train on.
        landmarks: how many samples the kernel is built on where all are learned from; 0 makes the
            model exactly, from `samples`, and None leaves it to the length of the motion.
        positive: whether the mass matrix is kept positive definite.
        loss: what a residual costs, "square" or "huber".
        bandwidth: Hz of the low-pass.
        effort_scale, effort_offset: by joint, N·m per unit of effort and N·m.
        additions: what to add.
    """

    task: Task
    output: str
    bags: tuple[str, ...] = ()
    confirm: tuple[str, ...] = ()
    topic: str = "joint_states"
    model_file: str = ""
    effects_file: str = ""
    joints: tuple[str, ...] = ()
    model: str = "auto+fri"
    urdf: str = ""
    prismatic: tuple[str, ...] = ()
    train: float = 2.0 / 3.0
    samples: int = 500
    landmarks: int | None = None
    positive: bool = False
    loss: str = "square"
    bandwidth: float = 25.0
    effort_scale: dict[str, float] = field(default_factory=dict)
    effort_offset: dict[str, float] = field(default_factory=dict)
    additions: tuple[Addition, ...] = ()

    def to_json(self) -> str:
        """One line of JSON."""
        return json.dumps({**asdict(self), "task": self.task.value})

    @staticmethod
    def from_json(text: str) -> "Order":
        """The order that `to_json` wrote."""
        fields = json.loads(text)
        for name in ("bags", "confirm", "joints", "prismatic"):
            fields[name] = tuple(fields[name])
        fields["additions"] = tuple(Addition(**each) for each in fields["additions"])
        return Order(**{**fields, "task": Task(fields["task"])})
