"""Which joints slide, where no description of the robot tells it."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.spec import ALTERNATIVES, Spec
from lagrangian_ff.kernels import KERNELS, Kernel
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

NUMBER = "prismatic"
"""The hyperparameter of the kernels that tell sliding joints from those that turn."""


def with_sliding(spec: Spec, prismatic: tuple[str, ...], motion: Motion, known: bool) -> Spec:
    """The model of an arm some of whose joints slide.

    Args:
        spec: kernel and effects.
        prismatic: names of the joints that slide.
        motion: what is learned from.
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
    """Refuse to say that joints slide where it would make no difference, or is known already.

    Args:
        spec: kernel and effects.
        prismatic: names of the joints that slide.
        known: whether there is a description of the mechanism.

    Raises:
        ModelError: says what to do.
    """
    if not prismatic:
        return
    named = ", ".join(prismatic)
    if known:
        raise ModelError(
            f"prismatic names {named}, but there is a URDF or a linkage, which says itself how "
            "joints move: leave out one of the two"
        )
    if not all(_tells(kernel) for kernel in spec.kernels or (spec.kernel,)):
        able = [*ALTERNATIVES, *(name for name, kernel in KERNELS.items() if _tells(kernel))]
        raise ModelError(
            f"prismatic names {named}, but the kernel {spec.kernel.name} does not tell sliding "
            f"joints from those that turn; those that do are {', '.join(able)}; without prismatic, "
            "vrbf takes the position of every joint as it is"
        )


def _tells(kernel: type[Kernel]) -> bool:
    return any(one.name == NUMBER for one in kernel.further)


def sliding_of(kernel: Kernel, joints: int) -> Floats:
    """(N,) 1 where a kernel knows that a joint slides, 0 elsewhere."""
    return np.asarray(kernel.hyperparameters.get(NUMBER, np.zeros(joints)))
