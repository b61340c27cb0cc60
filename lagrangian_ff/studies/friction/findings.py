"""What section IV-A says of Fig. 3, and whether the lines bear it out."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lagrangian_ff.studies.common.case import Line
from lagrangian_ff.studies.dof.numbers import ByRobot, Comparison, by_model

FEW_JOINTS = 2
MANY_TIMES = 3.0
"""A kernel fails where its error is more than this times that of the same with `fri`; with `fri` it
is back where its error is less than this times that where there is no friction."""


def findings(lines: Sequence[Line]) -> list[Comparison]:
    """The claims, kernel by kernel.

    Returns:
        See `Comparison`. `means` are over the robots that were learned with both: of the kernel, of
        the same with `fri`, and `frictionless`, that of the latter's numbers where there is no
        friction.
    """
    held = by_model(lines)
    return [
        finding
        for model in held
        if f"{model}+fri" in held
        for finding in _of_kernel(model, held[model], held[f"{model}+fri"])
    ]


def _of_kernel(
    model: str, bare: Mapping[int, ByRobot], knowing: Mapping[int, ByRobot]
) -> list[Comparison]:
    rows: dict[int, dict[str, Any]] = {}
    without, with_fri, alone, ratio = {}, {}, {}, {}
    for joints in sorted(set(bare) & set(knowing)):
        robots = sorted(set(bare[joints]) & set(knowing[joints]))
        if not robots:
            continue
        without[joints] = _mean(bare[joints], robots, "error")
        with_fri[joints] = _mean(knowing[joints], robots, "error")
        alone[joints] = _mean(knowing[joints], robots, "frictionless")
        ratio[joints] = without[joints] / with_fri[joints]
        names = (model, f"{model}+fri", "frictionless")
        means = (without[joints], with_fri[joints], alone[joints])
        rows[joints] = {"means": dict(zip(names, means, strict=True)), "robots": len(robots)}

    def claim(words: str, holds: Mapping[int, bool]) -> Comparison:
        judged = {str(joints): {"holds": held, **rows[joints]} for joints, held in holds.items()}
        return {"claim": words, "joints": judged}

    few = [joints for joints in rows if joints <= FEW_JOINTS]
    claims = [
        claim(
            f"{model} without fri fails at few joints",
            {joints: ratio[joints] > MANY_TIMES for joints in few},
        ),
        claim(
            f"{model}+fri errs as where there is no friction",
            {joints: with_fri[joints] < MANY_TIMES * alone[joints] for joints in rows},
        ),
        claim(
            f"{model} misses fri less than at one joint",
            {joints: ratio[joints] < ratio[1] for joints in rows if joints > 1 and 1 in rows},
        ),
    ]
    return [one for one in claims if one["joints"]]


def _mean(by_robot: ByRobot, robots: Sequence[int], what: str) -> float:
    return float(np.mean([by_robot[robot][what] for robot in robots]))
