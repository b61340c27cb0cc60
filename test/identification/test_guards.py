"""Too little memory, and a Gram matrix that has no factor."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pendulum
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.identification.blueprint import Blueprint, Solved, solve
from lagrangian_ff.identification.build import build
from lagrangian_ff.identification.memory import available, needed, require_memory
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.samples import Samples
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.kernels import States

SPEC = parse("vrbfs+fri")


@pytest.mark.parametrize("folds", [None, 5])
@pytest.mark.parametrize("coupled", [True, False])
@given(free=st.integers(10**6, 10**12), joints=st.integers(1, 12))
def test_the_size_that_fits_fits_and_one_more_does_not(
    coupled: bool, folds: int | None, free: int, joints: int
) -> None:
    option = "--samples " if folds is None else "--inducing-points "
    how: dict[str, Any] = {"coupled": coupled, "folds": folds, "free": lambda: free}
    with pytest.raises(ModelError, match="use at most") as refused:
        require_memory(10**7, joints, **how)
    fit = int(str(refused.value).split(option)[1].rstrip(")"))
    require_memory(fit, joints, **how)
    with pytest.raises(ModelError):
        require_memory(fit + 1, joints, **how)


def test_nothing_is_refused_if_the_memory_is_unknown() -> None:
    require_memory(10**9, 6, free=lambda: None)


def test_joints_learned_apart_need_less() -> None:
    assert needed(500, 6, coupled=False) == needed(500, 6) // 6


def test_the_least_of_machine_and_container_counts(tmp_path: Path) -> None:
    meminfo, groups = tmp_path / "meminfo", tmp_path / "cgroup"
    assert available(meminfo, groups) is None
    meminfo.write_text("MemTotal: 16000 kB\nMemAvailable: 8000 kB\n")
    assert available(meminfo, groups) == 8000 * 1024
    (groups / "memory").mkdir(parents=True)
    for name, text in {
        "memory.max": "max\n", "memory.current": "3000000\n",
        "memory.stat": "anon 2000000\ninactive_file 500000\n",
    }.items():  # fmt: skip
        (groups / name).write_text(text)
    assert available(meminfo, groups) == 8000 * 1024
    (groups / "memory.max").write_text("5000000\n")
    assert available(meminfo, groups) == 2_500_000
    for name, text in {
        "limit_in_bytes": "1500000\n", "usage_in_bytes": "1000000\n", "stat": "inactive_file 0\n"
    }.items():  # fmt: skip
        (groups / "memory" / f"memory.{name}").write_text(text)
    assert available(meminfo, groups) == 500_000


def test_a_model_that_does_not_fit_is_refused_with_one_that_does() -> None:
    with pytest.raises(ModelError, match=r"600 samples of 2 joints needs .*--samples 118"):
        require_memory(600, 2, free=lambda: 2_000_000)
    with pytest.raises(ModelError, match=r"300 inducing points of .*--inducing-points 7\d"):
        require_memory(300, 2, folds=5, free=lambda: 2_000_000)


@pytest.mark.skipif(available() is None, reason="the system does not report its memory")
def test_identify_refuses_before_it_begins() -> None:
    """Every sample of seven minutes: 200 GB and more."""
    long = pendulum.motion(400.0)
    reports: list[float] = []
    for more in (
        Settings(samples=40_000, landmarks=0, train=1.0),
        Settings(samples=100, landmarks=39_000, train=1.0),
    ):
        with pytest.raises(ModelError, match=r"of 2 joints needs .* are free: use at most \d+ "):
            identify(long, more, lambda share, label: reports.append(share))
    assert not reports


def twice(noise: float, qdd: float = 1.0, loss: str = "square") -> Solved:
    """Return a fit of a motion with every sample twice, which has no factor without noise."""
    motion = pendulum.motion(10.0, noise=0.02).take(np.repeat(np.arange(0, 1000, 25), 2))
    x = States.of(motion.q, motion.qd, qdd * motion.qdd)
    samples = Samples(Inputs.of(x), motion.tau)
    start = Problem.started(SPEC, samples, Scaling.of(motion.tau)).noisier(noise)
    weight = np.ones_like(motion.tau) if loss == "huber" else None
    every = np.arange(len(motion))
    settings, trained = Settings(loss=loss), np.full(len(motion), True)
    drawn = Blueprint("vrbfs+fri", start.prior, motion, trained, every, every, settings, weight)
    return solve(drawn, Inputs.of(x))


def test_enough_noise_is_left_alone() -> None:
    solved = twice(1.0)
    assert solved.notes == ()


@pytest.mark.parametrize("loss", ["square", "huber"])
def test_too_little_noise_is_raised_step_by_step_and_noted(loss: str) -> None:
    solved = twice(1e-17, loss=loss)
    ratio = solved.prior.noise[0] / twice(1e-17 * 1e17).prior.noise[0] * 1e17
    assert ratio == pytest.approx(10.0 ** round(np.log10(ratio)))
    assert ratio > 1.0
    (note,) = solved.notes
    assert note.startswith(f"the noise is taken {ratio:g} times as large")
    assert np.isfinite(solved.posterior.weights).all()


def test_a_matrix_that_no_noise_mends_is_refused_in_words() -> None:
    with pytest.raises(ModelError, match=r"80 samples has no Cholesky .* rad/s²"):
        twice(1.0, qdd=1e200)


def test_the_record_notes_the_noise_that_was_raised() -> None:
    settings = Settings(samples=40, evaluations=4, train=1.0)
    model = identify(pendulum.motion(10.0), settings).model
    drawn = Blueprint.of(model)
    index = np.sort(np.tile(drawn.index[:20], 2))
    variance = model.kernel.variance(model.centres)
    hardly = 1e-18 * np.full(2, variance.mean())
    drawn = replace(drawn, index=index, seen=index, prior=replace(drawn.prior, noise=hardly))
    found = build(drawn, model.inputs_of(model.data))
    notes = json.loads(json.dumps(found.record["notes"]))
    assert any("Gram matrix of 40 samples" in note for note in notes)
    assert (found.model.prior.noise > hardly).all()
