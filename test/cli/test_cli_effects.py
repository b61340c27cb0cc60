"""`effects`: the catalogue listed, and one effect explained."""

import json
from pathlib import Path

import pytest
from cli_examples import assert_refused, lagrangian_ff, process

from lagrangian_ff.cli.commands.effects import EPILOG
from lagrangian_ff.effects import EFFECTS, KINDS, effect_record, look_alikes


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """Return the file of an effect as the help shows it."""
    path = tmp_path / "mine.py"
    lines = EPILOG[EPILOG.index("  import numpy") :].splitlines()
    path.write_text("\n".join(line[2:] for line in lines) + "\n")
    return path


def test_all_are_listed_by_kind() -> None:
    outcome = process("effects")
    assert outcome.code == 0, outcome
    for effect in EFFECTS.values():
        assert f"  {effect.name} " in outcome.out
        assert effect.formula in outcome.text
        assert effect.meaning in outcome.text
    headings = [line.split(":")[0] for line in outcome.out.splitlines() if line[:1].isalpha()]
    assert headings[:-1] == list(KINDS)


@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_one_is_explained(name: str) -> None:
    effect = EFFECTS[name]
    outcome = lagrangian_ff("effects", name)
    assert outcome.code == 0, outcome
    words = [effect.formula, effect.source, effect.shows_as, effect.next_motion, effect.caution]
    words += [f"{p.unit} {p.meaning}" for p in effect.parameters]
    words += [s.meaning for s in effect.shapes]
    words += [f"{other} {difference}" for other, difference in look_alikes(effect).items()]
    missing = [
        word for word in words if " ".join(word.split()) not in " ".join(outcome.out.split())
    ]
    assert not missing
    assert max(map(len, outcome.out.splitlines())) <= 100


def test_records() -> None:
    outcome = lagrangian_ff("effects", "--json", "-")
    records = json.loads(outcome.out)["effects"]
    assert [record["name"] for record in records] == list(EFFECTS)
    record = json.loads(lagrangian_ff("effects", "stribeck", "--json", "-").out)
    assert record == effect_record(EFFECTS["stribeck"])
    assert record["parameters"] == [
        {
            "name": "F_s",
            "unit": "N·m",
            "meaning": "static friction above Coulomb's",
            "positive": True,
        }
    ]
    assert set(record["look_alikes"]) == set(look_alikes(EFFECTS["stribeck"]))


def test_a_picture(tmp_path: Path) -> None:
    picture = tmp_path / "ripple.png"
    outcome = lagrangian_ff("effects", "ripple", "--picture", picture)
    assert outcome.code == 0, outcome
    assert picture.read_bytes().startswith(b"\x89PNG")
    again = lagrangian_ff("effects", "ripple", "--picture", picture)
    assert_refused(again, "ripple.png", "exists already")
    assert lagrangian_ff("effects", "ripple", "--picture", picture, "--force").code == 0


def test_ones_own(own: Path, tmp_path: Path) -> None:
    """In processes of their own, as users see it: the catalogue of this one stays as it is."""
    listed = process("effects", "--effects-file", own)
    assert listed.code == 0, listed
    assert "  pit " in listed.out
    picture = tmp_path / "pit.png"
    outcome = process("effects", "pit", "--effects-file", own, "--picture", picture)
    assert outcome.code == 0, outcome
    for words in ("extra friction in a worn place", "source: user", "N·m"):
        assert words in outcome.text
    assert picture.exists()


def test_a_file_that_is_wrong(own: Path) -> None:
    own.write_text(own.read_text().replace("[:, None]", ""))
    outcome = lagrangian_ff("effects", "--effects-file", own)
    assert_refused(outcome, "mine.py", "'pit'", "shape (1000,)", "expected (1000, 1)")
    own.write_text("import numpi")
    assert_refused(lagrangian_ff("effects", "--effects-file", own), "mine.py", "line 1", "numpi")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["stribek"], ["no effect 'stribek'", "did you mean stribeck"]),
        (["xyz"], ["no effect 'xyz'", "lists all"]),
        (["fri"], ["'fri' stands for viscous"]),
        (["--picture", "all.png"], ["--picture draws one effect"]),
        (["drift", "--picture", "drift.jpg"], ["drift.jpg", ".png"]),
        (["--effects-file", "none.py"], ["none.py", "no such file"]),
    ],
)
def test_mistakes(arguments: list[str], words: list[str]) -> None:
    assert_refused(lagrangian_ff("effects", *arguments), *words)
