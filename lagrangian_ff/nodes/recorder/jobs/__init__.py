"""The jobs of the identify node: each is a service, one class in one file, and a line here."""

from lagrangian_ff.nodes.recorder.jobs.add import Add
from lagrangian_ff.nodes.recorder.jobs.base import Job
from lagrangian_ff.nodes.recorder.jobs.compare import Compare
from lagrangian_ff.nodes.recorder.jobs.diagnose import Diagnose
from lagrangian_ff.nodes.recorder.jobs.identify import Identify
from lagrangian_ff.nodes.recorder.jobs.investigate import Investigate
from lagrangian_ff.nodes.recorder.jobs.load import Load

JOBS: tuple[type[Job], ...] = (Load, Identify, Compare, Diagnose, Add, Investigate)
