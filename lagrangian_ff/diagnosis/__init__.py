"""Where a model differs from what was measured, which effect it lacks, and what adding it does."""

from lagrangian_ff.diagnosis.adding import add, apply, history, with_consequences
from lagrangian_ff.diagnosis.compare import Comparison, compare, with_intervals
from lagrangian_ff.diagnosis.confidence import Verdict
from lagrangian_ff.diagnosis.diagnose import diagnose
from lagrangian_ff.diagnosis.record import diagnosis_record, run_record
from lagrangian_ff.diagnosis.results import Diagnosis, Finding
from lagrangian_ff.diagnosis.run import Changed, DiagnosisRun, Round, believed
from lagrangian_ff.diagnosis.sentences import verdict
from lagrangian_ff.diagnosis.since import changed_if_misfit, changed_since

__all__ = [
    "Changed",
    "Comparison",
    "Diagnosis",
    "DiagnosisRun",
    "Finding",
    "Round",
    "Verdict",
    "add",
    "apply",
    "believed",
    "changed_if_misfit",
    "changed_since",
    "compare",
    "diagnose",
    "diagnosis_record",
    "history",
    "run_record",
    "verdict",
    "with_consequences",
    "with_intervals",
]
