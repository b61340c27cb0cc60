"""Choosing numbers by cross-validation or by evidence, and learning torques with them."""

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrangian_ff.errors import UserError
from lagrangian_ff.studies.learning import learn, model_of
from lagrangian_ff.studies.paper import STAGES, Axis, least
from lagrangian_ff.studies.robots import Scene, draw_samples

ROUGH = Scene(training=100, validation=400, friction=True, noise=0.05)


def test_the_search_finds_the_least_and_ends_on_all_samples() -> None:
    seen = []

    def cost(values: NDArray[np.float64], share: float) -> float:
        seen.append(share)
        return float(np.sum(np.log(values / np.array([20.0, 0.3])) ** 2))

    found = least(cost, [Axis("a", 1.0, 1e-3, 1e3, 1.2), Axis("b", 1.0, 1e-3, 1e3, 1.2)])
    np.testing.assert_allclose(found, [20.0, 0.3], rtol=0.1)
    assert list(dict.fromkeys(seen)) == [share for share, _ in STAGES]
    assert seen[-1] == 1.0


def test_the_search_stays_within_bounds() -> None:
    def cost(values: NDArray[np.float64], share: float) -> float:
        assert 0.5 <= values[0] <= 2.0
        return float(-values[0])

    (found,) = least(cost, [Axis("a", 1.0, 0.5, 2.0, 3.0)])
    assert found == pytest.approx(2.0)


@pytest.mark.parametrize("model", ["srbfs+fri", "vrbfs+fri", "chain+fri"])
def test_friction_is_learned_beside_the_links(model: str) -> None:
    samples = draw_samples(ROUGH, 0, 1, 0)
    spec, free = model_of(model), model_of(model.removesuffix("+fri"))
    errors = [
        np.std(learn(one, samples.x, samples.tau, samples.fold, None).torque(samples.asked)
               - samples.truth)
        for one in (spec, free)
    ]  # fmt: skip
    assert np.std(samples.asked_friction) > 0.3
    assert errors[0] < 0.05
    assert errors[1] > 0.2


def test_joints_choose_apart_where_their_kernels_are_apart() -> None:
    samples = draw_samples(ROUGH, 0, 2, 0)
    for model, count in (("srbfs", 2), ("svrbfs", 1), ("vrbfs", 1)):
        learned = learn(model_of(model), samples.x, samples.tau, samples.fold, None)
        numbers = learned.record()["hyperparameters"]
        assert isinstance(numbers, dict)
        assert len(np.atleast_1d(numbers["sigma"])) == count
        assert numbers["velocity_scale"] == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize("model", ["auto", "none+fri", "vrbfs+stribeck", "vrbfs+viscous"])
def test_other_models_are_refused_with_those_there_are(model: str) -> None:
    with pytest.raises(UserError, match=r"expected one kernel \(rbf, .*, motor\), alone or with"):
        model_of(model)
