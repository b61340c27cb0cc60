"""What is drawn of a comparison: no peak is lost, and what is chosen is what lies inside."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.workbench.traces import Axis, Traces, running_time, spans

COUNT, JOINTS = 5000, 2


@pytest.fixture(scope="module")
def traces(tmp_path_factory: pytest.TempPathFactory) -> Traces:
    random, time = np.random.default_rng(0), np.arange(COUNT) * 0.002
    q = np.sin(time[:, None] * [1.0, 2.0])
    tau = random.standard_normal((COUNT, JOINTS))
    tau[3333, 1] = 50.0
    file: Path = tmp_path_factory.mktemp("traces") / "one.npz"
    at = np.arange(0, COUNT, 10)
    np.savez(file, time=time, q=q, qd=q, tau=tau, predicted=0.5 * tau, load=q, at=at,
             reach=np.ones((len(at), JOINTS)))  # fmt: skip
    return Traces(file)


def drawn(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Return the times (B,) and the least and largest values, (S, 2, N, B)."""
    count, joints, series = np.frombuffer(data, "<i4", 3)
    numbers = np.frombuffer(data, "<f4", offset=12)
    return numbers[:count], numbers[count:].reshape(series, 2, joints, count)


@given(st.integers(1, 900), st.floats(0.0, 9.0), st.floats(0.01, 10.0))
def test_every_peak_stays_in_the_window(
    traces: Traces, width: int, start: float, length: float
) -> None:
    end = min(start + length, traces.time[-1])
    time, values = drawn(traces.window(start, end, width, ("tau", "residual")))
    assert len(time) <= width
    inside = (traces.time >= start) & (traces.time <= end)
    for row, name in enumerate(("tau", "residual")):
        wanted = traces.series[name][inside].astype(np.float32)
        if len(wanted):
            assert (values[row, 0].min(axis=1) <= wanted.min(axis=0)).all()
            assert (values[row, 1].max(axis=1) >= wanted.max(axis=0)).all()


def test_the_interval_lies_around_the_prediction(traces: Traces) -> None:
    _, values = drawn(traces.window(0.0, 10.0, 10**6, ("lower", "predicted", "upper")))
    np.testing.assert_allclose(values[1] - values[0], 1.0, atol=1e-4)
    np.testing.assert_allclose(values[2] - values[1], 1.0, atol=1e-4)


def test_a_map_holds_all_of_the_error(traces: Traces) -> None:
    found = traces.map(1, Axis("q", 0), Axis("time"), 20)
    count = np.array(found["count"])
    total = sum(n * (rms or 0.0) ** 2 for n, rms in zip(count, found["rms"], strict=True))
    assert count.sum() == COUNT
    assert total == pytest.approx(np.sum(traces.series["residual"][:, 1] ** 2), rel=0.02)
    assert all((rms is None) == (n == 0) for n, rms in zip(count, found["rms"], strict=True))


def test_what_is_chosen_lies_inside(traces: Traces) -> None:
    found = traces.chosen(Axis("q", 0), Axis("time"), (0.5, 2.0), (0.0, 4.0))
    ((start, end),) = found
    assert start == pytest.approx(np.arcsin(0.5), abs=0.004)
    assert end == pytest.approx(np.pi - np.arcsin(0.5), abs=0.004)
    assert traces.chosen(Axis("q", 0), Axis("time"), (5.0, 6.0), (0.0, 4.0)) == []


def test_what_is_chosen_on_a_map_lights_up_there(traces: Traces) -> None:
    across, up, bins = Axis("q", 0), Axis("time"), 20
    everywhere = traces.lit(across, up, bins, [(0.0, float(traces.time[-1]))])
    count = np.array(traces.map(1, across, up, bins)["count"])
    np.testing.assert_array_equal(everywhere, np.flatnonzero(count))
    assert traces.lit(across, up, bins, []) == []
    rows = np.array(traces.lit(across, up, bins, [(2.0, 3.0)])) // bins
    assert set(rows) == {4, 5, 6}  # 10 s in 20 rows
    (span,) = traces.chosen(across, up, (0.5, 2.0), (0.0, 4.0))
    assert all(k % bins >= 14 for k in traces.lit(across, up, bins, [span]))


@given(st.lists(st.booleans(), min_size=1, max_size=60))
def test_spans_hold_the_samples_and_close_short_pauses(inside: list[bool]) -> None:
    time, flags = 0.05 * np.arange(len(inside)), np.array(inside)
    found = spans(np.asarray(time, dtype=np.float64), flags)
    for at, wanted in zip(time, flags, strict=True):
        if wanted:
            assert any(start <= at <= end for start, end in found)
    ends = [end for _, end in found]
    assert all(later[0] - end > 0.1 for end, later in zip(ends, found[1:], strict=False))


def test_time_goes_on_through_segments() -> None:
    time = np.r_[np.arange(5) * 0.1, 100.0 + np.arange(5) * 0.1]
    found = running_time(time, np.repeat([0, 1], 5))
    np.testing.assert_allclose(found, np.arange(10) * 0.1, atol=1e-9)
