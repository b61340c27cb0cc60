"""Reading a model's name: `vrbfs+fri` is a kernel and a basis of effects, eq. (43)."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from lagrangian_ff.effects import EFFECTS, GROUPS, Effect
from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels import KERNELS, Kernel, Mechanism

ALTERNATIVES: Mapping[str, tuple[str, ...]] = {"auto": ("chain", "chain_rbf")}
"""Names that stand for several kernels, of which the data choose one."""

FRICTION = GROUPS["fri"]
"""Effects that are fitted together with the kernel, as the paper does; others are added to it."""


@dataclass(frozen=True)
class Spec:
    """Which kernel and which effects a model is made of.

    Attributes:
        text: the name as given, e.g. `vrbfs+fri`.
        kernel: the family of the Lagrangian part; `none` where there is none.
        effects: the friction basis, in order, each on every joint.
        further: effects that are added once these are fitted, each with its joint; None is all.
        basic: the name without the further effects.
        kernels: where the name leaves it open, all kernels that it may be; `kernel` is the first.
        sliding: numbers of the joints that are said to slide.
    """

    text: str
    kernel: type[Kernel]
    effects: tuple[Effect, ...]
    further: tuple[tuple[Effect, str | None], ...] = ()
    basic: str = ""
    kernels: tuple[type[Kernel], ...] = ()
    sliding: tuple[int, ...] = ()

    @property
    def alternatives(self) -> "tuple[Spec, ...]":
        """One for each kernel that it may be."""
        return tuple(
            replace(self, kernel=one, kernels=(), basic="+".join(_settled(self.basic, one.name)))
            for one in self.kernels or (self.kernel,)
        )

    def within(self, mechanism: Mechanism) -> "Spec":
        """The same model of a mechanism of which something is known."""
        kernels = tuple(mechanism.around(one) for one in self.kernels)
        return replace(self, kernel=mechanism.around(self.kernel), kernels=kernels)


def parse(text: str) -> Spec:
    """The model a name stands for: at most one kernel and any number of effects, joined by +.

    Raises:
        ModelError: a part is unknown, stands twice, or there are two kernels; lists what there is.
    """
    parts = [part.strip() for part in text.split("+")]
    kernels = [part for part in parts if part in KERNELS or part in ALTERNATIVES]
    effects: list[str] = []
    for part in parts:
        if part in kernels:
            continue
        name, at, joint = part.partition("@")
        if (name not in GROUPS and name not in EFFECTS) or (at and not joint):
            known = ", ".join([*ALTERNATIVES, *KERNELS])
            raise ModelError(
                f"model '{text}': '{part}' is neither a kernel ({known}) "
                f"nor an effect ({', '.join([*GROUPS, *EFFECTS])}); "
                "join one kernel and effects with +, as in vrbfs+fri or vrbfs+fri+stribeck@joint_2"
            )
        effects.extend(f"{one}{at}{joint}" for one in GROUPS.get(name, (name,)))
    if len(kernels) > 1:
        raise ModelError(
            f"model '{text}': {' and '.join(kernels)} are both kernels; "
            "a model has one kernel and any number of effects, as in vrbfs+fri"
        )
    everywhere = {name for name in effects if "@" not in name}
    alone = [name.partition("@")[0] for name in effects if "@" in name]
    twice = sorted(
        {name for name in effects if effects.count(name) > 1} | everywhere.intersection(alone)
    )
    if twice:
        raise ModelError(f"model '{text}': {', '.join(twice)} stands in it twice")
    basic = [name for name in effects if name in FRICTION]
    further = [name.partition("@") for name in effects if name not in FRICTION]
    named = kernels[0] if kernels else "none"
    several = tuple(KERNELS[name] for name in ALTERNATIVES.get(named, ()))
    return Spec(
        text,
        several[0] if several else KERNELS[named],
        tuple(EFFECTS[name] for name in basic),
        tuple((EFFECTS[name], joint or None) for name, _, joint in further),
        _name(kernels, basic, parts),
        several,
    )


def _name(kernels: list[str], basic: list[str], parts: list[str]) -> str:
    """The kernel and the friction by the names they were given."""
    kept = [part for part in parts if part in kernels or part in GROUPS or part in basic]
    return "+".join(kept or kernels or ["none"])


def _settled(name: str, kernel: str) -> list[str]:
    """The parts of a name with the kernel that was chosen."""
    return [kernel if part in ALTERNATIVES else part for part in name.split("+")]
