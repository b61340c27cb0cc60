"""Numbers as people read them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.report.numbers import mrad, number, percent

SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")


def read(text: str) -> float:
    """The number that a text says."""
    return float(text.replace("·10", "e").translate(SUPERSCRIPTS))


@given(st.floats(-1e12, 1e12).filter(lambda x: x == 0.0 or abs(x) > 1e-12))
def test_a_number_reads_back_to_three_digits(value: float) -> None:
    assert read(number(value)) == pytest.approx(value, rel=0.0051)


@given(st.floats(1e-12, 1e12))
def test_a_negative_number_is_the_same_with_a_minus(value: float) -> None:
    assert number(-value) == f"−{number(value)}"


def test_what_is_no_number_is_a_dash() -> None:
    assert {number(x) for x in (math.nan, math.inf, -math.inf)} == {"–"}
    assert percent(math.nan) == "–"


def test_a_share_is_finer_where_it_is_small() -> None:
    assert percent(0.0583) == "5.8 %"
    assert percent(0.443) == "44 %"
    assert percent(1.0) == "100 %"


def test_an_angle_is_finer_where_it_is_small() -> None:
    assert mrad(0.0182) == "18.2"
    assert mrad(0.00106) == "1.06"
