"""Kernels on torques, by the names the paper gives them."""

from lagrangian_ff.kernels.base import (
    Contracted,
    CoupledKernel,
    DifferentiableKernel,
    Hyperparameter,
    IndependentKernel,
    Kernel,
    LagrangianKernel,
    Learned,
)
from lagrangian_ff.kernels.finite import Motor, Nothing, Pol
from lagrangian_ff.kernels.lagrangian import Srbf, Srbfs, Svrbf, Svrbfs, Vrbf, Vrbfs
from lagrangian_ff.kernels.mechanism import Mechanism
from lagrangian_ff.kernels.rbf import Rbf, Rbfs
from lagrangian_ff.kernels.states import States
from lagrangian_ff.kernels.structured import Chain, ChainRbf, Energy, EnergyRbf

PAPER = (Rbf, Rbfs, Srbf, Srbfs, Svrbf, Svrbfs, Vrbf, Vrbfs)

KERNELS: dict[str, type[Kernel]] = {
    kernel.name: kernel
    for kernel in (*PAPER, Energy, EnergyRbf, Chain, ChainRbf, Pol, Motor, Nothing)
}
"""Every kernel by its name; a new one joins here and in its own file: the tests read this list."""

__all__ = [
    "KERNELS",
    "Contracted",
    "CoupledKernel",
    "DifferentiableKernel",
    "Hyperparameter",
    "IndependentKernel",
    "Kernel",
    "LagrangianKernel",
    "Learned",
    "Mechanism",
    "States",
]
