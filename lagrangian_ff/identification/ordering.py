"""The order of the joints from base to tool, which the kernels of a serial arm need."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations

import numpy as np

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.choosing.evidence import Logarithms, maximise_evidence, solvable
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.samples import Samples, decimated, evenly
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.kernels import Mechanism, States
from lagrangian_ff.kernels.threads import one_blas_thread
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import Motion, concatenate

FEW, MANY = 40, 160
"""Samples that orders are searched with, and that the best is compared with the given one on."""
STEPS = 8
MOST_JOINTS = 10
WORTH_A_SEARCH = 10.0
"""Nats on few samples that the best exchange must bring, or the given order is kept."""
SURE = 50.0
"""Nats on many samples from which on another order is taken. Below, both predict alike: a wrist
whose axes meet has no order that the torques would show."""

Order = tuple[int, ...]


@dataclass(frozen=True)
class JointOrder:
    """An order of the joints.

    Attributes:
        joints: from base to tool.
        nats: how much more evidence it has than the given order; 0 if data were not asked.
    """

    joints: tuple[str, ...]
    nats: float = 0.0

    def words(self, given: Sequence[str]) -> str:
        """Return what was found, for people; "" for the given order."""
        if self.joints == tuple(given):
            return ""
        source = f"by the data ({self.nats:.0f} nats)" if self.nats else "by the description"
        return (
            f"the joints come as {', '.join(given)}; from base to tool they are taken as "
            f"{', '.join(self.joints)}, {source}"
        )


def numbered(joints: Sequence[str]) -> bool:
    """Return whether names count upwards and differ in their last number alone: base to tool."""
    parts = [re.fullmatch(r"(.*?)(\d+)(\D*)", joint) for joint in joints]
    if not all(parts):
        return False
    found = [one.groups() for one in parts if one is not None]
    counts = [int(number) for _, number, _ in found]
    alike = len({(before, after) for before, _, after in found}) == 1
    return alike and counts == sorted(set(counts))


def joint_order(
    motions: Sequence[Motion],
    model: str,
    mechanism: Mechanism | None = None,
    progress: Progress = silent,
) -> JointOrder:
    """Return the order of the joints from base to tool.

    A description of the arm says it. Without one, names that count upwards are taken to be in
    order. Otherwise parts of the arm change places as long as the evidence of a serial arm grows.

    Args:
        motions: conditioned recordings of the same joints.
        model: the name of the model to identify; kernels that know no order keep the given one.
        mechanism: what is known of the arm; None is nothing.
        progress: receives the share done, 0 to 1.
    """
    spec = parse(model)
    data = concatenate([decimated(motion) for motion in motions])
    given, start = data.joints, tuple(range(len(data.joints)))
    if mechanism is not None:
        described = tuple(joint for joint in mechanism.base_to_tool if joint in given)
        return JointOrder(described if len(described) == len(given) else given)
    ordered = any(kernel.separates for kernel in (spec.kernels or (spec.kernel,)))
    if not ordered or not 3 <= len(given) <= MOST_JOINTS or numbered(given):
        return JointOrder(given)
    few, many = (_evidence(data, count) for count in (FEW, MANY))
    with one_blas_thread():  # threads cost more than they bring on such small matrices
        best, gain = start, WORTH_A_SEARCH
        while True:
            around = _moved(best)
            scores = []
            for number, order in enumerate(around):
                progress(number / len(around), "looking for the order of the joints")
                scores.append(few(order))
            place = int(np.argmax(scores))
            if scores[place] <= few(best) + gain:
                break
            best, gain = around[place], 0.0
        if best == start:
            return JointOrder(given)
        nats = many(best) - many(start)
    return JointOrder(tuple(given[n] for n in best), nats) if nats > SURE else JointOrder(given)


def _moved(order: Order) -> list[Order]:
    """Return the orders in which two neighbouring parts change places, and the reverse."""
    cuts = combinations(range(len(order) + 1), 3)
    swapped = [(*order[:a], *order[b:c], *order[a:b], *order[c:]) for a, b, c in cuts]
    return [*swapped, order[::-1]]


def _evidence(data: Motion, count: int) -> Callable[[Order], float]:
    """Return the log evidence of a serial arm with friction, by order of its joints."""
    spec = parse("chain+fri")
    moving = np.flatnonzero(~data.rest.all(axis=1))
    pick = moving[evenly(len(moving), count)]

    @cache
    def evidence(order: Order) -> float:
        q, qd, qdd, tau = (table[:, order] for table in (data.q, data.qd, data.qdd, data.tau))
        inputs = Inputs.of(States.of(q, qd, qdd), data.time, data.segment).take(pick)
        samples = Samples(inputs, tau[pick])
        problem = Problem.started(spec, samples, Scaling.of(samples.tau, per_joint=False))
        prior = Logarithms(problem, shapes=False).prior
        found = maximise_evidence(solvable(problem), STEPS, prior, shapes=False)
        return float(found.log_evidence)

    return evidence
