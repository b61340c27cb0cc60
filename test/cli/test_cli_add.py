"""`add` on the command line: a model with one more effect."""

import itertools
import json
from pathlib import Path

import pytest
from cli_examples import COULOMB, JOINTS, assert_refused, lagrangian_ff, small_model

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Model


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of a model without dry friction, which the arm has."""
    path = tmp_path_factory.mktemp("add") / "model.npz"
    return small_model(path, "--model", "chain+viscous")


def test_the_error_falls_and_the_parameters_are_told(model: Path, tmp_path: Path) -> None:
    output = tmp_path / "new.npz"
    outcome = lagrangian_ff(
        "add", model, "coulomb", "--joint", "shoulder", "--joint", "elbow",
        "--output", output, "--json", tmp_path / "added.json",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    record = json.loads((tmp_path / "added.json").read_text())
    assert record["error_after"] < 0.3 * record["error_before"]
    for joint, size in zip(JOINTS, COULOMB, strict=True):
        assert record["joints"][joint]["after"] < record["joints"][joint]["before"]
        (found,) = (one for one in record["effects"] if one["joint"] == joint)
        assert found["parameters"]["F_c"]["value"] == pytest.approx(size, rel=0.2)
    assert "90 % intervals" in outcome.out
    assert f"lagrangian_ff history {output}" in outcome.text
    new = Model.load(output)
    assert new.name == "chain+viscous+coulomb@shoulder+coulomb@elbow"
    assert [step["added"] for step in new.steps] == [
        "identified", "coulomb on shoulder", "coulomb on elbow"
    ]  # fmt: skip
    assert Model.load(model).name == "chain+viscous"


def test_a_curve_is_added_over_what_is_asked(tmp_path: Path) -> None:
    model, output = (
        small_model(tmp_path / "small.npz", "--model", "chain+offset"),
        tmp_path / "n.npz",
    )
    arguments = ("add", model, "curve", "--joint", "elbow", "--output", output)
    outcome = lagrangian_ff(
        *arguments, "--over", "velocity", "--odd", "--monotone", "--json", tmp_path / "added.json"
    )
    assert outcome.code == 0, outcome
    record = json.loads((tmp_path / "added.json").read_text())
    assert record["joints"]["elbow"]["after"] < 0.6 * record["joints"]["elbow"]["before"]
    ((curve,),) = (record["curves"],)
    (over,) = curve["over"]
    assert (over["coordinate"], over["unit"], curve["friction"]) == ("velocity", "rad/s", False)
    rising = [b - a for a, b in itertools.pairwise(curve["torque"])]
    assert min(rising) >= 0.0
    assert "velocity from" in outcome.text
    assert Model.load(output).name == "chain+offset+curve_velocity@elbow"
    for wrong, words in (
        ((), "--over velocity"),
        (("--over", "speed"), "expected one or two of position"),
        (("--over", "position@knee"), "has the joints shoulder, elbow"),
        (("--over", "position", "velocity", "--monotone"), "over one coordinate"),
        (("--over", "velocity", "--shape", "v=1"), "a curve has none"),
    ):
        assert_refused(lagrangian_ff(*arguments, "--force", *wrong), words)


def test_without_a_name_the_new_file_is_called_what_it_is(model: Path) -> None:
    outcome = lagrangian_ff("add", model, "offset", "--joint", "elbow")
    assert outcome.code == 0, outcome
    output = model.with_name("model+offset@elbow.npz")
    assert output.exists()
    again = lagrangian_ff("add", model, "offset", "--joint", "elbow")
    assert_refused(again, output.name, "exists already", "--force")
    output.unlink()


def test_a_shape_is_taken_as_given(model: Path, tmp_path: Path) -> None:
    output = tmp_path / "new.npz"
    arguments = ("add", model, "stribeck", "--joint", "elbow", "--shape", "v_s=0.07")
    assert lagrangian_ff(*arguments, "--output", output).code == 0
    assert Model.load(output).basis.terms[-1].shape == {"v_s": 0.07}
    coupled = tmp_path / "coupled.npz"
    outcome = lagrangian_ff(
        "add", model, "coupled", "--joint", "elbow", "--shape", "partner=shoulder", "ratio=-1",
        "--output", coupled,
    )  # fmt: skip
    assert outcome.code == 0, outcome
    assert Model.load(coupled).basis.terms[-1].shape == {"partner": 0.0, "ratio": -1.0}


def test_what_is_not_given_of_a_shape_is_searched(model: Path, tmp_path: Path) -> None:
    output = tmp_path / "new.npz"
    outcome = lagrangian_ff(
        "add", model, "coupled", "--joint", "elbow", "--shape", "ratio=-1", "--output", output
    )
    assert outcome.code == 0, outcome
    assert Model.load(output).basis.terms[-1].shape == {"partner": 0.0, "ratio": -1.0}


def diagnosis(path: Path, effect: str, joint: str, **more: object) -> Path:
    found = {
        "effect": effect, "joints": [joint], "why": "a bump at creeping speed", "shape": {},
        "verdict": "confirmed", "evidence_gain": 75.0, "p_value": 0.0025,
    }  # fmt: skip
    path.write_text(json.dumps({"findings": [{**found, **more}]}))
    return path


def test_the_history_tells_the_diagnosis_for_which_it_was_added(
    model: Path, tmp_path: Path
) -> None:
    found = diagnosis(tmp_path / "found.json", "stribeck", "elbow", shape={"v_s": 0.0712345})
    output = tmp_path / "new.npz"
    arguments = ("add", model, "stribeck", "--joint", "elbow", "--because", found)
    outcome = lagrangian_ff(*arguments, "--output", output)
    assert outcome.code == 0, outcome
    new = Model.load(output)
    assert new.basis.terms[-1].shape == {"v_s": 0.0712345}
    assert new.steps[-1]["verdict"] == "confirmed"
    told = lagrangian_ff("history", output).text
    for words in ("a bump at creeping speed", "75.0", "0.0025"):
        assert words in told


def test_a_diagnosis_that_does_not_find_it_is_refused(model: Path, tmp_path: Path) -> None:
    arguments = ("add", model, "stribeck", "--joint", "elbow", "--because")
    other = diagnosis(tmp_path / "other.json", "ripple", "shoulder")
    assert_refused(lagrangian_ff(*arguments, other), "stribeck on elbow", "ripple on shoulder")
    event = diagnosis(tmp_path / "event.json", "stribeck", "elbow", why="")
    assert_refused(lagrangian_ff(*arguments, event), "nothing to add")
    assert_refused(lagrangian_ff(*arguments, tmp_path / "no.json"), "no.json", "No such file")
    assert_refused(lagrangian_ff(*arguments, model), "expected the file", "diagnose --json")
    (tmp_path / "list.json").write_text('{"findings": [1]}')
    assert_refused(lagrangian_ff(*arguments, tmp_path / "list.json"), "diagnose --json")
    (tmp_path / "half.json").write_text('{"findings": [{"effect": "x", "joints": [], "why": ""}]}')
    assert_refused(lagrangian_ff(*arguments, tmp_path / "half.json"), "diagnose --json")
    over = lagrangian_ff(*arguments, event, "--json", event, "--force")
    assert_refused(over, "--json", event.name)
    assert "findings" in json.loads(event.read_text())
    assert list(model.parent.glob("*+*")) == []


def test_what_the_model_has_already_is_refused_with_the_reason(model: Path, tmp_path: Path) -> None:
    twice = lagrangian_ff("add", model, "viscous", "--joint", "elbow")
    assert_refused(twice, "viscous on elbow already", "chain+viscous")
    friction = small_model(tmp_path / "friction.npz")
    equal = lagrangian_ff("add", friction, "asymmetric_coulomb", "--joint", "elbow")
    assert_refused(equal, "asymmetric_coulomb on elbow", "another name", "coulomb, offset")
    assert list(tmp_path.glob("*+*")) == list(model.parent.glob("*+*")) == []


def test_what_no_motion_tells_apart_is_said(model: Path, tmp_path: Path) -> None:
    outcome = lagrangian_ff(
        "add", model, "rotor_inertia", "--joint", "elbow", "--output", tmp_path / "new.npz"
    )
    assert outcome.code == 0, outcome
    assert EFFECTS["rotor_inertia"].caution in outcome.text


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["stribeck"], ["--joint"]),
        (["stribek", "--joint", "elbow"], ["no effect 'stribek'", "did you mean stribeck"]),
        (["fri", "--joint", "elbow"], ["viscous and coulomb and offset"]),
        (["stribeck", "--joint", "wrist"], ["no joint 'wrist'", "shoulder, elbow"]),
        (["stribeck", "--joint", "elbow", "--shape", "w=1"], ["w=1", "v_s"]),
        (["stribeck", "--joint", "elbow", "--shape", "v_s=x"], ["v_s=x", "no number"]),
        (["stribeck", "--joint", "elbow", "--shape", "v_s=99"], ["v_s=99", "between", "rad/s"]),
        (["stribeck", "--joint", "elbow", "--shape", "v_s=-0.1"], ["v_s=-0.1", "between"]),
        (["ripple", "--joint", "elbow", "--shape", "order=2.5"], ["order=2.5", "a whole order"]),
        (["offset", "--joint", "elbow", "--shape", "c=1"], ["c=1", "linear"]),
        (["offset", "--joint", "elbow", "--output", "new.txt"], ["new.txt", ".npz"]),
    ],
)
def test_mistakes(arguments: list[str], words: list[str], model: Path) -> None:
    assert_refused(lagrangian_ff("add", model, *arguments), *words)
    assert [path.name for path in model.parent.glob("*.npz")] == ["model.npz"]


def test_no_model(tmp_path: Path) -> None:
    assert_refused(lagrangian_ff("add", tmp_path / "none.npz", "drift", "--joint", "a"), "none.npz")
