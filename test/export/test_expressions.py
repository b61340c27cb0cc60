"""Expressions of the state: the formulas of users taken apart, whatever they are."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.effects.formula import FUNCTIONS as OF_USERS
from lagrangian_ff.effects.formula import INPUTS, formula_effect
from lagrangian_ff.effects.user import trial_motion
from lagrangian_ff.export.effects import CATALOGUE, mapped
from lagrangian_ff.export.expressions import FUNCTIONS, evaluated, names_in, parsed, text_of

NAMES = st.sampled_from(sorted(INPUTS))
LEAVES = NAMES | st.floats(0.1, 5.0).map(lambda one: f"{one:.3f}") | st.just("pi")
INNER = st.recursive(
    LEAVES,
    lambda part: st.one_of(
        st.tuples(part, st.sampled_from("+-*"), part).map(lambda p: f"({p[0]}{p[1]}{p[2]})"),
        st.tuples(st.sampled_from(["sin", "cos", "tanh", "atan", "abs", "sign"]), part).map(
            lambda p: f"{p[0]}({p[1]})"
        ),
        part.map(lambda one: f"-{one}"),
        part.map(lambda one: f"abs({one})^1.5"),
    ),
    max_leaves=6,
)


@example("sign(qd)", "qdd", "abs(sign(q))^1.5")
@given(INNER, INNER, INNER)
def test_parameters_get_what_they_multiply(one: str, two: str, three: str) -> None:
    formula = f"A*({one}) - ({two})*(B - A*{three})/2"
    if len(formula) > 400:
        return
    effect, x = formula_effect("mine", formula, {}), trial_motion()
    found = mapped(effect)
    assert found is not None
    given_ = {name: getattr(x, name)[:, 1] for name in INPUTS} | {"v0": x.sign_speed[1]}
    expected = effect.columns(x, 1, {})
    for place, text in enumerate(found.columns):
        again = evaluated(parsed(text_of(parsed(text))), given_) + np.zeros(len(x))
        scale = 1.0 + np.abs(expected[:, place])
        assert np.max(np.abs(again - expected[:, place]) / scale) < 1e-12


def test_formulas_have_no_function_that_an_export_lacks() -> None:
    assert set(OF_USERS) - {"sign"} <= set(FUNCTIONS)


@pytest.mark.parametrize("name", CATALOGUE)
def test_an_expression_for_each_parameter_of_known_names(name: str) -> None:
    effect = EFFECTS[name]
    assert len(CATALOGUE[name].columns) == len(effect.parameters)
    known = {*INPUTS, "torque", "v0", "qd_partner", *(shape.name for shape in effect.shapes)}
    for text in CATALOGUE[name].columns:
        assert names_in(parsed(text)) <= known
    if "torque" in effect.uses and not CATALOGUE[name].refused:
        assert any("torque" in names_in(parsed(text)) for text in CATALOGUE[name].columns)
