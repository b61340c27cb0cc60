"""What Fig. 6 of the paper is there to show: three groups, and how near the bound a model comes."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

from lagrangian_ff.studies.arm.errors import Errors
from lagrangian_ff.studies.arm.models import FRICTION, OURS
from lagrangian_ff.studies.common.findings import Finding, finding
from lagrangian_ff.studies.tracking.case import NONE, TRUE

PAPERS = "vrbfs+fri"


def tracking_findings(errors: Errors) -> dict[str, Finding]:
    """What can be said of the cases that are done."""
    return dict(_findings(errors))


def _findings(errors: Errors) -> Iterator[tuple[str, Finding]]:
    models = [name for name in errors.of if name not in (NONE, TRUE)]
    groups = [
        [NONE],
        [model for model in models if FRICTION not in model],
        [model for model in models if FRICTION in model],
    ]
    speeds = errors.common(NONE, *models)
    if speeds and all(groups):
        yield "three_groups", _three_groups(errors, groups, speeds)
    speeds = errors.common(NONE, TRUE)
    if speeds:
        yield "bound_below", _bound_below(errors, speeds)
    speeds = errors.common(OURS[0], PAPERS, TRUE)
    if speeds:
        yield "ours_nearest", _ours_nearest(errors, speeds)


def _three_groups(errors: Errors, groups: list[list[str]], speeds: list[int]) -> Finding:
    means = [{name: errors.mean(name, speeds) for name in group} for group in groups]
    none, without, with_ = (_span(list(group.values())) for group in means)
    apart = [_apart(errors, worse, better, speeds) for worse, better in pairwise(groups)]
    return finding(
        all(min(worse.values()) > max(better.values()) for worse, better in pairwise(means)),
        f"tracking falls in three groups: {none} mrad without feedforward, {without} without "
        f"friction in the model, {with_} with it; the first two are apart on {apart[0]} of "
        f"{len(speeds)} trajectories, the last two on {apart[1]}",
        mean={name: mean for group in means for name, mean in group.items()},
        apart=apart,
        trajectories=len(speeds),
    )


def _span(means: Sequence[float]) -> str:
    ends = dict.fromkeys((min(means), max(means)))
    return " to ".join(f"{1e3 * mean:.1f}" for mean in ends)


def _apart(errors: Errors, worse: list[str], better: list[str], speeds: list[int]) -> int:
    """On how many trajectories all of one group are above all of the other."""
    return sum(
        min(errors.of[name][speed] for name in worse)
        > max(errors.of[name][speed] for name in better)
        for speed in speeds
    )


def _bound_below(errors: Errors, speeds: list[int]) -> Finding:
    ratio, below = errors.ratio(TRUE, NONE, speeds), errors.below(TRUE, NONE, speeds)
    return finding(
        below == len(speeds),
        f"the plant's own torques, the bound for any model, leave {ratio:.3f} of the error without "
        "feedforward",
        ratio=ratio,
    )


def _ours_nearest(errors: Errors, speeds: list[int]) -> Finding:
    over = {name: errors.ratio(name, TRUE, speeds) for name in (OURS[0], PAPERS)}
    below = errors.below(OURS[0], PAPERS, speeds)
    return finding(
        over[OURS[0]] < over[PAPERS],
        f"{OURS[0]} is nearer to the bound than {PAPERS}: {over[OURS[0]]:.2f} times it, {PAPERS} "
        f"{over[PAPERS]:.2f} times; smaller on {below} of {len(speeds)} trajectories",
        over_bound=over,
        below=below,
        trajectories=len(speeds),
    )
