"""Numbers as people read them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.numbers import DASH, chance, mrad, number, percent, typeset

SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")


def read(text: str) -> float:
    """The number that a text says."""
    return float(text.replace("·10", "e").translate(SUPERSCRIPTS))


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"), (1234.5, "1234"), (99.96, "100"), (12.34, "12.3"), (-0.5, "-0.500"),
        (0.0571, "0.0571"), (1.19e-06, "1.19e-06"), (3.2e7, "3.20e+07"), (None, "-"),
        (float("nan"), "-"),
    ],
)  # fmt: skip
def test_numbers_have_three_digits(value: float | None, text: str) -> None:
    assert number(value) == text


@given(st.floats(1e-9, 1e9), st.sampled_from([-1.0, 1.0]))
def test_numbers_stay_what_they_are(size: float, sign: float) -> None:
    assert float(number(sign * size)) == pytest.approx(sign * size, rel=5.1e-3)


@given(st.floats(-1e12, 1e12).filter(lambda x: x == 0.0 or abs(x) > 1e-12))
def test_a_typeset_number_reads_back_to_three_digits(value: float) -> None:
    assert read(typeset(value)) == pytest.approx(value, rel=0.0051)


@given(st.floats(1e-12, 1e12))
def test_a_negative_number_is_the_same_with_a_minus(value: float) -> None:
    assert typeset(-value) == f"−{typeset(value)}"


def test_an_unknown_number_is_a_dash() -> None:
    assert {typeset(x) for x in (None, math.nan, math.inf, -math.inf)} == {DASH}
    assert percent(math.nan) == DASH
    assert (chance(None), chance(math.nan, DASH)) == ("-", DASH)


def test_a_probability_is_never_zero() -> None:
    assert [chance(p) for p in (0.0, 0.0025, 0.05, 0.5)] == ["< 0.001", "0.0025", "0.05", "0.5"]


def test_a_share_is_finer_where_it_is_small() -> None:
    assert percent(0.0583) == "5.8 %"
    assert percent(0.443) == "44 %"
    assert percent(1.0) == "100 %"


def test_an_angle_is_finer_where_it_is_small() -> None:
    assert mrad(0.0182) == "18.2"
    assert mrad(0.00106) == "1.06"


def test_a_number_that_rounds_up_has_no_digit_more() -> None:
    assert [number(value, 2) for value in (9.94, 9.97, 99.7, 0.0997)] == [
        "9.9",
        "10",
        "100",
        "0.10",
    ]
