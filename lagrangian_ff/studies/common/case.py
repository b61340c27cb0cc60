"""A case: the smallest piece of a study, done in one go and kept as one line."""

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Protocol

from threadpoolctl import threadpool_limits

from lagrangian_ff.kernels import threads

Line = dict[str, Any]
"""What is kept of a case, as JSON holds it: `case`, its findings, and `seconds`; or `failed`."""


class Case(Protocol):
    """Independent of all others and picklable, so that any process on any machine can do it."""

    @property
    def name(self) -> str:
        """Unique in the study."""

    def run(self) -> Mapping[str, Any]:
        """Do it; the findings, the same wherever it is done."""


def attempt(case: Case) -> Line:
    """Do a case, on one thread.

    Returns:
        Its line. A case that breaks down is a finding about what was studied, not the end of the
        study: the line says in `failed` why.
    """
    began = time.monotonic()
    with one_thread():
        try:
            found = dict(case.run())
        except Exception as error:
            found = {"failed": f"{type(error).__name__}: {error}"}
    return {"case": case.name, "seconds": round(time.monotonic() - began, 2), **found}


@contextmanager
def one_thread() -> Iterator[None]:
    """Let the block compute on one thread: cases fill the processors, not their parts."""
    with threads.limited(1), threadpool_limits(1):
        yield
