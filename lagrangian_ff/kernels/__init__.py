"""Kernels on torques, by the names the paper gives them."""

from lagrangian_ff.kernels.base import CoupledKernel, Hyperparameter, IndependentKernel, Kernel
from lagrangian_ff.kernels.chain import Chain
from lagrangian_ff.kernels.finite import Motor, Nothing, Pol
from lagrangian_ff.kernels.lagrangian import Srbf, Srbfs, Svrbf, Svrbfs, Vrbf, Vrbfs
from lagrangian_ff.kernels.rbf import Rbf, Rbfs
from lagrangian_ff.kernels.states import States

KERNELS: dict[str, type[Kernel]] = {
    kernel.name: kernel
    for kernel in (Rbf, Rbfs, Srbf, Srbfs, Svrbf, Svrbfs, Vrbf, Vrbfs, Chain, Pol, Motor, Nothing)
}
"""Every kernel by its name; a new one joins here and in its own file: the tests read this list."""

__all__ = [
    "KERNELS",
    "CoupledKernel",
    "Hyperparameter",
    "IndependentKernel",
    "Kernel",
    "States",
]
