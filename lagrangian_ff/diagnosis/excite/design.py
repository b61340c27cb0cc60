"""A motion designed by its information: it is to show as much as the limits allow."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite.assumed import SIZE, Assumed, Expected, representative
from lagrangian_ff.diagnosis.excite.climbing import USUAL, Effort, Way, samples_of
from lagrangian_ff.diagnosis.excite.excite import inside, seen_pose
from lagrangian_ff.diagnosis.excite.keeping import Clear, Keeper, limits_of
from lagrangian_ff.diagnosis.excite.objective import Objective, nats_of
from lagrangian_ff.diagnosis.excite.path import GRID, Limits, Reference
from lagrangian_ff.diagnosis.excite.questions import For, Question, cases_of, creeping_in
from lagrangian_ff.diagnosis.excite.splines import DEGREE, Splines
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.threads import limited, one_blas_thread
from lagrangian_ff.progress import Progress, part, silent

SECONDS, SHORTEST, LONGEST = 20.0, 8.0, 60.0
SPACING = 0.2
"""s between the knots."""


@dataclass(frozen=True)
class Design:
    """A designed motion.

    Attributes:
        question: that it is to answer.  joints: N names.
        reference: the motion, every 0.01 s.
        nats: expected to decide the question at the size asked for, the least of all ways to err;
            or those that it tells of the rigid bodies.
        expected: of every effect on every joint at this size.
        used: by limit, (N,) the share of it that the motion takes.
        begun: the motion that it was climbed from.
        beyond: the joints that go where the model has not seen them, where it guesses.
        finished: whether the search went to its end.
    """

    question: Question
    joints: tuple[str, ...]
    reference: Reference
    nats: float
    expected: tuple[Expected, ...]
    used: Mapping[str, Floats]
    begun: str
    beyond: tuple[str, ...] = ()
    finished: bool = True


def design(
    model: Model,
    question: Question,
    limits: Limits | None = None,
    *,
    start: Floats | None = None,
    seconds: float = SECONDS,
    size: float = SIZE,
    clear: Clear | None = None,
    assumed: Assumed | None = None,
    effort: Effort = USUAL,
    seed: int = 0,
    progress: Progress = silent,
) -> Design:
    """Return the motion that is expected to say most about a question.

    Interrupted (KeyboardInterrupt), it returns the best motion that it has found.

    Args:
        limits: never left; None takes what the model's own data reached.
        start: (N,) rad, where it begins and ends; None takes a pose of those data.
        seconds: how long it lasts; a little longer where limits ask for it.
        size: of effects, see `Expected`.
        clear: says what touches on a path; None if nothing is known of that.
        assumed: of the model, if it is at hand.
        effort: how long the search goes on.
        seed: of what is random.
        progress: receives the share done, 0 to 1.

    Raises:
        ModelError: a question that no motion answers, no joint with room to move, a start outside
            the limits or not clear, or a duration or size that cannot be.
    """
    if not SHORTEST <= seconds <= LONGEST:
        raise ModelError(f"a duration of {seconds:g} s: expected {SHORTEST:g} to {LONGEST:g} s")
    if not 0.0 < size <= 1.0:
        raise ModelError(f"a size of {size:g}: expected more than 0, and 1 at most")
    limits = limits_of(model) if limits is None else limits
    assumed = Assumed.of(model, part(progress, 0.0, 0.15)) if assumed is None else assumed
    pose = pose_for(question, model, limits) if start is None else start
    pose = inside("start", pose, model.joints, limits)
    keeper = Keeper(model, limits, 2.0 * assumed.base.noise, clear)
    if clear is not None and (touch := clear(pose[None, :])):
        raise ModelError(f"the motion would begin where {touch} touch: name another start")
    splines = Splines(GRID * round(seconds / GRID), round(seconds / SPACING) + DEGREE)
    index = samples_of(splines, effort, len(pose), seed)
    groups = cases_of(question, assumed, size)
    assumed = assumed.knowing(case.true for group in groups for case in group)
    assumed = assumed.unsure_of_creep(creeping_in(question, model.joints))
    objective = Objective(assumed, groups, splines, size, index, not question.suspects)
    every = Way(objective, keeper, pose, effort, tuple(range(len(pose))))
    # Threads that share products as small as these mostly wait for each other.
    with limited(1), one_blas_thread():
        return _designed(every, question, seed, part(progress, 0.15, 1.0))


def _designed(every: Way, question: Question, seed: int, progress: Progress) -> Design:
    """Return the best motion that is found where all joints move, or only those asked for."""
    model = every.keeper.model
    wanted = joints_of(question, model)
    starts = every.starts(wanted, seed, part(progress, 0.0, 0.1))
    ways = [(every, starts)]
    if (alone := every.alone([model.joints.index(name) for name in wanted], starts)) is not None:
        ways.append(alone)
    ends = [(way, found[0]) for way, found in ways]
    looks, finished = 0, True
    try:
        for number, (way, found) in enumerate(ways):
            for best in way.uphill(found, seed):
                ends[number] = way, best
                looks += best.looks
                share = looks / (len(ways) * way.effort.looks)
                progress(0.1 + 0.75 * share, f"climbing from {best.begun}")
    except KeyboardInterrupt:
        finished = False
    progress(0.85, "predicting what it will show")
    made = [
        _prediction(way, question, *kept, best.begun)
        for way, best in ends
        if (kept := way.kept(best)) is not None
    ]
    if not made:
        raise ModelError(
            "no motion keeps the limits: at the start, the torque predicted comes too near to its "
            "limit already; name another start or other limits"
        )
    fastest = max(made, key=lambda one: one.nats / float(one.reference.time[-1]))
    return replace(fastest, finished=finished)


def _prediction(
    way: Way, question: Question, splines: Splines, control: Floats, begun: str
) -> Design:
    """Return a motion with what it is expected to show."""
    objective, reference = way.objective, splines.reference(control)
    assumed = objective.assumed.suited_to(reference)
    asked = [case.true for group in objective.groups for case in group]
    keys = {one.key for one in asked}
    others = [one for one in representative(assumed.base) if one.key not in keys]
    expected = assumed.gains(reference, objective.size, [*asked, *others])
    nats = nats_of(assumed, objective.groups, reference, objective.size)
    if isinstance(question, For):
        name, joint = question.suspect.effect, question.suspect.joint
        own = [one.nats for one in expected if (one.effect, one.joint) == (name, joint)]
        nats = min(nats, *own)
    joints = assumed.model.joints
    excess = assumed.model.range.excess(States.of(*reference[1:])).max(axis=0)
    beyond = tuple(name for name, share in zip(joints, excess, strict=True) if share > 1e-6)
    used = way.keeper.used(reference)
    return Design(question, joints, reference, nats, expected, used, begun, beyond)


def joints_of(question: Question, model: Model) -> Sequence[str]:
    """Return the joints that a question is about: all if it names no effect.

    Raises:
        ModelError: the model lacks one.
    """
    if not question.suspects:
        return model.joints
    for one in question.suspects:
        if one.joint not in model.joints:
            raise ModelError(f"there is no joint {one.joint}; there are {', '.join(model.joints)}")
    return list(dict.fromkeys(one.joint for one in question.suspects))


def pose_for(question: Question, model: Model, limits: Limits) -> Floats:
    """Return (N,) rad, where a motion for a question begins; see `seen_pose`."""
    wanted = joints_of(question, model)
    return seen_pose(model, wanted[0] if len(wanted) == 1 else None, limits)
