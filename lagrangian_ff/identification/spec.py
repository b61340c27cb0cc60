"""A model's name, as in `vrbfs+fri`, a kernel and a basis of effects (43); and sliding joints."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import EFFECTS, GROUPS, Effect
from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels import KERNELS, Family, Kernel, Mechanism
from lagrangian_ff.recording.motion import Motion

ALTERNATIVES: Mapping[str, tuple[str, ...]] = {"auto": ("chain", "chain_rbf")}
"""Names that stand for several kernels, of which the data choose one."""

FRICTION = GROUPS["fri"]
"""Effects that are fitted together with the kernel, as in the paper; others are added to it."""
NUMBER = "prismatic"
"""The hyperparameter of kernels that distinguish sliding joints from those that turn."""


@dataclass(frozen=True)
class Spec:
    """The kernel and the effects of a model.

    Attributes:
        text: the name as given, e.g. `vrbfs+fri`.
        kernel: the family of the Lagrangian part; `none` where there is none.
        effects: the friction basis, in order, each on every joint.
        further: effects that are added after the fit, each with its joint; None is all joints.
        basic: the name without the further effects.
        kernels: all that a name such as `auto` stands for, `kernel` first; empty for one kernel.
        sliding: indices of the joints that slide.
        weightless: whether the torque holds no gravity.
    """

    text: str
    kernel: Family
    effects: tuple[Effect, ...]
    further: tuple[tuple[Effect, str | None], ...] = ()
    basic: str = ""
    kernels: tuple[Family, ...] = ()
    sliding: tuple[int, ...] = ()
    weightless: bool = False

    @property
    def alternatives(self) -> "tuple[Spec, ...]":
        """Return one spec for each kernel that the name stands for."""

        def settled(kernel: Family) -> Spec:
            parts = [kernel.name if p in ALTERNATIVES else p for p in self.basic.split("+")]
            return replace(self, kernel=kernel, kernels=(), basic="+".join(parts))

        return tuple(map(settled, self.kernels or (self.kernel,)))

    def within(self, mechanism: Mechanism) -> "Spec":
        """Return the same model around a known mechanism."""
        kernels = tuple(mechanism.around(one) for one in self.kernels)
        return replace(self, kernel=mechanism.around(self.kernel), kernels=kernels)


def parse(text: str) -> Spec:
    """Return the model of a name: at most one kernel and any number of effects, joined by +.

    Raises:
        ModelError: a part is unknown or stands twice, or there are two kernels; lists the choices.
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
    twice = {name for name in effects if effects.count(name) > 1} | everywhere.intersection(alone)
    if twice:
        raise ModelError(f"model '{text}': {', '.join(sorted(twice))} stands in it twice")
    basic = [name for name in effects if name in FRICTION]
    further = [name.partition("@") for name in effects if name not in FRICTION]
    named = kernels[0] if kernels else "none"
    several = tuple(KERNELS[name] for name in ALTERNATIVES.get(named, ()))
    kept = [part for part in parts if part in kernels or part in GROUPS or part in basic]
    return Spec(
        text,
        several[0] if several else KERNELS[named],
        tuple(EFFECTS[name] for name in basic),
        tuple((EFFECTS[name], joint or None) for name, _, joint in further),
        "+".join(kept or kernels or ["none"]),
        several,
    )


def with_sliding(spec: Spec, prismatic: tuple[str, ...], motion: Motion, known: bool) -> Spec:
    """Return the model of an arm some of whose joints slide.

    Args:
        prismatic: names of the joints that slide.
        known: whether there is a description of the mechanism.

    Raises:
        ModelError: the motion has no such joint; see `require_sliding`, too.
    """
    require_sliding(spec, prismatic, known)
    absent = [name for name in prismatic if name not in motion.joints]
    if absent:
        raise ModelError(
            f"prismatic names {', '.join(absent)}, which is no joint of {motion.source}; it holds "
            f"{', '.join(motion.joints)}: name those of them that slide"
        )
    return replace(spec, sliding=tuple(motion.joints.index(name) for name in prismatic))


def require_sliding(spec: Spec, prismatic: tuple[str, ...], known: bool) -> None:
    """Refuse sliding joints if the kernel ignores them, or a description of the mechanism is given.

    Args:
        spec, prismatic, known: see `with_sliding`.

    Raises:
        ModelError: there is a description, or a kernel does not distinguish sliding joints.
    """
    if not prismatic:
        return
    named = ", ".join(prismatic)
    if known:
        raise ModelError(
            f"prismatic names {named}, but there is a URDF or a linkage, which says itself how "
            "joints move: leave out one of the two"
        )
    if not all(_distinguishes(kernel) for kernel in spec.kernels or (spec.kernel,)):
        able = [*ALTERNATIVES, *(name for name in KERNELS if _distinguishes(KERNELS[name]))]
        raise ModelError(
            f"prismatic names {named}, but the kernel {spec.kernel.name} does not distinguish "
            f"sliding joints from those that turn; those that do are {', '.join(able)}; without "
            "prismatic, vrbf takes the position of every joint as it is"
        )


def _distinguishes(kernel: Family) -> bool:
    return any(one.name == NUMBER for one in kernel.further)


def sliding_of(kernel: Kernel, joints: int) -> NDArray[np.float64]:
    """Return (N,) 1 for joints that slide according to a kernel, 0 for others."""
    return np.asarray(kernel.hyperparameters.get(NUMBER, np.zeros(joints)))
