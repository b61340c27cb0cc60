"""Names of models, and joints that are said to slide."""

import numpy as np
import pendulum
import pytest
from mechanism_examples import robot

from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.samples import Samples
from lagrangian_ff.identification.spec import parse, require_sliding, with_sliding
from lagrangian_ff.kernels import KERNELS, States


def test_a_kernel_and_a_group() -> None:
    spec = parse("vrbfs+fri")
    assert spec.kernel.name == "vrbfs"
    assert [e.name for e in spec.effects] == ["viscous", "coulomb", "offset"]


def test_effects_may_stand_alone_and_anywhere() -> None:
    assert parse("fri").kernel.name == "none"
    assert parse("coulomb + rbf").kernel.name == "rbf"


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("vrbsf+fri", "neither a kernel"),
        ("", "neither a kernel"),
        ("vrbfs+rbf", "both kernels"),
        ("vrbfs+fri+viscous", "viscous stands in it twice"),
        ("vrbfs+fri+viscous@joint_2", "viscous stands in it twice"),
    ],
)
def test_what_cannot_be_is_refused_with_the_reason(name: str, said: str) -> None:
    with pytest.raises(ModelError, match=said):
        parse(name)


@pytest.mark.parametrize("name", ["auto", "chain", "chain_rbf", "energy", "energy_rbf"])
def test_every_kernel_that_may_be_chosen_starts_with_it(name: str) -> None:
    motion = pendulum.motion(4.0)
    spec = with_sliding(parse(f"{name}+fri"), (pendulum.JOINTS[1],), motion, known=False)
    x = Inputs.of(States.of(motion.q, motion.qd, motion.qdd))
    samples, scaling = Samples(x, motion.tau), Scaling.of(motion.tau)
    for one in spec.alternatives:
        numbers = Problem.started(one, samples, scaling).kernel.hyperparameters
        np.testing.assert_array_equal(numbers["prismatic"], [0.0, 1.0])


def test_a_kernel_that_has_no_number_for_it_says_so() -> None:
    motion = pendulum.motion(4.0)
    x = States.of(motion.q, motion.qd, motion.qdd)
    for name, kernel in KERNELS.items():
        if "prismatic" in kernel.start(x).hyperparameters:
            require_sliding(parse(name), ("elbow",), known=False)
            continue
        with pytest.raises(ModelError, match=f"the kernel {name} does not distinguish"):
            require_sliding(parse(name), ("elbow",), known=False)
        require_sliding(parse(name), (), known=True)


def test_a_known_mechanism_says_it_itself() -> None:
    motion = pendulum.motion(4.0)
    with pytest.raises(ModelError, match="prismatic names elbow, but there is a URDF"):
        identify(motion, Settings(prismatic=("elbow",)), mechanism=robot())
