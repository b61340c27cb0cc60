"""Work that nobody waits for: it begins when all is free, gives way, and can be given up."""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import pytest

from lagrangian_ff.workbench.aside import Aside, Later
from lagrangian_ff.workbench.looking import Look

NOWHERE = Look("nowhere.npz")  # ends soon, with an error


@dataclass
class Said:
    """What came out, by what it was about."""

    words: list[tuple[str, Any]]

    def later(self, key: str, job: Any = NOWHERE) -> Later:
        def say(found: Any) -> None:
            self.words.append((key, found))

        return Later(key, job, say, say)


@pytest.fixture
def aside() -> Iterator[Aside]:
    made = Aside()
    yield made
    made.close()


def until_one_ends(aside: Aside, *, free: bool = True) -> None:
    end = time.monotonic() + 60.0
    while not aside.tick(free=free):
        assert time.monotonic() < end
        time.sleep(0.02)


def test_it_begins_when_all_is_free_in_the_order_in_which_it_came(aside: Aside) -> None:
    said = Said([])
    aside.add(said.later("a"))
    aside.add(said.later("b"))
    for _ in range(5):
        assert not aside.tick(free=False)
    until_one_ends(aside)
    assert [key for key, _ in said.words] == ["a"]
    assert "nowhere.npz" in said.words[0][1]
    until_one_ends(aside)
    assert [key for key, _ in said.words] == ["a", "b"]
    assert not aside.tick(free=True)


def test_what_gave_way_begins_again(aside: Aside) -> None:
    said = Said([])
    aside.add(said.later("a"))
    aside.tick(free=True)
    aside.give_way()
    assert not aside.tick(free=False)
    until_one_ends(aside)
    assert [key for key, _ in said.words] == ["a"]


def test_what_is_dropped_or_asked_again_does_not_come_twice(aside: Aside) -> None:
    said = Said([])
    for key in ("a", "b", "a"):
        aside.add(said.later(key))
    aside.tick(free=True)
    aside.drop("b")
    until_one_ends(aside)
    assert [key for key, _ in said.words] == ["a"]
    assert not aside.tick(free=True)
