"""Models of an effort from which the driver removed gravity, or the drive friction."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pendulum import friction_torque, motion, rigid_torque

from lagrangian_ff.diagnosis import compare, diagnose
from lagrangian_ff.errors import ModelError, RecordingError
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.identification.settings import usual_model
from lagrangian_ff.kernels import States
from lagrangian_ff.recording import Conditioning, Motion, concatenate

SMALL = Settings(samples=80, train=1.0, evaluations=12)


def pendulum(effort: str, seed: int = 0, seconds: float = 15.0) -> Motion:
    """Return a double pendulum whose effort holds what it is said to."""
    whole = motion(seconds, seed=seed, noise=0.01)
    x = States.of(whole.q, whole.qd, whole.qdd)
    less = {
        "total": np.zeros_like(whole.tau),
        "without-gravity": rigid_torque(x.at_rest()),
        "without-friction": friction_torque(x),
    }[effort]
    return replace(whole, tau=whole.tau - less, conditioning=Conditioning(effort=effort).record())


@pytest.fixture(scope="module")
def weightless() -> Model:
    return identify(pendulum("without-gravity"), replace(SMALL, model="chain+fri")).model


@pytest.mark.parametrize("kernel", ["chain", "chain_rbf", "energy", "energy_rbf", "motor"])
def test_a_model_of_an_effort_without_gravity_has_exactly_none(kernel: str) -> None:
    few = replace(SMALL, samples=40, evaluations=6, model=f"{kernel}+fri")
    model = identify(pendulum("without-gravity"), few).model
    q = np.random.default_rng(0).uniform(-3.0, 3.0, (20, 2))
    assert np.abs(model.terms(q, 0.0 * q, 0.0 * q).gravity).max() == 0.0


def test_it_is_as_good_and_survives_its_file(weightless: Model, tmp_path: Path) -> None:
    other = pendulum("without-gravity", seed=1)
    assert compare(weightless, other).score.mean_nmse < 0.02
    weightless.save(tmp_path / "model.npz")
    again = Model.load(tmp_path / "model.npz")
    assert again.identified.conditioning == Conditioning(effort="without-gravity")
    assert np.array_equal(
        again.predict(other.q, other.qd, other.qdd),
        weightless.predict(other.q, other.qd, other.qdd),
    )


def test_it_knows_no_gravity_but_a_mass_matrix(weightless: Model) -> None:
    q = np.zeros((1, 2))
    for asked in (weightless.dynamics.gravity, weightless.dynamics.potential_energy):
        with pytest.raises(ModelError, match="effort without gravity"):
            asked(q)
    assert np.linalg.eigvalsh(weightless.dynamics.mass_matrix(q)).min() > 0.0


def test_a_kernel_that_cannot_leave_gravity_out_says_so() -> None:
    few = replace(SMALL, samples=40, evaluations=4, model="vrbfs+fri")
    notes = identify(pendulum("without-gravity"), few).model.identified.notes
    assert any("vrbfs cannot leave gravity out" in note for note in notes)


def test_an_effort_of_another_kind_is_refused(weightless: Model) -> None:
    total = pendulum("total", seed=1)
    for use in (compare, diagnose):
        with pytest.raises(ModelError, match=r"without-gravity, and .* was read as total"):
            use(weightless, total)
    with pytest.raises(RecordingError, match="one model holds for one of them"):
        concatenate([total, pendulum("without-gravity")])
    # Nothing is said of it.
    assert compare(weightless, replace(total, conditioning={})).score.mean_nmse > 0.1


def test_no_friction_is_searched_in_detail_where_it_is_compensated() -> None:
    assert usual_model("without-friction") == "auto"
    first = pendulum("without-friction", seconds=20.0)
    model = identify(first, replace(SMALL, model="chain")).model
    found = diagnose(model, first, pendulum("without-friction", seed=1, seconds=20.0))
    assert not found.findings
    searched = {one.name for one in found.ranking}
    assert "viscous" in searched
    assert not {"stribeck", "hysteresis", "load_friction"} & searched
