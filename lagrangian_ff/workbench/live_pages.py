"""What the server answers about a robot that the workbench is attached to."""

import asyncio
from collections.abc import Callable, Sequence
from typing import Any

from tornado.iostream import StreamClosedError

from lagrangian_ff.workbench.handler import Handler, Part, Service
from lagrangian_ff.workbench.live import Live


class LiveHandler(Handler):
    """Knows the robot."""

    def initialize(self, service: Service, live: Live | None = None) -> None:
        super().initialize(service)
        assert live is not None
        self.live = live


class Stream(LiveHandler):
    """Samples and state as they come, as long as the page is open."""

    async def get(self) -> None:
        self.set_header("Content-Type", "text/event-stream")
        queue = self.live.listen()
        try:
            while True:
                self.write(f"data: {await queue.get()}\n\n")
                await self.flush()
        except (StreamClosedError, asyncio.CancelledError):
            return
        finally:
            self.live.leave(queue)


class LiveAsk(LiveHandler):
    """Something to do with the robot; answers when it is done, or why it is not."""

    async def post(self, what: str) -> None:
        self.say(await self.live.ask(what, self.asked()))


def attached(arguments: Sequence[str]) -> Callable[[Service], Part]:
    """Return what makes the part of a server that is attached to a ROS graph.

    Args:
        arguments: of ROS, such as remappings.
    """

    def join(service: Service) -> Part:
        live = Live(service.bench, arguments, service.changed)
        service.bench.more = lambda: {"live": live.summary()}
        given: dict[str, Any] = {"service": service, "live": live}
        pages = [(r"/api/live", Stream, given), (r"/api/live/([a-z]+)", LiveAsk, given)]
        return Part(pages, live.start, live.tick, live.close)

    return join
