"""The demo's settings: what cannot work is refused in words."""

from typing import Any

import pytest

from lagrangian_ff.demo import QUICK, Options
from lagrangian_ff.errors import UserError


@pytest.mark.parametrize(
    "wrong",
    [
        {"duration": 2.0},
        {"unseen_duration": float("nan")},
        {"train": 0.0},
        {"samples": 3},
        {"speed": 11},
        {"through": "telepathy"},
        {"clock_speed": 0.0},
        {"domain": 200},
    ],
)
def test_a_setting_that_cannot_work_is_named(wrong: dict[str, Any]) -> None:
    with pytest.raises(UserError, match=next(iter(wrong))):
        Options(**wrong)


def test_the_quick_demo_moves_less() -> None:
    quick, usual = Options(**QUICK), Options()
    assert quick.duration < usual.duration
    assert quick.unseen_duration < usual.unseen_duration
