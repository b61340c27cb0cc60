"""The whole study: case by case, in several processes, from where it was interrupted."""

import fnmatch
import os
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from lagrangian_ff.errors import UserError
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.studies.hidden.cases import Case, cases
from lagrangian_ff.studies.hidden.examine import examine
from lagrangian_ff.studies.hidden.examined import Examined
from lagrangian_ff.studies.hidden.plants import FULL, Stretches
from lagrangian_ff.studies.hidden.store import Folder

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True)
class Options:
    """What is studied.

    Attributes:
        output: the study's folder; a study that is there already goes on.
        seed: of everything that chance decides.
        small: a few cases only.
        only: a pattern with * and ? that the names of the cases must match.
        jobs: processes, each with one thread.
        keep: keep the recordings, and use those that are there.
        stretches: what each recording is made of.
    """

    output: Path
    seed: int = 0
    small: bool = False
    only: str = "*"
    jobs: int = 1
    keep: bool = False
    stretches: Stretches = FULL

    def cases(self) -> list[Case]:
        """The cases asked for.

        Raises:
            UserError: none has such a name.
        """
        every = cases(self.seed, small=self.small)
        found = [case for case in every if fnmatch.fnmatchcase(case.name, self.only)]
        if not found:
            raise UserError(
                f"no case is named {self.only!r}; there are {len(every)}, such as "
                f"{every[0].name} and {every[-1].name}"
            )
        return found


def run(options: Options, examined: Examined, progress: Progress = silent) -> list[dict[str, Any]]:
    """Do what is not done yet.

    Args:
        options: what is studied.
        examined: who diagnoses; must be picklable for several jobs.
        progress: told the share of cases done.

    Returns:
        The lines of all the cases asked for.

    Raises:
        UserError: the folder holds another study or cannot be written, or no case matches.
        KeyboardInterrupt: Ctrl-C; what was done is kept, and the same call goes on from there.
    """
    if options.jobs < 1:
        raise UserError(f"jobs is {options.jobs}, expected at least 1")
    wanted = options.cases()
    folder = Folder(options.output)
    folder.prepare(
        {
            "seed": options.seed,
            "small": options.small,
            "stretches": [list(part) for part in options.stretches.parts],
        }
    )
    lines = {name: line for name, line in folder.done().items() if "failed" not in line}
    todo = [case for case in wanted if case.name not in lines]
    progress((len(wanted) - len(todo)) / len(wanted), "cases")
    for line in _lines(todo, options, examined):
        lines[line["case"]] = folder.append(line)
        count = sum(case.name in lines for case in wanted)
        progress(count / len(wanted), f"{count} of {len(wanted)} cases, {line['case']}")
    return [lines[case.name] for case in wanted]


def _lines(todo: Sequence[Case], options: Options, examined: Examined) -> Iterator[dict[str, Any]]:
    work = [(case, options.output, options.stretches, examined, options.keep) for case in todo]
    if options.jobs == 1 or len(work) < 2:
        with threadpool_limits(1):
            yield from map(_one, work)
        return
    with _one_thread(), get_context("spawn").Pool(options.jobs, _quiet) as pool:
        yield from pool.imap_unordered(_one, work)


def _one(work: tuple[Case, Path, Stretches, Examined, bool]) -> dict[str, Any]:
    case, folder, stretches, examined, keep = work
    return examine(case, folder, stretches, examined, keep=keep)


def _quiet() -> None:
    """Leave Ctrl-C to the process that started this one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Let processes started in the block compute with one thread each."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
