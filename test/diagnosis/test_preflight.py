"""Faults put into a measurement are found and named; a sound measurement has none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.preflight import Check, preflight
from lagrangian_ff.diagnosis.preflight.effort import UNITS
from lagrangian_ff.diagnosis.record import check_record
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.recording import Conditioning, Motion, Recording, concatenate, condition, load

Floats = NDArray[np.float64]

JOINTS = ("shoulder", "elbow")
RATE = 200.0
NOISE = 0.1


def torque(q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """N·m of two links in the vertical plane, with friction."""
    c2, s2 = np.cos(q[:, 1]), np.sin(q[:, 1])
    g1, g2 = 9.81 * np.cos(q[:, 0]), 9.81 * np.cos(q[:, 0] + q[:, 1])
    turning = s2 * (2.0 * qd[:, 0] * qd[:, 1] + qd[:, 1] ** 2)
    first = (3.0 + 2.0 * c2) * qdd[:, 0] + (1.0 + c2) * qdd[:, 1] - turning + 2.0 * g1 + g2
    second = (1.0 + c2) * qdd[:, 0] + qdd[:, 1] + s2 * qd[:, 0] ** 2 + g2
    friction = np.array([0.8, 0.3]) * qd + np.array([2.0, 0.8]) * np.tanh(qd / 0.02)
    return np.stack([first, second], axis=1) + friction


def recorded(seconds: float = 40.0, seed: int = 0, noise: int = 0, reach: float = 1.0) -> Recording:
    """Both joints on eight sines of 0.1 to 3 Hz, at rest nowhere."""
    draw = np.random.default_rng(seed)
    time = np.arange(round(seconds * RATE)) / RATE
    q, qd, qdd = np.zeros((3, len(time), 2))
    for omega in 2 * np.pi * np.geomspace(0.1, 3.0, 8):
        angle = omega * draw.uniform(0.9, 1.1, 2) * time[:, None] + draw.uniform(0, 6.28, 2)
        rate = np.gradient(angle, time, axis=0)
        size = reach * 0.6 / (1.0 + (omega / 2.0) ** 2)
        q += size * np.sin(angle)
        qd += size * rate * np.cos(angle)
        qdd -= size * rate**2 * np.sin(angle)
    tau = torque(q, qd, qdd)
    tau += NOISE * np.random.default_rng(100 + noise).normal(size=tau.shape)
    return Recording(JOINTS, time, q, qd, tau, 0.0)


def motion(recording: Recording) -> Motion:
    """As identification gets it."""
    return condition(recording, Conditioning(clock="stamps", bandwidth=25.0))


@pytest.fixture(scope="module")
def model() -> Model:
    """Return a model of the arm."""
    settings = Settings(samples=150, evaluations=15, train=1.0)
    return identify(motion(recorded(seed=1)), settings).model


@pytest.fixture(scope="module")
def clean() -> Recording:
    """Return a recording without a fault."""
    return recorded()


def changed(recording: Recording, effort: Floats) -> Motion:
    """The motion of the recording with another effort."""
    return motion(replace(recording, effort=effort))


def serious(checks: list[Check]) -> list[Check]:
    """Return what must be mended."""
    return [check for check in checks if check.serious]


def only(checks: list[Check]) -> Check:
    """Return the one serious check."""
    found = serious(checks)
    assert len(found) == 1, found
    return found[0]


def test_a_sound_measurement(model: Model, clean: Recording) -> None:
    checks = preflight(model, motion(clean))
    assert not serious(checks)
    found = {check.check: check for check in checks}
    assert found["effort unit"].values["lowest"] == pytest.approx(1.0, abs=0.1)
    assert abs(found["delay"].values["delay"]) < 0.002
    assert not {"saturation", "noise floor", "still", "duration"} & set(found)
    assert all(check.finding for check in checks)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_one_joint_in_another_unit(model: Model, clean: Recording, factor: float) -> None:
    check = only(preflight(model, changed(clean, clean.effort * [1.0, factor])))
    assert (check.check, check.joint) == ("effort unit", "elbow")
    assert check.values["factor"] == pytest.approx(factor, rel=0.1)
    undo = float(check.advice.partition("elbow=")[2].split()[0])
    assert undo == pytest.approx(1.0 / factor, rel=0.1)


@pytest.mark.parametrize("unit", UNITS)
def test_all_joints_in_another_unit(model: Model, clean: Recording, unit: float) -> None:
    checks = preflight(model, changed(clean, clean.effort * unit))
    if max(unit, 1 / unit) < 1.5:
        assert not serious(checks)
        return
    check = only(checks)
    assert (check.check, check.joint) == ("effort unit", None)
    assert UNITS[unit] in check.finding


def test_a_current_instead_of_a_torque(model: Model, clean: Recording) -> None:
    check = only(preflight(model, changed(clean, clean.effort / 43.0)))
    assert "motor current" in check.finding
    assert "shoulder=4" in check.advice


def test_advice_counts_the_scale_in_with_which_the_effort_was_read(
    model: Model, clean: Recording
) -> None:
    given = Conditioning(clock="stamps", effort_scale={"elbow": 4.0})
    read = condition(replace(clean, effort=clean.effort * [1.0, -0.25]), given)
    assert "--effort-scale elbow=-4," in only(preflight(model, read)).advice
    read = condition(replace(clean, effort=clean.effort * [1.0, 0.5]), given)
    undo = float(only(preflight(model, read)).advice.partition("elbow=")[2].split()[0])
    assert undo == pytest.approx(2.0, rel=0.1)


@pytest.mark.parametrize("factor", [[1.0, 0.5], [-1.0, 1.0], [1.0 / 43.0] * 2, [-1.0, -1.0]])
def test_the_remedy_undoes_the_fault(model: Model, clean: Recording, factor: list[float]) -> None:
    """It counts the scale in with which the effort was read, and the advice shows it."""
    given = Conditioning(clock="stamps", bandwidth=25.0, effort_scale={"elbow": 4.0})
    wrong = replace(clean, effort=clean.effort * factor / [1.0, 4.0])
    check = only(preflight(model, condition(wrong, given)))
    assert check.remedy is not None
    assert check.remedy.option in check.advice
    assert check.remedy.words
    assert not serious(preflight(model, condition(wrong, check.remedy.applied(given))))
    assert check_record(check)["remedy"] == check.remedy.option


def test_what_no_setting_mends_has_no_remedy(model: Model) -> None:
    check = only(preflight(model, motion(recorded(seed=3, reach=2.0))))
    assert check.remedy is None
    assert "remedy" not in check_record(check)


def test_the_sign(model: Model, clean: Recording) -> None:
    check = only(preflight(model, changed(clean, clean.effort * [-1.0, 1.0])))
    assert (check.check, check.joint) == ("effort sign", "shoulder")
    check = only(preflight(model, changed(clean, -clean.effort)))
    assert (check.check, check.joint) == ("effort sign", None)


@pytest.mark.parametrize("samples", [2, -2])
def test_a_delay_of_all_joints(model: Model, clean: Recording, samples: int) -> None:
    check = only(preflight(model, changed(clean, np.roll(clean.effort, samples, axis=0))))
    assert (check.check, check.joint) == ("delay", None)
    assert check.values["delay"] == pytest.approx(samples / RATE, abs=0.002)
    late = "torque" if samples > 0 else "position"
    assert check.finding.startswith(f"the {late} of every joint comes")


def test_a_delay_of_one_joint(model: Model, clean: Recording) -> None:
    effort = clean.effort.copy()
    effort[:, 1] = np.roll(effort[:, 1], 4)
    check = only(preflight(model, changed(clean, effort)))
    assert (check.check, check.joint) == ("delay", "elbow")
    assert check.values["delay"] == pytest.approx(0.02, abs=0.003)


def presliding(recording: Recording, distance: float = 0.06) -> Recording:
    """Return the recording with more dry friction in both gears, which turns over on a way."""
    slip = np.array([15.0, 6.0])
    bent = np.zeros_like(recording.effort)
    for k in range(1, len(bent)):
        moved = recording.position[k] - recording.position[k - 1]
        bent[k] = np.clip(bent[k - 1] + slip * moved / distance, -slip, slip)
    return replace(recording, effort=recording.effort + bent)


@pytest.mark.parametrize("samples", [0, 2])
def test_between_reversals_hysteresis_hides_no_delay_and_makes_none(samples: int) -> None:
    few = Settings(samples=150, evaluations=15, train=1.0)
    model = identify(motion(presliding(recorded(seed=1))), few).model
    other = presliding(recorded())
    late = changed(other, np.roll(other.effort, samples, axis=0))
    (check,) = (check for check in preflight(model, late) if check.check == "delay")
    seen = check.values.get("between reversals", check.values["delay"])
    assert seen == pytest.approx(samples / RATE, abs=0.002)
    assert not (check.serious and samples == 0)


def test_a_wrong_mass_is_no_delay(model: Model, clean: Recording) -> None:
    q, qd = clean.position, clean.velocity
    more = np.array([2.0, 0.6]) * np.gradient(qd, clean.time, axis=0) + np.array([3.0, 1.0]) * qd
    checks = preflight(model, changed(clean, clean.effort + more - 3.0 * np.cos(q)))
    assert not [check for check in serious(checks) if check.check == "delay"]


@pytest.mark.parametrize("share", [0.9, 0.98])
def test_saturation(model: Model, clean: Recording, share: float) -> None:
    effort = clean.effort.copy()
    level = float(np.quantile(effort[:, 0], share))
    effort[:, 0] = np.minimum(effort[:, 0], level)
    check = only(preflight(model, changed(clean, effort)))
    assert (check.check, check.joint) == ("saturation", "shoulder")
    assert check.values["level"] == pytest.approx(level, rel=0.01)
    assert check.values["share"] == pytest.approx(1.0 - share, rel=0.6)
    first = clean.time[int(np.argmax(clean.effort[:, 0] > level))]
    assert check.values["first"] > first - 0.1


def test_saturation_under_noise(model: Model, clean: Recording) -> None:
    """A limit of the motor, measured with noise: no two samples are alike."""
    effort = clean.effort.copy()
    level = float(np.quantile(effort[:, 0], 0.75))
    noise = 0.02 * level * np.random.default_rng(5).normal(size=len(effort))
    effort[:, 0] = np.minimum(effort[:, 0], level) + noise
    check = only(preflight(model, changed(clean, effort)))
    assert (check.check, check.joint) == ("saturation", "shoulder")
    assert check.values["level"] == pytest.approx(level, rel=0.02)
    assert check.values["share"] == pytest.approx(0.25, rel=0.3)


def test_a_limit_in_the_other_direction(model: Model, clean: Recording) -> None:
    effort = clean.effort.copy()
    level = float(np.quantile(effort[:, 0], 0.1))
    effort[:, 0] = np.maximum(effort[:, 0], level)
    check = only(preflight(model, changed(clean, effort)))
    assert check.values["level"] == pytest.approx(level, rel=0.02)


@pytest.mark.parametrize("kind", ["less", "quantised", "soft", "one height"])
def test_what_only_resembles_a_limit(model: Model, clean: Recording, kind: str) -> None:
    effort = clean.effort.copy()
    if kind == "less":  # peaks lower than the model expects, and as round
        effort[:, 0] *= 0.85
    elif kind == "quantised":
        effort = 2.0 * np.round(effort / 2.0)
    elif kind == "soft":
        top = 1.5 * float(effort[:, 0].max())
        effort[:, 0] = top * np.tanh(effort[:, 0] / top)
    else:  # the same round peak again and again, with noise
        effort = np.tile(effort[:800], (10, 1))
        jump = np.arange(len(effort)) // 800
        repeated = replace(
            clean,
            time=clean.time[: len(effort)] + jump,
            effort=effort + NOISE * np.random.default_rng(7).normal(size=effort.shape),
            velocity=np.full_like(effort, np.nan),
            position=np.tile(clean.position[:800], (10, 1)),
        )
        checks = preflight(model, motion(repeated))
        assert not [check for check in checks if check.check == "saturation"]
        return
    checks = preflight(model, changed(clean, effort))
    assert not [check for check in checks if check.check == "saturation"]


def test_a_torque_that_rests_with_the_motion_is_not_cut(model: Model) -> None:
    """Constant speed against dry friction and hardly any gravity: flat, as the model says."""
    time = np.arange(round(40.0 * RATE)) / RATE
    qd = np.repeat([1.0, -1.0] * 10, round(2.0 * RATE))
    qd = np.convolve(qd, np.hanning(41) / np.hanning(41).sum(), "same")
    q = np.cumsum(qd) / RATE
    q, qd = np.stack([0.01 * q + np.pi / 2, q], axis=1), np.stack([0.01 * qd, qd], axis=1)
    tau = torque(q, qd, np.gradient(qd, time, axis=0))
    checks = preflight(model, motion(Recording(JOINTS, time, q, qd, tau, 0.0)))
    assert not [check for check in checks if check.check == "saturation"]


def test_the_noise_of_a_second_recording(model: Model, clean: Recording) -> None:
    """White noise of 0.1 N·m, of which the low-pass of 25 Hz lets about a half through."""
    kept = np.sqrt(25.0 / (RATE / 2))
    late = replace(recorded(noise=1), time=clean.time + 3.0)
    checks = preflight(model, motion(clean), [motion(late)])
    (again,) = (check for check in checks if check.check == "repeated motion")
    assert again.values["seconds"] > 20.0
    assert "another motion" in again.advice
    found = [check for check in checks if check.check == "noise floor"]
    assert [check.joint for check in found] == list(JOINTS)
    for check in found:
        assert check.values["floor"] == pytest.approx(NOISE * kept, rel=0.15)
        assert check.values["error"] > check.values["floor"]
        assert check.values["seconds"] > 20.0
        assert not check.serious


@pytest.mark.parametrize("later", [0.0, 25.0])
def test_the_noise_of_a_repeat_within(model: Model, later: float) -> None:
    """Also where the clock begins again."""
    once, again = motion(recorded(20.0)), motion(recorded(20.0, noise=1))
    both = concatenate([once, replace(again, time=again.time + later)])
    found = [c for c in preflight(model, both) if c.check == "noise floor"]
    assert len(found) == 2
    assert found[0].values["seconds"] == pytest.approx(19.5, abs=1.0)
    assert found[0].values["floor"] == pytest.approx(NOISE * np.sqrt(0.25), rel=0.2)


def test_the_same_recording_twice_has_no_noise(model: Model, clean: Recording) -> None:
    once = motion(clean)
    checks = preflight(model, once, [once])
    assert "noise floor" not in {check.check for check in checks}


def test_gaps_are_told(model: Model, clean: Recording) -> None:
    whole = motion(clean)
    kept = (whole.time < 10.0) | (whole.time > 12.0)
    segment = (whole.time > 11.0).astype(np.int64)
    found = preflight(model, replace(whole, segment=segment).take(kept))
    check = next(check for check in found if check.check == "stamps")
    assert check.values["pieces"] == 2
    assert check.values["lost"] == pytest.approx(2.0, abs=0.02)


def test_leaving_the_range(model: Model) -> None:
    check = only(preflight(model, motion(recorded(seed=3, reach=2.0))))
    assert check.check == "range"
    assert check.values["share"] > 0.25
    assert "Identify" in check.advice or "identify" in check.advice


def test_a_short_slow_recording_with_a_joint_at_rest(model: Model) -> None:
    short = recorded(10.0, reach=0.15)
    position = short.position * [1.0, 0.0]
    found = preflight(model, motion(replace(short, position=position, velocity=position)))
    told = {(check.check, check.joint) for check in found}
    assert {("still", "elbow"), ("duration", None), ("speeds", "shoulder")} <= told
    still = next(check for check in found if check.check == "still")
    assert "excite" in still.advice


def test_other_joints(model: Model, clean: Recording) -> None:
    turned = motion(clean).select(("elbow", "shoulder"))
    assert [c.finding for c in preflight(model, turned)] == [
        c.finding for c in preflight(model, motion(clean))
    ]
    with pytest.raises(ModelError, match="lacks elbow"):
        preflight(model, motion(clean).select(("shoulder",)))


def test_a_measured_arm_is_sound(shared_data: Path) -> None:
    """An LWR 4 that makes one motion twice: nothing to mend, and its noise is seen."""
    files = [shared_data / "kuka_lwr4" / f"measurements_{k}.npz" for k in (1, 2)]
    first, second = (condition(load(path)) for path in files)
    settings = Settings("chain+fri", samples=80, evaluations=8, train=1.0)
    model = identify(first, settings).model
    checks = preflight(model, second, [first])
    assert not serious(checks)
    floor = [check for check in checks if check.check == "noise floor"]
    assert len(floor) == 7
    for check in floor:
        assert 0.0 < check.values["floor"] < check.values["error"]


@pytest.mark.parametrize("mass", [0.7, 1.5])
def test_a_load_is_no_unit(model: Model, clean: Recording, mass: float) -> None:
    """It adds gravity and inertia, and leaves friction as it is."""
    ready = motion(clean)
    q, qd, qdd = ready.q, ready.qd, ready.qdd
    c2, s2 = np.cos(q[:, 1]), np.sin(q[:, 1])
    g1, g2 = 9.81 * np.cos(q[:, 0]), 9.81 * np.cos(q[:, 0] + q[:, 1])
    turning = s2 * (2.0 * qd[:, 0] * qd[:, 1] + qd[:, 1] ** 2)
    first = (2.0 + 2.0 * c2) * qdd[:, 0] + (1.0 + c2) * qdd[:, 1] - turning + g1 + g2
    second = (1.0 + c2) * qdd[:, 0] + qdd[:, 1] + s2 * qd[:, 0] ** 2 + g2
    loaded = replace(ready, tau=ready.tau + mass * np.stack([first, second], axis=1))
    checks = [check for check in preflight(model, loaded) if check.check == "effort unit"]
    assert not serious(checks)
    elbow = next(check for check in checks if check.joint == "elbow")
    assert "no unit does that" in elbow.finding
    assert elbow.values["gravity"] == pytest.approx(1.0 + mass, rel=0.1)
    assert elbow.values["friction, low"] < 1.1 < elbow.values["gravity, low"]
