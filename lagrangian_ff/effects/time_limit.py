"""A time limit on code that users bring: an endless loop in it must not run for ever."""

import ctypes
import os
import signal
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

from lagrangian_ff.errors import EffectError

VARIABLE = "LAGRANGIAN_FF_EFFECT_SECONDS"
"""The environment variable that sets another limit."""
USUAL = 20.0  # s, of importing a file, and of one call of an effect
_AGAIN = 0.1  # s until code that swallowed the interruption is interrupted again

Result = TypeVar("Result")


class TooLongError(BaseException):
    """Interrupts code at the end of its time; `except Exception` does not swallow it."""


def seconds_allowed() -> float:
    """Return s that a file of effects may take to import, and a call of an effect to return.

    Raises:
        EffectError: the environment variable holds no number above 0.
    """
    given = os.environ.get(VARIABLE, "")
    try:
        allowed = float(given or USUAL)
    except ValueError:
        allowed = 0.0
    if not 0.0 < allowed < threading.TIMEOUT_MAX:
        raise EffectError(f"{VARIABLE}={given}: expected seconds, more than 0")
    return allowed


def in_time(what: str, call: Callable[[], Result], file: Path | None = None) -> Result:
    """Return what a call returns, unless it takes longer than `seconds_allowed`.

    Args:
        what: is called, for the message.
        file: in which to look for the line that runs; None takes the innermost one.

    Raises:
        EffectError: it took longer; says where it was then.
        Exception: whatever it raises.
    """
    allowed = seconds_allowed()
    try:
        with _limit(allowed):
            return call()
    except TooLongError as error:
        place = _place(error, file)
    raise EffectError(
        f"{what} took more than {allowed:g} s{place}: is that an endless loop? The environment "
        f"variable {VARIABLE} allows more"
    )


def _place(error: BaseException, file: Path | None) -> str:
    frames: list[traceback.FrameSummary] = []
    cause: BaseException | None = error
    while cause is not None:  # the first interruption last: a later one may hit who handles it
        frames = [*frames, *traceback.extract_tb(cause.__traceback__)]
        cause = cause.__context__
    own = [f for f in frames if file is not None and Path(f.filename).resolve() == file.resolve()]
    outside = [f for f in frames if f.filename != __file__]
    known = own or outside
    return f", and was in {known[-1].filename}, line {known[-1].lineno}" if known else ""


@contextmanager
def _limit(seconds: float) -> Iterator[None]:
    """Raise TooLongError in the block after this time."""
    if threading.current_thread() is threading.main_thread():
        yield from _by_signal(seconds)
    else:
        yield from _by_thread(seconds)


def _by_signal(seconds: float) -> Iterator[None]:
    """Interrupt by SIGALRM, which also ends a sleep."""

    def interrupt(number: int, frame: object) -> None:
        raise TooLongError

    before = signal.signal(signal.SIGALRM, interrupt)
    left, every = signal.setitimer(signal.ITIMER_REAL, seconds, _AGAIN)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, left, every)
        signal.signal(signal.SIGALRM, before)


def _by_thread(seconds: float) -> Iterator[None]:
    """Interrupt another thread than the main one between two of its bytecodes."""
    raise_in = ctypes.pythonapi.PyThreadState_SetAsyncExc
    ident = ctypes.c_ulong(threading.get_ident())
    ended, turn = threading.Event(), threading.Lock()

    def watch() -> None:
        wait = seconds
        while not ended.wait(wait):
            with turn:
                if not ended.is_set():
                    raise_in(ident, ctypes.py_object(TooLongError))
            wait = _AGAIN

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        with turn:
            ended.set()
            raise_in(ident, None)  # one that was sent and has not arrived
