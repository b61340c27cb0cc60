"""Effects that users bring, sound and not."""

import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from lagrangian_ff.cli.main import main
from lagrangian_ff.diagnosis.search.candidates import named
from lagrangian_ff.effects import (
    EFFECTS,
    checked_columns,
    load_effects,
    load_installed,
    look_alikes,
)
from lagrangian_ff.effects.user import check, trial_motion
from lagrangian_ff.errors import EffectError
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.spec import parse

TEN_LINES = """\
import numpy as np
from lagrangian_ff.effects import Effect, Parameter

class Pit(Effect):
    name = "pit"
    formula = "F sign(qd) exp(-((q - 0.4) / 0.1)^2)"
    parameters = (Parameter("F", "N·m", "extra friction in a worn place"),)

    def columns(self, x, joint, shape):
        return (x.sign(joint) * np.exp(-(((x.q[:, joint] - 0.4) / 0.1) ** 2)))[:, None]
"""


@pytest.fixture(autouse=True)
def catalogue() -> Iterator[None]:
    """Put the catalogue back as it was."""
    before = dict(EFFECTS)
    yield
    EFFECTS.clear()
    EFFECTS.update(before)
    load_installed.cache_clear()


def written(folder: Path, text: str, name: str = "mine.py") -> Path:
    file = folder / name
    file.write_text(dedent(text))
    return file


def changed(folder: Path, old: str, new: str) -> Path:
    assert old in TEN_LINES
    return written(folder, TEN_LINES.replace(old, new))


@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_our_own_effects_are_sound(name: str) -> None:
    check(EFFECTS[name])


def test_ten_lines_take_part_in_everything(tmp_path: Path) -> None:
    file = written(tmp_path, TEN_LINES)
    assert len(TEN_LINES.splitlines()) == 10
    (pit,) = load_effects(file)
    assert pit.source == "user"
    assert EFFECTS["pit"] is pit
    assert parse("vrbfs+fri+pit@elbow").further == ((pit, "elbow"),)
    assert [f.name for f in tmp_path.iterdir()] == ["mine.py"]


def test_a_new_effect_is_one_class_and_is_known_everywhere(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    looks = '    look_alikes = {"coulomb": "a pit is in one place only"}\n'
    line = '    parameters = (Parameter("F", "N·m", "extra friction in a worn place"),)\n'
    (pit,) = load_effects(changed(tmp_path, line, line + looks))
    assert look_alikes(EFFECTS["coulomb"])["pit"] == "a pit is in one place only"
    assert main(["effects"]) == 0
    assert "  pit " in capsys.readouterr().out
    assert main(["effects", "coulomb"]) == 0
    assert "a pit is in one place only" in capsys.readouterr().out
    missing = named(trial_motion(), Basis(()), joints=(0, 1))
    assert [one.joint for one in missing if one.source is pit] == [0, 1]


def test_instances_and_classes_with_shapes(tmp_path: Path) -> None:
    text = """
        from lagrangian_ff.effects import EFFECTS, Effect, Parameter, Shape
        from lagrangian_ff.effects.ripple import Ripple

        known = EFFECTS["viscous"]

        class _Base(Effect):
            parameters = (Parameter("F", "N·m", "size"),)

        class Beat(_Base):
            shapes = (Shape("w", "rad/s", "frequency", 1.0, 50.0, 10.0),)

            def __init__(self, name, power):
                self.name, self.formula, self.power = name, "F sin(w t)", power

            def columns(self, x, joint, shape):
                import numpy as np
                t = np.where(np.isfinite(x.time), x.time, 0.0)
                return np.sin(shape["w"] * t)[:, None] ** self.power

        one, two = Beat("beat_one", 1), Beat("beat_two", 2)
    """
    assert [effect.name for effect in load_effects(written(tmp_path, text))] == [
        "beat_one",
        "beat_two",
    ]


def test_a_file_may_be_loaded_again(tmp_path: Path) -> None:
    load_effects(written(tmp_path, TEN_LINES))
    load_effects(changed(tmp_path, '"pit"', '"hollow"'))
    assert "hollow" in EFFECTS
    assert "pit" not in EFFECTS


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("import numpy as np", "import nunpy as np", ["does not import", "line 1", "nunpy"]),
        ("import numpy as np", "x = 1 +", ["does not import", "line 1", "SyntaxError"]),
        ("import numpy as np", "raise SystemExit(3)", ["does not import", "SystemExit"]),
        ("[:, None]", "", ["'pit'", "shape (1000,)", "expected (1000, 1)"]),
        ("x.sign(joint) *", "np.inf *", ["'pit'", "inf", "finite", "F"]),
        ("x.q[:, joint]", "x.angle", ["'pit'", "line 10", "AttributeError", "angle"]),
        ("def columns", "def column", ["Pit", "no columns()"]),
        ('"pit"', '"coulomb"', ["'coulomb'", "taken by the catalogue"]),
        ('"pit"', '"fri"', ["'fri'", "taken by a group"]),
        ('"pit"', '"rbf"', ["'rbf'", "taken by a kernel"]),
        ('"pit"', '"a pit"', ["'a pit'", "one word"]),
        ('"pit"', "3", ["name", "a text", "3"]),
        (",)", ")", ["'pit'", "parameters", "tuple"]),
        ("(Effect)", "", ["defines no effect"]),
        ('    name = "pit"\n', '    name = "pit"\n    kind = "frictoin"\n', ["kind", "frictoin"]),
        ('    name = "pit"\n', '    name = "pit"\n    motion = "dance"\n', ["motion", "dance"]),
        ('    name = "pit"\n', '    name = "pit"\n    uses = {"tau"}\n', ["uses", "tau"]),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, old: str, new: str, words: list[str]) -> None:
    before = dict(EFFECTS)
    modules = set(sys.modules)
    file = changed(tmp_path, old, new)
    with pytest.raises(EffectError) as caught:
        load_effects(file)
    for word in [str(file), *words]:
        assert word in str(caught.value)
    assert before == EFFECTS
    assert "nunpy" not in set(sys.modules) - modules


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        ('Shape("w", "s", "width", 0.0, 2.0, 1.0)', ["shape w", "0 < low"]),
        ('Shape("w", "s", "width", 0.1, 2.0, 3.0)', ["shape w", "3.0"]),
        ('Shape("w", "s", "width", -1.0, 2.0, 3.0, even=True)', ["shape w", "3.0"]),
        ('Shape("F", "s", "width", 0.1, 2.0, 1.0)', ["different names"]),
        ('"w"', ["shapes", "tuple"]),
    ],
)
def test_shapes_are_checked(tmp_path: Path, shape: str, words: list[str]) -> None:
    file = changed(tmp_path, '    name = "pit"\n', f'    name = "pit"\n    shapes = ({shape},)\n')
    file.write_text(file.read_text().replace("Effect, ", "Effect, Shape, "))
    with pytest.raises(EffectError) as caught:
        load_effects(file)
    assert all(word in str(caught.value) for word in words)


def test_one_bad_effect_keeps_its_whole_file_out(tmp_path: Path) -> None:
    second = TEN_LINES[TEN_LINES.index("class") :].replace("Pit", "Bad").replace("pit", "bad")
    file = written(tmp_path, TEN_LINES + "\n" + second.replace("[:, None]", ""))
    with pytest.raises(EffectError, match="'bad'"):
        load_effects(file)
    assert "pit" not in EFFECTS


def test_two_files_with_one_name(tmp_path: Path) -> None:
    first = written(tmp_path, TEN_LINES)
    load_effects(first)
    with pytest.raises(EffectError, match=r"taken by .*mine\.py"):
        load_effects(written(tmp_path, TEN_LINES, "other.py"))


@pytest.mark.parametrize("name", ["none.py", ".", "notes.txt"])
def test_files_that_are_none(tmp_path: Path, name: str) -> None:
    (tmp_path / "notes.txt").write_text("hello")
    with pytest.raises(EffectError, match=r"no such file|a Python file"):
        load_effects(tmp_path / name)


def test_installed_effects_join_and_broken_ones_are_warned_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written(tmp_path, TEN_LINES, "worn_gear.py")
    written(tmp_path, "raise OSError('no licence')", "broken_gear.py")
    monkeypatch.syspath_prepend(str(tmp_path))
    installed = tmp_path / "worn_gear-1.0.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: worn-gear\nVersion: 1.0\n")
    (installed / "entry_points.txt").write_text(
        "[lagrangian_ff.effects]\nbroken = broken_gear:Pit\nabsent = worn_gear:Hollow\n"
        "number = math:pi\npit = worn_gear:Pit\n"
    )
    with pytest.warns(UserWarning, match="left out") as warned:
        found = load_installed()
    assert [effect.name for effect in found] == ["pit"]
    assert EFFECTS["pit"] is found[0]
    said = " ".join(str(w.message) for w in warned)
    assert all(word in said for word in ("no licence", "Hollow", "got float"))
    assert load_installed() is found


def test_the_trial_motion_has_rest_and_reversals() -> None:
    x = trial_motion()
    assert (x.qd == 0.0).any()
    assert (np.diff(np.sign(x.qd), axis=0) != 0).any(axis=0).all()


STUBBORN = """\
while True:
    try:
        while True:
            pass
    except Exception:
        pass
"""
LOOP = "        while True:\n            pass\n        return"


@pytest.mark.parametrize("in_thread", [False, True])
@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("while True:\n    pass\n", "line [12]"),
        (STUBBORN, "line [34]"),
        (TEN_LINES.replace("        return", LOOP), "line 1[012]"),
    ],
)
def test_an_endless_loop_ends_with_its_line(
    text: str, line: str, in_thread: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LAGRANGIAN_FF_EFFECT_SECONDS", "0.2")
    file = written(tmp_path, text)
    expected = rf"took more than 0.2 s, and was in .*mine.py, {line}: is that an endless loop"
    with ThreadPoolExecutor(1) as pool:
        runs = {True: lambda: pool.submit(load_effects, file).result(30.0)}
        with pytest.raises(EffectError, match=expected):
            runs.get(in_thread, lambda: load_effects(file))()
    assert "pit" not in EFFECTS


def test_a_sleep_is_ended_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAGRANGIAN_FF_EFFECT_SECONDS", "0.2")
    with pytest.raises(EffectError, match=r"importing it took more than 0.2 s.*line 2"):
        load_effects(written(tmp_path, "import time\ntime.sleep(60.0)\n"))


def test_columns_that_loop_on_some_motions_only_are_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    loop = LOOP.replace("True", "len(x) == 7")
    load_effects(written(tmp_path, TEN_LINES.replace("        return", loop)))
    monkeypatch.setenv("LAGRANGIAN_FF_EFFECT_SECONDS", "0.2")
    x = trial_motion()
    assert len(checked_columns(EFFECTS["pit"], x, 0, {})) == len(x)
    with pytest.raises(EffectError, match=r"'pit': columns\(\) took more than 0.2 s.*line 1"):
        checked_columns(EFFECTS["pit"], x.take(np.arange(7)), 0, {})


def test_a_limit_that_is_no_number_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LAGRANGIAN_FF_EFFECT_SECONDS", "soon")
    with pytest.raises(EffectError, match="expected seconds"):
        load_effects(written(tmp_path, TEN_LINES))
