"""An effect confirmed on earlier motion stays, unless the new motion speaks against it."""

from dataclasses import replace

import diagnosed_rods
import numpy as np
import pytest
import two_rods
from whitened_examples import few_torques

from lagrangian_ff.diagnosis import Diagnosis, diagnose, with_consequences
from lagrangian_ff.diagnosis.search.forward import Search
from lagrangian_ff.diagnosis.thresholds import Thresholds, using
from lagrangian_ff.diagnosis.verdicts import findings_of
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.recording.motion import concatenate

_small = few_torques(1200)
stuck, stuck_search = diagnosed_rods.stuck, diagnosed_rods.stuck_search


@pytest.mark.parametrize(
    ("limits", "stays"),
    [
        (Thresholds(size_ratio=(3.0, 4.0)), False),
        (Thresholds(held_out_share=1.1), True),
        (Thresholds(fewest_groups=99), True),
        (Thresholds(large_rest=-1.0), True),
    ],
)
def test_what_other_motion_confirmed_stays_unless_this_one_speaks_against_it(
    stuck: Diagnosis, stuck_search: Search, limits: Thresholds, stays: bool
) -> None:
    known = tuple(replace(step, stands=True) for step in stuck_search.steps)
    with using(limits):
        (finding,) = findings_of(
            replace(stuck_search, steps=known), stuck.held_out, stuck.model, None
        )
    assert finding.confirmed == finding.stands == stays


def test_what_is_no_longer_known_needs_the_nats_of_a_claim(
    stuck: Diagnosis, stuck_search: Search
) -> None:
    (step,), (finding,) = stuck_search.steps, stuck.findings
    known = replace(stuck_search, steps=(replace(step, stands=True),))
    other_size, floor = (3.0, 4.0), finding.log_bayes_factor
    for limits, left in (
        (Thresholds(size_ratio=other_size, floor=0.9 * floor), 1),
        (Thresholds(size_ratio=other_size, floor=1.1 * floor), 0),
        (Thresholds(floor=1.1 * floor), 1),
    ):
        with using(limits):
            found = findings_of(known, stuck.held_out, stuck.model, None)
        assert len(found) == left


@pytest.mark.parametrize(
    ("stands", "nats", "stays"), [(False, 90.0, False), (True, 90.0, True), (True, 1.0, False)]
)
def test_a_known_effect_stays_by_its_evidence_or_by_the_error(
    stuck: Diagnosis, stands: bool, nats: float, stays: bool
) -> None:
    """Half of the motion has the friction: the error neither falls nor rises surely."""
    (finding,) = stuck.findings
    hold_out = replace(finding.hold_out, gained=np.zeros(1))
    one = replace(finding, stands=stands, log_bayes_factor=nats, hold_out=hold_out)
    half = concatenate([stuck.held_out, two_rods.motion(3)])
    judged = replace(stuck, findings=(one,), held_out=half)
    found = with_consequences(judged, confirmed_only=True)
    (made,) = [one.consequence for one in found.findings]
    assert made is not None
    assert (made.worth, made.harms) == (False, False)
    assert [one.confirmed for one in found.findings] == [stays]


def test_a_known_effect_is_found_again(stuck: Diagnosis) -> None:
    known = Term(EFFECTS["stribeck"], 1, {"v_s": 0.3})
    (again,) = diagnose(stuck.model, stuck.motion, stuck.held_out, known=[known]).findings
    (first,) = stuck.findings
    assert again.name == first.name
    assert again.stands > first.stands
    assert again.shape["v_s"] == pytest.approx(first.shape["v_s"], rel=0.1)
    assert again.size == pytest.approx(first.size, rel=0.1)
