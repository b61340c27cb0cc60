"""Friction that follows a thermometer: found, added, and predicted with the temperature."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import two_rods
from whitened_examples import few_torques

from lagrangian_ff.diagnosis import Diagnosis, add, compare, diagnose
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.recording.motion import Motion, concatenate

FEW = Settings(train=1.0, samples=120, evaluations=20, model="chain+fri")
NAMES = ("stribeck", "warm_up", "temperature_friction", "quadratic_drag")


_small = few_torques(800)


def celsius(seed: int, time: two_rods.Floats) -> two_rods.Floats:
    """°C of the elbow, which warms up, cools in a draught and warms up again."""
    return 28.0 + 8.0 * np.sin(0.25 * time + seed) + 0.1 * time


def warmed(seed: int) -> Motion:
    """Return a motion whose elbow's grease thins by 2 % a degree, with its temperature."""

    def grease(
        t: two_rods.Floats, q: two_rods.Floats, qd: two_rods.Floats, qdd: two_rods.Floats
    ) -> two_rods.Floats:
        more = 0.98 ** (celsius(seed, t) - 28.0) - 1.0
        friction = 1.2 * qd[:, 1] + 0.8 * np.tanh(qd[:, 1] / two_rods.WIDTH)
        return np.stack([np.zeros_like(t), more * friction + 0.8 * qd[:, 1]], axis=1)

    motion = two_rods.motion(seed, hidden=grease)
    temperature = np.stack([np.full(len(motion), np.nan), celsius(seed, motion.time)], axis=1)
    return replace(motion, temperature=temperature)


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    first, second = warmed(1), warmed(2)
    model = identify(first, FEW).model
    return diagnose(model, first, second, {name: EFFECTS[name] for name in NAMES}, steps=1)


def test_it_is_confirmed_with_its_size(found: Diagnosis) -> None:
    (finding,) = found.confirmed
    assert (finding.effect.name, finding.joint) == ("temperature_friction", "elbow")
    at, fall = finding.shape["T0"], finding.shape["D"]
    slope = finding.parameters["B_T"].value / fall
    assert slope == pytest.approx(1.2 * 0.02 * 0.98 ** (at - 28.0), rel=0.3)


def test_without_a_thermometer_it_is_no_candidate(found: Diagnosis) -> None:
    unknown, other = (replace(warmed(seed), temperature=None) for seed in (1, 2))
    effects = {name: EFFECTS[name] for name in ("stribeck", "temperature_friction")}
    done = diagnose(found.model, unknown, other, effects, steps=1)
    assert "temperature_friction" not in {one.name for one in done.ranking}


def test_a_model_with_it_keeps_the_temperature_and_uses_it(
    found: Diagnosis, tmp_path: Path
) -> None:
    larger = add(found.model, "temperature_friction", "elbow", found.findings[0].shape)
    larger.save(tmp_path / "model.npz")
    read = Model.load(tmp_path / "model.npz")
    assert read.data.temperature is not None
    unseen = warmed(3)
    before, after = (compare(one, unseen).score.rmse[1] for one in (found.model, read))
    assert after < 0.6 * before
    unknown = compare(read, replace(unseen, temperature=None)).score.rmse[1]
    assert unknown == pytest.approx(before, rel=0.1)


def test_recordings_with_and_without_are_put_together() -> None:
    whole = concatenate([warmed(1), replace(warmed(2), temperature=None)])
    assert whole.temperature is not None
    assert np.isfinite(whole.temperature[:, 1]).sum() == len(whole) // 2
