"""A model that is replaced while torque flows: checked first, and without a bump."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fake_model import RANGE, FakeModel, Floats
from small_model import save_small_model

from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.predicting import Terms
from lagrangian_ff.nodes.streaming.plan import Plan, Policy, make_plan
from lagrangian_ff.nodes.streaming.reference import Reference
from lagrangian_ff.nodes.streaming.replacing import ModelFile
from lagrangian_ff.nodes.streaming.stream import Settings, TorqueStream

SECOND = 1_000_000_000


class Heavier(FakeModel):
    """The same arm with half a kilogram more."""

    def terms(self, q: Floats, qd: Floats, qdd: Floats) -> Terms:
        found = super().terms(q, qd, qdd)
        return replace(found, gravity=1.5 * found.gravity)


def plan_of(model: FakeModel, points: int) -> Plan:
    still = np.zeros((points, 2))
    reference = Reference(("a", "b"), np.arange(float(points)), still, still, still)
    return make_plan(model, reference, Policy("allow"))


@pytest.mark.parametrize("points", [1, 9])
def test_another_model_takes_over_along_a_ramp(points: int) -> None:
    stream = TorqueStream(
        ("a", "b"),
        Settings(
            np.ones(2), np.full(2, 50.0), np.full(2, 1e6), ramp_time=0.5, tracking_tolerance=0.0,
            joint_state_timeout=0.0, reference_timeout=0.0,
        ),
    )  # fmt: skip
    present = plan_of(FakeModel(), points)
    heavier = Heavier(range=replace(RANGE))
    other = replace(plan_of(heavier, points), reference=present.reference)
    stream.play(present, 0, 0.0)
    taus = []
    for k in range(1000):
        if k == 500:
            stream.exchange(other)
        taus.append(stream.tick(k * 2_000_000, k * 0.002).tau[0])
    before, after = taus[499], taus[-1]
    assert (before, after) == pytest.approx((10.0, 13.5))
    assert np.abs(np.diff(taus[490:])).max() <= (after - before) * 0.002 / 0.5 + 1e-9


@pytest.fixture
def file(tmp_path: Path) -> ModelFile:
    save_small_model(tmp_path / "model.npz")
    return ModelFile(lambda: str(tmp_path / "model.npz"), ())


def looked(file: ModelFile, found: Callable[[], object]) -> None:
    """Look until this is found."""
    end = time.monotonic() + 30.0
    while not found() and time.monotonic() < end:
        file.look()
        time.sleep(0.02)
    assert found()


def test_a_file_that_stays_is_loaded_once(file: ModelFile) -> None:
    for _ in range(3):
        file.look()
    assert file.take() is None
    assert file.refusal == ""


def test_a_new_model_is_loaded_once_it_is_whole(file: ModelFile, tmp_path: Path) -> None:
    path = tmp_path / "model.npz"
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    looked(file, lambda: file.refusal)
    assert "model.npz" in file.refusal
    assert file.take() is None
    path.write_bytes(whole)
    looked(file, lambda: file.refusal == "")
    ready = file.take()
    assert ready is not None
    assert ready.model.joints == file.first.model.joints
    path.unlink()
    looked(file, lambda: file.refusal)
    assert file.take() is None


def test_a_model_of_other_joints_is_refused(file: ModelFile, tmp_path: Path) -> None:
    save_small_model(tmp_path / "model.npz", ("a", "c"))
    looked(file, lambda: file.refusal)
    assert "is a model of a, c, in use is one of a, b" in file.refusal


def test_without_a_model_there_is_no_start(tmp_path: Path) -> None:
    with pytest.raises(ModelError):
        ModelFile(lambda: str(tmp_path / "missing.npz"), ())
