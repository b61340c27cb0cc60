"""Where a model differs from what was measured, which effect it lacks, and what adding it does."""

from lagrangian_ff.diagnosis.adding import add, apply, consequences, history
from lagrangian_ff.diagnosis.compare import Comparison, compare, with_intervals
from lagrangian_ff.diagnosis.diagnose import diagnose
from lagrangian_ff.diagnosis.record import diagnosis_record
from lagrangian_ff.diagnosis.results import Diagnosis, Finding, Verdict
from lagrangian_ff.diagnosis.since import Changed, changed_since

__all__ = [
    "Changed",
    "Comparison",
    "Diagnosis",
    "Finding",
    "Verdict",
    "add",
    "apply",
    "changed_since",
    "compare",
    "consequences",
    "diagnose",
    "diagnosis_record",
    "history",
    "with_intervals",
]
