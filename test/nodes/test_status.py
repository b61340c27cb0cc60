"""Warnings are counted in full and logged once a second at most; statuses become text."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.nodes.common.status import Level, Status, ThrottledWarnings


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_the_first_is_said_at_once_and_the_rest_gathered() -> None:
    said: list[str] = []
    clock = Clock()
    warnings = ThrottledWarnings(said.append, clock=clock)
    warnings.add("nan", "NaN came")
    assert said == ["NaN came"]
    for _ in range(5):
        warnings.add("nan", "NaN came")
    warnings.add("empty", "empty came")
    assert len(said) == 1
    clock.now = 1.5
    warnings.flush()
    assert said[1] == "NaN came (5 times); empty came"
    warnings.flush()
    assert len(said) == 2


@given(st.lists(st.tuples(st.floats(0.0, 0.7), st.sampled_from("abc")), max_size=60))
def test_never_two_warnings_within_a_second_and_none_forgotten(
    events: list[tuple[float, str]],
) -> None:
    clock = Clock()
    said: list[float] = []
    warnings = ThrottledWarnings(lambda text: said.append(clock.now), clock=clock)
    for pause, kind in events:
        clock.now += pause
        warnings.add(kind, kind)
    assert warnings.counts.total() == len(events)
    assert all(later - earlier >= 1.0 for earlier, later in pairwise(said))
    assert bool(said) == bool(events)


def test_values_become_text() -> None:
    status = Status(Level.OK, "fine", {"rate": 499.98765432, "count": 3, "name": "a"})
    assert status.texts() == {"rate": "499.988", "count": "3", "name": "a"}
