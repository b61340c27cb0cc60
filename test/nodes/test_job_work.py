"""The work of the jobs as their process does it: results, files, statuses.

The recording is short and the model small; that the search itself is right is tested where it is.
"""

import json
import pickle
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_model import JOINTS, recorded_bag

from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Model, Settings
from lagrangian_ff.nodes.common.status import Level
from lagrangian_ff.nodes.recorder.jobs import Job
from lagrangian_ff.nodes.recorder.jobs.add import Add
from lagrangian_ff.nodes.recorder.jobs.base import Situation
from lagrangian_ff.nodes.recorder.jobs.compare import Compare
from lagrangian_ff.nodes.recorder.jobs.diagnose import Addition, Diagnose
from lagrangian_ff.nodes.recorder.jobs.identify import Identify
from lagrangian_ff.nodes.recorder.jobs.load import Load
from lagrangian_ff.nodes.recorder.session import Result, Session
from lagrangian_ff.progress import silent
from lagrangian_ff.recording import Recording, write_bag

VALUES = {"effects_file": "", "output_directory": "."}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a model of the clean arm, and a bag with drag on joint b."""
    path: Path = tmp_path_factory.mktemp("jobs")
    clean = recorded_bag(path / "clean", drag=0.0)
    settings = Settings(samples=100)
    Identify(output=str(path / "model.npz"), bags=(str(clean),), settings=settings).work(silent)
    recorded_bag(path / "bag", drag=0.9)
    return path


def done(job: Job) -> tuple[Session, Result]:
    """Do a job; return the session after it and its result as the node gets it."""
    reported: list[float] = []
    result = job.work(lambda share, label: reported.append(share))
    assert reported == sorted(reported)
    session, received = Session(), pickle.loads(pickle.dumps(result))
    session.take(job.service, received)
    return session, received


def of(folder: Path, output: str) -> dict[str, Any]:
    """Return the fields of a request about the model and the bag."""
    return {
        "output": str(folder / output),
        "bags": (str(folder / "bag"),),
        "model_file": str(folder / "model.npz"),
    }


def test_compare_says_where_and_writes_it_down(folder: Path) -> None:
    job = Compare(**of(folder, "where.json"))
    session, result = done(job)
    written = json.loads((folder / "where.json").read_text())
    assert written["joints"]["b"]["rmse"] > 2.0 * written["joints"]["a"]["rmse"]
    status = Compare.statuses(session)["comparison"]
    assert status.values["page"] == str(folder / "where.html")
    assert "<html" in (folder / "where.html").read_text()
    assert "where 1" in status.values
    assert result.log[0] == status.message


def test_diagnose_then_add_what_it_confirmed(folder: Path) -> None:
    session, _ = done(Diagnose(**of(folder, "missing.json")))
    written = json.loads((folder / "missing.json").read_text())
    assert written["findings"][0]["effect"] == "quadratic_drag"
    assert {"check", "finding", "serious"} <= set(written["preflight"][0])
    statuses = Diagnose.statuses(session)
    status = statuses["quadratic_drag on b"]
    assert status.level is Level.WARN
    assert status.values["verdict"] == "confirmed"
    assert {"evidence gain [nats]", "error before [N·m]", "error after [N·m]", "C",
            "next motion"} <= set(status.values)  # fmt: skip
    short = statuses["diagnosis"]
    assert "missing: quadratic drag on b" in short.message
    assert len(short.message) <= 120
    assert written["verdict"] in str(short.values["verdict"])
    assert "<html" in Path(str(statuses["diagnosis"].values["page"])).read_text()

    values = {"model_file": str(folder / "model.npz"), "effects_file": "", "add.effect": "",
              "add.joint": ""}  # fmt: skip
    session, _ = done(Add.request(Situation(session, values.__getitem__, "joint_states")))
    assert session.model is not None
    larger = Model.load(session.model.file)
    assert session.model.file == folder / "model_quadratic_drag_b.npz"
    assert [step["added"] for step in larger.steps][-1] == "quadratic_drag on b"
    assert larger.steps[-1]["verdict"] == "confirmed"
    assert session.model.values["model"] == larger.name
    assert "added quadratic_drag on b" in Add.statuses(session)["addition"].message
    still = np.zeros((1, 2))
    moving = np.array([[0.0, 1.5]])
    assert not np.allclose(
        larger.predict(still, moving, still),
        Model.load(folder / "model.npz").predict(still, moving, still),
    )


def test_recordings_that_exist_are_used_as_if_they_had_been_made_here(folder: Path) -> None:
    asked = {"recordings": [str(folder / "bag"), str(folder / "clean"), str(folder / "bag")]}
    session = Session(bags=[folder / "clean"])
    job = Load.request(Situation(session, {**VALUES, **asked}.__getitem__, "robot/joint_states"))
    assert job.bags == (str(folder / "bag"),)
    result = job.work(silent)
    session.take(job.service, result)
    assert session.bags == [folder / "clean", folder / "bag"]
    assert session.joints == JOINTS
    assert "3000 samples in 30.0 s of a, b" in result.log[1]
    with pytest.raises(UserError, match="all loaded"):
        Load.request(Situation(session, {**VALUES, **asked}.__getitem__, "joint_states"))
    nothing = {**VALUES, "recordings": [""]}
    with pytest.raises(UserError, match="ros2 param set"):
        Load.request(Situation(session, nothing.__getitem__, "joint_states"))
    with pytest.raises(UserError, match="no such file"):
        replace(job, bags=(str(folder / "absent"),)).work(silent)


def test_impossible_requests_are_mistakes_in_words(folder: Path) -> None:
    model, findings = of(folder, "x.npz"), of(folder, "x.json")
    for job, expected in (
        (Add(**model, additions=(Addition("magic", "a"),)), "no effect 'magic'"),
        (Add(**model, additions=(Addition("coulomb", "a"),)), "already"),
        (Add(**model, additions=(Addition("stribeck", "c"),)), "no joint 'c'"),
        (Compare(**{**findings, "bags": (str(folder / "absent"),)}), "no such file"),
        (Compare(**findings, effects_file="/nowhere.py"), "no such file"),
    ):
        with pytest.raises(UserError, match=expected):
            done(job)
    assert not list(folder.glob("x.*"))


def test_a_missing_page_does_not_hide_the_findings(folder: Path) -> None:
    (folder / "plain.html").mkdir()  # so that the page cannot be written
    session, _ = done(Compare(**of(folder, "plain.json")))
    assert (folder / "plain.json").exists()
    values = Compare.statuses(session)["comparison"].values
    assert "plain.html" in str(values["no page because"])
    assert "page" not in values


@pytest.fixture(scope="module")
def amperes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a bag of 20 s of two joints whose effort is half the torque."""
    time = np.arange(0.0, 20.0, 0.01)
    phase = time[:, None] * np.array([2.1, 3.3])
    q, qd, qdd = 0.6 * np.sin(phase), 0.6 * np.cos(phase), -0.6 * np.sin(phase)
    qd, qdd = qd * [2.1, 3.3], qdd * np.square([2.1, 3.3])
    tau = 6.0 * np.cos(q) + 1.2 * qdd + 0.5 * qd
    path: Path = tmp_path_factory.mktemp("amperes") / "bag"
    return write_bag(path, Recording(JOINTS, time, q, qd, 0.5 * tau, start=1.7e9))


def test_from_bags_to_a_model_in_newton_metres(amperes: Path, tmp_path: Path) -> None:
    job = Identify(
        output=str(tmp_path / "model.npz"), bags=(str(amperes),),
        effort_scale={"a": 2.0, "b": 2.0}, settings=Settings(samples=60, train=0.6),
    )  # fmt: skip
    session, result = done(job)
    model = Model.load(tmp_path / "model.npz")
    still = np.zeros((1, 2))
    np.testing.assert_allclose(model.predict(still, still, still), 6.0, rtol=0.05)
    assert re.match(r"identified chain\w*\+fri from 60 samples", result.log[0])
    assert len(result.log) == 4
    status = Identify.statuses(session)["identification"]
    assert status.message == "identified"
    assert {"model file", "held-out RMSE [N·m]", "held-out error a"} <= set(status.values)


def test_what_cannot_be_identified_is_a_mistake_in_words(amperes: Path, tmp_path: Path) -> None:
    job = Identify(output=str(tmp_path / "model.npz"), bags=(str(amperes),))
    for change, expected in (
        ({"joints": ("c",)}, "no joint c"),
        ({"settings": Settings("nonsense")}, "nonsense"),
        ({"settings": Settings(prismatic=("c",))}, "prismatic names c"),
        ({"settings": Settings(landmarks=-2)}, "landmarks is -2"),
        ({"settings": Settings("rbf", positive=True)}, "kept positive"),
        ({"bags": (str(tmp_path / "missing"),)}, "no such file"),
    ):
        with pytest.raises(UserError, match=expected):
            replace(job, **change).work(silent)
    assert not (tmp_path / "model.npz").exists()
