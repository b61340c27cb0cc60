"""Kernels that know what a mechanical Lagrangian is: quadratic in velocity, gravity apart."""

from lagrangian_ff.kernels.structured.chain import Chain, ChainRbf, Energy, EnergyRbf

__all__ = ["Chain", "ChainRbf", "Energy", "EnergyRbf"]
