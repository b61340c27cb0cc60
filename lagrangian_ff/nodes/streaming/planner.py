"""Computing plans beside the stream, always for the newest reference."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.streaming.doubt import Doubts
from lagrangian_ff.nodes.streaming.plan import InverseDynamics, Plan, Policy, make_plan
from lagrangian_ff.nodes.streaming.reference import Reference

Tag = TypeVar("Tag")


class _SupersededError(Exception):
    """A newer reference came."""


@dataclass(frozen=True)
class _Task(Generic[Tag]):
    read: Callable[[], tuple[Reference, Tag]]
    policy: Policy


class Planner(Generic[Tag]):
    """A thread that turns references into plans; a newer one takes the place of an older one.

    Args:
        model: gives the torques.
        done: called in this thread with each plan and what came with its reference.
        failed: called in this thread where there is no plan, with the reason.
        doubts: how far torques are a guess, where the model tells.

    Attributes:
        fraction: of the plan under way, 0 to 1; 1 where there is none.
    """

    def __init__(
        self,
        model: InverseDynamics,
        done: Callable[[Plan, Tag], None],
        failed: Callable[[Exception], None],
        doubts: Doubts | None = None,
    ) -> None:
        self._model, self._doubts = model, doubts
        self._done = done
        self._failed = failed
        self._wake = threading.Condition()
        self._task: _Task[Tag] | None = None
        self._ended = False
        self.fraction = 1.0
        self._thread = threading.Thread(target=self._run, name="planner", daemon=True)
        self._thread.start()

    def submit(self, read: Callable[[], tuple[Reference, Tag]], policy: Policy) -> None:
        """Compute the plan of this reference next, and nothing older.

        Args:
            read: called in the thread: the reference, and what comes with it.
            policy: what to do outside the identified range.
        """
        with self._wake:
            self._task = _Task(read, policy)
            self._wake.notify()

    def drop(self) -> None:
        """Compute nothing more of what was submitted."""
        with self._wake:
            self._task = None
            self.fraction = 1.0

    def stop(self) -> None:
        """End the thread."""
        with self._wake:
            self._ended, self._task = True, None
            self._wake.notify()
        self._thread.join(timeout=2.0)

    def _run(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._task is not None or self._ended)
                task = self._task
            if task is None:
                return
            try:
                self._work(task)
            except _SupersededError:
                continue
            except Exception as error:
                self._end(task)
                self._failed(error)

    def _work(self, task: "_Task[Tag]") -> None:
        def report(fraction: float) -> None:
            if self._task is not task:
                raise _SupersededError
            self.fraction = fraction

        self.fraction = 0.0
        reference, tag = task.read()
        plan = make_plan(self._model, reference, task.policy, report=report, doubts=self._doubts)
        if self._end(task):
            self._done(plan, tag)

    def _end(self, task: "_Task[Tag]") -> bool:
        """Whether this task was still the newest; forget it."""
        with self._wake:
            newest = self._task is task
            if newest:
                self._task = None
            self.fraction = 1.0
            return newest


def reason(error: Exception) -> str:
    """The text to show: of a user's mistake as it is, of anything else with its type."""
    return str(error) if isinstance(error, UserError) else f"{type(error).__name__}: {error}"
