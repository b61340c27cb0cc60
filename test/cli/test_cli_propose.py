"""`propose` on the command line: friction of the elbow that is higher near an angle."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cli_examples import QUICK, arm, assert_refused, csv, lagrangian_ff

from lagrangian_ff.diagnosis.thresholds import Effort, using
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Model
from lagrangian_ff.recording import Recording


def worn(reach: float = 1.0) -> Recording:
    """The small arm with noise, and a worn place in its elbow."""
    recording = arm(24.0, reach=reach)
    random = np.random.default_rng(round(1000 * reach))
    effort = recording.effort + 0.1 * random.normal(size=recording.effort.shape)
    speed = np.gradient(recording.position[:, 1], recording.time)
    near = np.exp(-(((recording.position[:, 1] - 0.2) / 0.15) ** 2))
    effort[:, 1] += 2.0 * np.tanh(speed / 0.02) * near
    return replace(recording, effort=effort)


@pytest.fixture(autouse=True, scope="module")
def _few_samples() -> Iterator[None]:
    with using(effort=Effort(800, ((60, 10), (120, 3), (240, 1)))):
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a model and two recordings."""
    path = tmp_path_factory.mktemp("propose")
    csv(path / "first.csv", worn())
    csv(path / "second.csv", worn(reach=0.9))
    outcome = lagrangian_ff(
        "identify", path / "first.csv", *QUICK, "--model", "chain+fri", "--train", "1.0",
        "--output", path / "model.npz",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    return path


def test_a_formula_is_proposed_kept_and_added(folder: Path) -> None:
    mine, found = folder / "mine.json", folder / "found.json"
    outcome = lagrangian_ff(
        "propose", folder / "model.npz", folder / "first.csv", "--confirm", folder / "second.csv",
        "--joint", "elbow", "--over", "position", "--output", mine, "--json", found,
    )  # fmt: skip
    assert outcome.code == 0, outcome
    record = json.loads(found.read_text())
    names = [one["name"] for one in record["proposals"]]
    assert "formula_friction_bump_position" in names[:2]
    assert record["proposals"][0]["error_after"] < record["proposals"][0]["error_before"]
    assert json.loads(mine.read_text())["effects"] == record["effects"]
    for words in ("near position", "N·m", f"--effects-file {mine}"):
        assert words in outcome.text
    better = folder / "better.npz"
    try:
        outcome = lagrangian_ff(
            "add", folder / "model.npz", names[0], "--joint", "elbow", "--effects-file", mine,
            "--output", better,
        )  # fmt: skip
        assert outcome.code == 0, outcome
        assert Model.load(better).name == f"chain+fri+{names[0]}@elbow"
    finally:
        for name in names:
            EFFECTS.pop(name, None)
    # The model has the formula itself: nothing needs its file any more.
    outcome = lagrangian_ff("history", better)
    assert outcome.code == 0, outcome
    outcome = lagrangian_ff("export", better, "--to", "json", "--output", folder / "better.json")
    assert outcome.code == 0, outcome
    assert names[0] in (folder / "better.json").read_text()


def test_mistakes_are_said(folder: Path) -> None:
    arguments = ("propose", folder / "model.npz", folder / "first.csv")
    for wrong, words in (
        (("--joint", "knee"), "no joint 'knee'"),
        (("--joint", "elbow", "--over", "speed"), "expected one or two of position"),
        (("--confirm", folder / "first.csv"), "confirm on a recording"),
        (("--joint", "elbow", "--output", folder / "mine.npz"), ".json"),
    ):
        assert_refused(lagrangian_ff(*arguments, *wrong), words)
