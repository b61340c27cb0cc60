"""`identify --prismatic`: a joint that slides, against the equations of motion of a telescope."""

import json
from pathlib import Path

import numpy as np
import pytest
from cli_examples import QUICK, Floats, Outcome, assert_refused, csv, lagrangian_ff, motion

from lagrangian_ff.identification import Model
from lagrangian_ff.recording import Recording

JOINTS = ("turn", "reach")
INERTIA, MASS, GRAVITY = 1.0, 2.0, 9.81
VISCOUS = np.array([0.8, 3.0])


def states(seconds: float, rate: float, share: float = 1.0) -> tuple[Floats, Floats, Floats]:
    """Some rad about the horizontal, and from 1 to 5 m: q, qd, qdd (M, 2)."""
    _, q, qd, qdd = motion(seconds, rate, share)
    size = np.array([1.0, 2.0])
    return size * q + np.array([0.3, 3.0]), size * qd, size * qdd


def torque(q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """N·m and N: a beam that turns in the vertical plane, a mass that slides on it, friction."""
    (turn, reach), (w, v), (dw, dv) = q.T, qd.T, qdd.T
    first = (INERTIA + MASS * reach**2) * dw + 2.0 * MASS * reach * v * w
    second = MASS * dv - MASS * reach * w**2
    weight = MASS * GRAVITY
    rigid = [first + weight * reach * np.cos(turn), second + weight * np.sin(turn)]
    return np.stack(rigid, axis=1) + VISCOUS * qd


@pytest.fixture(scope="module")
def telescope(tmp_path_factory: pytest.TempPathFactory) -> Path:
    q, qd, qdd = states(24.0, 100.0)
    recording = Recording(JOINTS, np.arange(len(q)) / 100.0, q, qd, torque(q, qd, qdd))
    return csv(tmp_path_factory.mktemp("telescope") / "telescope.csv", recording)


@pytest.fixture(scope="module")
def told(telescope: Path) -> tuple[Path, Outcome]:
    """Return the model of joints that are told apart, and what was printed."""
    path = telescope.with_name("told.npz")
    outcome = identified(telescope, path, "--prismatic", "reach")
    return path, outcome


def identified(telescope: Path, path: Path, *options: str) -> Outcome:
    outcome = lagrangian_ff("identify", telescope, *QUICK, "--output", path, *options)
    assert outcome.code == 0, outcome
    return outcome


def test_it_is_learned_far_better_when_it_is_said_to_slide(
    telescope: Path, told: tuple[Path, Outcome], tmp_path: Path
) -> None:
    identified(telescope, tmp_path / "untold.npz")
    model, untold = Model.load(told[0]), Model.load(tmp_path / "untold.npz")
    assert float(str(model.record["rmse"])) < 0.03 * float(str(untold.record["rmse"]))
    x = states(5.0, 50.0, 0.7)
    error = model.predict(*x) - torque(*x)
    assert (error.std(axis=0) / torque(*x).std(axis=0)).max() < 2e-3


def test_the_model_keeps_it_and_tells_it(told: tuple[Path, Outcome]) -> None:
    path, outcome = told
    model = Model.load(path)
    np.testing.assert_array_equal(model.kernel.hyperparameters["prismatic"], [0.0, 1.0])
    for text in (outcome.text, lagrangian_ff("info", path).text):
        assert "sliding joints, all of whose numbers are in m and N: reach" in text


def test_a_larger_model_still_slides(told: tuple[Path, Outcome], tmp_path: Path) -> None:
    path, output = told[0], tmp_path / "larger.npz"
    outcome = lagrangian_ff(
        "add", path, "quadratic_drag", "--joint", "turn", "--output", output, "--json", "-"
    )
    assert outcome.code == 0, outcome
    larger = Model.load(output)
    np.testing.assert_array_equal(larger.kernel.hyperparameters["prismatic"], [0.0, 1.0])
    assert larger.record["settings"] == Model.load(path).record["settings"]
    added = json.loads(outcome.out)
    assert added["error_after"] < 1.2 * added["error_before"]


def test_it_goes_with_a_positive_mass_matrix_and_a_robust_loss(
    telescope: Path, tmp_path: Path
) -> None:
    """Nor does a recording without noise leave a robust fit without a Cholesky factor."""
    path = tmp_path / "model.npz"
    identified(telescope, path, "--prismatic", "reach", "--positive", "--loss", "huber")
    model = Model.load(path)
    assert np.linalg.eigvalsh(model.dynamics.mass_matrix(states(5.0, 20.0)[0])).min() > 0.0
    x = states(5.0, 50.0, 0.7)
    error = model.predict(*x) - torque(*x)
    assert (error.std(axis=0) / torque(*x).std(axis=0)).max() < 2e-3


@pytest.mark.parametrize("given", [("reach,turn",), ("reach", "--prismatic", "turn")])
def test_several_joints_may_slide(given: tuple[str, ...], telescope: Path, tmp_path: Path) -> None:
    path = tmp_path / "both.npz"
    identified(telescope, path, "--model", "energy", "--prismatic", *given)
    np.testing.assert_array_equal(Model.load(path).kernel.hyperparameters["prismatic"], [1.0, 1.0])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--prismatic", "rail"), ("rail", "telescope.csv", "turn, reach")),
        (
            ("--prismatic", "reach", "--model", "vrbfs+fri"),
            ("vrbfs", "auto, energy, energy_rbf, chain, chain_rbf", "vrbf takes"),
        ),
        (("--prismatic", "reach", "--urdf", "arm.urdf"), ("reach", "URDF", "leave out one")),
    ],
)
def test_what_cannot_be_is_refused(
    options: tuple[str, ...], words: tuple[str, ...], telescope: Path, tmp_path: Path
) -> None:
    output = tmp_path / "model.npz"
    outcome = lagrangian_ff("identify", telescope, *QUICK, "--output", output, *options)
    assert_refused(outcome, *words)
    assert not output.exists()
