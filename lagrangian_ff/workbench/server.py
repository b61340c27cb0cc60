"""The server of the page: loopback only unless told, one session, any number of tabs.

Tornado, since HTTP, uploads in pieces and events that last are in one library that Ubuntu packages.
"""

import asyncio
import json
import os
import secrets
import signal
import tempfile
from collections.abc import Awaitable, Callable, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import tornado.httpserver
import tornado.netutil
import tornado.web
from tornado.iostream import StreamClosedError

from lagrangian_ff.errors import UserError
from lagrangian_ff.workbench.curve_handlers import Chosen, Lit, Map, Trace
from lagrangian_ff.workbench.handler import Handler, Part, Service
from lagrangian_ff.workbench.investigating import Arm
from lagrangian_ff.workbench.session import Session

LOOPBACK = ("127.0.0.1", "localhost", "::1")
LARGEST_UPLOAD = 4 * 2**30  # bytes
TICK = 0.1  # s
PAGE = Path(str(files(__package__).joinpath("page")))


class Index(Handler):
    """The page."""

    def get(self) -> None:
        if self.service.token:
            self.set_cookie("token", self.service.token, httponly=True, samesite="Strict")
        self.set_header("Content-Type", "text/html; charset=utf-8")
        self.finish((PAGE / "index.html").read_bytes())


class Static(Handler, tornado.web.StaticFileHandler):
    """The files of the page."""

    def initialize(self, service: Service, path: str) -> None:  # type: ignore[override]
        Handler.initialize(self, service)
        tornado.web.StaticFileHandler.initialize(self, path)


class State(Handler):
    """All that is shown."""

    def get(self) -> None:
        self.say(self.service.bench.state())


class Events(Handler):
    """The state after every change, as long as the page is open; of work its progress alone."""

    async def get(self) -> None:
        self.set_header("Content-Type", "text/event-stream")
        bench, told = self.service.bench, -1
        try:
            while True:
                same = bench.session.version == told
                state = bench.progress() if same else bench.state()
                told = bench.session.version
                self.write(f"data: {json.dumps(state, ensure_ascii=False)}\n\n")
                await self.flush()
                await self.service.news()
                await asyncio.sleep(0.05)  # changes that come together are sent once
        except (StreamClosedError, asyncio.CancelledError):
            return


class Ask(Handler):
    """A change, or work to begin."""

    def post(self, what: str) -> None:
        self.say({**self.service.bench.ask(what, self.asked()), "done": what})


@tornado.web.stream_request_body
class Upload(Handler):
    """A recording, as it is, in the body of the request."""

    _path: Path | None = None

    def prepare(self) -> Awaitable[None] | None:
        super().prepare()
        self.request.connection.set_max_body_size(LARGEST_UPLOAD)  # type: ignore[union-attr]
        place = self.service.bench.session.folder
        number, name = tempfile.mkstemp(dir=place, prefix=".upload-")
        self._file, self._path = os.fdopen(number, "wb"), Path(name)
        return None

    def data_received(self, chunk: bytes) -> None:
        self._file.write(chunk)

    def post(self) -> None:
        self._file.close()
        name = self.get_query_argument("name", "recording")[:200]
        assert self._path is not None
        card = self.service.bench.take_upload(name, self._path)
        self.say({"card": card.id})

    def on_connection_close(self) -> None:
        if self._path is not None:  # a request that was refused has none
            self._file.close()
            self._path.unlink(missing_ok=True)


class Download(Handler):
    """A file to keep: nothing of it is shown here, since a report has scripts of its own."""

    def send(self, file: Path, name: str) -> None:
        """Answer with a file.

        Raises:
            UserError: it was not made yet.
        """
        if not file.exists():
            raise UserError(f"there is no {name} yet")
        self.set_header("Content-Type", "application/octet-stream")
        self.set_header("Content-Disposition", f'attachment; filename="{name}"')
        self.finish(file.read_bytes())


class Take(Download):
    """The file of a model."""

    def get(self, node: str) -> None:
        found = self.service.bench.session.node(node)
        self.send(Path(found.file), f"model_{found.id}.npz")


class Motion(Download):
    """The trajectory of a motion."""

    def get(self, motion: str) -> None:
        found = self.service.bench.session.motion(motion)
        name = f"{found['motion']}_{found['title']}".replace(" ", "_")
        self.send(Path(found["file"]), f"{name}.csv")


class Page(Download):
    """A report."""

    def get(self, kind: str, node: str) -> None:
        session = self.service.bench.session
        if kind == "investigation":
            known = next((one["id"] for one in session.investigations if one["id"] == node), "")
            return self.send(session.folder / "pages" / f"{kind}_{known}.html", f"{kind}.html")
        file = session.folder / "pages" / f"{kind}_{session.node(node).id}.html"
        return self.send(file, f"{kind}.html")


def application(service: Service, *parts: Part) -> tornado.web.Application:
    """Return the handlers of a page."""
    given = {"service": service}
    return tornado.web.Application(
        [
            (r"/", Index, given),
            (r"/page/(.*)", Static, {**given, "path": str(PAGE)}),
            (r"/api/state", State, given),
            (r"/api/events", Events, given),
            (r"/api/upload", Upload, given),
            (r"/api/ask/([a-z]+)", Ask, given),
            (r"/api/trace/(\w+)", Trace, given),
            (r"/api/map/(\w+)", Map, given),
            (r"/api/chosen/(\w+)", Chosen, given),
            (r"/api/lit/(\w+)", Lit, given),
            (r"/api/page/(compare|diagnose|investigation)/(\w+)", Page, given),
            (r"/api/motion/(\w+)", Motion, given),
            (r"/api/take/(\w+)", Take, given),
            *(page for part in parts for page in part.pages),
        ],
        log_function=lambda handler: None,
    )


async def serve(
    session: Session,
    sources: Sequence[Path],
    port: int,
    host: str,
    said: Any,
    skeleton: Sequence[dict[str, Any]] = (),
    joined: Sequence[Callable[[Service], Part]] = (),
    arm: Arm | None = None,
) -> None:
    """Serve a session until a signal ends it.

    Args:
        sources: recordings to take in first.
        port: 0 for any that is free.
        host: the address to listen on.
        skeleton: of the arm that is drawn; empty for none.
        joined: makes the parts of the server besides.
        arm: that may be investigated; None for none.
        said: is called with the address of the page, once it can be opened.

    Raises:
        UserError: the port is taken.
    """
    alone = host in LOOPBACK
    token = "" if alone else secrets.token_urlsafe(24)
    service = Service(session, LOOPBACK if alone else (*LOOPBACK, host), token, skeleton, arm)
    known = {card.file for card in session.cards}
    for source in sources:
        if str(source.resolve()) not in known:
            service.bench.take_file(source.name, source.resolve())
    parts = [join(service) for join in joined]
    server = tornado.httpserver.HTTPServer(
        application(service, *parts), max_body_size=LARGEST_UPLOAD
    )
    try:
        sockets = tornado.netutil.bind_sockets(port, host)
    except OSError as error:
        raise UserError(f"--port {port}: cannot be used: {error.strerror or error}") from error
    for part in parts:
        await part.start()
    server.add_sockets(sockets)
    number = sockets[0].getsockname()[1]
    said(f"http://{host}:{number}/" + (f"?token={token}" if token else ""))
    ended = asyncio.Event()
    for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        asyncio.get_running_loop().add_signal_handler(one, ended.set)
    try:
        while not ended.is_set():
            for tick in (service.bench.tick, *(part.tick for part in parts)):
                tick()
            try:
                await asyncio.wait_for(ended.wait(), TICK)
            except asyncio.TimeoutError:
                continue
    finally:
        for part in parts:
            await part.close()
        service.bench.close()
        server.stop()
