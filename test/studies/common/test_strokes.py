"""Every kernel has a line of its own."""

from lagrangian_ff.identification.spec import ALTERNATIVES
from lagrangian_ff.kernels import KERNELS
from lagrangian_ff.studies.common.strokes import OTHER, STROKES, stroke_of


def test_every_kernel_is_drawn_in_its_own_way() -> None:
    assert set(STROKES) == {*KERNELS, *ALTERNATIVES} - {"none"}
    assert len({(stroke.colour, stroke.dashes) for stroke in STROKES.values()}) == len(STROKES)
    assert stroke_of("vrbfs+fri") == STROKES["vrbfs"]
    assert stroke_of("none+fri") == OTHER
