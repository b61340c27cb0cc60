"""Which joints slide: what may be said, and what the kernels hear of it."""

import numpy as np
import pendulum
import pytest
from mechanism_examples import robot

from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.identification.choosing.search import starting_choice
from lagrangian_ff.identification.sliding import require_sliding, with_sliding
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.kernels import KERNELS, States


@pytest.mark.parametrize("name", ["auto", "chain", "chain_rbf", "energy", "energy_rbf"])
def test_every_kernel_that_may_be_chosen_starts_with_it(name: str) -> None:
    motion = pendulum.motion(4.0)
    spec = with_sliding(parse(f"{name}+fri"), (pendulum.JOINTS[1],), motion, known=False)
    x = States.of(motion.q, motion.qd, motion.qdd)
    for one in spec.alternatives:
        numbers = starting_choice(one, x).kernel.hyperparameters
        np.testing.assert_array_equal(numbers["prismatic"], [0.0, 1.0])


def test_a_kernel_that_has_no_number_for_it_says_so() -> None:
    motion = pendulum.motion(4.0)
    x = States.of(motion.q, motion.qd, motion.qdd)
    for name, kernel in KERNELS.items():
        if "prismatic" in kernel.start(x).hyperparameters:
            require_sliding(parse(name), ("elbow",), known=False)
            continue
        with pytest.raises(ModelError, match=f"the kernel {name} does not tell"):
            require_sliding(parse(name), ("elbow",), known=False)
        require_sliding(parse(name), (), known=True)


def test_a_known_mechanism_says_it_itself() -> None:
    motion = pendulum.motion(4.0)
    with pytest.raises(ModelError, match="prismatic names elbow, but there is a URDF"):
        identify(motion, Settings(prismatic=("elbow",)), mechanism=robot())
