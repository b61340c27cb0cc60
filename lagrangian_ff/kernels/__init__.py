"""Kernels on torques, by the names the paper gives them."""

from lagrangian_ff.kernels.base import (
    CoupledKernel,
    DifferentiableKernel,
    Family,
    Hyperparameter,
    IndependentKernel,
    Kernel,
    LagrangianKernel,
    Learned,
    Mechanism,
)
from lagrangian_ff.kernels.baselines import Motor, Nothing, Pol, Rbf, Rbfs
from lagrangian_ff.kernels.lagrangian import Srbf, Srbfs, Svrbf, Svrbfs, Vrbf, Vrbfs
from lagrangian_ff.kernels.states import States
from lagrangian_ff.kernels.structured.chain import Chain, ChainRbf, Energy, EnergyRbf

PAPER = (Rbf, Rbfs, Srbf, Srbfs, Svrbf, Svrbfs, Vrbf, Vrbfs)

KERNELS: dict[str, type[Kernel]] = {
    kernel.name: kernel
    for kernel in (*PAPER, Energy, EnergyRbf, Chain, ChainRbf, Pol, Motor, Nothing)
}
"""Every kernel by its name; add a new one here. The tests run over this list."""

__all__ = [
    "KERNELS",
    "CoupledKernel",
    "DifferentiableKernel",
    "Family",
    "Hyperparameter",
    "IndependentKernel",
    "Kernel",
    "LagrangianKernel",
    "Learned",
    "Mechanism",
    "States",
]
