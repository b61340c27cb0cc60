"""Filters that show sudden changes of the residual, and how large the model's own errors make them.

Filters of several lengths take the mean residual of the last states less that shortly before. The
model's own errors change it, too: about reversals, in creeping, with speed and position, by noise.
How much they do is learned from the model's training motion, as components of a variance
(`diagnosis.bursts` does it for whole recordings, with windows to both sides). A touch accelerates
the arm, so that acceleration excuses an output only if it was there before.
"""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.identification import Model
from lagrangian_ff.nodes.watching.chance import starts_of_blocks
from lagrangian_ff.sampling import usual_step

LENGTHS = 0.02, 0.04
"""s that the filters look back on."""
GAP = 0.03
"""s left out before, over which the low-pass spreads the beginning of a touch."""
BEFORE = 0.2
"""s before that, which the last are compared with."""
CREEP = 0.1
"""Share of a joint's rms speed below which friction may have any form."""
AFTER = 0.1
"""s after a reversal in which friction settles."""
CHANGES, NOW, EARLIER = 4, 3, 2
"""Causes of a model's errors that count as they change, as they are, and as they were before."""
MOST = 6000
"""States of the training motion that are learned from."""
STEPS = 30
"""Of the climb to the likeliest components of the variance."""


@dataclass(frozen=True)
class Usual:
    """The usual motion of a model's data, to measure states by.

    Attributes:
        middle: (N,) rad, the mean position.
        width, speed, hardness: (N,) rad, rad/s, rad/s², the rms from there, never 0.
    """

    middle: Floats
    width: Floats
    speed: Floats
    hardness: Floats

    @classmethod
    def of(cls, model: Model) -> "Usual":
        """Return that of the data of a model."""
        known = model.data
        middle = known.q.mean(axis=0)
        each = known.q - middle, known.qd, known.qdd
        return cls(middle, *(np.maximum(np.sqrt(np.mean(one**2, axis=0)), 1e-9) for one in each))


class _Sources:
    """Turns states into the causes of a model's errors, each as a number that grows with it.

    Args:
        usual: motion of the model's data.
    """

    def __init__(self, usual: Usual) -> None:
        self._usual = usual
        self.restart()

    def restart(self) -> None:
        """Forget the last state."""
        self._last: tuple[float, Floats, Floats] | None = None
        self._settling = np.zeros_like(self._usual.speed)

    def take(self, time: float, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """Return (CHANGES + NOW + EARLIER, N): what counts as it changes, as it is, as it was.

        Args:
            time: s.  q, qd, qdd: (N,) rad, rad/s, rad/s².
        """
        hard, fast = qdd / self._usual.hardness, (qd / self._usual.speed) ** 2
        creep = np.exp(-fast / CREEP**2)
        way = np.tanh(qd / (0.5 * CREEP * self._usual.speed))
        jerk = np.zeros_like(q)
        if self._last is not None:
            before, speed, earlier = self._last
            passed = max(time - before, 1e-6)
            jerk = (hard - earlier) / passed
            turned = np.signbit(qd) != np.signbit(speed)
            self._settling = np.where(turned, 1.0, self._settling * np.exp(-passed / AFTER))
        self._last = time, qd, hard
        changes = fast, q / self._usual.width, way, way * creep
        return np.stack([*changes, fast, self._settling, creep, hard**2, jerk**2])


@dataclass(frozen=True)
class Seen:
    """The output of the filters at one state, and what may have caused it.

    Attributes:
        output: (F, N) N·m, of F filters.
        shares: (F, K, N) the size of each of K causes, as a share of the output's variance.
    """

    output: Floats
    shares: Floats


class Filters:
    """The filters over the last states.

    Args:
        model: of N joints.  step: s between states.

    Attributes:
        size: states that an output needs.
    """

    def __init__(self, model: Model, step: float) -> None:
        self._sources, self._joints = _Sources(Usual.of(model)), len(model.joints)
        lengths = [max(1, round(length / step)) for length in LENGTHS]
        gap, before = (max(1, round(length / step)) for length in (GAP, BEFORE))
        self._spans = [(now, now + gap, now + gap + before) for now in lengths]
        self.size = max(span[-1] for span in self._spans)
        # Every row stands twice, so that the last ones always lie in one piece.
        self._rows = np.zeros((2 * self.size, 1 + CHANGES + NOW + EARLIER, self._joints))
        self._count = 0

    def restart(self) -> None:
        """Forget the past."""
        self._count = 0
        self._sources.restart()

    def take(
        self, time: float, q: Floats, qd: Floats, qdd: Floats, residual: Floats
    ) -> Seen | None:
        """Take a state; return what is seen, None while there are too few.

        Args:
            time: s.  q, qd, qdd: (N,) rad, rad/s, rad/s².  residual: (N,) N·m.
        """
        place = self._count % self.size
        row = np.concatenate([residual[None], self._sources.take(time, q, qd, qdd)])
        self._rows[place] = self._rows[place + self.size] = row
        self._count += 1
        if self._count < self.size:
            return None
        end = place + self.size + 1
        output, shares = [], []
        for now, until, since in self._spans:
            earlier = self._rows[end - since : end - until].mean(axis=0)
            change = self._rows[end - now : end].mean(axis=0) - earlier
            whole = self._rows[end - since : end].mean(axis=0)
            causes = np.concatenate(
                [change[1 : 1 + CHANGES] ** 2, whole[1 + CHANGES : -EARLIER], earlier[-EARLIER:]]
            )
            others = causes.sum(axis=1, keepdims=True) - causes
            output.append(change[0])
            shares.append(np.concatenate([np.ones((1, self._joints)), causes, others]))
        return Seen(np.stack(output), np.stack(shares))


@dataclass(frozen=True)
class Errors:
    """The spread of the filters' outputs that comes from a model's own errors.

    Attributes:
        parts: (F, K, N) the variances of K components.
        least: (F, N) N·m, a tenth of the usual output in the training motion.
        blocks: (B, N) the largest output of each second of the training motion, over what was
            expected.
    """

    parts: Floats
    least: Floats
    blocks: Floats

    @classmethod
    def of(cls, model: Model) -> "Errors":
        """Return those of a model in its own training motion."""
        motion = model.data.take(np.flatnonzero(model.trained)[:MOST])
        residual = motion.tau - model.torque(model.inputs_of(motion))
        step = usual_step(motion.time, motion.segment)
        filters = Filters(model, step)
        rows, seen = [], []
        for k, time in enumerate(motion.time):
            if k and motion.segment[k] != motion.segment[k - 1]:
                filters.restart()
            here = motion.q[k], motion.qd[k], motion.qdd[k]
            found = filters.take(float(time), *here, residual[k])
            if found is not None:
                rows.append(k)
                seen.append(found)
        if not seen:
            none = np.zeros((len(LENGTHS), 0, len(model.joints)))
            return cls(none, none.sum(axis=1), none[0])
        output = np.stack([one.output for one in seen])
        shares = np.stack([one.shares for one in seen])
        parts = np.stack([_components(output[::2, f], shares[::2, f]) for f in range(len(LENGTHS))])
        scale = np.sqrt(np.einsum("mfkn,fkn->mfn", shares, parts))
        largest = (np.abs(output) / scale).max(axis=1)
        starts = starts_of_blocks(motion.time[rows])
        least = 0.1 * np.sqrt(np.mean(output**2, axis=0)) + 1e-9
        return cls(parts, least, np.maximum.reduceat(largest, starts))

    def scale(self, seen: Seen, more: Floats) -> Floats:
        """Return (F, N) N·m that are expected of the outputs at one state.

        Args:
            more: (F, N) N·m, what is there besides, as of noise that training motion did not have.
        """
        learned = np.einsum("fkn,fkn->fn", seen.shares, self.parts)
        return np.asarray(np.sqrt(learned + more**2))


def _components(output: Floats, shares: Floats) -> Floats:
    """Return (K, N) the likeliest variances of the components of outputs (M, N).

    The multiplicative steps are those of Févotte, Bertin and Durrieu 2009, Neural Computation 21.

    Args:
        shares: (M, K, N) what each component may have in the variance of each output.
    """
    mean = np.maximum(shares.mean(axis=0), 1e-100)
    shares, square = shares / mean, output**2
    part = np.maximum(square.mean(axis=0), 1e-24) / len(mean) * np.ones_like(mean)
    for _ in range(STEPS):
        variance = np.einsum("mkn,kn->mn", shares, part)
        more = np.einsum("mn,mkn->kn", square / variance**2, shares)
        less = np.einsum("mn,mkn->kn", 1.0 / variance, shares)
        part = part * more / np.maximum(less, 1e-100)
    return np.asarray(part / mean)
