"""The exported C library: a state's torque, beside Pinocchio's recursive Newton-Euler algorithm.

For `chain+fri`, 6 joints, 500 samples: the library as its CMake package builds it (-O3), for
numbers of 64 and of 32 bits, and its torque in parts. Bound: 15 µs a state. Pinocchio's algorithm
knows the arm's 60 inertial parameters, and is called from Python, whose call is timed alone, too.
The other kernels are sums over their samples; their times are those that docs/export.md states, as
is that of `chain+fri` with a curve over position and velocity on every joint. Prints the largest
difference from Python in parts of each joint's largest torque, as well.
"""

import argparse
import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from timing import medians, moving

from lagrangian_ff.effects import Over, curve_over
from lagrangian_ff.effects.curve import Axis
from lagrangian_ff.export import write
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]
BOUND = 15.0  # µs
JOINTS, SAMPLES, STATES = 6, 500, 500
BENDS = 15  # of a curve, along each coordinate
OTHERS = ("vrbfs+fri", "rbfs+fri", "energy+fri", "chain_rbf+fri", "srbfs+fri", "pol+fri")
MANY = """
#include "arm.h"
void many(int count, const arm_real *x, arm_real *tau)
{
    for (int i = 0; i < count; ++i, x += 3 * ARM_JOINTS)
        arm_tau(x, x + ARM_JOINTS, x + 2 * ARM_JOINTS, tau + i * ARM_JOINTS);
}
void terms(int count, const arm_real *x, arm_real *tau)
{
    arm_parts parts;
    for (int i = 0; i < count; ++i, x += 3 * ARM_JOINTS) {
        arm_terms(x, x + ARM_JOINTS, x + 2 * ARM_JOINTS, &parts);
        tau[i] = parts.gravity[0];
    }
}
"""


def main() -> None:
    """Measure the library and, where it is installed, Pinocchio."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=15)
    options = parser.parse_args()
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        print("skipped: there is no C compiler")
        return
    pinocchio_alone(options.repeats)
    for model in models():
        with tempfile.TemporaryDirectory() as folder:
            write(model, "c", Path(folder) / "arm")
            measure(model, Path(folder), compiler, options.repeats)


def models() -> Iterator[Model]:
    """Yield the models to measure."""
    chain = learned("chain+fri")
    yield chain
    yield with_curves(chain)
    yield from map(learned, OTHERS)


def with_curves(model: Model) -> Model:
    """Return a model with a curve on every joint, whose heights are drawn."""
    axis = Axis(tuple(np.linspace(-2.0, 2.0, BENDS).tolist()))
    heights = np.random.default_rng(0).normal(size=(axis.count**2, 1))
    curve = curve_over([Over("position"), Over("velocity")])
    curve = curve.made((axis, axis), np.ones(axis.count**2, dtype=bool), heights)
    terms = (*model.basis.terms, *(Term(curve, n, {}) for n in range(JOINTS)))
    prior = replace(model.prior, basis=replace(model.basis, terms=terms))
    coefficients = np.append(model.coefficients, np.ones(JOINTS))
    return replace(model, name=f"{model.name}+curves", prior=prior, coefficients=coefficients)


def learned(name: str) -> Model:
    """Return a model of an arm that moves, its hyperparameters not searched."""
    time = np.arange(0.0, 30.0, 0.01)
    q, qd, qdd, tau = moving(np.random.default_rng(0), time, JOINTS)
    names = tuple(f"joint_{n + 1}" for n in range(JOINTS))
    motion = Motion(names, time, q, qd, qdd, tau, np.zeros(len(time), dtype=np.int64), "benchmark")
    return identify(motion, Settings(model=name, train=1.0, samples=SAMPLES, evaluations=1)).model


def measure(model: Model, folder: Path, compiler: str, repeats: int) -> None:
    """Print the times of a model's library."""
    (folder / "many.c").write_text(MANY)
    bounded = f" (bound {BOUND:g})" if model.name.startswith("chain+") else ""
    for kind, flag in ((np.float64, ()), (np.float32, ("-DARM_FLOAT32",))):
        made = folder / f"{np.dtype(kind).name}.so"
        sources = [folder / "many.c", folder / "arm" / "arm.c"]
        flags = ["-std=c99", "-O3", "-DNDEBUG", "-shared", "-fPIC", f"-I{folder / 'arm'}", *flag]
        subprocess.run([compiler, *flags, *sources, "-o", made, "-lm"], check=True)
        library = ctypes.CDLL(str(made))
        some = np.linspace(0, len(model.data) - 1, STATES).astype(np.int64)
        q, qd, qdd = (getattr(model.data, one)[some] for one in ("q", "qd", "qdd"))
        x = np.ascontiguousarray(np.hstack([q, qd, qdd]), dtype=kind)
        tau = np.empty((STATES, JOINTS), dtype=kind)
        given = STATES, ctypes.c_void_p(x.ctypes.data), ctypes.c_void_p(tau.ctypes.data)
        works = [partial(library.terms, *given), partial(library.many, *given)]
        parts, whole = medians(works, repeats)
        expected = model.predict(q, qd, qdd)
        off = np.max(np.abs(tau - expected) / np.abs(expected).max(axis=0))
        print(
            f"{model.name}, {np.dtype(kind).name}: {1e6 * whole / STATES:.1f} µs a state{bounded}, "
            f"{1e6 * parts / STATES:.1f} in parts; differs from Python by {off:.1e}"
        )


def pinocchio_alone(repeats: int) -> None:
    """Print the time of Pinocchio's algorithm for the simulated arm."""
    try:
        import pinocchio
    except ImportError:
        print("Pinocchio is not installed: nothing to compare with")
        return
    urdf = Path(__file__).resolve().parents[1] / "lagrangian_ff" / "arm" / "arm6.urdf"
    built = pinocchio.buildModelFromUrdf(str(urdf))
    data, state = built.createData(), (0.3 * np.ones(JOINTS),) * 3

    def algorithm() -> None:
        for _ in range(STATES):
            pinocchio.rnea(built, data, *state)

    def call() -> None:
        for _ in range(STATES):
            pinocchio.neutral(built)

    whole, alone = medians([algorithm, call], repeats)
    print(
        f"Pinocchio's RNEA of 6 joints from Python: {1e6 * whole / STATES:.1f} µs a state; a call "
        f"that does next to nothing: {1e6 * alone / STATES:.1f}"
    )


if __name__ == "__main__":
    main()
