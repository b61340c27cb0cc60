"""A look at all motions so far: a model of them, and what that lacks."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from lagrangian_ff.diagnosis import apply, diagnose, with_consequences
from lagrangian_ff.diagnosis.results import Diagnosis
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.identification.settings import usual_model
from lagrangian_ff.investigation.motions import Named
from lagrangian_ff.investigation.stretches import closely, learned_and_unseen
from lagrangian_ff.kernels.threads import one_blas_thread
from lagrangian_ff.recording import Conditioning, Motion, Recording, condition_alike


@dataclass(frozen=True)
class Look:
    """A model of all motions so far, and what it lacks.

    Attributes:
        base: the model that was diagnosed.  diagnosis: of that model.
        model: `base` with what is confirmed.
        stretches: of motion that was learned from.
        used: s of motion so far.
        answer: to the question before it, in words.
        made: the models that motions were designed with; `for_design` fits none of them twice.
    """

    base: Model
    diagnosis: Diagnosis
    model: Model
    stretches: int
    used: float = 0.0
    answer: str = ""
    made: dict[tuple[Named, ...], Model] = field(default_factory=dict)

    @property
    def found(self) -> tuple[Term, ...]:
        """Return the effects that were confirmed."""
        return self.model.basis.terms[len(self.base.basis.terms) :]

    @property
    def confirmed(self) -> tuple[str, ...]:
        """Return their names."""
        return tuple(one.name for one, _ in self.diagnosis.tried)


class Looking:
    """The recordings of an investigation, and how they are looked at.

    Args:
        joints: names of those that are investigated.
        model: to identify; empty for the usual one.
        conditioning: of the recordings; a lag of all torques that is found is set right in it.
        say: receives what is done.

    Attributes:
        recordings: of all motions so far.
    """

    def __init__(
        self,
        joints: Sequence[str],
        model: str,
        conditioning: Conditioning,
        say: Callable[[str], None],
    ) -> None:
        self.recordings: list[Recording] = []
        self._joints, self._conditioning, self._say = joints, conditioning, say
        self._model = model or usual_model(conditioning.effort)

    def parts(self) -> tuple[list[Motion], list[Motion]]:
        """Return what is learned from and searched of each motion, and what is not."""
        motions = condition_alike(self.recordings, self._conditioning)
        return learned_and_unseen([motion.select(self._joints) for motion in motions])

    def look(self, known: Sequence[Term], seen: int) -> Look:
        """Return a look at all recordings.

        Args:
            known: what is taken to be there, unless these motions are against it.
            seen: stretches that an earlier look has seen.

        Raises:
            UserError: a recording cannot be read as motion.
        """
        base, found, count = self._diagnosed(known, seen)
        if (lag := found.lag) is not None:
            self._conditioning = lag.applied(self._conditioning)
            base, found, count = self._diagnosed(known, seen)
            found = replace(found, lag=lag)
        with one_blas_thread():
            found = with_consequences(found, confirmed_only=True)
        return Look(base, found, apply(found), count)

    def _diagnosed(self, known: Sequence[Term], seen: int) -> tuple[Model, Diagnosis, int]:
        """Return a model of what is learned from, what it lacks, and the count of its stretches.

        Stretches that no look has seen are looked at closely: they would drown in all that came
        before.
        """
        learned, unseen = self.parts()
        self._say("identifying a model")
        base = identify(learned, Settings(model=self._model, train=1.0)).model
        self._say("looking for what is missing")
        first, second = ([*some[:seen], *map(closely, some[seen:])] for some in (learned, unseen))
        with one_blas_thread():
            return base, diagnose(base, first, second, known=known), len(learned)
