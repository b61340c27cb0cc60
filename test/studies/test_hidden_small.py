"""A small version of the study, with the diagnosis itself: one hidden effect, and none."""

from pathlib import Path

from lagrangian_ff.studies.hidden.examiner import Diagnosis
from lagrangian_ff.studies.hidden.plants import Stretches
from lagrangian_ff.studies.hidden.run import Options, run

SHORT = Stretches(((2, 6.0), (6, 12.0)))


def test_a_ripple_is_named_and_a_clean_arm_is_left_alone(tmp_path: Path) -> None:
    clean, ripple = (
        run(Options(tmp_path, small=True, only=name, stretches=SHORT), Diagnosis(steps=1))[0]
        for name in ("clean-00", "ripple-joint_2-20")
    )
    assert clean["judgement"] == {"outcome": "nothing", "false": [], "suggested": []}
    assert ripple["judgement"]["outcome"] == "right"
    (found,) = ripple["record"]["findings"]
    order = ripple["plant"]["hidden"][0]["facts"]["times a turn"]
    assert found["shape"]["order"] == order
    assert ripple["ratio"] < 1.1
    assert ripple["errors"]["found"]["joint_2"] < ripple["errors"]["base"]["joint_2"]
