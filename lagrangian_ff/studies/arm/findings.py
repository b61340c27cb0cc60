"""What Figs. 5 and 7 of the paper are there to show, on our arm and with our models too."""

from collections.abc import Iterator

from lagrangian_ff.studies.arm.errors import Errors, ends
from lagrangian_ff.studies.arm.models import ALONE, FRICTION, LAGRANGIAN, OURS, PAPER
from lagrangian_ff.studies.common.findings import Finding, finding
from lagrangian_ff.words import listed

TRADITIONAL, REFERENCE = "motor+fri", "vrbfs+fri"


def prediction_findings(errors: Errors) -> dict[str, Finding]:
    """What can be said of the cases that are done."""
    return dict(_findings(errors))


def rise(errors: Errors, model: str, speeds: list[int]) -> float:
    """Its error on the fastest third of trajectories over that on the slowest."""
    slow, fast = ends(speeds)
    return errors.mean(model, fast) / errors.mean(model, slow)


def _findings(errors: Errors) -> Iterator[tuple[str, Finding]]:
    speeds = errors.common(TRADITIONAL, REFERENCE)
    if len(speeds) > 1:
        yield "motor_deteriorates", _motor_deteriorates(errors, speeds)
    best = _lagrangian_best(errors)
    if best:
        yield "lagrangian_best", best
    for model in OURS:
        speeds = errors.common(model, REFERENCE)
        if speeds:
            yield f"{model}_better", _better(errors, model, speeds)
    needed = _friction_needed(errors)
    if needed:
        yield "friction_needed", needed


def _motor_deteriorates(errors: Errors, speeds: list[int]) -> Finding:
    simple, reference = (rise(errors, model, speeds) for model in (TRADITIONAL, REFERENCE))
    return finding(
        simple > max(1.0, reference),
        f"{TRADITIONAL} deteriorates with speed, and faster than {REFERENCE}: its error on the "
        f"fastest third of trajectories is {simple:.2f} times that on the slowest, that of "
        f"{REFERENCE} {reference:.2f} times",
        rise={TRADITIONAL: simple, REFERENCE: reference},
    )


def _lagrangian_best(errors: Errors) -> Finding | None:
    """Among the paper's models, where they are done on the same trajectories."""
    there = [model for model in PAPER if model in errors.of]
    others = [model for model in there if model not in LAGRANGIAN]
    speeds = errors.common(*there)
    if len(others) in (0, len(there)) or not speeds:
        return None
    means = {model: errors.mean(model, speeds) for model in there}
    ours = min((model for model in there if model in LAGRANGIAN), key=means.__getitem__)
    next_ = min(others, key=means.__getitem__)
    first = sum(
        min(there, key=lambda model: errors.of[model][speed]) in LAGRANGIAN for speed in speeds
    )
    return finding(
        means[ours] < means[next_],
        f"the Lagrangian kernels with friction are the best of the paper's models: {ours} has "
        f"{means[ours] / means[next_]:.2f} of the error of {next_}, the best of the others; on "
        f"{first} of {len(speeds)} trajectories one of them is first",
        mean=means,
        first=first,
        trajectories=len(speeds),
    )


def _better(errors: Errors, model: str, speeds: list[int]) -> Finding:
    ratio, below = errors.ratio(model, REFERENCE, speeds), errors.below(model, REFERENCE, speeds)
    return finding(
        ratio < 1.0,
        f"{model} is below {REFERENCE}: {ratio:.2f} of its error, smaller on {below} of "
        f"{len(speeds)} trajectories",
        ratio=ratio,
        below=below,
        trajectories=len(speeds),
    )


def _friction_needed(errors: Errors) -> Finding | None:
    """On the slowest third of trajectories."""
    ratios = {}
    for alone in ALONE:
        speeds = errors.common(alone, alone + FRICTION)
        if speeds:
            ratios[alone] = errors.ratio(alone + FRICTION, alone, ends(speeds)[0])
    if not ratios:
        return None
    figures = listed([f"{model} {ratio:.2f}" for model, ratio in ratios.items()])
    return finding(
        max(ratios.values()) < 1.0,
        "friction beside the kernel is needed at low speed: on the slowest third of trajectories "
        f"it leaves of the kernel's error alone: {figures}",
        ratio=ratios,
    )
