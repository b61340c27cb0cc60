"""Every threshold of a diagnosis, in one place, with the reason for its value."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass


@dataclass(frozen=True)
class Thresholds:
    """The least or most that a claim needs. A log Bayes factor (log BF) is in nats.

    Attributes:
        floor: least log BF of any claim. A form that is not quite the true one leaves about as
            much, whatever the null says.
        near_floor: share of it from which on a log BF may reach it with the hyperparameters that
            suit the effect: load viscosity of 5 % had 17 nats with those fitted without it, and 33.
        event_floor: the same for an event: random signs of blocks cannot separate it from an
            outlier.
        level: largest p-value, over all candidates and on the hold-out motion.
        touch_level: the same for a touch of the arm to be sure, as no other motion can confirm it.
        promising: log BF of the best effect above which it is mentioned although the null reaches
            it.
        least_size: share of a joint's torque below which an effect is not worth a name.
        least_left: share of a joint's torque below which a dependence without a name is not worth a
            word: no arm is rigid, and none of its parts is round, to a hundredth.
        above_noise: ratio of what is left on a joint to the noise between neighbouring samples,
            above which it is more than noise: on arms that lack nothing it is 0.9 to 1.05.
        least_rest: share of a joint's torque below which that is not worth a word.
        remainder: share of the log BF of another effect on the joint that may be a flaw of its
            form.
        name_share: share of the log BF of the best curve that an effect must reach to be named, if
            it leaves something of the curve.
        possible_share: share of the best log BF that an effect must reach to come before one with a
            shape at an end of what nature allows.
        plain_share, first_share: share of the best log BF that plain friction must reach, where
            the model has some on the joint and where it has none.
        bare_factor: ratio to the best log BF that a change of the arm must exceed where plain
            friction is missing: a second Lagrangian takes up much of it.
        near: an effect or a curve is refitted if at first it reaches this share of the best log
            BF.
        rival_nats, rival_deviations: nats, and standard deviations of the difference by blocks
            (Vuong 1989), by which a rival must fall behind to be ruled out.
        rival_share: share of the best log BF below which nothing is a rival.
        same_cause: share of the best log BF that a cause found on another joint must reach.
        group_nats: log BF expected of a group of hold-out blocks: less is noise, more makes the
            groups too few.
        fewest_groups, groups, most_groups: number of groups. With more of them, they would be as
            short as the residual is correlated.
        held_out_share: share of these groups in which an effect must help.
        size_ratio: range of the effect's size on hold-out motion relative to that found.
        large_rest: a finding is only suggested where curves on the joint reach this share of its
            log BF.
        shortest: s of motion that a search or a confirmation needs.
        fewest_blocks: number of independent blocks of a motion that a verdict needs: of fewer,
            random signs too often leave all as they are, or turn all.
        held_back: share of a single recording, from its end, that confirms what the rest suggests.
        change_floor: least log BF of a change of the arm: a second Lagrangian is a large freedom.
        change_promising: log BF on few samples above which a change is examined on all.
        change_beyond_chance, change_again: standard deviations by which the log BF of a change
            must exceed those with shuffled blocks, in the search and on hold-out motion. Nine
            arms without a load reached 6.4 at most, loads of 10 % and 20 % 9 and 14.
        change_elsewhere: share of its gain that a change keeps without any one block. Of four
            false ones three kept nothing and one .23, of five loads all kept .55 or more, .40 on
            hold-out motion.
        change_helps: largest share of a model's error on a recording that a change since its
            identification may leave.
        change_motion: s of motion below which no change is searched.
        change_margin: s of motion needed before and after a moment of change.
        change_shortest: s that a change lasts at least, and that remain after its end.
        felt: share of a joint's torque above which the joint counts as feeling a load.
        unit_floor: nats of log evidence that other units of effort need to be believed: on
            recorded arms wrong ones gained 99.
        known_unit_floor: the same for the units that the model was identified with.
        learned: share of a parameter's prior variance; with more left, the motion says nothing of
            the parameter.
        alike: nats within which another change of the robot's bodies explains as much.
        observable_size: share of a joint's torque at which a motion should show an effect.
        still: rad within which a joint stands still.
        covered_least: share of torques inside 90 % intervals below which a long motion shows that
            something is wrong: eight models of simulated arms that had not changed had at least
            0.71 on every joint.
        misfit: ratio of a model's error on a recording to that on motion left out of its training,
            surely exceeded, from which the arm counts as another than the one identified. Motion
            of another kind alone makes it 1 to 1.3.
        poor: nmse of a joint from which what a model leaves is not called noise.
        fails: error on unseen motion, in parts of the noise, from which a model does not know the
            arm, whatever it leaves of the motion that was searched.
        covered_deviations: standard deviations, one second counted as one sample, by which a short
            motion may fall below 90 %.
    """

    floor: float = 20.0
    near_floor: float = 0.4
    event_floor: float = 25.0
    level: float = 0.05
    touch_level: float = 0.01
    promising: float = 60.0
    least_size: float = 0.005
    least_left: float = 0.01
    above_noise: float = 1.5
    least_rest: float = 0.02
    remainder: float = 0.03
    name_share: float = 0.7
    possible_share: float = 0.5
    plain_share: float = 0.6
    first_share: float = 0.1
    bare_factor: float = 3.0
    near: float = 0.2
    rival_nats: float = 4.0
    rival_deviations: float = 2.0
    rival_share: float = 0.25
    same_cause: float = 0.7
    group_nats: tuple[float, float] = (2.0, 4.0)
    fewest_groups: int = 5
    groups: int = 6
    most_groups: int = 8
    held_out_share: float = 0.75
    size_ratio: tuple[float, float] = (0.5, 1.6)
    large_rest: float = 0.5
    shortest: float = 2.0
    fewest_blocks: int = 8
    held_back: float = 1.0 / 3.0
    change_floor: float = 100.0
    change_promising: float = 3.0
    change_beyond_chance: float = 7.0
    change_again: float = 3.5
    change_elsewhere: float = 1.0 / 3.0
    change_helps: float = 0.95
    change_motion: float = 15.0
    change_margin: float = 3.0
    change_shortest: float = 1.0
    felt: float = 0.02
    unit_floor: float = 100.0
    known_unit_floor: float = 5.0
    learned: float = 0.5
    alike: float = 3.0
    observable_size: float = 0.1
    still: float = 1e-3
    covered_least: float = 0.65
    misfit: float = 1.5
    poor: float = 0.2
    fails: float = 5.0
    covered_deviations: float = 3.0


@dataclass(frozen=True)
class Effort:
    """The part of a motion that is examined, and how long hyperparameters are fitted.

    Attributes:
        rows: torques (samples times joints) that are whitened; factoring 3600 takes half a second.
        stages: samples that the evidence is maximised on, and the largest number of steps.
    """

    rows: int = 3600
    stages: tuple[tuple[int, int], ...] = ((60, 20), (120, 6), (240, 2))


USED, EFFORT = Thresholds(), Effort()
"""In use; read as `thresholds.USED`, so that `using` can put others in their place."""


@contextmanager
def using(limits: Thresholds | None = None, effort: Effort | None = None) -> Iterator[None]:
    """Use other thresholds or another effort in the block."""
    global USED, EFFORT
    before = USED, EFFORT
    USED, EFFORT = limits or USED, effort or EFFORT
    try:
        yield
    finally:
        USED, EFFORT = before
