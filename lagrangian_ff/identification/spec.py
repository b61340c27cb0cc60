"""Reading a model's name: `vrbfs+fri` is a kernel and a basis of effects, eq. (43)."""

from dataclasses import dataclass

from lagrangian_ff.effects import EFFECTS, GROUPS, Effect
from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels import KERNELS, Kernel


@dataclass(frozen=True)
class Spec:
    """Which kernel and which effects a model is made of.

    Attributes:
        text: the name as given, e.g. `vrbfs+fri`.
        kernel: the family of the Lagrangian part; `none` where there is none.
        effects: the basis, in order, each on every joint.
    """

    text: str
    kernel: type[Kernel]
    effects: tuple[Effect, ...]


def parse(text: str) -> Spec:
    """The model a name stands for: at most one kernel and any number of effects, joined by +.

    Raises:
        ModelError: a part is unknown, stands twice, or there are two kernels; lists what there is.
    """
    parts = [part.strip() for part in text.split("+")]
    kernels = [part for part in parts if part in KERNELS]
    effects: list[str] = []
    for part in parts:
        if part in KERNELS:
            continue
        if part not in GROUPS and part not in EFFECTS:
            raise ModelError(
                f"model '{text}': '{part}' is neither a kernel ({', '.join(KERNELS)}) "
                f"nor an effect ({', '.join([*GROUPS, *EFFECTS])}); "
                "join one kernel and effects with +, as in vrbfs+fri"
            )
        effects.extend(GROUPS.get(part, (part,)))
    if len(kernels) > 1:
        raise ModelError(
            f"model '{text}': {' and '.join(kernels)} are both kernels; "
            "a model has one kernel and any number of effects, as in vrbfs+fri"
        )
    twice = sorted({name for name in effects if effects.count(name) > 1})
    if twice:
        raise ModelError(f"model '{text}': {', '.join(twice)} stands in it twice")
    kernel = KERNELS[kernels[0] if kernels else "none"]
    return Spec(text, kernel, tuple(EFFECTS[name] for name in effects))
