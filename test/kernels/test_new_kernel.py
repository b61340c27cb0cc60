"""A new kernel costs its class, with one method, and one line in the list."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pendulum
import pytest
from numpy.typing import NDArray
from test_kernel_list import random_states

from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.kernels import (
    KERNELS,
    CoupledKernel,
    Hyperparameter,
    IndependentKernel,
    Kernel,
    States,
)

Floats = NDArray[np.float64]

FEW = Settings(samples=100, evaluations=12, train=0.5)
WIDTH = Hyperparameter("width", "1", "squared length scale of positions", 1e-2, 1e2)


def similarity(x: States, u: States, width: float) -> Floats:
    """Return (M_x, M_u), linear in accelerations and smooth in positions."""
    apart = x.q[:, None] - u.q[None]
    return np.asarray((1.0 + x.qdd @ u.qdd.T) * np.exp(-np.sum(apart**2, axis=2) / width))


@dataclass(frozen=True)
class ToyCoupled(CoupledKernel):
    """Joints that share half of their torque."""

    width: Floats

    name = "toy_coupled"
    meaning = "a toy that couples joints"
    searched: ClassVar[tuple[Hyperparameter, ...]] = (WIDTH,)

    def cross(self, x: States, u: States) -> Floats:
        shared = 0.5 + 0.5 * np.eye(x.joints)
        return np.asarray(np.kron(similarity(x, u, self.width[0]), shared), dtype=np.float64)


@dataclass(frozen=True)
class ToyIndependent(IndependentKernel):
    """Joints that share nothing."""

    width: Floats

    name = "toy_independent"
    meaning = "a toy of joints apart"
    searched: ClassVar[tuple[Hyperparameter, ...]] = (WIDTH,)

    def cross(self, x: States, u: States, joint: int) -> Floats:
        return similarity(x, u, self.width[joint if len(self.width) > 1 else 0])


@pytest.mark.parametrize("toy", [ToyCoupled, ToyIndependent])
def test_a_kernel_of_one_method_is_identified_by_its_name(
    toy: type[Kernel], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(KERNELS, toy.name, toy)
    found = identify(pendulum.motion(12.0, noise=0.02), replace(FEW, model=f"{toy.name}+fri"))
    assert found.record["model"] == f"{toy.name}+fri"
    assert isinstance(found.model.kernel, toy)
    fresh = pendulum.motion(6.0, seed=0)
    error = fresh.tau - found.model.predict(fresh.q, fresh.qd, fresh.qdd)
    assert (error.std(axis=0) / fresh.tau.std(axis=0)).max() < 0.3
    found.model.save(tmp_path / "toy.npz")
    again = Model.load(tmp_path / "toy.npz")
    np.testing.assert_array_equal(
        again.predict(fresh.q, fresh.qd, fresh.qdd),
        found.model.predict(fresh.q, fresh.qd, fresh.qdd),
    )


@pytest.mark.parametrize("toy", [ToyCoupled, ToyIndependent])
def test_what_a_kernel_leaves_out_follows_from_its_one_method(toy: type[Kernel]) -> None:
    x, u = random_states(40, 3, 1), random_states(5, 3, 2)
    kernel = toy.start(x)
    assert {name: value.tolist() for name, value in kernel.hyperparameters.items()} == {
        "width": [1.0]
    }
    wide = kernel.replace(width=np.array([4.0]))
    a = np.random.default_rng(3).normal(size=(5, 3))
    share = np.eye(3) if toy is ToyIndependent else 0.5 + 0.5 * np.eye(3)
    expected = similarity(x, u, 4.0) @ a @ share
    np.testing.assert_allclose(wide.apply(x, u, a), expected, rtol=1e-9)
    np.testing.assert_allclose(wide.learned(u, a).torque(x), expected, rtol=1e-9)
    own = np.repeat(1.0 + np.sum(x.qdd**2, axis=1)[:, None], 3, axis=1)
    np.testing.assert_allclose(wide.variance(x), own, rtol=1e-9)
