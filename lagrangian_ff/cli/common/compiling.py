"""Whether loops are being compiled: the first command after an installation waits for it."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def told_of_compiling(after: float, tell: Callable[[], None]) -> Iterator[None]:
    """Tell, once, when the work in the block spends long on compiling.

    What Numba has kept from an earlier run is only loaded, and is not told of.

    Args:
        after: s since it began to compile. It is looked at where another loop is begun.
        tell: called at most once.
    """
    if "numba" not in sys.modules:  # which is slow to import, and nobody else here has asked for it
        yield
        return
    from numba.core import event

    class Compiling(event.Listener):
        began: float | None = None
        told = False

        def on_start(self, event: object) -> None:
            now = time.monotonic()
            if self.began is None:
                self.began = now
            if now - self.began > after and not self.told:
                self.told = True
                tell()

        def on_end(self, event: object) -> None:
            pass

    with event.install_listener("numba:compile", Compiling()):
        yield
