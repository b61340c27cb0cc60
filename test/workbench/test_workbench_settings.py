"""What a user chose: recordings are read with their own scales, and models are known by choice."""

from pathlib import Path

import numpy as np
import pytest
from workbench_examples import JOINTS, moved

from lagrangian_ff.diagnosis.preflight import Check, Remedy
from lagrangian_ff.errors import UserError
from lagrangian_ff.identification.settings import USUAL
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.recording import Conditioning, condition, load
from lagrangian_ff.recording.motion import EFFORTS, WITHOUT_FRICTION
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.workbench.session import Node, Role, Session
from lagrangian_ff.workbench.settings import URDF, Reading, choices, model_name, told


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return load(moved(tmp_path_factory.mktemp("settings") / "motion.npz", 0, seconds=12.0))


def test_each_recording_has_the_scale_of_its_file(recording: Recording) -> None:
    reading = Reading(scales={"b": {JOINTS[1]: -2.0, "another arm's": 9.0}})
    one, other = reading.ready(["a", "b"], [recording, recording])
    np.testing.assert_allclose(other.tau, one.tau * [1.0, -2.0], atol=1e-9)
    given = Conditioning(effort_scale={JOINTS[1]: -2.0}, bandwidth=None)
    np.testing.assert_allclose(other.tau, condition(recording, given).tau, atol=1e-9)
    assert one.conditioning["effort_scale"] == {}
    assert other.conditioning["effort_scale"] == {JOINTS[1]: -2.0}


def test_a_model_says_how_to_read_but_not_the_scale(recording: Recording) -> None:
    before = Conditioning(bandwidth=9.0, effort_scale={JOINTS[0]: 5.0}, effort=WITHOUT_FRICTION)
    (motion,) = Reading().ready(["a"], [recording], before)
    assert motion.conditioning["bandwidth"] == 9.0
    assert motion.effort == WITHOUT_FRICTION
    assert motion.conditioning["effort_scale"] == {}


@pytest.mark.parametrize("effort", EFFORTS)
def test_every_choice_is_a_model(effort: str) -> None:
    for one in choices("some/arm.urdf"):
        spec = parse(model_name(one.name, effort))
        assert bool(spec.effects) == (effort != WITHOUT_FRICTION)
        assert one.title
        assert one.meaning.endswith(".")
    assert model_name("auto", EFFORTS[0]) == USUAL
    assert URDF not in [one.name for one in choices("")]


def test_recordings_are_read_in_step(recording: Recording) -> None:
    (motion,) = Reading(effort_delay=0.008).ready(["a"], [recording])
    wanted = condition(recording, Conditioning(effort_delay=0.008))
    np.testing.assert_array_equal(motion.tau, wanted.tau)
    assert motion.conditioning["effort_delay"] == 0.008


def test_a_check_is_told_with_its_remedy() -> None:
    remedy = Remedy("Turn it", {"a": -1.0})
    found = told(Check("effort sign", "a", "it is turned", True, "Turn it", remedy=remedy))
    shown = {"words": "Turn it", "scale": {"a": -1.0}, "effort": "", "delay": None}
    assert found["remedy"] == shown
    assert told(Check("still", "a", "it stands still"))["remedy"] is None


def test_a_session_keeps_the_choice_and_knows_which_models_are_outdated(tmp_path: Path) -> None:
    session = Session.open(tmp_path / "session")
    card = session.add_card("motion", tmp_path / "motion.npz")
    card.looked = {"joints": []}
    session.choose("energy")
    files = session.files(Role.LEARN)
    settings = session.chosen(files)
    assert (settings["model"], settings["asked"]) == ("energy+fri", "energy+fri")
    session.add_node(Node("m1", "model.npz", "", "learned", {}, settings=settings))
    assert session.derived()["outdated"] == []
    card.scale = {"a": -1.0}
    session.save()
    again = Session.open(session.folder)
    assert again.choice == "energy"
    assert again.reading == Reading(scales={card.file: {"a": -1.0}})
    assert again.derived()["outdated"] == ["m1"]
    card.scale, session.effort_delay = {}, 0.004
    session.save()
    again = Session.open(session.folder)
    assert again.reading == Reading(effort_delay=0.004)
    assert again.derived()["outdated"] == ["m1"]
    with pytest.raises(UserError, match="no model 'urdf'"):
        again.choose(URDF)
    again.choice = URDF  # of a session that was begun with a description
    assert again.chosen(files)["model"] == USUAL
