"""`demo`: its options reach the demo as they are."""

from fractions import Fraction
from pathlib import Path

import pytest
from cli_examples import lagrangian_ff

from lagrangian_ff import demo
from lagrangian_ff.demo.options import QUICK


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[demo.Options]:
    """Return what the demo is asked for, in the place of running it."""
    options: list[demo.Options] = []

    def run(given: demo.Options) -> int:
        options.append(given)
        return 0

    monkeypatch.setattr(demo, "run", run)
    return options


def test_nothing_given_leaves_everything_to_the_demo(asked: list[demo.Options]) -> None:
    assert lagrangian_ff("demo").code == 0
    assert asked == [demo.Options()]


def test_every_option_reaches_the_demo(asked: list[demo.Options]) -> None:
    outcome = lagrangian_ff(
        "demo", "--output", "there", "--speed", "7", "--seed", "3", "--duration", "20",
        "--unseen-duration", "9", "--model", "srbfs+fri", "--samples", "200", "--train", "0.5",
        "--through", "trajectory", "--clock-speed", "1", "--domain", "42",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    expected = demo.Options(
        output=Path("there"), speed=7, seed=3, duration=20.0, unseen_duration=9.0,
        model="srbfs+fri", samples=200, train=0.5, through="trajectory",
        clock_speed=1.0, domain=42,
    )  # fmt: skip
    assert asked == [expected]
    untouched = [name for name, value in vars(demo.Options()).items()
                 if value == getattr(expected, name)]  # fmt: skip
    assert untouched == []


def test_quick_gives_way_to_what_is_given(asked: list[demo.Options]) -> None:
    assert lagrangian_ff("demo", "--quick", "--samples", "123").code == 0
    assert asked == [demo.Options(**{**QUICK, "samples": 123})]


def test_a_setting_that_cannot_work(asked: list[demo.Options]) -> None:
    outcome = lagrangian_ff("demo", "--train", "3")
    assert outcome.code == 2
    assert "train" in outcome.err
    assert asked == []


def test_the_help_names_the_defaults_there_are() -> None:
    text = " ".join(lagrangian_ff("demo", "--help").out.split())
    for name, value in vars(demo.Options()).items():
        if value is not None:
            shown = Fraction(value).limit_denominator(10) if isinstance(value, float) else value
            assert f"(default: {shown})" in text, name
