"""Short touches of the arm are found at their times, and a model's own errors are none."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pendulum
import pytest
from diagnosis_examples import diagnosis

from lagrangian_ff.cli.text.diagnose import touches
from lagrangian_ff.diagnosis import diagnosis_record, verdict
from lagrangian_ff.diagnosis.contacts import Contact, contacts_of
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.studies.measured.known import known_arms
from lagrangian_ff.studies.measured.reading import motions

FEW = Settings(samples=200, evaluations=15, train=1.0)


@pytest.fixture(scope="module")
def model() -> Model:
    return identify(pendulum.motion(40.0, noise=0.02, seed=0), FEW).model


@pytest.fixture(scope="module")
def clean() -> Motion:
    return pendulum.motion(40.0, noise=0.02, seed=1)


def touched(motion: Motion, when: Sequence[float], long: float, size: Sequence[float]) -> Motion:
    """Return a motion with a torque on both joints, at half its largest for `long` s each time."""
    near = [np.exp(-4.0 * np.log(2.0) * ((motion.time - t) / long) ** 2) for t in when]
    return replace(motion, tau=motion.tau + np.outer(np.sum(near, axis=0), size))


@pytest.mark.parametrize("long", [0.1, 0.3, 0.8])
def test_a_touch_is_found_at_its_time_with_its_size(
    model: Model, clean: Motion, long: float
) -> None:
    (one,) = contacts_of(model, [touched(clean, [17.0], long, (0.0, 2.0))])
    assert one.sure
    assert list(one.sizes) == ["elbow"]
    assert one.begin == pytest.approx(17.0 - 0.5 * long, abs=0.3 * long)
    assert one.end == pytest.approx(17.0 + 0.5 * long, abs=0.3 * long)
    size = one.sizes["elbow"]
    assert 0.9 < size.value < 2.0  # the mean about a peak of 2, above what is left beside it
    assert size.low < size.value < size.high


def test_several_touches_do_not_hide_each_other(model: Model, clean: Motion) -> None:
    found = contacts_of(model, [touched(clean, [8.0, 17.0, 22.0, 33.0], 0.25, (-5.0, 2.0))])
    middles = [0.5 * (one.begin + one.end) for one in found]
    assert middles == pytest.approx([8.0, 17.0, 22.0, 33.0], abs=0.1)
    assert all(one.sizes["elbow"].value > 0.0 for one in found)
    assert any(one.sizes.get("shoulder", Estimate(0.0)).value < 0.0 for one in found)


def test_nothing_touches_an_arm_that_only_differs_from_its_model(
    model: Model, clean: Motion
) -> None:
    creeping = np.sign(clean.qd) * np.exp(-((clean.qd / 0.15) ** 2))
    ripple = np.sin(20.0 * clean.q)
    late = np.gradient(clean.tau, 0.01, axis=0) * 0.01
    load = 0.15 * pendulum.rigid_torque(pendulum.states(40.0, 100.0, 1)[1])
    for wrong in (0.0, creeping, ripple, late, load):
        assert contacts_of(model, [replace(clean, tau=clean.tau + wrong)]) == ()


def test_rest_and_motion_that_the_model_does_not_know_say_nothing(
    model: Model, clean: Motion
) -> None:
    struck = touched(clean, [17.0], 0.3, (0.0, 2.0))
    still = np.abs(clean.time - 17.0) < 1.5
    q = np.where(still[:, None], clean.q[still][0], clean.q)
    qd, qdd = (np.where(still[:, None], 0.0, one) for one in (clean.qd, clean.qdd))
    assert contacts_of(model, [replace(struck, q=q, qd=qd, qdd=qdd)]) == ()
    away = replace(struck, q=struck.q + 4.0)
    assert contacts_of(model, [away]) == ()
    assert contacts_of(model, [struck.take(slice(0, 150))]) == ()


def test_chance_has_all_recordings_whatever_parts_they_are_in(model: Model, clean: Motion) -> None:
    weak = touched(clean, [17.0], 0.3, (0.0, 0.35))
    more = [pendulum.motion(40.0, noise=0.02, seed=seed) for seed in (2, 3, 4)]
    (alone,), (among,) = contacts_of(model, [weak]), contacts_of(model, [weak, *more])
    assert among.p_value > 2.0 * alone.p_value
    ends = np.linspace(0, len(weak), 9).astype(int)
    parts = [weak.take(slice(a, b)) for a, b in pairwise(ends.tolist())]
    (again,) = contacts_of(model, parts)
    assert again.begin == alone.begin
    assert 0.5 * alone.p_value < again.p_value < 2.0 * alone.p_value


def test_the_verdict_and_the_record_say_what_touched_the_arm() -> None:
    sizes = {"elbow": Estimate(-0.41, -0.5, -0.3, "N·m")}
    sure = Contact(6.4, 6.5, sizes, 0.001, "bag")
    said = verdict(diagnosis(contacts=(sure,)))
    assert "Something touched the arm at 6.40 s of bag for 0.1 s: -0.41 N·m on elbow." in said
    alone = replace(sure, source=diagnosis().motion.source)
    assert "arm at 6.40 s for 0.1 s" in verdict(diagnosis(contacts=(alone,)))
    unsure = replace(sure, p_value=0.03)
    assert "Something may have touched the arm" in verdict(diagnosis(contacts=(unsure,)))
    assert "may have" not in verdict(diagnosis(contacts=(sure, unsure)))
    assert "2 times more" in verdict(diagnosis(contacts=(sure,) * 5))
    (one,) = diagnosis_record(diagnosis(contacts=(sure,)))["contacts"]
    assert (one["begin"], one["end"], one["sure"], one["source"]) == (6.4, 6.5, True, "bag")
    assert one["sizes"]["elbow"]["value"] == -0.41
    rows = touches(diagnosis(contacts=(sure, unsure)))
    assert [row[:4] for row in rows] == [["6.40", "6.50", "elbow", "-0.410"]] * 2
    assert [row[-2] for row in rows] == ["sure", "suggested"]


def test_a_pulse_of_the_measured_acrobot_is_found(shared_data: Path, root: Path) -> None:
    arms = known_arms(shared_data, root / "config" / "measured")
    arm = next(one for one in arms if one.name == "dfki_touched")
    split = next(one for one in arm.splits if one.name == "pulses-2")
    found = identify(motions(arm, split.train), FEW).model
    (one,) = contacts_of(found, motions(arm, split.search, found.data))
    assert one.p_value < 0.05
    assert one.begin < 1.08 < one.end  # -0.7 N·m were injected on the elbow
    assert 0.4 < one.sizes["elbow"].value < 0.7
    assert contacts_of(found, motions(arm, split.test, found.data)) == ()
