"""Against peers on the same data in the same run: time to learn, and error on unseen motion.

scikit-learn's kernel ridge and Gaussian process regression (rbf on cosines and sines of positions,
velocities and accelerations, scaled; hyperparameters by its own search), and automatic
differentiation by JAX for forming the Gram matrix of `vrbfs`.

    pip install -e '.[benchmark]'
"""

import argparse
import time
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, WhiteKernel
from sklearn.kernel_ridge import KernelRidge
from sklearn.model_selection import GridSearchCV, GroupKFold
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from timing import medians

from lagrangian_ff.arm import Arm, exciting_trajectory
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.kernels import States, Vrbfs
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

jax.config.update("jax_enable_x64", True)
STEP = 0.01
GRID = {"kernelridge__alpha": [1e-6, 1e-4, 1e-2], "kernelridge__gamma": [1e-3, 1e-2, 1e-1]}


def main() -> None:
    """Learn with each from the first part of a motion, and judge on the rest."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=500)
    parser.add_argument("--share", type=float, default=0.5)
    parser.add_argument("--gram", type=int, default=100, help="samples of the Gram matrix")
    options = parser.parse_args()
    motion = simulated()
    count = int(options.share * len(motion))
    learned = evenly(count, options.samples)
    x, tau = features(motion), motion.tau

    def judged(name: str, learn: Callable[[], Callable[[Floats], Floats]]) -> None:
        began = time.perf_counter()
        predict = learn()
        seconds = time.perf_counter() - began
        error = np.mean((predict(x[count:]) - tau[count:]) ** 2, axis=0)
        nmse = float(np.mean(error / tau[count:].var(axis=0)))
        print(f"{name:45s} {seconds:7.1f} s   nmse {nmse:.4f}")

    groups = (motion.time[learned] / 3.0).astype(int)

    def ridge() -> Callable[[Floats], Floats]:
        pipe = make_pipeline(StandardScaler(), KernelRidge(kernel="rbf"))
        search = GridSearchCV(pipe, GRID, cv=GroupKFold(5))
        return search.fit(x[learned], tau[learned], groups=groups).predict

    def process() -> Callable[[Floats], Floats]:
        kernel = RBF(np.ones(x.shape[1])) + WhiteKernel(1e-2)
        regressor = GaussianProcessRegressor(kernel, normalize_y=True, random_state=0)
        return make_pipeline(StandardScaler(), regressor).fit(x[learned], tau[learned]).predict

    def ours(name: str) -> Callable[[], Callable[[Floats], Floats]]:
        def learn() -> Callable[[Floats], Floats]:
            settings = Settings(model=name, train=options.share, samples=options.samples)
            model = identify(motion, settings).model
            return lambda _: model.predict(motion.q, motion.qd, motion.qdd)[count:]

        return learn

    judged("scikit-learn KernelRidge, blocked search", ridge)
    judged("scikit-learn GaussianProcessRegressor", process)
    judged("lagrangian_ff vrbfs+fri", ours("vrbfs+fri"))
    judged("lagrangian_ff auto+fri", ours("auto+fri"))
    some = motion.take(evenly(len(motion), options.gram))
    by_hand, by_jax = gram_times(States.of(some.q, some.qd, some.qdd))
    print(
        f"Gram matrix of {options.gram} samples: {1e3 * by_hand:.1f} ms, by JAX "
        f"{1e3 * by_jax:.0f} ms, ratio 1/{by_jax / by_hand:.0f}"
    )


def simulated() -> Motion:
    """A minute of the simulated arm, with its true torques and a little noise."""
    t = np.arange(0.0, 60.0, STEP)
    q, qd, qdd = exciting_trajectory(5).sample(t)
    arm = Arm()
    tau = arm.plant.true_torque(q, qd, qdd)
    arm.close()
    tau = tau + 0.02 * tau.std(axis=0) * np.random.default_rng(0).normal(size=tau.shape)
    names = tuple(f"joint_{n + 1}" for n in range(q.shape[1]))
    return Motion(names, t, q, qd, qdd, tau, np.zeros(len(t), dtype=np.int64), "simulated")


def features(motion: Motion) -> Floats:
    """(M, 4 N) what the peers learn from."""
    return np.hstack([np.cos(motion.q), np.sin(motion.q), motion.qd, motion.qdd])


def gram_times(x: States) -> tuple[float, float]:
    """Seconds for the Gram matrix of `vrbfs`: ours, and differentiated automatically."""
    kernel = Vrbfs.start(x)
    alpha = 1.0 / float(kernel.sigma[0])
    w = alpha * float(kernel.velocity_scale[0]) ** 2

    def scalar(q, v, p, u):  # type: ignore[no-untyped-def]
        close = jnp.sum(1.0 - jnp.cos(q - p))
        return jnp.exp(-alpha * close - 0.5 * w * jnp.sum((v - u) ** 2))

    def pushed(f, place):  # type: ignore[no-untyped-def]
        """T of (2): d/dt ∂f/∂v − ∂f/∂q in the arguments at a place, 0 or 2."""

        def operator(a, *arguments):  # type: ignore[no-untyped-def]
            q, v = arguments[place : place + 2]
            momentum = jax.grad(f, argnums=place + 1)

            def along(q, v):  # type: ignore[no-untyped-def]
                return momentum(*arguments[:place], q, v, *arguments[place + 2 :])

            _, rate = jax.jvp(along, (q, v), (v, a))
            return rate - jax.grad(f, argnums=place)(*arguments)

        return operator

    def block(x, u):  # type: ignore[no-untyped-def]
        (q, v, a), (p, s, b) = x, u

        def row(m):  # type: ignore[no-untyped-def]
            return lambda q, v, p, s: pushed(scalar, 2)(b, q, v, p, s)[m]

        return jnp.stack([pushed(row(m), 0)(a, q, v, p, s) for m in range(len(q))], axis=1)

    whole = jax.jit(jax.vmap(jax.vmap(block, (None, 0)), (0, None)))
    states = (x.q, x.qd, x.qdd)
    found = np.asarray(whole(states, states)).transpose(0, 2, 1, 3)
    size = len(x) * x.joints
    lower = np.tril(np.ones((size, size), dtype=bool))
    np.testing.assert_allclose(
        found.reshape(size, size)[lower], kernel.gram(x)[lower], atol=1e-9 * abs(found).max()
    )
    ours, theirs = medians(
        [lambda: kernel.gram(x), lambda: whole(states, states).block_until_ready()], 3
    )
    return float(ours), float(theirs)


if __name__ == "__main__":
    main()
