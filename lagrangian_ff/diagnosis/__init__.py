"""Where a model differs from what was measured, which effect it lacks, and what adding it does."""

from lagrangian_ff.diagnosis.add import add, history
from lagrangian_ff.diagnosis.apply import apply
from lagrangian_ff.diagnosis.compare import Comparison, compare, with_intervals
from lagrangian_ff.diagnosis.diagnose import Diagnosis, Finding, diagnose
from lagrangian_ff.diagnosis.since import Changed, changed_since

__all__ = [
    "Changed",
    "Comparison",
    "Diagnosis",
    "Finding",
    "add",
    "apply",
    "changed_since",
    "compare",
    "diagnose",
    "history",
    "with_intervals",
]
