"""Errors of what is compared, by trajectory, and what they come to."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lagrangian_ff.studies.common.case import Line


@dataclass(frozen=True)
class Errors:
    """Errors on trajectories of rising speed; some may not be done yet.

    Attributes:
        of: for each of what is compared, its error by speed.
        velocity: rad/s, the mean norm of velocity by speed.
    """

    of: Mapping[str, Mapping[int, float]]
    velocity: Mapping[int, float]

    @classmethod
    def collected(cls, lines: Iterable[Line], key: str, value: str) -> "Errors":
        """From the lines of cases that did not fail.

        Args:
            lines: with `speed` and `velocity`.
            key: under which a line tells what it is of.  value: and its error.
        """
        of: dict[str, dict[int, float]] = {}
        velocity: dict[int, float] = {}
        for line in sorted((line for line in lines if "failed" not in line), key=_speed):
            of.setdefault(line[key], {})[line["speed"]] = line[value]
            velocity[line["speed"]] = line["velocity"]
        return cls(of, velocity)

    def common(self, *names: str) -> list[int]:
        """The speeds at which all of these are done, rising; none where a name is not there."""
        done = [set(self.of.get(name, ())) for name in names]
        return sorted(set.intersection(*done)) if done else []

    def mean(self, name: str, speeds: Sequence[int]) -> float:
        """Geometric mean: every trajectory counts the same, however large its torques."""
        return float(np.exp(np.mean(np.log([self.of[name][speed] for speed in speeds]))))

    def ratio(self, name: str, other: str, speeds: Sequence[int]) -> float:
        """How many times the other's error, in the geometric mean."""
        return self.mean(name, speeds) / self.mean(other, speeds)

    def below(self, name: str, other: str, speeds: Sequence[int]) -> int:
        """On how many of the trajectories its error is the smaller one."""
        return sum(self.of[name][speed] < self.of[other][speed] for speed in speeds)

    def record(self) -> dict[str, Any]:
        """For JSON: for each of what is compared, `speed`, `velocity` and `rmse` as lists."""
        return {
            name: {
                "speed": list(by_speed),
                "velocity": [self.velocity[speed] for speed in by_speed],
                "rmse": list(by_speed.values()),
            }
            for name, by_speed in self.of.items()
        }


def ends(speeds: Sequence[int]) -> tuple[Sequence[int], Sequence[int]]:
    """The slowest and the fastest third of trajectories, at least one each."""
    third = max(1, len(speeds) // 3)
    return speeds[:third], speeds[-third:]


def _speed(line: Line) -> int:
    return int(line["speed"])
