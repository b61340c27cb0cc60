"""What every handler of the server has: whom it answers, and how."""

import asyncio
import hmac
import json
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

import tornado.web

from lagrangian_ff.errors import UserError
from lagrangian_ff.workbench.bench import Bench
from lagrangian_ff.workbench.investigating import Arm
from lagrangian_ff.workbench.session import Session

LARGEST_QUESTION = 2**16  # bytes
RULES = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)


class Service:
    """State shared by the handlers.

    Args:
        session: the one that is shown.
        hosts: names by which the page may be asked for.
        token: what a page must know; empty for none, on loopback.
        skeleton: of the arm that is drawn.
        arm: that may be investigated; None for none.
    """

    def __init__(
        self,
        session: Session,
        hosts: Sequence[str],
        token: str,
        skeleton: Sequence[dict[str, Any]] = (),
        arm: Arm | None = None,
    ) -> None:
        self.hosts, self.token = frozenset(hosts), token
        self._news = asyncio.Event()
        self.bench = Bench(session, self.changed, skeleton, arm)

    def changed(self) -> None:
        """Let every page hear of a change."""
        news, self._news = self._news, asyncio.Event()
        news.set()

    async def news(self) -> None:
        """Wait for the next change."""
        await self._news.wait()


@dataclass(frozen=True)
class Part:
    """What a server does besides: pages, and work while it runs.

    Attributes:
        pages: rules of Tornado.
        start: is awaited before the first page.
        tick: is called several times a second.
        close: is awaited at the end.
    """

    pages: Sequence[Any]
    start: Callable[[], Awaitable[None]]
    tick: Callable[[], None]
    close: Callable[[], Awaitable[None]]


class Handler(tornado.web.RequestHandler):
    """Answers only pages that came from here."""

    service: Service

    def initialize(self, service: Service) -> None:
        self.service = service

    def set_default_headers(self) -> None:
        self.set_header("Content-Security-Policy", RULES)
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("Cache-Control", "no-store")
        self.clear_header("Server")

    def prepare(self) -> Awaitable[None] | None:
        """Refuse other hosts, other pages, and those without the token."""
        host = urlsplit(f"//{self.request.host}").hostname or ""
        if host not in self.service.hosts:
            raise tornado.web.HTTPError(403, log_message="asked for by another name")
        origin = self.request.headers.get("Origin")
        if origin is not None and urlsplit(origin).netloc != self.request.host:
            raise tornado.web.HTTPError(403, log_message="asked by another page")
        if self.request.method == "POST" and origin is None:
            raise tornado.web.HTTPError(403, log_message="asked by no page")
        if self.service.token:
            given = self.get_query_argument("token", "") or self.get_cookie("token") or ""
            if not hmac.compare_digest(given.encode(), self.service.token.encode()):
                raise tornado.web.HTTPError(401, log_message="without the token")
        return None

    def say(self, found: object) -> None:
        """Answer in JSON."""
        self.set_header("Content-Type", "application/json; charset=utf-8")
        self.finish(json.dumps(found, ensure_ascii=False, allow_nan=False))

    def write_error(self, status_code: int, **told: Any) -> None:
        error = told.get("exc_info", (None, None))[1]
        words = str(error) if isinstance(error, UserError) else self._reason
        if isinstance(error, UserError):
            self.set_status(400)
        self.say({"error": words})

    def log_exception(self, kind: Any, value: Any, trace: Any) -> None:
        if not isinstance(value, UserError):
            super().log_exception(kind, value, trace)

    def asked(self) -> dict[str, Any]:
        """Return the JSON object in the body of the request."""
        if len(self.request.body) > LARGEST_QUESTION:
            raise tornado.web.HTTPError(413)
        try:
            asked = json.loads(self.request.body or b"{}")
        except ValueError:
            raise tornado.web.HTTPError(400) from None
        if not isinstance(asked, dict):
            raise tornado.web.HTTPError(400)
        return asked
