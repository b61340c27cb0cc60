"""Any kernel as one matrix over all joints."""

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels.base import CoupledKernel, IndependentKernel, Kernel
from lagrangian_ff.kernels.states import States

Floats = NDArray[np.float64]


def dense_cross(kernel: Kernel, x: States, u: States) -> Floats:
    """(M_x N, M_u N) kernel between two sets of states, sample major."""
    if isinstance(kernel, CoupledKernel):
        return kernel.cross(x, u)
    assert isinstance(kernel, IndependentKernel)
    out = np.zeros((len(x), x.joints, len(u), x.joints))
    for joint in range(x.joints):
        out[:, joint, :, joint] = kernel.cross(x, u, joint)
    return out.reshape(len(x) * x.joints, -1)


def dense_gram(kernel: Kernel, x: States) -> Floats:
    """(M N, M N) Gram matrix, sample major; its lower triangle of blocks is written."""
    return kernel.gram(x) if isinstance(kernel, CoupledKernel) else dense_cross(kernel, x, x)
