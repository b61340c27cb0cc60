"""The cases of the study of curves and proposed formulas; none is recorded here."""

import numpy as np
import pytest
from sines import sines

from lagrangian_ff.arm import JOINTS
from lagrangian_ff.arm.hidden import HIDDEN
from lagrangian_ff.diagnosis.proposing.grammar import forms
from lagrangian_ff.effects import EFFECTS, Inputs, Over
from lagrangian_ff.effects.formula import formula_effect
from lagrangian_ff.effects.user import check
from lagrangian_ff.kernels import States
from lagrangian_ff.studies.formulas import CASES, Judged, Strange


def moving() -> Inputs:
    """Return 5 s of six joints that all move, with a load."""
    time = np.arange(0.0, 5.0, 0.01)
    q, qd, qdd = sines(np.random.default_rng(0), time, len(JOINTS), (0.4, 4.0))
    return Inputs.of(States.of(q, qd, qdd), time, load=3.0 * np.cos(q) + qdd)


@pytest.mark.parametrize("case", CASES, ids=lambda case: str(case.name))
def test_a_case_is_a_form_of_the_grammar_and_can_be_a_curve(case: Strange) -> None:
    truth = formula_effect("truth", case.true, case.ranges)
    check(truth)
    assert case.true not in {effect.formula for effect in EFFECTS.values()}
    x = moving()
    names = {one.effect.name for one in forms(x, case.joint, JOINTS)}
    assert set(case.forms) <= names
    assert all(Over.of(one, JOINTS) for one in case.over)
    if case.torque is None:
        assert not HIDDEN[case.physics].known
        return
    torque = case.torque(x, case.joint)
    assert np.std(torque) > 0.0
    fits = []
    for shape in truth.candidates(x, case.joint):
        columns = truth.columns(x, case.joint, shape)
        left = torque - columns @ np.linalg.lstsq(columns, torque, rcond=None)[0]
        fits.append(np.std(left) / np.std(torque))
    assert min(fits) < 0.3  # on the grid; the fit refines the shapes


def test_what_is_counted() -> None:
    def one(rank: int) -> Judged:
        return Judged("drag", 1.0, 0.22, 0.21, 0.2, 1.0, 1.1, ("a", "b"), ("confirmed",) * 2, rank)

    assert one(1).ratio == pytest.approx(1.1)
    assert [one(rank).named for rank in (0, 1, 3, 4)] == [False, True, True, False]
    assert len({case.name for case in CASES}) == len(CASES)
