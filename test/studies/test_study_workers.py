"""Processes and clusters do the cases, whatever happens to a process."""

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from counting import Square

from lagrangian_ff.errors import UserError
from lagrangian_ff.studies.workers import Workers, cluster, processes

HERE = Path(__file__).parent


def squares(folder: Path, count: int = 4) -> list[Square]:
    return [Square(number, folder) for number in range(count)]


def test_processes_do_what_one_does(tmp_path: Path) -> None:
    lines = list(processes(2)(squares(tmp_path, 24)))
    assert {line["case"]: line["square"] for line in lines} == {
        f"square-{number}": number**2 for number in range(24)
    }
    assert os.getpid() not in {line["process"] for line in lines}
    assert [line["process"] for line in processes(1)(squares(tmp_path, 1))] == [os.getpid()]


def test_a_killed_process_costs_its_case_a_try(tmp_path: Path) -> None:
    deadly = Square(7, tmp_path, deadly=True)
    lines = list(processes(2)([*squares(tmp_path), deadly]))
    assert sorted(line["square"] for line in lines) == [0, 1, 4, 9, 49]
    assert deadly.tries() == 2


def test_fewer_than_one_process_is_refused() -> None:
    with pytest.raises(UserError, match="jobs is 0"):
        processes(0)


SCHEDULER = ("scheduler", "--host", "127.0.0.1", "--no-dashboard", "--port")
WORKER = ("--nthreads", "1", "--host", "127.0.0.1", "--no-dashboard")


def _free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """Yield the address of a Dask scheduler with two workers, three processes in all."""
    pytest.importorskip("distributed", reason="Dask is not installed")
    port = _free_port()
    address = f"tcp://127.0.0.1:{port}"
    started = [_dask(*SCHEDULER, str(port))]
    try:
        started += [_dask("worker", address, *WORKER) for _ in range(2)]
        yield address
    finally:
        # Workers first, and waited for: without their scheduler they take seconds to end.
        for process in reversed(started):
            process.terminate()
            process.wait(20.0)


def _dask(*arguments: str, first: Path = HERE) -> subprocess.Popen[bytes]:
    path = os.pathsep.join([str(first), str(HERE), os.environ.get("PYTHONPATH", "")])
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments],
        env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def patient(address: str) -> Workers:
    """Return the workers of a scheduler on a machine that may be busy."""
    return cluster(address, answer=60.0, workers=60.0)


def test_a_cluster_does_what_one_process_does(scheduler: str, tmp_path: Path) -> None:
    cases = [*squares(tmp_path), Square(-1, tmp_path)]
    lines = {line["case"]: line for line in patient(scheduler)(cases)}
    assert [lines[f"square-{number}"]["square"] for number in range(4)] == [0, 1, 4, 9]
    assert lines["square--1"]["failed"] == "ValueError: negative"
    assert os.getpid() not in {line.get("process") for line in lines.values()}


def test_a_killed_worker_costs_its_case_a_try(scheduler: str, tmp_path: Path) -> None:
    deadly = Square(7, tmp_path, deadly=True)
    lines = list(patient(scheduler)([deadly, *squares(tmp_path)]))
    assert sorted(line["square"] for line in lines) == [0, 1, 4, 9, 49]
    assert deadly.tries() == 2
    assert all(case.tries() <= 2 for case in squares(tmp_path))


def test_workers_of_another_version_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("distributed", reason="Dask is not installed")
    (tmp_path / "sitecustomize.py").write_text(
        "import lagrangian_ff\nlagrangian_ff.__version__ = '9.9.9'\n"
    )
    port = _free_port()
    address = f"tcp://127.0.0.1:{port}"
    started = [_dask(*SCHEDULER, str(port)), _dask("worker", address, *WORKER, first=tmp_path)]
    try:
        with pytest.raises(UserError, match=r"the worker tcp://.* has lagrangian_ff 9\.9\.9, exp"):
            list(patient(address)(squares(tmp_path)))
    finally:
        for process in reversed(started):
            process.terminate()
            process.wait(20.0)


def test_a_scheduler_that_is_not_there_is_reported(tmp_path: Path) -> None:
    pytest.importorskip("distributed", reason="Dask is not installed")
    with pytest.raises(UserError, match=r"no Dask scheduler answers at tcp://127\.0\.0\.1:9"):
        list(cluster("tcp://127.0.0.1:9", answer=1.0)(squares(tmp_path)))
    with pytest.raises(UserError, match="no Dask scheduler answers at nonsense"):
        list(cluster("nonsense://here")(squares(tmp_path)))


def test_a_scheduler_without_workers_is_reported(tmp_path: Path) -> None:
    pytest.importorskip("distributed", reason="Dask is not installed")
    port = _free_port()
    process = _dask(*SCHEDULER, str(port))
    try:
        with pytest.raises(UserError, match="has no workers"):
            list(cluster(f"tcp://127.0.0.1:{port}", answer=60.0, workers=0.2)(squares(tmp_path)))
    finally:
        process.terminate()
        process.wait(20.0)
