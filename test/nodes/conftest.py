"""What a test of nodes starts ends with it."""

from collections.abc import Iterator
from typing import Any

import pytest


@pytest.fixture(autouse=True)
def processes_end_with_their_test(request: pytest.FixtureRequest) -> Iterator[None]:
    """End what a test started on a bench of its module; what the fixtures started stays.

    A simulated arm takes a processor: the next test would be late.
    """
    if "bench" not in request.fixturenames:
        yield
        return
    bench: Any = request.getfixturevalue("bench")
    with bench.passing():
        yield
