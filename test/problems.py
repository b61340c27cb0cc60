"""Problems of motions as a search begins with them."""

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.samples import Samples
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.kernels import States
from lagrangian_ff.recording.motion import Motion


def problem_of(motion: Motion, name: str = "vrbfs+fri", scaling: Scaling | None = None) -> Problem:
    """Return the problem of a motion, each torque normalised by its own spread by default."""
    samples = Samples(Inputs.of(States.of(motion.q, motion.qd, motion.qdd)), motion.tau)
    return Problem.started(parse(name), samples, scaling or Scaling.of(motion.tau))
