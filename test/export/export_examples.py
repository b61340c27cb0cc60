"""Models with given numbers, nothing of them fitted, and C libraries that are built and called."""

import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from sines import sines

from lagrangian_ff.effects import Effect, Over, curve_over
from lagrangian_ff.effects.curve import Axis
from lagrangian_ff.effects.formula import formula_effect
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.predicting import MotionRange
from lagrangian_ff.identification.problem import Prior, Scaling
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.kernels import Kernel, States
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
SANE = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g")

DRIVER = """
#include <stdio.h>
#include "NAME.h"
enum { N = MACRO_JOINTS };
static void give(const NAME_real *values, int count)
{
    for (int n = 0; n < count; ++n) {
        double one = (double)values[n];
        fwrite(&one, sizeof one, 1, stdout);
    }
}
int main(void)
{
    double row[3 * N];
    while (fread(row, sizeof row, 1, stdin) == 1) {
        NAME_real x[3 * N], tau[N], over[N], inside;
        NAME_parts parts;
        for (int n = 0; n < 3 * N; ++n)
            x[n] = (NAME_real)row[n];
        NAME_tau(x, x + N, x + 2 * N, tau);
        NAME_terms(x, x + N, x + 2 * N, &parts);
        NAME_excess(x, x + N, x + 2 * N, over);
        inside = (NAME_real)NAME_in_range(x, x + N, x + 2 * N);
        give(tau, N), give(parts.tau, N), give(parts.gravity, N), give(parts.inertia, N);
        give(parts.coriolis, N), give(over, N), give(&inside, 1);
        give(parts.effect[0], MACRO_EFFECTS * N);
    }
    return 0;
}
"""


def compiler() -> str:
    """The C compiler of this machine; a test without one is skipped."""
    found = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)
    if found is None:
        pytest.skip("there is no C compiler")
    return found


@dataclass(frozen=True)
class Answers:
    """What a library said of M states: (M, N) each, inside (M,), effects (M, E, N)."""

    tau: Floats
    total: Floats
    gravity: Floats
    inertia: Floats
    coriolis: Floats
    over: Floats
    inside: Floats
    effects: Floats


def built(folder: Path, *flags: str) -> Path:
    """A program that answers for an exported library; every warning is an error."""
    name = folder.name
    driver, program = folder.parent / f"{name}_driver.c", folder.parent / f"{name}_driver"
    driver.write_text(DRIVER.replace("NAME", name).replace("MACRO", name.upper()))
    sources = [str(folder / f"{name}.c"), str(driver)]
    command = [compiler(), *STRICT, *flags, f"-I{folder}", *sources, "-o", str(program), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:4000]
    return program


def answered(program: Path, x: States) -> Answers:
    """What a program of `built` says of states."""
    given = np.hstack([x.q, x.qd, x.qdd]).tobytes()
    done = subprocess.run([program], input=given, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()[:4000]
    n = x.joints
    rows = np.frombuffer(done.stdout).reshape(len(x), -1)
    tau, total, gravity, inertia, coriolis, over = (rows[:, k * n : k * n + n] for k in range(6))
    effects = rows[:, 6 * n + 1 :].reshape(len(x), -1, n)
    return Answers(tau, total, gravity, inertia, coriolis, over, rows[:, 6 * n], effects)


def states(count: int, joints: int, seed: int = 0) -> States:
    """Random states."""
    rng = np.random.default_rng(seed)
    size = count, joints
    return States.of(
        rng.uniform(-3, 3, size), 1.5 * rng.normal(size=size), 4 * rng.normal(size=size)
    )


def model_of(
    name: str = "chain+fri",
    joints: int = 3,
    further: Sequence[Term] = (),
    centres: int = 30,
    kernel: Kernel | None = None,
    names: Sequence[str] = (),
) -> Model:
    """A model whose weights and coefficients are drawn, on a motion of sines."""
    rng = np.random.default_rng(7)
    t = np.arange(400) / 100.0
    data_states = States.of(*sines(rng, t, joints, (0.5, 4.0)))
    u = data_states.take(np.linspace(0, len(t) - 1, centres).astype(np.int64))
    spec = parse(name)
    named = (*spec.effects, *(effect for effect, _ in spec.further))
    plain = [Term(effect, n, shape_of(effect)) for effect in named for n in range(joints)]
    basis = Basis((*plain, *further))
    kernel = kernel or spec.kernel.start(u)
    unit = np.linspace(5.0, 9.0, joints)
    weights = rng.normal(size=(centres, joints)) / centres
    made = Model(
        joints=tuple(names) or tuple(f"joint_{n + 1}" for n in range(joints)),
        name=name,
        prior=Prior(kernel, np.full(joints, 1e-3), Scaling(unit, np.ones(joints)), basis),
        centres=u,
        weights=weights,
        coefficients=rng.uniform(0.3, 1.5, basis.size),
        range=MotionRange.of(data_states, np.full((len(t), joints), 40.0)),
        record={},
        data=Motion(
            joints=tuple(f"joint_{n + 1}" for n in range(joints)), time=t, q=data_states.q,
            qd=data_states.qd, qdd=data_states.qdd, tau=np.zeros((len(t), joints)),
            segment=np.zeros(len(t), dtype=np.int64), source="sines",
        ),
        trained=np.ones(len(t), dtype=bool),
        index=np.linspace(0, len(t) - 1, centres).astype(np.int64),
        seen=np.linspace(0, len(t) - 1, centres).astype(np.int64),
    )  # fmt: skip
    measured = made.torque(made.inputs_of(made.data))
    noisy = measured + 0.01 * rng.normal(size=measured.shape) * measured.std(axis=0)
    return replace(made, data=replace(made.data, tau=noisy))


def curves() -> list[Term]:
    """Curves over one and two coordinates, and a formula that reads other joints."""
    rng = np.random.default_rng(3)
    wishes = (
        (curve_over([Over("velocity")]), 0),
        (curve_over([Over("position"), Over("load", 1, "joint_2")], friction=True), 2),
        (curve_over([Over("acceleration", 0, "joint_1")], odd=True), 1),
    )
    terms = []
    for wish, joint in wishes:
        axes = tuple(Axis(tuple(np.sort(rng.uniform(-2, 2, 7)).tolist())) for _ in wish.over)
        count = int(np.prod([axis.count for axis in axes]))
        made = wish.made(axes, np.ones(count, dtype=bool), rng.normal(size=(count, 4)))
        terms.append(Term(made, joint, {}))
    pressed = formula_effect(
        "pressed", "A*sign(qd)*exp(-(q_3/w)^2)+B*load_2*qd_1", {"w": (0.1, 1, 3)}
    )
    return [*terms, Term(pressed, 0, {"w": 0.5})]


def shape_of(effect: Effect) -> dict[str, float]:
    """An effect's shape before any search; a partner is the next joint."""
    found = {one.name: one.start for one in effect.shapes}
    return {**found, "partner": 1.0} if "partner" in found else found


def apart(found: Floats, expected: Floats) -> float:
    """The largest difference, in parts of each joint's largest torque."""
    scale = np.maximum(np.abs(expected).max(axis=0), 1e-300)
    return float(np.max(np.abs(found - expected) / scale))


def rms(values: Floats) -> Floats:
    """The root mean square of (M, N) by joint."""
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
