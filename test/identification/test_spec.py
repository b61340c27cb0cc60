"""Reading model names."""

import pytest

from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.spec import parse


def test_a_kernel_and_a_group() -> None:
    spec = parse("vrbfs+fri")
    assert spec.kernel.name == "vrbfs"
    assert [e.name for e in spec.effects] == ["viscous", "coulomb", "offset"]


def test_effects_may_stand_alone_and_anywhere() -> None:
    assert parse("fri").kernel.name == "none"
    assert parse("coulomb + rbf").kernel.name == "rbf"


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("vrbsf+fri", "neither a kernel"),
        ("", "neither a kernel"),
        ("vrbfs+rbf", "both kernels"),
        ("vrbfs+fri+viscous", "viscous stands in it twice"),
        ("vrbfs+fri+viscous@joint_2", "viscous stands in it twice"),
    ],
)
def test_what_cannot_be_is_refused_with_the_reason(name: str, said: str) -> None:
    with pytest.raises(ModelError, match=said):
        parse(name)
