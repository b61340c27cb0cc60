"""Work on pairs of states, shared by threads: the compiled loops hold no lock."""

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from itertools import pairwise
from typing import TypeVar

import numpy as np

try:
    from threadpoolctl import threadpool_limits
except ImportError:  # ROS' package has no key for it
    threadpool_limits = None

Result = TypeVar("Result")
Part = TypeVar("Part")

FEWEST_PAIRS = 4000
"""A second thread pays from this number of pairs of states on."""


_limit: ContextVar[int | None] = ContextVar("limit", default=None)


def count() -> int:
    """Return how many threads may work: the limit, OMP_NUM_THREADS, or one a processor."""
    limit = _limit.get()
    if limit is None:
        asked = os.environ.get("OMP_NUM_THREADS", "").partition(",")[0]
        limit = int(asked) if asked.isdigit() else len(os.sched_getaffinity(0))
    return max(1, limit)


@contextmanager
def limited(threads: int) -> Iterator[None]:
    """Limit the number of threads in the block."""
    before = _limit.set(threads)
    try:
        yield
    finally:
        _limit.reset(before)


def one_blas_thread() -> AbstractContextManager[object]:
    """Keep the linear algebra to one thread, from the call to the end of the block, if it has one.

    Without threadpoolctl the number of threads stays what OMP_NUM_THREADS or OPENBLAS_NUM_THREADS
    says: slower, and no different in its results.
    """
    return nullcontext() if threadpool_limits is None else threadpool_limits(1)


def each(work: Callable[[Part], Result], parts: Iterable[Part], pairs: int) -> list[Result]:
    """Return the result of the work on every part, in their order.

    Args:
        work: is called from several threads.
        parts: in any number; a thread takes the next when it is free.
        pairs: of states, in all parts together.
    """
    many = count() if pairs >= FEWEST_PAIRS else 1
    if many == 1:
        return [work(part) for part in parts]
    with ThreadPoolExecutor(many) as pool:
        return list(pool.map(work, parts))


def side_by_side(work: Callable[[Part], Result], parts: Iterable[Part]) -> list[Result]:
    """Return the result of the work on every part, in their order.

    Each part is done by one thread, its linear algebra with it: threads of BLAS that share a small
    product mostly wait for each other.
    """

    def alone(part: Part) -> Result:
        with limited(1):
            return work(part)

    with one_blas_thread(), ThreadPoolExecutor(count()) as pool:
        return list(pool.map(alone, parts))


def over_rows(
    work: Callable[[slice], None], rows: int, pairs: float, *, lower: bool = False
) -> None:
    """Divide rows among threads, or do all in this one if that is quicker.

    Args:
        work: is called from several threads, with their rows.
        rows: how many there are.
        pairs: see `each`; for other work, the pairs that cost as much.
        lower: whether only pairs up to the diagonal count.
    """
    if pairs < FEWEST_PAIRS or count() == 1:
        work(slice(0, rows))
    else:
        each(lambda part: work(slice(*part)), row_ranges(rows, lower), round(pairs))


def row_ranges(rows: int, lower: bool) -> list[tuple[int, int]]:
    """Return ranges of rows of a matrix with equal numbers of pairs, one a thread."""
    share = np.linspace(0.0, 1.0, count() + 1)
    ends = np.rint(rows * (np.sqrt(share) if lower else share)).astype(int)
    return [(a, b) for a, b in pairwise(ends.tolist()) if b > a]
