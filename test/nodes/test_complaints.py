"""What goes wrong is counted in full and said once a second at most."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.nodes.common.complaints import Complaints


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_the_first_is_said_at_once_and_the_rest_gathered() -> None:
    said: list[str] = []
    clock = Clock()
    complaints = Complaints(said.append, clock=clock)
    complaints.add("nan", "NaN came")
    assert said == ["NaN came"]
    for _ in range(5):
        complaints.add("nan", "NaN came")
    complaints.add("empty", "empty came")
    assert len(said) == 1
    clock.now = 1.5
    complaints.flush()
    assert said[1] == "NaN came (5 times); empty came"
    complaints.flush()
    assert len(said) == 2


@given(st.lists(st.tuples(st.floats(0.0, 0.7), st.sampled_from("abc")), max_size=60))
def test_never_two_warnings_within_a_second_and_none_forgotten(
    events: list[tuple[float, str]],
) -> None:
    clock = Clock()
    said: list[float] = []
    complaints = Complaints(lambda text: said.append(clock.now), clock=clock)
    for pause, kind in events:
        clock.now += pause
        complaints.add(kind, kind)
    assert complaints.total == len(events)
    assert all(later - earlier >= 1.0 for earlier, later in pairwise(said))
    assert bool(said) == bool(events)
