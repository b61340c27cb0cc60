"""Kernel matrices over all joints, or over those that are solved together."""

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.kernels.base import CoupledKernel, IndependentKernel, Kernel
from lagrangian_ff.kernels.states import States


def dense_cross(kernel: Kernel, x: States, u: States) -> Floats:
    """Return (M_x N, M_u N) the kernel between two sets of states, sample major."""
    if isinstance(kernel, CoupledKernel):
        return kernel.cross(x, u)
    assert isinstance(kernel, IndependentKernel)
    out = np.zeros((len(x), x.joints, len(u), x.joints))
    for joint in range(x.joints):
        out[:, joint, :, joint] = kernel.cross(x, u, joint)
    return out.reshape(len(x) * x.joints, -1)


def dense_gram(kernel: Kernel, x: States) -> Floats:
    """Return (M N, M N) the Gram matrix, sample major; its upper blocks need not be set."""
    return kernel.gram(x) if isinstance(kernel, CoupledKernel) else dense_cross(kernel, x, x)


def together(kernel: Kernel, joints: int) -> list[tuple[int, ...]]:
    """Return the groups of joints that are solved together."""
    if isinstance(kernel, CoupledKernel):
        return [tuple(range(joints))]
    return [(joint,) for joint in range(joints)]


def cross_of(kernel: Kernel, x: States, u: States, joints: tuple[int, ...]) -> Floats:
    """Return (M_x n, M_u n) the kernel of n joints that are solved together, sample major."""
    if isinstance(kernel, CoupledKernel):
        return kernel.cross(x, u)
    assert isinstance(kernel, IndependentKernel)
    return kernel.cross(x, u, joints[0])


def gram_of(kernel: Kernel, x: States, joints: tuple[int, ...]) -> Floats:
    """Return (M n, M n) their Gram matrix, C-contiguous; its upper blocks need not be set."""
    if isinstance(kernel, CoupledKernel):
        return kernel.gram(x)
    assert isinstance(kernel, IndependentKernel)
    return np.ascontiguousarray(kernel.gram(x, joints[0]))
