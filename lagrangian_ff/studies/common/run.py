"""A whole study: case by case, on whatever workers, from where it was interrupted."""

from pathlib import Path

from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.studies.common.case import Line
from lagrangian_ff.studies.common.folder import Folder
from lagrangian_ff.studies.common.study import Study
from lagrangian_ff.studies.common.workers import Workers, here


def run(
    study: Study, output: Path, workers: Workers = here, progress: Progress = silent
) -> list[Line]:
    """Do what is not done yet.

    Args:
        study: what is done.
        output: the study's folder; a study that is there already goes on.
        workers: who does the cases.
        progress: told the share of cases done.

    Returns:
        The lines of all the cases asked for, in the study's order.

    Raises:
        UserError: the folder holds another study or cannot be written, no case matches, or there
            are no workers.
        KeyboardInterrupt: Ctrl-C; what was done is kept, and the same call goes on from there.
    """
    wanted = study.cases()
    folder = Folder(output, study.name)
    folder.prepare(study.identity())
    lines = {name: line for name, line in folder.done().items() if "failed" not in line}
    todo = [case for case in wanted if case.name not in lines]
    count = len(wanted) - len(todo)
    progress(count / len(wanted), "cases")
    for line in workers(todo) if todo else ():
        lines[line["case"]] = folder.append(line)
        count += 1
        progress(count / len(wanted), f"{count} of {len(wanted)} cases, {line['case']}")
    return [lines[case.name] for case in wanted]
