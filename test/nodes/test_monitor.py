"""The monitor tells once why the torque fades, and each second how the stream did."""

import numpy as np
import pytest

from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.streaming.monitor import Monitor
from lagrangian_ff.nodes.streaming.stream import Output, Phase


def output(phase: Phase = Phase.FOLLOWING, withheld: str = "", saturated: bool = False) -> Output:
    flags = np.array([saturated, False])
    return Output(np.zeros(2), 1.0, phase, withheld, flags, np.zeros(2, dtype=bool))


def test_each_beginning_of_a_fade_is_told_once() -> None:
    monitor = Monitor()
    told = [
        monitor.note(output(withheld=reason))
        for reason in ("", "disabled", "disabled", "", "no joint states", "no joint states")
    ]
    assert told == ["", "disabled", "", "", "no joint states", ""]
    assert Monitor().note(output(Phase.WAITING, "no reference")) == ""


@pytest.mark.parametrize(
    ("last", "rate", "level", "message"),
    [
        (output(), 0.0, Level.OK, "following"),
        (output(Phase.WAITING, "no reference"), 0.0, Level.OK, "no reference"),
        (output(withheld="disabled"), 0.0, Level.WARN, "disabled"),
        (output(withheld="no joint states"), 0.0, Level.STALE, "no joint states"),
        (output(saturated=True), 0.0, Level.WARN, "torque limit reached in 1 ticks"),
        (output(), 1e12, Level.WARN, "Hz instead of 1e+12 Hz"),
    ],
)
def test_the_status_names_the_worst(last: Output, rate: float, level: Level, message: str) -> None:
    monitor = Monitor()
    monitor.note(last)
    status = monitor.status(rate, {"more": 1})
    assert status.level is level
    assert message in status.message
    assert status.values["more"] == 1
    assert monitor.status(0.0, {}).values["ticks at the torque limit"] == 0


def test_values_become_text() -> None:
    status = Status(Level.OK, "fine", {"rate": 499.98765432, "count": 3, "name": "a"})
    assert status.texts() == {"rate": "499.988", "count": "3", "name": "a"}
