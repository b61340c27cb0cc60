"""Workers that do cases: this process, processes of this machine, or a Dask cluster."""

import signal
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from lagrangian_ff import __version__
from lagrangian_ff.errors import UserError
from lagrangian_ff.kernels import threads
from lagrangian_ff.studies.study import Case, Line

if TYPE_CHECKING:
    from distributed import Client

Workers = Callable[[Sequence[Case]], Iterable[Line]]
"""Does cases and yields their lines as they come, in any order."""

KILLS = 3
"""How often a process of this machine may be killed before the study gives up."""


def attempt(case: Case) -> Line:
    """Do a case, on one thread: cases fill the processors, not their parts.

    Returns:
        Its line. A case that breaks down is a finding about what was studied, not the end of the
        study: the line's `failed` says why.
    """
    began = time.monotonic()
    with threads.limited(1), threads.one_blas_thread():
        try:
            found = dict(case.run())
        except Exception as error:
            found = {"failed": f"{type(error).__name__}: {error}"}
    return {"case": case.name, "seconds": round(time.monotonic() - began, 2), **found}


def here(cases: Sequence[Case]) -> Iterator[Line]:
    """Do cases in this process, one after the other."""
    yield from map(attempt, cases)


def processes(jobs: int | None = None) -> Workers:
    """Return workers that are processes of this machine, of one thread each.

    The case of a process that is killed, as for want of memory, is tried again.

    Args:
        jobs: how many processes; None is one for every processor.

    Raises:
        UserError: fewer than one.
    """
    import joblib

    many = joblib.cpu_count() if jobs is None else jobs
    if many < 1:
        raise UserError(f"jobs is {many}, expected at least 1")
    if many == 1:
        return here

    # Ubuntu 24.04 has joblib 1.3, which gives no result before those of earlier cases.
    recent = tuple(map(int, joblib.__version__.split(".")[:2])) >= (1, 4)
    order = "generator_unordered" if recent else "generator"

    def done(cases: Sequence[Case]) -> Iterator[Line]:
        from joblib.externals.loky.process_executor import TerminatedWorkerError

        left = {case.name: case for case in cases}
        for tries in range(KILLS + 1):
            work = joblib.Parallel(n_jobs=many, return_as=order, batch_size=1)
            try:
                for line in work(joblib.delayed(_quietly)(case) for case in list(left.values())):
                    del left[line["case"]]
                    yield line
                return
            except TerminatedWorkerError as error:
                if tries == KILLS:
                    raise UserError(
                        f"processes of the study were killed {KILLS + 1} times, perhaps for want "
                        "of memory: use fewer --jobs. What was done is kept"
                    ) from error

    return done


def _quietly(case: Case) -> Line:
    """Do a case, and leave Ctrl-C to the process that started this one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    return attempt(case)


def cluster(address: str, *, answer: float = 10.0, workers: float = 30.0) -> Workers:
    """Return the workers of a Dask scheduler at an address such as `tcp://host:8786`.

    The case of a worker that dies is tried again on another worker.

    Args:
        address: of the scheduler.
        answer, workers: s to wait for its answer, and for a worker of it.

    Raises:
        UserError: the package distributed is not installed.
    """
    try:
        from distributed import as_completed
    except ImportError as error:
        raise UserError(
            "--scheduler needs Dask: pip install -e '.[cluster]' in the source folder, here and on "
            "the workers"
        ) from error

    def done(cases: Sequence[Case]) -> Iterator[Line]:
        with _connected(address, answer, workers) as client:
            futures = {client.submit(attempt, case, pure=False): case for case in cases}
            for future in as_completed(list(futures)):
                case = futures.pop(future)
                if future.status == "finished":
                    yield future.result()
                else:
                    error = future.exception()
                    yield {"case": case.name, "failed": f"{type(error).__name__}: {error}"}

    return done


def _connected(address: str, answer: float, workers: float) -> "Client":
    from distributed import Client

    try:
        client = Client(address, timeout=answer)
    except (OSError, ValueError) as error:
        raise UserError(
            f"no Dask scheduler answers at {address} within {answer:g} s: start one with "
            "`dask scheduler`, and workers with `dask worker ADDRESS --nthreads 1`"
        ) from error
    with ExitStack() as unless_ready:
        unless_ready.callback(client.close)
        try:
            client.wait_for_workers(1, timeout=workers)
            found = client.run(_installed)
        except TimeoutError as error:
            raise UserError(
                f"the Dask scheduler at {address} has no workers: start some with "
                f"`dask worker {address} --nthreads 1`"
            ) from error
        except ModuleNotFoundError as error:
            raise UserError(
                f"a worker of {address} has no {error.name}: install lagrangian_ff {__version__} "
                "there"
            ) from error
        for worker, version in found.items():
            if version != __version__:
                raise UserError(
                    f"the worker {worker} has lagrangian_ff {version}, expected {__version__} as "
                    "here"
                )
        unless_ready.pop_all()
    return client


def _installed() -> str:
    return __version__
