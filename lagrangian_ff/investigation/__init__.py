"""Experiments that decide: move, diagnose, ask the next question, until nothing is left."""

from lagrangian_ff.investigation.asking import next_question
from lagrangian_ff.investigation.investigate import investigate
from lagrangian_ff.investigation.rig import Permit, Plan, Proposal, Rig, StoppedError
from lagrangian_ff.investigation.story import Asked, Ended, Investigation, PassedOver, Turn

__all__ = [
    "Asked",
    "Ended",
    "Investigation",
    "PassedOver",
    "Permit",
    "Plan",
    "Proposal",
    "Rig",
    "StoppedError",
    "Turn",
    "investigate",
    "next_question",
]
