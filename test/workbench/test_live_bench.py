"""A workbench that cannot attach to a graph says why, and does the rest of its work."""

import asyncio
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from lagrangian_ff.errors import UserError
from lagrangian_ff.workbench.bench import Bench
from lagrangian_ff.workbench.live import LAST, Live
from lagrangian_ff.workbench.session import Session


def attached(folder: Path) -> tuple[Bench, Live]:
    bench = Bench(Session.open(folder), lambda: None)
    return bench, Live(bench, (), lambda: None)


async def refused(live: Live, what: str, **asked: Any) -> str:
    """Return why something is refused."""
    with pytest.raises(UserError) as error:
        await live.ask(what, asked)
    return str(error.value)


def test_without_ros_it_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)

    async def look() -> None:
        _, live = attached(tmp_path)
        await live.start()
        assert "source ROS 2" in live.summary()["error"]
        assert "source ROS 2" in await refused(live, "record")
        assert "not known" in await refused(live, "nonsense")
        assert "unknown way" in await refused(live, "prepare")
        assert "there is no motion" in await refused(live, "prepare", motion="a.csv", topic="/b")
        assert "not confirmed" in await refused(live, "send", motion="a", topic="/b", token="c")
        live.tick()
        await live.close()

    asyncio.run(look())


def test_a_process_that_ends_is_said_with_its_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("rclpy")
    (tmp_path / "rclpy.py").write_text("raise ImportError('no middleware')\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))

    async def look() -> None:
        _, live = attached(tmp_path / "session")
        queue = live.listen()
        await live.start()
        end = time.monotonic() + 60.0
        while not live.summary()["error"]:
            assert time.monotonic() < end
            await asyncio.sleep(0.05)
        assert "no middleware" in live.summary()["error"]
        while "no middleware" not in await asyncio.wait_for(queue.get(), 10.0):
            pass
        await live.close()

    asyncio.run(look())


def test_a_recording_that_never_began_is_no_card(tmp_path: Path) -> None:
    (tmp_path / LAST).write_text(str(tmp_path / "recordings" / "nowhere"))
    bench, _ = attached(tmp_path)
    assert not bench.session.cards
    assert not (tmp_path / LAST).exists()
