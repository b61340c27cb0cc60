"""Formulas proposed for a torque that no effect of the catalogue explains."""

from lagrangian_ff.diagnosis.proposing.propose import Proposal, Proposals, propose
from lagrangian_ff.diagnosis.proposing.record import proposals_record

__all__ = ["Proposal", "Proposals", "proposals_record", "propose"]
