"""Torque limits of a robot description."""

import pytest

from lagrangian_ff.nodes.common.errors import MessageError
from lagrangian_ff.nodes.streaming.urdf_limits import effort_limits


def test_positive_limits_are_found_by_joint() -> None:
    urdf = """<robot name="r">
      <joint name="a" type="revolute"><limit effort="12.5" velocity="1"/></joint>
      <joint name="b" type="continuous"><limit effort="0" velocity="1"/></joint>
      <joint name="c" type="fixed"/>
      <joint name="d" type="prismatic"><limit velocity="1"/></joint>
    </robot>"""
    assert effort_limits(urdf) == {"a": 12.5}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "not XML"),
        ("<robot>", "not XML"),
        ('<robot><joint name="a"><limit effort="strong"/></joint></robot>', "limit of a"),
    ],
)
def test_what_is_no_description_is_told(text: str, expected: str) -> None:
    with pytest.raises(MessageError, match=expected):
        effort_limits(text)
