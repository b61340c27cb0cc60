"""The workbench attached to a robot: a process in the graph, and what pages may ask of it.

The process is `nodes/live.py`. No motion is sent without a token: it is given with what the motion
would do, for this motion and this topic, and holds once.
"""

import asyncio
import hmac
import json
import secrets
import sys
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from importlib.util import find_spec
from pathlib import Path
from subprocess import PIPE
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.workbench.bench import Bench

PROGRAM = ("-m", "lagrangian_ff.nodes.live")
HOLDS = 120.0  # s in which a confirmation may be given
PATIENCE = 15.0  # s for an answer
ENDING = 6.0  # s for the process to end: it may have a motion to stop
WAITING = 50
"""Events that wait for a page that is slow; the oldest go."""
LAST = "live_recording.txt"
"""Names the recording under way, so that a killed workbench does not lose it."""

Asked = dict[str, Any]


@dataclass(frozen=True)
class Confirmation:
    """What somebody was told, and may confirm.

    Attributes:
        token: names it; only who was told knows it.
        motion, topic: what is sent, and where.
        prepared: names the motion in the process.
        until: s of the monotonic clock.
    """

    token: str
    motion: str
    topic: str
    prepared: int
    until: float


class Live:
    """The process, the newest of what it says, and the pages that listen.

    Args:
        bench: gets the recordings.
        arguments: of ROS, for the process.
        changed: is called after every change that all pages show.
    """

    def __init__(self, bench: Bench, arguments: Sequence[str], changed: Callable[[], None]) -> None:
        self._bench, self._arguments, self._changed = bench, tuple(arguments), changed
        self._process: asyncio.subprocess.Process | None = None
        self._reading: list[asyncio.Task[None]] = []
        self._answers: dict[int, asyncio.Future[Asked]] = {}
        self._number = 0
        self._listening: set[asyncio.Queue[str]] = set()
        self._status: Asked = {}
        self._error = ""
        self._lines: deque[str] = deque(maxlen=20)
        self._model: tuple[str, str] | None = None
        self._motion = ""
        self._confirmation: Confirmation | None = None
        self._recording: Path | None = None
        self._asks = {
            "connect": self._connect,
            "record": self._record,
            "finish": self._finish,
            "prepare": self._prepare,
            "send": self._send,
            "stop": self._stop,
        }
        self._adopt()

    def summary(self) -> Asked:
        """Return what every page shows of it, whichever step it is at."""
        recording, motion = self._status.get("recording"), self._status.get("motion")
        return {
            "error": self._error,
            "rate": self._status.get("rate"),
            "joints": len(self._status.get("joints", ())),
            "topics": [one["topic"] for one in self._status.get("topics", ())],
            "recording": int(recording["seconds"]) if recording else None,
            "motion": {**motion, "elapsed": int(motion["elapsed"]), "name": self._motion}
            if motion
            else None,
        }

    def tick(self) -> None:
        """Let the process compare with the model that is looked at; to be called often."""
        session = self._bench.session
        node = next((one for one in session.nodes if one.id == session.current), None)
        model = (node.file if node else "", str(session.effects) if session.formulas else "")
        if self._process is not None and self._status and model != self._model:
            self._model = model
            self._write(do="model", file=model[0], effects=model[1])

    async def ask(self, what: str, asked: Asked) -> Asked:
        """Do what a page asks, and return what came of it.

        Raises:
            UserError: it is not possible now, and why.
        """
        if what not in self._asks:
            raise UserError(f"the page asks for {what!r}, which is not known; reload it")
        try:
            return await self._asks[what](asked)
        except (KeyError, TypeError, ValueError) as error:
            raise UserError(f"the page asks for {what} in an unknown way: {error}") from error

    def listen(self) -> "asyncio.Queue[str]":
        """Return a queue of events in JSON, the newest status first."""
        made: asyncio.Queue[str] = asyncio.Queue(WAITING)
        self._listening.add(made)
        made.put_nowait(self._told())
        return made

    def leave(self, queue: "asyncio.Queue[str]") -> None:
        """Send no more events to a queue."""
        self._listening.discard(queue)

    async def start(self) -> None:
        """Start the process."""
        if find_spec("rclpy") is None:
            self._fail("rclpy is not there: source ROS 2 in the shell, then start the workbench")
            return
        self._error, self._model, self._status = "", None, {}
        # A new session: the Ctrl-C that ends the workbench must not reach the process first.
        self._process = await asyncio.create_subprocess_exec(
            sys.executable,
            *PROGRAM,
            *self._arguments,
            stdin=PIPE,
            stdout=PIPE,
            stderr=PIPE,
            start_new_session=True,
            limit=2**22,
        )
        self._reading = [
            asyncio.create_task(self._listen(self._process)),
            asyncio.create_task(self._keep_log(self._process)),
        ]

    async def close(self) -> None:
        """End the process: it stops its motion and closes its recording."""
        process = self._process
        if process is None:
            return
        assert process.stdin is not None
        process.stdin.close()
        try:
            await asyncio.wait_for(process.wait(), ENDING)
        except asyncio.TimeoutError:
            process.kill()
        await asyncio.gather(*self._reading, return_exceptions=True)
        self._keep()

    async def _listen(self, process: asyncio.subprocess.Process) -> None:
        assert process.stdout is not None
        async for line in process.stdout:
            try:
                event = json.loads(line)
            except ValueError:
                continue  # a library that prints
            if not isinstance(event, dict):
                continue
            if event.get("event") == "status":
                before, self._status = self.summary(), event
                self._tell(self._told())
                if self.summary() != before:
                    self._changed()
            elif "event" in event:
                self._tell(line.decode().strip())
            elif (waiting := self._answers.get(event.get("answer", 0))) and not waiting.done():
                waiting.set_result(event)
        code = await process.wait()
        self._process = None
        words = self._lines[-1] if self._lines else f"exit code {code}"
        self._fail(f"the process in the ROS graph has ended: {words}")
        self._keep()

    async def _keep_log(self, process: asyncio.subprocess.Process) -> None:
        assert process.stderr is not None
        async for line in process.stderr:
            text = line.decode(errors="replace").strip()
            if text:
                self._lines.append(text)
                print(text, file=sys.stderr, flush=True)

    def _fail(self, words: str) -> None:
        self._error, self._status, self._confirmation = words, {}, None
        for waiting in self._answers.values():
            if not waiting.done():
                waiting.set_exception(UserError(words))
        self._tell(self._told())
        self._changed()

    def _now(self, **status: Any) -> None:
        """Change what pages are told before the process says it."""
        self._status |= status
        self._tell(self._told())
        self._changed()

    def _told(self) -> str:
        """Return the status for pages."""
        place = self._bench.session.folder / "motions"
        status = {
            **self._status,
            "event": "status",
            "error": self._error,
            "folder": str(place),
            "motions": sorted(file.name for file in place.glob("*.csv")),
        }
        return json.dumps(status, ensure_ascii=False)

    def _tell(self, event: str) -> None:
        for queue in self._listening:
            if queue.full():
                queue.get_nowait()
            queue.put_nowait(event)

    def _write(self, **command: Any) -> int:
        """Write a command to the process, and return its number.

        Raises:
            UserError: there is no process.
        """
        if self._process is None or self._process.stdin is None:
            raise UserError(self._error or "the process in the ROS graph is starting")
        self._number += 1
        line = json.dumps({"id": self._number, **command}, ensure_ascii=False)
        self._process.stdin.write(line.encode() + b"\n")
        return self._number

    async def _told_to(self, **command: Any) -> Asked:
        """Return the answer to a command.

        Raises:
            UserError: it was refused, or nothing came.
        """
        number = self._write(**command)
        answer = self._answers[number] = asyncio.get_running_loop().create_future()
        try:
            found = await asyncio.wait_for(answer, PATIENCE)
        except asyncio.TimeoutError:
            raise UserError("the process in the ROS graph does not answer") from None
        finally:
            del self._answers[number]
        if "error" in found:
            raise UserError(str(found["error"]))
        return found

    async def _connect(self, asked: Asked) -> Asked:
        if self._process is None:
            await self.start()
        return {}

    async def _record(self, asked: Asked) -> Asked:
        if self._recording is not None:
            raise UserError("a recording is under way: stop it first")
        stem = f"live_{datetime.now():%Y%m%d_%H%M%S}"
        path = self._bench.session.folder / "recordings" / stem
        found = await self._told_to(do="record", path=str(path))
        self._recording = path
        (self._bench.session.folder / LAST).write_text(str(path), encoding="utf-8")
        return {"lasts": found["lasts"]}

    async def _finish(self, asked: Asked) -> Asked:
        found = await self._told_to(do="finish")
        self._now(recording=None)
        self._keep()
        if not found["samples"]:
            raise UserError("no joint states came: there is nothing in the recording")
        return {"seconds": found["seconds"], "ended": found["ended"]}

    def _keep(self) -> None:
        """Let the recording that ended join the cards, if anything is in it."""
        path, self._recording = self._recording, None
        mark = self._bench.session.folder / LAST
        mark.unlink(missing_ok=True)
        if path is not None and path.is_dir() and any(f.stat().st_size for f in path.iterdir()):
            self._bench.take_file(path.name.replace("_", " "), path)

    def _adopt(self) -> None:
        """Take in the recording that was under way when the workbench was killed."""
        mark = self._bench.session.folder / LAST
        if mark.exists():
            self._recording = Path(mark.read_text(encoding="utf-8").strip())
            self._keep()

    async def _prepare(self, asked: Asked) -> Asked:
        motion, topic = str(asked["motion"]), str(asked["topic"])
        self._require_free()
        places = (self._bench.session.folder / "motions").glob("*.csv")
        file = next((one for one in places if one.name == motion), None)
        if file is None:
            raise UserError(f"there is no motion {motion} in the session")
        self._confirmation = None
        found = await self._told_to(do="prepare", file=str(file), topic=topic)
        token, until = secrets.token_urlsafe(24), time.monotonic() + HOLDS
        self._confirmation = Confirmation(token, motion, topic, int(found["answer"]), until)
        return {**found, "motion": motion, "token": token, "holds": HOLDS}

    def _require_free(self) -> None:
        """Raise UserError while an investigation moves the arm."""
        if self._bench.investigations.moving:
            raise UserError("an investigation moves the arm: wait for its end, or stop it")

    async def _send(self, asked: Asked) -> Asked:
        given = str(asked["token"]), str(asked["motion"]), str(asked["topic"])
        known = self._confirmation
        self._require_free()
        if known is None or not hmac.compare_digest(known.token.encode(), given[0].encode()):
            raise UserError("this motion was not confirmed: look at it again")
        self._confirmation = None
        if given[1:] != (known.motion, known.topic):
            raise UserError("another motion or topic was confirmed: look at it again")
        if time.monotonic() > known.until:
            raise UserError("the confirmation came too late: look at the motion again")
        found = await self._told_to(do="send", prepared=known.prepared)
        self._motion = known.motion.removesuffix(".csv")
        return {"seconds": found["seconds"]}

    async def _stop(self, asked: Asked) -> Asked:
        found = await self._told_to(do="stop")
        self._now(motion=None)
        return {"seconds": found["seconds"]}
