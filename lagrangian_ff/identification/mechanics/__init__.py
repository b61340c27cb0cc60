"""Rigid-body quantities of a learned Lagrangian, and a mass matrix kept positive definite."""
