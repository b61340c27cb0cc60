"""`diagnose` on the command line: a pendulum whose elbow cogs, which no model knows of."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cli_examples import (
    JOINTS,
    QUICK,
    arm,
    assert_refused,
    csv,
    interrupted,
    lagrangian_ff,
    motion,
    small_model,
    torque,
)
from diagnosis_examples import consequence, diagnosis, fault, finding, run, taken_up
from diagnosis_examples import doubt as doubted

from lagrangian_ff.cli.text.diagnose import doubt, excite, fall_table, next_steps
from lagrangian_ff.diagnosis import Finding
from lagrangian_ff.diagnosis.results import Unexplained
from lagrangian_ff.diagnosis.thresholds import Effort, using
from lagrangian_ff.effects import EFFECTS, Over, curve_over
from lagrangian_ff.identification import Model
from lagrangian_ff.recording import Recording

SIZE, ORDER = 1.0, 9  # N·m, to a turn


def cogging(seconds: float = 24.0, reach: float = 1.0) -> Recording:
    """The small arm with noise, its elbow's motor cogging; no code of the catalogue."""
    recording = arm(seconds, reach=reach)
    random = np.random.default_rng(round(1000 * reach))
    effort = recording.effort + 0.1 * random.normal(size=recording.effort.shape)
    effort[:, 1] += SIZE * np.cos(ORDER * recording.position[:, 1])
    return replace(recording, effort=effort)


@pytest.fixture(autouse=True, scope="module")
def _few_samples() -> Iterator[None]:
    """Judge on fewer samples and choose the prior in fewer sweeps, which is quicker."""
    with using(effort=Effort(1000, ((60, 10), (120, 3), (240, 1)))):
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a model of the cogging arm, one of before, and two recordings.

    Of a kernel whose gravity cannot be anything over position: that would hold the ripple.
    """
    path = tmp_path_factory.mktemp("diagnose")
    small_model(path / "old.npz")
    csv(path / "first.csv", cogging())
    outcome = lagrangian_ff(
        "identify", path / "first.csv", *QUICK, "--model", "chain+fri", "--train", "1.0",
        "--output", path / "model.npz",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    csv(path / "second.csv", cogging(reach=0.9))
    return path


def test_what_is_missing_is_named_confirmed_added_and_the_error_falls(folder: Path) -> None:
    page, better, found = (folder / name for name in ("page.html", "better.npz", "found.json"))
    outcome = lagrangian_ff(
        "diagnose", folder / "model.npz", folder / "first.csv", "--confirm", folder / "second.csv",
        "--steps", "2", "--apply", "--output", better, "--report", page, "--json", found,
    )  # fmt: skip
    assert outcome.code == 0, outcome
    record = json.loads(found.read_text())
    first = record["findings"][0]
    assert (first["effect"], first["joints"]) == ("ripple", ["elbow"])
    assert first["verdict"] == "confirmed"
    assert first["error_after"] < 0.9 * first["error_before"]
    assert first["p_value"] < 0.05
    size = first["parameters"]["a"]
    assert size["low"] <= size["value"] <= size["high"]
    assert size["value"] == pytest.approx(SIZE, rel=0.2)
    assert size["unit"] == "N·m"
    assert {"verdict", "unexplained", "not_observable", "compare"} <= set(record)
    assert not [check for check in record["preflight"] if check["serious"]]
    for one in record["not_observable"]:
        assert one["effect"] in EFFECTS
        assert one["joint"] in (*JOINTS, "all")
        assert one["next_motion"]
    # What was done with it.
    assert record["applied"]["added"][0] == "ripple on elbow"
    assert record["steps"][1]["after"] < record["steps"][1]["before"]
    assert "+fri+ripple@elbow" in Model.load(better).name
    assert page.read_text("utf-8").endswith("</html>\n")
    # And what was printed.
    assert "Missing and confirmed: ripple on elbow" in outcome.text
    assert "added: ripple on elbow" in outcome.text
    assert f"lagrangian_ff history {better}" in outcome.text
    told = lagrangian_ff("history", better)
    assert "confirmed" in told.out
    assert "helps in" in told.text


def test_what_appeared_since_is_found_and_said_not_to_be_in_the_models_data(
    folder: Path, tmp_path: Path
) -> None:
    """And without another recording the end of this one is held back."""
    old, source = folder / "old.npz", csv(tmp_path / "long.csv", cogging(40.0))
    outcome = lagrangian_ff(
        "diagnose", old, source, "--steps", "1", "--since", "--json", tmp_path / "found.json"
    )
    assert outcome.code == 0, outcome
    assert "the last third of the motion is held back" in outcome.text
    assert "adding it does not lower the error of this model" in outcome.text
    assert f"lagrangian_ff identify {source} --train 1.0" in outcome.text
    changed = json.loads((tmp_path / "found.json").read_text())["changed"]
    assert [(one["what"], one["joints"]) for one in changed][:1] == [("ripple", ["elbow"])]
    assert changed[0]["change"]["a"]["value"] == pytest.approx(SIZE, rel=0.2)
    assert f"what changed since {old} was identified" in outcome.text
    assert "ripple  elbow" in outcome.out


def test_a_joint_that_stands_still_shows_nothing(folder: Path, tmp_path: Path) -> None:
    time, q, qd, qdd = motion(24.0, 100.0)
    for values in (q, qd, qdd):
        values[:, 1] = 0.0
    effort = torque(q, qd, qdd) + 0.1 * np.random.default_rng(0).normal(size=q.shape)
    recording = Recording(JOINTS, time, q, qd, effort)
    outcome = lagrangian_ff(
        "diagnose", folder / "model.npz", csv(tmp_path / "one.csv", recording), "--steps", "1",
        "--json", tmp_path / "found.json",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    record = json.loads((tmp_path / "found.json").read_text())
    assert not [one for one in record["findings"] if one["joints"] == ["elbow"]]
    still = {one["effect"] for one in record["not_observable"] if one["joint"] == "elbow"}
    assert {"stribeck", "ripple", "hysteresis"} <= still
    assert "not observable here" in outcome.text
    assert "lagrangian_ff excite" in outcome.text


def test_recordings_that_cannot_be_judged(folder: Path, tmp_path: Path) -> None:
    model = folder / "model.npz"
    short = csv(tmp_path / "short.csv", arm(2.0))
    still = arm(8.0)
    still.position[:] = 0.5
    silent = arm(8.0)
    silent.effort[:] = np.nan
    other = csv(tmp_path / "other.csv", arm(8.0, joints=("shoulder", "wrist")))
    for source, words in (
        (short, ("short.csv", "not observable here", "record half a minute")),
        (csv(tmp_path / "still.csv", still), ("still.csv", "no joint moves")),
        (csv(tmp_path / "silent.csv", silent), ("silent.csv", "effort")),
        (other, ("model.npz", "elbow", "wrist")),
        (tmp_path / "none.csv", ("none.csv", "no such file")),
    ):
        outcome = lagrangian_ff("diagnose", model, source, "--report", tmp_path / "page.html")
        assert_refused(outcome, *words)
        assert_refused(lagrangian_ff("diagnose", model, folder / "first.csv", "--confirm", source),
                       *words)  # fmt: skip
    assert not (tmp_path / "page.html").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--apply"], ["--apply needs --output"]),
        (["--output", "better.npz"], ["--apply"]),
        (["--steps", "0"], ["--steps 0"]),
        (["--confirm", "first.csv"], ["--confirm", "first.csv", "searched too"]),
        (["--report", "page.txt"], ["page.txt", ".html"]),
        (["--apply", "--output", "model.npz", "--force"], ["model.npz", "something else"]),
        (["--effects-file", "none.py"], ["none.py", "no such file"]),
    ],
)
def test_what_is_refused_before_any_work(
    arguments: list[str], words: list[str], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    assert_refused(lagrangian_ff("diagnose", "model.npz", "first.csv", *arguments), *words)


def test_faults_of_measurement_are_printed_first_and_an_interrupt_leaves_nothing(
    folder: Path, tmp_path: Path
) -> None:
    recording = arm(30.0)
    recording.effort[:, 1] *= 0.5
    source = csv(tmp_path / "half.csv", recording)
    outcome = interrupted(
        "elbow=2", "diagnose", folder / "old.npz", source, "--apply",
        "--output", tmp_path / "new.npz", "--report", tmp_path / "page.html",
        "--json", tmp_path / "found.json",
    )  # fmt: skip
    assert outcome.code == 130
    assert "Traceback" not in outcome.text
    assert "fix first" in outcome.out
    assert "--effort-scale elbow=2" in outcome.text
    assert list(tmp_path.iterdir()) == [source]


RIVAL = ("delay",)


@pytest.mark.parametrize(
    ("found", "confirmed"),
    [
        (finding("ripple"), True),
        (finding("ripple", doubt=doubted()), False),
        (finding("ripple", rivals=RIVAL), False),
    ],
)
def test_only_what_is_confirmed_is_told_to_be_added(found: Finding, confirmed: bool) -> None:
    this = run(diagnosis(findings=(found,)), sources=("a", "b"), confirm=("c",))
    lines = "\n".join(next_steps(this))
    add = "lagrangian_ff add model.npz ripple --joint elbow --shape order=9"
    assert (add in lines) == confirmed
    assert (excite("ripple", "elbow", "model.npz") in lines) == (not confirmed)
    assert ("a b --confirm c --apply" in lines) == confirmed
    lines = "\n".join(next_steps(this, saved="d.json"))
    assert ("--joint elbow --because d.json" in lines) == confirmed


def test_a_load_taken_up_is_not_told_to_be_added() -> None:
    lines = "\n".join(next_steps(run(diagnosis(taken_up=taken_up()))))
    assert "payload is of this recording" in lines
    assert "lagrangian_ff add" not in lines


def test_the_measurement_comes_first_and_the_unexplained_is_not_forgotten() -> None:
    found = diagnosis(
        findings=(finding("ripple", doubt=doubted()),),
        unexplained=(Unexplained("elbow", "time", 0.1, 30.0),),
    )
    lines = next_steps(run(found, checks=(fault(),)))
    assert "measurement" in lines[0]
    assert any("--effects-file" in line for line in lines)
    assert excite("ripple", "elbow", "model.npz") in "\n".join(lines)
    assert next_steps(run(diagnosis())) == []
    curved = Unexplained("elbow", "velocity", 0.1, 30.0, curve_over([Over("velocity")]))
    text = "\n".join(next_steps(run(diagnosis(unexplained=(curved,)))))
    assert "add model.npz curve --joint elbow --over velocity --output NEW.npz" in text


def test_doubts_say_why_and_what_to_do() -> None:
    assert doubt(finding("ripple"), JOINTS) == ""
    ambiguous = doubt(finding("ripple", rivals=("gear_mesh",)), JOINTS)
    assert "it may be gear_mesh too: on this motion they look the same; " in ambiguous
    text = doubt(finding("ripple", rivals=RIVAL, doubt=doubted("it helps in 50% only")), JOINTS)
    motion = EFFECTS["ripple"].next_motion
    for words in ("no more than suggested", "it helps in 50% only", "delay", f"do: {motion}"):
        assert words in text


def test_the_fall_names_each_addition_and_its_joint() -> None:
    header, first, second = fall_table(((finding(), consequence()),))
    assert header.split() == ["model", "all", "joints", "its", "joint"]
    assert first.split() == ["as", "it", "was", "3.00"]
    assert second.split()[:5] == ["+", "stribeck", "on", "elbow", "1.80"]
    assert second.endswith("elbow: 1.50 -> 0.900")
