"""The nodes' processes always end and their logs are shown; what others take of the machine."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from lagrangian_ff.demo.processes import NodeProcess, Nodes, OtherWork, processor_seconds
from lagrangian_ff.errors import DemoError

PATIENCE = 60.0


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory without the sources: `python -m` would find those first."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def stub(folder: Path, body: str) -> dict[str, str]:
    """An environment in which the module lagrangian_ff.nodes.stub does this.

    A package of that name is put before the real one on the path.
    """
    package = folder / "path" / "lagrangian_ff" / "nodes"
    package.mkdir(parents=True)
    for one in (package, package.parent):
        (one / "__init__.py").touch()
    (package / "stub.py").write_text(body)
    return {**os.environ, "PYTHONPATH": str(folder / "path")}


def until(condition: object, what: str) -> None:
    """Wait for a callable to be true."""
    assert callable(condition)
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, f"waited for {what}"
        time.sleep(0.02)


SLEEPER = "import time\nprint('awake', flush=True)\ntime.sleep(600)\n"
STUBBORN = (
    "import signal, time\n"
    "for number in (signal.SIGINT, signal.SIGTERM):\n"
    "    signal.signal(number, signal.SIG_IGN)\n"
    "print('awake', flush=True)\ntime.sleep(600)\n"
)


@pytest.mark.parametrize("body", [SLEEPER, STUBBORN], ids=["asked to end", "made to end"])
def test_leaving_ends_every_process(elsewhere: Path, body: str) -> None:
    started: list[NodeProcess] = []

    def fail() -> None:
        with Nodes(elsewhere, stub(elsewhere, body)) as nodes:
            started.append(nodes.start("stub"))
            until(lambda: "awake" in started[0].tail(), "the process")
            raise RuntimeError("on purpose")

    with pytest.raises(RuntimeError, match="on purpose"):
        fail()
    assert not started[0].alive


def test_a_process_that_ends_by_itself_is_noticed_with_its_last_words(elsewhere: Path) -> None:
    with Nodes(elsewhere, stub(elsewhere, "raise SystemExit('no such arm')")) as nodes:
        process = nodes.start("stub")
        until(lambda: not process.alive, "its end")
        with pytest.raises(DemoError, match=r"stub ended by itself(.|\n)*no such arm"):
            nodes.check()


def test_parameters_and_remappings_reach_the_node(elsewhere: Path) -> None:
    with Nodes(elsewhere, stub(elsewhere, "import sys; print(sys.argv[1:])")) as nodes:
        process = nodes.start(
            "stub", parameters={"a": True, "b": "out dir", "c": 2}, remap={"__ns": "/x"}
        )
        until(lambda: not process.alive, "its end")
    expected = ["--ros-args", "-r", "__ns:=/x", "-p", "a:=true", "-p", 'b:="out dir"', "-p", "c:=2"]
    assert str(expected) in process.tail()


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells children of a death")
def test_a_killed_demo_leaves_no_process(elsewhere: Path) -> None:
    environment = stub(elsewhere, SLEEPER)
    demo = (
        "import sys, time; from pathlib import Path\n"
        f"sys.path.remove({str(elsewhere / 'path')!r})\n"
        "from lagrangian_ff.demo.processes import Nodes\n"
        "import os\n"
        f"nodes = Nodes(Path({str(elsewhere)!r}), dict(os.environ))\n"
        "process = nodes.start('stub')\n"
        "while 'awake' not in process.tail(): process.check() or time.sleep(0.02)\n"
        "print(process._process.pid, flush=True)\n"
        "time.sleep(600)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", demo], env=environment, stdout=subprocess.PIPE, text=True
    ) as parent:
        assert parent.stdout is not None
        child = int(parent.stdout.readline())
        parent.kill()
    until(lambda: not _runs(child), "the end of the child")


def _runs(pid: int) -> bool:
    """Whether there is such a process, and it is not waiting to be buried."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


TICKS = os.sysconf("SC_CLK_TCK")


def stat(user: float, idle: float) -> str:
    return f"cpu  {round(user * TICKS)} 0 0 {round(idle * TICKS)} 0 0 0 0 0 0\ncpu0 1 2 3\n"


def test_what_is_not_ours_is_of_others() -> None:
    texts = iter([stat(100.0, 50.0), stat(106.0, 52.0)])
    ours = iter([10.0, 12.0])
    work = OtherWork(lambda: next(ours), lambda: next(texts))
    assert work.processors() == pytest.approx((os.cpu_count() or 1) * 4.0 / 8.0)


def test_a_system_that_does_not_tell_is_not_called_busy() -> None:
    def missing() -> str:
        raise FileNotFoundError

    assert OtherWork(lambda: 1.0, missing).processors() == 0.0


def test_our_own_seconds_grow_with_work() -> None:
    before = processor_seconds([os.getppid()])
    while sum(os.times()[:2]) == 0.0 or processor_seconds([]) < 0.02:
        pass
    assert processor_seconds([os.getppid(), 2**30]) >= before > 0.0
