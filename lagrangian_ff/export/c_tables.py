"""The numbers of a form as C tables, and the code that computes its torque from them."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.resources import files

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects.curve import FADES
from lagrangian_ff.errors import ExportError
from lagrangian_ff.export.curves import PortableCurve
from lagrangian_ff.export.rigid import (
    Bodies,
    Form,
    JointRbf,
    LagrangianRbf,
    Mechanical,
    Motors,
    PolSum,
    StateRbf,
    Trigonometric,
)
from lagrangian_ff.kernels.structured.chain import LONG, SHORT

LANES = 8
"""Centres that the loops of `mechanical` work on side by side."""
A_LINE = 4
"""Numbers on a line."""


def table(name: str, values: object, kind: str = "real", storage: str = "static const") -> str:
    """Return an array, (K,), (K, L) or (K, L, M) row by row, as a C definition."""
    array = np.asarray(values)
    sizes = "".join(f"[{size}]" for size in array.shape)
    return f"{storage} {kind} {name}{sizes} = {_braced(array)};\n"


def _braced(array: Floats) -> str:
    if array.ndim > 1:
        return "{\n" + ",\n".join(_braced(row) for row in array) + "}"
    words = [repr(one) for one in array.tolist()]
    lines = [", ".join(words[at : at + A_LINE]) for at in range(0, len(words), A_LINE)]
    return "{" + ",\n ".join(lines) + "}"


def form_in_c(form: Form) -> str:
    """Return tables and functions of a form; `<kind>_torque` is the last of them."""
    return "".join(_TABLES[type(form)](form)) + "\n" + _template(form.kind)


def curves_in_c(curves: Sequence[PortableCurve]) -> str:
    """Return tables of all curves, and the function `over` that reads them."""
    parts = [f"enum {{ PIECES = 4 }};\n#define FADES R({FADES})\n"]
    for number, curve in enumerate(curves):
        for axis, knots in enumerate(curve.knots()):
            parts.append(table(f"curve_{number}_knots_{axis}", knots))
        parts.append(table(f"curve_{number}_heights", curve.heights.ravel()))
    return "".join([*parts, "\n", _template("curve")])


def _template(kind: str) -> str:
    return (files("lagrangian_ff.export") / "c" / f"{kind}.c").read_text(encoding="utf-8")


def _trigonometric(form: Trigonometric) -> Iterator[str]:
    joints = len(form.rotor)
    sizes = f"TRIGONOMETRIC_ROOM = {_room(joints)}, TRIGONOMETRIC_HEIGHTS = {SHORT**joints}"
    yield f"enum {{ {sizes} }};\n"
    for name in ("mass", "potential", "rotor"):
        yield table(f"trigonometric_{name}", getattr(form, name))


def _room(joints: int) -> int:
    """Return how many numbers are left at most after a joint was taken out."""
    most, rows = 1, 1
    for k in range(joints):
        size, had = rows * LONG ** (joints - 1 - k), 1
        for factor in [LONG] * (joints - 1 - k) + [SHORT] * k:
            size, had = size // factor, had + 1
            most = max(most, size * had)
        rows = SHORT * rows + 1
    return max(most, *((n + 2) * SHORT ** (joints - 1 - n) for n in range(joints)))


def _motors(form: Motors) -> Iterator[str]:
    yield table("motors_inertia", form.inertia)
    yield table("motors_viscous", form.viscous)


def _lagrangian_rbf(form: LagrangianRbf) -> Iterator[str]:
    yield f"enum {{ {form.kind}_angles = {int(form.angles)} }};\n"
    yield table(f"{form.kind}_alpha", form.alpha)
    yield table(f"{form.kind}_w", form.w)
    yield from _centres(form.kind, form, angles=form.angles)


def _state_rbf(form: StateRbf) -> Iterator[str]:
    yield f"enum {{ state_rbf_angles = {int(form.angles)} }};\n"
    for name in ("velocity_scale", "acceleration_scale", "half"):
        yield table(f"state_rbf_{name}", getattr(form, name))
    yield from _centres("state_rbf", form, angles=form.angles)


def _pol(form: PolSum) -> Iterator[str]:
    yield table("pol_velocity_scale", form.velocity_scale)
    yield table("pol_acceleration_scale", form.acceleration_scale)
    yield from _centres("pol", form, angles=True)


def _bodies(form: Bodies) -> Iterator[str]:
    count = len(form.parent)
    yield f"enum {{ BODIES = {count} }};\n"
    for name in ("parent", "driver", "sliding"):
        yield table(f"bodies_{name}", getattr(form, name).astype(np.int64), "int")
    for name in ("offset", "axis", "ratio", "shift", "inertial", "gravity", "rotor"):
        yield table(f"bodies_{name}", getattr(form, name))
    yield table("bodies_rotation", form.rotation.reshape(count, 9))


def _mechanical(form: Mechanical) -> Iterator[str]:
    kinetic = (
        "serial_kinetic(N, qd, qdd, right, factors[KINETIC], squares, mechanical_inertia, "
        "mechanical_link, work, blocks)"
        if form.serial
        else "product_kinetic(N, qd, qdd, right, squares, mechanical_inertia, mechanical_link, "
        "work, blocks)"
    )
    forms = ", ".join(map(str, form.form.tolist()))
    yield f"#define MECHANICAL_FORMS {{{forms}}}\n#define MECHANICAL_KINETIC {kinetic}\n"
    rotors = form.rotor * form.inertia**2 * np.sum(form.qdd * form.weights, axis=0)
    for name in ("inertia", "link", "potential", "wave", "swing"):
        yield table(f"mechanical_{name}", getattr(form, name))
    yield table("mechanical_rotors", rotors)
    yield from _centres("mechanical", form, angles=True, whole=LANES)
    if not form.serial:
        yield "\n" + _loops("product.c")
    else:
        yield "\n" + _loops("serial.c")


def _centres(
    kind: str,
    form: "LagrangianRbf | StateRbf | PolSum | Mechanical",
    *,
    angles: bool,
    whole: int = 1,
) -> Iterator[str]:
    """Yield the centres; some of weight 0 make their number a multiple of `whole`."""
    count = len(form.q)
    more = -count % whole
    yield f"enum {{ {kind.upper()}_CENTRES = {count + more} }};\n"
    places = {"sine": np.sin(form.q), "cosine": np.cos(form.q)}
    if not angles:
        places = {"sine": form.q, "cosine": np.ones_like(form.q)}
    if isinstance(form, Mechanical):
        places["q"] = form.q
    for name, values in (
        *places.items(),
        *((n, getattr(form, n)) for n in ("qd", "qdd", "weights")),
    ):
        yield table(f"{kind}_{name}", np.vstack([values, np.zeros((more, values.shape[1]))]))


PRELUDE = f"""\
#include <stdint.h>

enum {{ LANES = {LANES}, WORK = 21 }};
enum {{ Q, QD, QDD, SIN, COS, PARTS }};
enum {{ KINETIC, POTENTIAL }};
enum {{ COSINE, BELL, LINE }};
typedef real Tile[LANES];
#if defined(__GNUC__) && !defined(__clang__)
#define EACH_LANE _Pragma("GCC ivdep") for (int z = 0; z < LANES; ++z)
#else
#define EACH_LANE for (int z = 0; z < LANES; ++z)
#endif

static real exponential(real x) {{ return F(exp)(x); }}

"""
SHARED = ("factor", "factor_square", "add_potential")
"""The functions of `structured.c` that a torque needs."""


def _loops(kinetic: str) -> str:
    """Return the loops that the model was learned with, of one precision and file."""
    folder = files("lagrangian_ff.loops")
    try:
        shared, own = (
            (folder / name).read_text(encoding="utf-8") for name in ("structured.c", kinetic)
        )
    except OSError as error:
        raise ExportError(f"the C loops are not installed beside the package: {error}") from error
    chosen = "\n".join(_function(shared, name) for name in SHARED)
    text = chosen + "\n" + own
    text = re.sub(r"^#include.*\n|^ *_Pragma\(.*\)\n", "", text, flags=re.MULTILINE)
    text = re.sub(r"\bdouble\b", "real", text)
    return PRELUDE + re.sub(r"^void ", "static void ", text, flags=re.MULTILINE)


def _function(source: str, name: str) -> str:
    """Return the definition of a function in a C file."""
    found = re.search(rf"^\w+ {name}\([^;{{]*\)\n{{\n.*?^}}\n", source, re.MULTILINE | re.DOTALL)
    if found is None:
        raise ExportError(f"the C loops beside the package lack {name}()")
    return found.group()


_TABLES: Mapping[type[Form], Callable[..., Iterator[str]]] = {
    Trigonometric: _trigonometric,
    LagrangianRbf: _lagrangian_rbf,
    JointRbf: _lagrangian_rbf,
    StateRbf: _state_rbf,
    PolSum: _pol,
    Motors: _motors,
    Mechanical: _mechanical,
    Bodies: _bodies,
}
"""What writes the tables of each form; a new form is a line here and its `c/<kind>.c`."""
