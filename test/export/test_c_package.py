"""The exported C library: what it computes, how it is built, and what is refused."""

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from export_examples import (
    SANE,
    STRICT,
    answered,
    apart,
    built,
    compiler,
    curves,
    model_of,
    shape_of,
    states,
)

from lagrangian_ff.effects import EFFECTS, Over, curve_over
from lagrangian_ff.effects.curve import Axis, Curve
from lagrangian_ff.effects.formula import formula_effect
from lagrangian_ff.errors import ExportError
from lagrangian_ff.export import FORMATS, Options, write
from lagrangian_ff.export.effects import CATALOGUE
from lagrangian_ff.export.rigid import Trigonometric, forms_of
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.kernels import KERNELS
from lagrangian_ff.kernels.rigid import read_urdf

ROUNDING = 1e-12
IN_MOTORS = 1e-11  # the kernel's own sum over samples rounds more than the two numbers it comes to
FLOAT32 = 1e-4


def library(model: Model, tmp_path: Path, name: str = "arm", *, settled: bool = False) -> Path:
    write(model, "c", tmp_path / name, Options(settled=settled))
    return tmp_path / name


def test_ten_thousand_states_of_the_default_model_are_those_of_python(tmp_path: Path) -> None:
    """Optimised, and with the sanitizers of addresses and undefined behaviour."""
    model = model_of("chain+fri", joints=6)
    folder, x = library(model, tmp_path), states(10_000, 6)
    expected = model.predict(x.q, x.qd, x.qdd)
    assert apart(answered(built(folder, "-O2"), x).tau, expected) < ROUNDING
    some = x.take(slice(0, 500))
    assert apart(answered(built(folder, "-O0", *SANE), some).tau, expected[:500]) < ROUNDING


@pytest.mark.parametrize("name", KERNELS)
def test_every_kernel_and_its_parts_are_those_of_python(name: str, tmp_path: Path) -> None:
    model, x = model_of(f"{name}+fri"), states(300, 3)
    found = answered(built(library(model, tmp_path), "-O0", *SANE), x)
    expected = model.terms(x.q, x.qd, x.qdd)
    allowed = IN_MOTORS if name == "motor" else ROUNDING
    total = model.predict(x.q, x.qd, x.qdd)
    scale = np.abs(total).max(axis=0)
    for part, other in (
        (found.tau, total), (found.total, total), (found.gravity, expected.gravity),
        (found.inertia, expected.inertia), (found.coriolis, expected.coriolis),
    ):  # fmt: skip
        assert np.max(np.abs(part - other) / scale) < allowed
    for place, effect in enumerate(expected.effects.values()):
        assert apart(found.effects[:, place], effect) < ROUNDING


@pytest.mark.parametrize("joints", [1, 2, 7, 8])
def test_chains_of_few_and_many_joints(joints: int, tmp_path: Path) -> None:
    model, x = model_of("chain+fri", joints, centres=15), states(50, joints)
    (form,) = forms_of(model.kernel, model.centres, model.weights)
    assert isinstance(form, Trigonometric) == (joints <= 7)
    found = answered(built(library(model, tmp_path), "-O0"), x)
    assert apart(found.tau, model.predict(x.q, x.qd, x.qdd)) < ROUNDING


def test_a_joint_that_slides(tmp_path: Path) -> None:
    model, x = model_of("chain+fri"), states(50, 3)
    sliding = model.kernel.replace(prismatic=np.array([1.0, 0.0, 0.0]))
    model = replace(model, prior=replace(model.prior, kernel=sliding))
    found = answered(built(library(model, tmp_path), "-O0", *SANE), x)
    assert apart(found.tau, model.predict(x.q, x.qd, x.qdd)) < ROUNDING


def test_known_bodies_are_exported_as_bodies(tmp_path: Path) -> None:
    pytest.importorskip("pinocchio", reason="reading a URDF needs Pinocchio")
    robot = read_urdf(Path(__file__).parents[2] / "lagrangian_ff" / "arm" / "arm6.urdf")
    blind = model_of("chain+fri", joints=6)
    known = robot.of_joints(robot.movable[:6], "test")
    kernel = known.around(KERNELS["chain"]).start(blind.centres)
    model, x = replace(blind, prior=replace(blind.prior, kernel=kernel)), states(200, 6)
    found = answered(built(library(model, tmp_path), "-O0", *SANE), x)
    assert apart(found.tau, model.predict(x.q, x.qd, x.qdd)) < ROUNDING


def test_every_effect_is_exported_and_equal_or_refused_with_a_reason(tmp_path: Path) -> None:
    """All that can be exported stand in one model, each on the middle joint."""
    assert set(CATALOGUE) == set(EFFECTS)
    exportable = [name for name, one in CATALOGUE.items() if not one.refused]
    terms = [Term(EFFECTS[name], 0, shape_of(EFFECTS[name])) for name in exportable]
    model, x = model_of("vrbfs", further=terms), states(400, 3)
    folder = library(model, tmp_path)
    found = answered(built(folder, "-O0", *SANE), x)
    expected = model.terms(x.q, x.qd, x.qdd).effects
    assert list(expected) == exportable
    for place, (name, torque) in enumerate(expected.items()):
        # A part with a torque in it may be larger than its effect: the load is the scale then.
        scale = np.maximum(np.abs(torque).max(axis=0), np.abs(found.tau).max(axis=0))
        assert np.max(np.abs(found.effects[:, place] - torque) / scale) < ROUNDING, name
    assert apart(found.tau, model.predict(x.q, x.qd, x.qdd)) < ROUNDING
    for name in set(CATALOGUE) - set(exportable):
        term = Term(EFFECTS[name], 0, shape_of(EFFECTS[name]))
        with pytest.raises(ExportError, match=rf"{name}: it .*--settled"):
            write(model_of("chain+fri", further=[term]), "c", tmp_path / "other")


@pytest.mark.parametrize("flags", [("-O2",), ("-O0", *SANE)])
def test_curves_and_formulas_of_other_joints_are_those_of_python(
    flags: tuple[str, ...], tmp_path: Path
) -> None:
    """Within what was seen, beyond it, and where a curve has faded."""
    model, x = model_of("chain+fri", further=curves()), states(10_000, 3)
    found = answered(built(library(model, tmp_path), *flags), x)
    assert apart(found.tau, model.predict(x.q, x.qd, x.qdd)) < ROUNDING
    expected = model.terms(x.q, x.qd, x.qdd).effects
    for place, torque in enumerate(expected.values()):
        assert apart(found.effects[:, place], torque) < ROUNDING
    (after,) = (t for t in model.basis.terms if t.effect.name == "curve_velocity")
    assert isinstance(after.effect, Curve)
    outside = after.effect.outside(model.inputs(x.q, x.qd, x.qdd), 0)
    assert 0.1 < np.mean(outside) < 0.9


def test_a_curve_that_depends_on_the_past_is_refused(tmp_path: Path) -> None:
    wish = curve_over([Over("reversal")], friction=True)
    made = wish.made((Axis((0.0, 0.5, 1.0)),), np.ones(5, dtype=bool), np.eye(5))
    with pytest.raises(ExportError, match="depends on the past"):
        write(model_of("chain", further=[Term(made, 0, {})]), "c", tmp_path / "other")


def test_settled_effects_are_left_as_python_has_them_without_time(tmp_path: Path) -> None:
    names = [name for name, one in CATALOGUE.items() if one.refused]
    terms = [Term(EFFECTS[name], 1, shape_of(EFFECTS[name])) for name in names]
    model, x = model_of("chain+fri", further=terms), states(100, 3)
    written = write(model, "c", tmp_path / "arm", Options(settled=True))
    found = answered(built(tmp_path / "arm", "-O1"), x)
    assert apart(found.tau, model.predict(x.q, x.qd, x.qdd)) < ROUNDING
    assert [loss.what.split(",")[0] for loss in written.losses] == names
    lost = {loss.what.split(",")[0]: loss.rms[1] for loss in written.losses}
    assert lost["drift"] > 0.1
    assert lost["payload"] >= 0.0
    assert written.difference[1] > 0.0
    assert written.difference[0] == pytest.approx(0.0, abs=1e-12)


def test_formulas_of_users_are_exported(tmp_path: Path) -> None:
    formulas = {
        "bump": ("A*exp(-(q/w)^2) - 2*B*sin(q)/pi + A*qd", {"w": (0.1, 1.0)}),
        "odd": ("-C*sign(qd)*abs(qd)^0.4 + (D + 3)*sqrt(abs(load))*0 + D*2^q*-atan(qdd)", {}),
    }
    terms = [
        Term(effect, 1, {one.name: one.start for one in effect.shapes})
        for effect in (formula_effect(n, f, shapes) for n, (f, shapes) in formulas.items())
    ]
    model, x = model_of("chain+fri", further=terms), states(200, 3)
    found = answered(built(library(model, tmp_path), "-O0", *SANE), x)
    terms_expected = model.basis.torque(model.inputs(x.q, x.qd, x.qdd), model.coefficients)
    for place, torque in enumerate(terms_expected.values()):
        assert apart(found.effects[:, place], torque) < ROUNDING


def test_effects_in_python_are_refused_by_name(tmp_path: Path) -> None:
    mine = type("Mine", (type(EFFECTS["viscous"]),), {"name": "mine"})()
    model = model_of("chain+fri", further=[Term(mine, 0, {})])
    with pytest.raises(ExportError, match=r"mine is Python code.*formula"):
        write(model, "c", tmp_path / "arm")


def test_range_and_limits_are_the_models(tmp_path: Path) -> None:
    model = model_of("chain+fri")
    x = states(500, 3)
    far = np.array([[9.0, 0.0, 0.0], [0.0, np.nan, 0.0]])
    x = type(x).of(np.vstack([x.q, far, 0.0 * far[:1]]), *(np.vstack([v, np.zeros((3, 3))])
                   for v in (x.qd, x.qdd)))  # fmt: skip
    found = answered(built(library(model, tmp_path), "-O0", *SANE), x)
    expected = model.range.excess(x)
    np.testing.assert_allclose(found.over[:501], expected[:501], rtol=1e-12)
    assert np.isinf(found.over[501, 1])
    inside = np.all(expected <= 0.0, axis=1).astype(np.float64)
    np.testing.assert_array_equal(found.inside[:501], inside[:501])
    assert found.inside[501] == 0.0
    assert found.inside[502] == 1.0


LIMIT = """
#include <math.h>
#include "arm.h"
int main(void)
{
    arm_real tau[3] = {1e9, -1e9, NAN}, fine[3] = {1.0, -1.0, 0.0};
    int ok = arm_limit(tau) == 3 && tau[0] == arm_tau_max[0] && tau[1] == -arm_tau_max[1];
    ok = ok && tau[2] == 0.0 && arm_limit(fine) == 0 && fine[0] == 1.0 && fine[1] == -1.0;
    return ok ? 0 : 1;
}
"""


def test_torques_are_limited(tmp_path: Path) -> None:
    folder = library(model_of("chain+fri"), tmp_path)
    (tmp_path / "limit.c").write_text(LIMIT)
    program = tmp_path / "limit"
    command = [compiler(), *STRICT, *SANE, f"-I{folder}", str(folder / "arm.c")]
    subprocess.run([*command, str(tmp_path / "limit.c"), "-o", program, "-lm"], check=True)
    assert subprocess.run([program], check=False).returncode == 0


def test_numbers_of_32_bits_cost_what_is_stated(tmp_path: Path) -> None:
    model, x = model_of("chain+stribeck+fri", joints=6), states(2000, 6)
    found = answered(built(library(model, tmp_path), "-O2", "-DARM_FLOAT32"), x)
    off = apart(found.tau, model.predict(x.q, x.qd, x.qdd))
    assert 1e-9 < off < FLOAT32


def test_names_of_joints_cannot_break_the_source(tmp_path: Path) -> None:
    names = ['a"; */ int main', "ü\\n", "??/ %s"]
    model, x = model_of("chain+fri", names=names), states(5, 3)
    found = answered(built(library(model, tmp_path), "-O0"), x)
    assert apart(found.tau, model.predict(x.q, x.qd, x.qdd)) < ROUNDING


def test_the_header_is_one_of_cpp_as_well(tmp_path: Path) -> None:
    cpp = shutil.which("c++") or shutil.which("g++")
    if cpp is None:
        pytest.skip("there is no C++ compiler")
    header = library(model_of("none+fri"), tmp_path) / "arm.h"
    run(cpp, "-std=c++17", *STRICT[1:], "-fsyntax-only", "-x", "c++", header)


@pytest.mark.parametrize("name", ["Arm", "int", "a-b", "1st", "arm.json"])
def test_a_name_that_c_does_not_take_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="cannot be the name of a C library"):
        write(model_of(), "c", tmp_path / name)
    assert not (tmp_path / name).exists()


USER = """\
cmake_minimum_required(VERSION 3.16)
project(user C)
find_package(arm 1.0 REQUIRED)
add_executable(user check.c)
target_link_libraries(user PRIVATE arm::arm)
"""


def run(*command: str | Path) -> str:
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_it_is_found_by_cmake_and_by_pkg_config_where_it_is_installed(tmp_path: Path) -> None:
    if shutil.which("cmake") is None:
        pytest.skip("CMake is not installed")
    compiler()
    folder, build, prefix = library(model_of(), tmp_path), tmp_path / "build", tmp_path / "prefix"
    run("cmake", "-S", folder, "-B", build, f"-DCMAKE_INSTALL_PREFIX={prefix}",
        "-DCMAKE_INSTALL_LIBDIR=lib")  # fmt: skip
    run("cmake", "--build", build)
    assert "largest" in run(build / "arm_check")
    run("cmake", "--install", build)
    user = tmp_path / "user"
    user.mkdir()
    (user / "CMakeLists.txt").write_text(USER)
    shutil.copy(folder / "check.c", user)
    run("cmake", "-S", user, "-B", user / "build", f"-DCMAKE_PREFIX_PATH={prefix}")
    run("cmake", "--build", user / "build")
    assert "largest" in run(user / "build" / "user")
    if shutil.which("pkg-config") is None:
        pytest.skip("pkg-config is not installed; CMake finds the library")
    found = {"PKG_CONFIG_PATH": str(prefix / "lib" / "pkgconfig"), "PATH": "/usr/bin:/bin"}
    flags = subprocess.run(
        ["pkg-config", "--cflags", "--libs", "arm"], env=found, capture_output=True, text=True,
        check=True,
    ).stdout.split()  # fmt: skip
    run(compiler(), user / "check.c", *flags, "-o", tmp_path / "linked")
    assert "largest" in run(tmp_path / "linked")


def test_an_unknown_format_names_those_there_are(tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="there are c, json"):
        write(model_of(), "matlab", tmp_path / "arm")
    assert list(FORMATS)[:2] == ["c", "json"]
