"""Parameters with their shapes held."""

import numpy as np
import two_rods
from whitened_examples import friction, quickly, whitened_of

from lagrangian_ff.diagnosis.search.fitted import Fitted
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification.basis import Basis, Term


def test_a_shape_that_the_motion_does_not_show_is_held_as_it_is() -> None:
    over = Term(EFFECTS["contact"], 1, {"t0": 99.0, "length": 1.0})  # after the end
    bump = Term(EFFECTS["stribeck"], 1, {"v_s": 0.15})
    with quickly(600):
        whitened = whitened_of(
            two_rods.motion(1, 20.0, two_rods.stick), Basis((*friction().terms, bump, over))
        )
    fitted = Fitted.of(whitened)
    both, one = fitted.holding((bump, over)), fitted.holding((bump,))
    np.testing.assert_allclose(both.values, one.values)
    assert np.isfinite(both.covariance).all()
