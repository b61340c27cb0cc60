"""Work that nobody waits for: it begins when the processors are free, and gives way."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from lagrangian_ff.worker import Worker


@dataclass(frozen=True)
class Later:
    """Work to be done some time.

    Attributes:
        key: what it is about.
        job: the request.
        take: receives what came out.
        failed: receives the error in words.
    """

    key: str
    job: Any
    take: Callable[[Any], None]
    failed: Callable[[str], None]


class Aside:
    """Work in the order in which it came, one at a time."""

    def __init__(self) -> None:
        self._waiting: list[Later] = []
        self._worker: Worker[Any] | None = None

    def add(self, later: Later) -> None:
        """Take work in; what was to be done about the same is dropped."""
        self.drop(later.key)
        self._waiting.append(later)

    def drop(self, key: str) -> None:
        """Give up the work about something."""
        if self._waiting and self._waiting[0].key == key:
            self.give_way()
        self._waiting = [one for one in self._waiting if one.key != key]

    def give_way(self) -> None:
        """End what is under way; it begins again when the processors are free."""
        if self._worker is not None:
            self._worker.cancel()
            self._worker = None

    def tick(self, *, free: bool) -> bool:
        """Take what has come out, or begin the next work.

        Args:
            free: whether nothing else is under way.

        Returns:
            Whether something has come out.
        """
        if self._worker is None:
            if free and self._waiting:
                self._worker = Worker(self._waiting[0].job)
            return False
        outcome = self._worker.outcome()
        if outcome is None:
            return False
        done, self._worker = self._waiting.pop(0), None
        if outcome.result is None:
            done.failed(outcome.error)
        else:
            done.take(outcome.result)
        return True

    def close(self) -> None:
        """End all work."""
        self.give_way()
        self._waiting = []
