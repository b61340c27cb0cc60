"""What is usual in a gear: known effects, a small weight, and nothing without a gear."""

import math

import pytest

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.effects.usual import GEARS, gear, usual_words, weight
from lagrangian_ff.errors import EffectError


@pytest.mark.parametrize("name", GEARS)
def test_a_gear_names_effects_of_the_catalogue_and_its_sources(name: str) -> None:
    known = GEARS[name]
    assert set(known.usual) | set(known.rare) <= set(EFFECTS)
    assert not set(known.usual) & set(known.rare)
    assert known.sources


@pytest.mark.parametrize("effect", EFFECTS)
def test_no_weight_comes_near_what_evidence_must_reach(effect: str) -> None:
    assert weight(effect, None) == 0.0
    assert usual_words(effect, None) == ""
    for name in GEARS:
        assert abs(weight(effect, name)) < 0.1 * thresholds.USED.floor
        assert bool(usual_words(effect, name)) == (weight(effect, name) != 0.0)


def test_what_is_usual_outweighs_what_is_rare_by_nine_to_one() -> None:
    difference = weight("hysteresis", "harmonic") - weight("backlash", "harmonic")
    assert math.exp(difference) == pytest.approx(9.0)
    assert "usual in a harmonic drive" in usual_words("hysteresis", "harmonic")
    assert "rare in a harmonic drive" in usual_words("backlash", "harmonic")


def test_an_unknown_gear_is_refused() -> None:
    with pytest.raises(EffectError, match="there are harmonic"):
        gear("magic")


def test_the_command_names_every_gear(capsys: pytest.CaptureFixture[str]) -> None:
    from lagrangian_ff.cli.main import main

    with pytest.raises(SystemExit):
        main(["diagnose", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert f"decides nothing: {', '.join(GEARS)}" in said
