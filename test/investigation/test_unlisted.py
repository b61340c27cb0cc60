"""Formulas that hold, told from their rivals or not: what they leave to ask."""

from dataclasses import replace

from diagnosis_examples import doubt, finding, model

from lagrangian_ff.diagnosis import Finding
from lagrangian_ff.diagnosis.excite import Between
from lagrangian_ff.diagnosis.proposing import Proposal, Proposals
from lagrangian_ff.effects.formula import formula_effect
from lagrangian_ff.investigation.unlisted import Unlisted


def formula(name: str, *rivals: str) -> Finding:
    """Return a formula on the elbow that holds."""
    effect = formula_effect(name, "A*sign(qd)*exp(-(q/w)^2)", {"w": (0.1, 1.0)})
    return replace(finding(rivals=rivals, shape={"w": 0.3}), effect=effect)


def unlisted(*findings: Finding) -> Unlisted:
    """Return what is left on the elbow, with these formulas proposed."""
    proposed = tuple(Proposal(one, "a tight place") for one in findings)
    found = Proposals("elbow", proposed, 100, 20.0, 300.0, None, "another bag")
    return Unlisted((), (), model(), (found,))


def test_two_formulas_that_hold_are_a_question_with_their_shapes() -> None:
    first, second = formula("tight", "loaded"), formula("loaded", "tight")
    left = unlisted(first, second)
    assert not left.terms
    ((question, found),) = left.open
    assert isinstance(question, Between)
    assert [one.known for one in question.suspects] == [first.effect, second.effect]
    assert [one.shape for one in question.suspects] == [first.shape, second.shape]
    assert found is first


def test_one_that_is_confirmed_leaves_nothing_to_ask() -> None:
    left = unlisted(formula("tight"), formula("loaded", "tight"))
    assert not left.open
    assert [term.effect.name for term in left.terms] == ["tight"]


def test_what_does_not_hold_on_unseen_motion_is_not_asked_about() -> None:
    suggested = replace(formula("tight", "loaded"), doubt=doubt())
    assert not unlisted(suggested, replace(formula("loaded", "tight"), doubt=doubt())).open
    assert not unlisted(formula("tight", "of the catalogue")).open
