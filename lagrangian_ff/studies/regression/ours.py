"""Learning as identification does: hyperparameters climb the evidence, and (44) is solved."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.choice import Choice, Scaling
from lagrangian_ff.identification.choosing.choose import choose_all
from lagrangian_ff.identification.choosing.training import TrainingSet
from lagrangian_ff.identification.records import hyperparameter_record
from lagrangian_ff.identification.solving.equations import fit
from lagrangian_ff.identification.solving.fit import Fit
from lagrangian_ff.identification.solving.solution import with_least_noise
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.kernels import States
from lagrangian_ff.studies.regression.relaxed import plain

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Exact:
    """Torques by (44) that were learned.

    Attributes:
        spec: of the model.  fitted: on which samples and with what.
        raised: what the noise was multiplied by, so that there was a Cholesky factor.
    """

    spec: Spec
    fitted: Fit[System]
    raised: float

    @classmethod
    def learned(cls, spec: Spec, choice: Choice, x: States, tau: Floats) -> "Exact":
        """Learn the torques tau (M, N) of states x (M, N).

        Raises:
            NotPositiveDefiniteError: even with much more noise there is no factor.
        """

        def fitted(raised: float) -> Fit[System]:
            stronger = replace(choice, noise=choice.noise * raised)
            return fit(spec, stronger, x, tau, _alike(x.joints))

        return cls(spec, *with_least_noise(fitted))

    def torque(self, x: States) -> Floats:
        """(V, N) predicted, in the unit of those learned from."""
        return self.fitted.torque(Inputs.of(x))

    def without_friction(self, tau: Floats) -> "Exact":
        """The same without the effects, learned from torques tau (M, N) that have no friction."""
        alone = replace(self.spec, effects=())
        choice = replace(self.fitted.choice, shapes={})
        return Exact.learned(alone, choice, self.fitted.states, tau)

    def record(self) -> dict[str, object]:
        """The numbers it was learned with, as JSON holds them."""
        held = hyperparameter_record(self.fitted.choice, self.fitted.basis, len(self.fitted.states))
        del held["gamma"]
        gamma = self.fitted.choice.noise / (self.raised * len(self.fitted.states))
        return {"hyperparameters": held, "gamma": plain(gamma), "gamma_raised": self.raised}


def learn_by_evidence(spec: Spec, x: States, tau: Floats, fold: Ints, gamma: float | None) -> Exact:
    """Learn with a kernel whose evidence can be climbed, from no tuning; see `choose_all`.

    Args:
        spec: a kernel and effects.
        x: (M, N) states.  tau: (M, N) torques.
        fold: (M,) of each sample; the evidence needs none left out.
        gamma: γ of (42) that the torques are learned with, raised tenfold as often as it takes to
            factor; None takes the noise that the evidence says.

    Raises:
        ModelError: no start has a factor.
        NotPositiveDefiniteError: what was chosen has none on all samples.
    """
    data = TrainingSet(Inputs.of(x), tau, fold)
    choice = choose_all(spec, data, [_alike(x.joints)], "evidence").choice
    if gamma is not None:
        choice = replace(choice, noise=np.full(x.joints, gamma * len(x)))
    return Exact.learned(spec, choice, x, tau)


def _alike(joints: int) -> Scaling:
    """Torques as they are, of all joints alike."""
    return Scaling(np.ones(joints), np.ones(joints))
