"""--effects-file: effects of one's own take part in every command that makes or reads a model."""

from pathlib import Path

import pytest
from cli_examples import Outcome, arm, assert_refused, csv, lagrangian_ff, process, small_model

OWN = """
import numpy as np
from lagrangian_ff.effects import Effect, Parameter

class Pit(Effect):
    name = "pit"
    formula = "F sign(qd) exp(-((q - 0.4) / 0.1)^2)"
    parameters = (Parameter("F", "N·m", "extra friction in a worn place"),)

    def columns(self, x, joint, shape):
        return (x.sign(joint) * np.exp(-(((x.q[:, joint] - 0.4) / 0.1) ** 2)))[:, None]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with an effect, a model that has it, a recording and a trajectory."""
    path = tmp_path_factory.mktemp("own")
    (path / "mine.py").write_text(OWN)
    csv(path / "arm.csv", arm(12.0))
    small_model(path / "old.npz", "--model", "none+fri")
    (path / "move.csv").write_text(
        "time,position/shoulder,position/elbow\n"
        + "".join(f"{0.1 * k:.1f},{0.01 * k},{0.02 * k}\n" for k in range(20))
    )
    arguments = ("add", "old.npz", "pit", "--joint", "elbow", "--output", "model.npz")
    outcome = run(path, *arguments)
    assert outcome.code == 0, outcome
    return path


def run(folder: Path, command: str, *arguments: str, own: bool = True) -> Outcome:
    """Run a command on the files of the folder, in a process that has loaded no other effects."""
    files = [str(folder / one) if (folder / one).exists() or one.endswith((".npz", ".csv"))
             else one for one in arguments]  # fmt: skip
    more = ["--effects-file", str(folder / "mine.py")] if own else []
    return process(command, *files, *more)


@pytest.mark.parametrize(
    ("command", "arguments", "words"),
    [
        ("predict", ("model.npz", "arm.csv"), "nmse"),
        ("compare", ("model.npz", "arm.csv"), "where it fails"),
        ("info", ("model.npz",), "pit"),
        ("history", ("model.npz",), "pit on elbow"),
        ("feedforward", ("model.npz", "move.csv", "--output", "torque.csv"), "elbow"),
    ],
)
def test_a_model_with_it_is_read_by_every_command(
    command: str, arguments: tuple[str, ...], words: str, folder: Path
) -> None:
    outcome = run(folder, command, *arguments)
    assert outcome.code == 0, outcome
    assert words in outcome.out


def test_commands_to_type_next_have_it(folder: Path) -> None:
    add = ("add", "old.npz", "pit", "--joint", "elbow", "--output", "next.npz")
    for arguments in (add, ("compare", "model.npz", "arm.csv")):
        outcome = run(folder, *arguments)
        _, shown = outcome.out.split("next:")
        (command,) = [line for line in shown.splitlines() if line.startswith("  lagrangian_ff")]
        assert command.endswith(f" --effects-file {folder / 'mine.py'}")
        if arguments is add:
            followed = process(*command.split()[1:])
            assert followed.code == 0, followed


def test_without_the_file_the_error_names_effect_and_option(folder: Path) -> None:
    outcome = run(folder, "predict", "model.npz", "arm.csv", own=False)
    assert_refused(outcome, "model.npz", "'pit'", "--effects-file")


def test_it_can_be_identified_with(folder: Path) -> None:
    outcome = run(
        folder, "identify", "arm.csv", "--model", "none+fri+pit@elbow", "--samples", "60",
        "--block", "1", "--output", "identified.npz",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    assert "pit" in outcome.out


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("import numpi", ("line 1", "numpi")),
        ("x = 1", ("defines no effect",)),
        (OWN.replace("[:, None]", ""), ("'pit'", "shape (1000,)", "expected (1000, 1)")),
        (OWN.replace('"pit"', '"stribeck"'), ("'stribeck'", "taken by the catalogue")),
        (OWN.replace("np.exp(", "np.nan * ("), ("'pit'", "nan", "finite")),
    ],
)
def test_a_file_that_fails_is_named_whatever_the_command(
    text: str, words: tuple[str, ...], folder: Path, tmp_path: Path
) -> None:
    wrong = tmp_path / "wrong.py"
    wrong.write_text(text)
    model, source = folder / "old.npz", folder / "arm.csv"
    for arguments in (("history", model), ("diagnose", model, source), ("compare", model, source)):
        outcome = lagrangian_ff(*arguments, "--effects-file", wrong)
        assert_refused(outcome, "wrong.py", *words)
