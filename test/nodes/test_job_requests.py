"""The recordings and the model that each job gets, and the reasons for which it is refused."""

import pickle
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Settings
from lagrangian_ff.nodes.recorder.jobs import Job
from lagrangian_ff.nodes.recorder.jobs.add import Add
from lagrangian_ff.nodes.recorder.jobs.base import Situation
from lagrangian_ff.nodes.recorder.jobs.compare import Compare
from lagrangian_ff.nodes.recorder.jobs.diagnose import Addition, Diagnose, Diagnosed
from lagrangian_ff.nodes.recorder.jobs.identify import Identify
from lagrangian_ff.nodes.recorder.session import SavedModel, Session
from lagrangian_ff.recording.motion import Conditioning

STRIBECK = Addition("stribeck", "b", {"v_s": 0.1}, {"why": "it is felt"})


@pytest.fixture
def values(tmp_path: Path) -> dict[str, Any]:
    return {
        "output_directory": str(tmp_path), "effects_file": "", "model_file": "", "joints": [""],
        "model": "motor+fri", "prismatic": [""], "urdf": "", "use_robot_description": False,
        "landmarks": -1, "positive": True,
        "train": 0.5, "samples": 50, "loss": "huber", "bandwidth": 20.0,
        "units": ["position=deg"], "effort": "total", "effort_delay": 0.003,
        "effort_scale.a": 2.0, "effort_offset.a": 0.1, "add.effect": "", "add.joint": "",
    }  # fmt: skip


def recorded(tmp_path: Path, count: int) -> Session:
    return Session(
        bags=[tmp_path / f"bag_{number}" for number in range(1, count + 1)],
        model=SavedModel(tmp_path / "old.npz", {}),
    )


def situation(session: Session, values: dict[str, Any], description: str = "") -> Situation:
    return Situation(session, values.__getitem__, "/joint_states", ["a"], description)


def names(bags: tuple[str, ...]) -> list[str]:
    return [Path(bag).name for bag in bags]


@pytest.mark.parametrize(
    ("job", "count", "used", "confirm"),
    [
        (Identify, 2, ["bag_1", "bag_2"], []),
        (Compare, 3, ["bag_3"], []),
        (Diagnose, 1, ["bag_1"], []),
        (Diagnose, 3, ["bag_1", "bag_2"], ["bag_3"]),
    ],
)
def test_each_job_gets_its_recordings(
    tmp_path: Path, values: dict[str, Any], job: type[Job], count: int, used: list[str],
    confirm: list[str],
) -> None:  # fmt: skip
    made = job.request(situation(recorded(tmp_path, count), values))
    assert names(made.bags) == used
    assert names(getattr(made, "confirm", ())) == confirm
    assert made.effort_scale == {"a": 2.0}
    assert all(name in made.summary() for name in [*used, *confirm])
    if job is Diagnose:
        assert ("held back" in made.summary()) == (count == 1)
    assert pickle.loads(pickle.dumps(made)) == made


def test_settings_of_the_identification_are_those_of_the_command_line(
    tmp_path: Path, values: dict[str, Any]
) -> None:
    given = situation(recorded(tmp_path, 1), values)
    made = Identify.request(given).settings
    assert (made.model, made.train, made.samples, made.loss) == ("motor+fri", 0.5, 50, "huber")
    assert (made.prismatic, made.landmarks, made.positive) == ((), None, True)
    values.update(prismatic=["rail", "lift"], landmarks=0, positive=False)
    made = Identify.request(given).settings
    assert (made.prismatic, made.landmarks, made.positive) == (("rail", "lift"), 0, False)


def test_the_installed_parameters_are_the_usual_settings() -> None:
    file = Path(__file__).parents[2] / "config" / "identify.yaml"
    given = YAML(typ="safe").load(file)["/**"]["ros__parameters"]
    for name in ("train", "samples", "positive", "loss"):
        assert given[name] == getattr(Settings, name), name
    assert given["bandwidth"] == 0.0  # chosen from the recordings
    assert given["effort"] == Conditioning.effort


@pytest.mark.parametrize(
    ("effort", "usual"),
    [("total", "auto+fri"), ("without-gravity", "auto+fri"), ("without-friction", "auto")],
)
def test_the_usual_model_has_what_the_effort_holds(
    tmp_path: Path, values: dict[str, Any], effort: str, usual: str
) -> None:
    values.update(model="", effort=effort)
    made = Identify.request(situation(recorded(tmp_path, 1), values))
    assert (made.effort, made.settings.model) == (effort, usual)


def test_the_description_is_a_file_or_what_came_on_the_topic(
    tmp_path: Path, values: dict[str, Any]
) -> None:
    session = recorded(tmp_path, 1)
    bare, described = situation(session, values), situation(session, values, "<robot name='ü'/>")
    assert Identify.request(described).urdf == ""
    values["use_robot_description"] = True
    with pytest.raises(UserError, match="nothing came on the topic robot_description"):
        Identify.request(bare)
    written = Path(Identify.request(described).urdf)
    assert written.read_text(encoding="utf-8") == "<robot name='ü'/>"
    assert written.parent == tmp_path
    values["urdf"] = str(tmp_path / "arm.urdf")
    with pytest.raises(UserError, match="set one of the two"):
        Identify.request(described)
    values["use_robot_description"] = False
    assert Identify.request(described).urdf == str(tmp_path / "arm.urdf")


def test_no_existing_file_is_overwritten(tmp_path: Path, values: dict[str, Any]) -> None:
    (tmp_path / "bag_1_compare.json").touch()
    made = Compare.request(situation(recorded(tmp_path, 1), values))
    assert Path(made.output).name == "bag_1_compare_2.json"


def test_the_model_is_the_last_one_or_the_one_that_is_named(
    tmp_path: Path, values: dict[str, Any]
) -> None:
    session = recorded(tmp_path, 1)
    given, named = situation(session, values), tmp_path / "named.npz"
    values["model_file"] = str(named)
    assert Compare.request(given).model_file == str(tmp_path / "old.npz")
    session.model = None
    with pytest.raises(UserError, match="which does not exist"):
        Compare.request(given)
    named.touch()
    assert Compare.request(given).model_file == str(named)
    values["model_file"] = ""
    with pytest.raises(UserError, match="call ~/identify first"):
        Compare.request(given)


def test_an_addition_was_asked_for_or_confirmed(tmp_path: Path, values: dict[str, Any]) -> None:
    session = recorded(tmp_path, 1)
    given = situation(session, values)
    with pytest.raises(UserError, match="call ~/diagnose first"):
        Add.request(given)
    session.take("diagnose", Diagnosed(("nothing",)))
    with pytest.raises(UserError, match="confirmed no effect"):
        Add.request(given)
    session.take("diagnose", Diagnosed(("stribeck",), confirmed=(STRIBECK,)))
    made = Add.request(given)
    assert made.additions == (STRIBECK,)
    assert Path(made.output) == tmp_path / "old_stribeck_b.npz"
    assert pickle.loads(pickle.dumps(made)) == made
    values["add.effect"] = "drift"
    with pytest.raises(UserError, match=r"set the parameter add\.joint, too"):
        Add.request(given)
    values["add.joint"] = "a"
    assert [str(each) for each in Add.request(given).additions] == ["drift on a"]
