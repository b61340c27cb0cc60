"""From a model and recordings to what is missing, confirmed on motion that was not used."""

import importlib
import json
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import two_rods

from lagrangian_ff.diagnosis import Diagnosis, add, apply, diagnose, history
from lagrangian_ff.diagnosis.ground import tuning
from lagrangian_ff.diagnosis.search import confirm
from lagrangian_ff.diagnosis.search.candidates import Candidate
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import EffectError, ModelError, RecordingError
from lagrangian_ff.identification import Model, Settings, identify

engine = importlib.import_module("lagrangian_ff.diagnosis.diagnose")
FEW = Settings(train=1.0, samples=120, evaluations=20)


@pytest.fixture(autouse=True, scope="module")
def _small() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tuning, "ROWS", 1200)
        patch.setattr(confirm, "ROWS", 1200)
        yield


def model_of(hidden: two_rods.Hidden | None, seed: int = 1) -> Model:
    return identify(two_rods.motion(seed, hidden=hidden), FEW).model


@pytest.fixture(scope="module")
def stuck() -> Diagnosis:
    """Return the diagnosis of an arm whose elbow sticks, confirmed on a second recording."""
    first, second = (two_rods.motion(seed, hidden=two_rods.stick) for seed in (1, 2))
    return diagnose(model_of(two_rods.stick), first, second)


def test_the_hidden_effect_is_confirmed_with_its_size(stuck: Diagnosis) -> None:
    (finding,) = stuck.confirmed
    assert (finding.effect.name, finding.joint) == ("stribeck", "elbow")
    assert finding.low[0] <= 0.6 <= finding.high[0] or finding.parameters[0] == pytest.approx(
        0.6, rel=0.2
    )
    assert finding.shape["v_s"] == pytest.approx(0.15, rel=0.3)
    assert finding.trial.ratio == pytest.approx(1.0, abs=0.4)
    assert not stuck.unexplained
    assert stuck.taken_up is None


def sprung(
    t: two_rods.Floats, q: two_rods.Floats, qd: two_rods.Floats, qdd: two_rods.Floats
) -> two_rods.Floats:
    """A spring in the elbow."""
    return np.stack([np.zeros(len(t)), 3.0 * q[:, 1]], axis=1)


def test_a_spring_is_missing_only_where_gravity_is_not_free(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model = identify(two_rods.motion(1), replace(FEW, model="chain+fri")).model
    first, second = (two_rods.motion(seed, hidden=sprung) for seed in (1, 2))
    found = diagnose(model, first, second)
    (finding,) = found.confirmed
    assert (finding.effect.name, finding.joint) == ("spring", "elbow")
    assert finding.low[0] < 3.0 < finding.high[0]
    with monkeypatch.context() as patch:
        found_at = (finding.parameters, finding.low - 9.0, finding.high - 9.0)
        patch.setattr(engine, "_frozen", lambda _: [found_at])
        (pushing,) = engine._confirmed(found.search, second, model, None)
        assert pushing.verdict == "suggested"
        assert "below zero as no spring's is" in pushing.reason
    monkeypatch.setattr(type(model.kernel), "free", True)
    (finding,) = engine._confirmed(found.search, second, model, None)
    assert finding.verdict == "suggested"
    assert "has this torque already" in finding.reason


def test_what_is_not_there_does_not_take_a_larger_effect_with_it(
    stuck: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A smaller one that the unseen motion refutes is fitted anew before the larger is judged."""
    (step,) = stuck.search.steps
    wrong = Candidate(EFFECTS["position_friction"], 1)
    smaller = replace(step, score=replace(step.score, candidate=wrong, gain=25.0))
    found = replace(stuck.search, steps=(step, smaller))
    (right,) = engine._frozen(stuck.search)
    far_off = np.array([1.5, -1.5])
    monkeypatch.setattr(engine, "_frozen", lambda _: [right, (far_off, far_off, far_off)])
    unseen = two_rods.motion(2, hidden=two_rods.stick)
    assert not engine._trial(found, engine._unseen(found, unseen, None), 0).holds
    views = engine._views(found, unseen, None)
    assert views[0][1].holds
    assert not views[1][1].holds


def test_what_happened_once_is_never_added(stuck: Diagnosis) -> None:
    (finding,) = stuck.findings
    contact = Candidate(EFFECTS["contact"], 1, {"t0": 1.0, "length": 2.0})
    once = replace(finding.step, score=replace(finding.step.score, candidate=contact))
    found = replace(stuck, findings=(replace(finding, step=once),))
    assert apply(found) is stuck.model


def test_the_load_of_another_model_is_no_part_of_a_finding(stuck: Diagnosis) -> None:
    (finding,) = stuck.findings
    mesh = Candidate(EFFECTS["gear_mesh"], 1, {"order": 6.0, "Jr": 0.02})
    found = replace(
        finding, step=replace(finding.step, score=replace(finding.step.score, candidate=mesh))
    )
    assert found.shape == {"order": 6.0}
    assert finding.shape == finding.step.score.candidate.shape


def test_the_record_is_json_and_complete(stuck: Diagnosis) -> None:
    record = json.loads(json.dumps(stuck.record(), allow_nan=False))
    assert "stribeck on elbow" in record["verdict"]
    (found,) = [one for one in record["findings"] if one["verdict"] == "confirmed"]
    assert found["error_after"] < found["error_before"]
    assert found["evidence_gain"] > 20.0
    assert 0.0 < found["p_value"] < 0.05
    assert found["parameters"]["F_s"]["unit"] == "N·m"
    assert {"effect", "joint", "next_motion"} <= set(record["not_observable"][0])
    assert len(found["signature"]["x"]) == len(found["signature"]["effect"])


def test_what_is_confirmed_is_added_and_the_history_tells_why(stuck: Diagnosis) -> None:
    model = apply(stuck)
    assert model.name == "chain+fri+stribeck@elbow"
    steps = history(model)["steps"]
    assert isinstance(steps, list)
    assert [step["added"] for step in steps] == ["identified", "stribeck on elbow"]
    assert steps[1]["verdict"] == "confirmed"
    assert steps[1]["joints"]["elbow"]["after"] < steps[1]["joints"]["elbow"]["before"]
    unseen = two_rods.motion(3, hidden=two_rods.stick)

    def error(one: Model) -> float:
        left = unseen.tau - one.predict(unseen.q, unseen.qd, unseen.qdd, time=unseen.time)
        return float(np.sqrt(np.mean(left[:, 1] ** 2)))

    assert error(model) < error(stuck.model)


def test_nothing_is_added_twice(stuck: Diagnosis) -> None:
    model = apply(stuck)
    with pytest.raises(ModelError, match="has stribeck on elbow already"):
        add(model, "stribeck", "elbow")
    with pytest.raises(ModelError, match="under another name"):
        add(model, "asymmetric_coulomb", "elbow")
    with pytest.raises(ModelError, match="no joint 'knee'"):
        add(model, "stribeck", "knee")
    with pytest.raises(EffectError, match="no effect 'magic'"):
        add(model, "magic", "elbow")


def test_once_added_it_is_not_missing_any_more(stuck: Diagnosis) -> None:
    again = diagnose(apply(stuck), stuck.motion, stuck.unseen)
    assert not again.confirmed


def test_a_recording_of_another_arm_is_refused_with_both_lists(stuck: Diagnosis) -> None:
    turned = replace(stuck.motion, joints=("shoulder", "wrist"), source="other")
    for first, unseen in ((turned, stuck.motion), (stuck.motion, [stuck.motion, turned])):
        with pytest.raises(ModelError, match=r"shoulder, elbow; other holds shoulder, wrist"):
            diagnose(stuck.model, first, unseen)


def test_a_clean_arm_lacks_nothing() -> None:
    motions = [two_rods.motion(seed) for seed in (5, 6)]
    found = diagnose(model_of(None, 5), motions[0], motions[1])
    assert not found.confirmed
    assert not found.unexplained
    assert "noise" in str(found.record()["verdict"])


def test_what_no_effect_explains_is_named_by_its_coordinate() -> None:
    motions = [two_rods.motion(seed, hidden=two_rods.sore_spot) for seed in (1, 2)]
    found = diagnose(model_of(two_rods.sore_spot), motions[0], motions[1])
    assert not found.confirmed
    rest = [(one.joint, one.coordinate) for one in found.unexplained]
    assert ("shoulder", "position, changing sign with direction") in rest


def test_one_recording_is_confirmed_on_its_end() -> None:
    motion = two_rods.motion(1, 60.0, two_rods.stick)
    found = diagnose(model_of(two_rods.stick), motion)
    assert not found.separate
    assert found.unseen.time[0] > found.motion.time[-1]
    assert found.findings[0].effect.name == "stribeck"


def test_a_motion_too_short_to_rule_out_chance_is_not_called_clean(stuck: Diagnosis) -> None:
    """Of four blocks one draw of signs in eight changes nothing: the best gain ties with itself."""
    motions = [two_rods.motion(seed, 7.0, two_rods.stick) for seed in (1, 2)]
    found = diagnose(stuck.model, motions[0], motions[1])
    assert not found.findings
    said = str(found.record()["verdict"])
    assert "stribeck on elbow" in said
    assert "Record longer" in said


def test_too_little_motion_is_said_with_what_to_do() -> None:
    with pytest.raises(RecordingError, match="not observable here; record half a minute"):
        diagnose(model_of(None), two_rods.motion(1, 4.0))


def test_results_are_reproducible(stuck: Diagnosis) -> None:
    again = diagnose(stuck.model, stuck.motion, stuck.unseen)
    gains = [finding.step.score.gain for finding in stuck.findings]
    assert [finding.step.score.gain for finding in again.findings] == gains
