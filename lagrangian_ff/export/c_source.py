"""The C99 source of a model: one header, one file, and a program that checks them."""

import re
from collections.abc import Iterator, Mapping
from importlib.resources import files

import numpy as np

from lagrangian_ff.errors import ExportError
from lagrangian_ff.export.c_tables import curves_in_c, form_in_c, table
from lagrangian_ff.export.expressions import in_c, number_in_c, parsed
from lagrangian_ff.export.portable import CHECKED, Portable, PortableTerm, checked
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.predicting import STILL

ALLOWED = {"FLOAT64": "1e-12", "FLOAT32": "1e-3"}
"""Largest difference that the check lets pass, in parts of a joint's largest torque."""
WORD = re.compile(r"[a-z][a-z0-9_]*", re.ASCII)
TAKEN = frozenset(
    """
    auto break case char const continue default do double else enum extern float for goto if inline
    int long register restrict return short signed sizeof static struct switch typedef union
    unsigned void volatile while class namespace template this new delete test m c
    """.split()  # noqa: SIM905
)
"""Names that a C, C++ or CMake file cannot give a library."""

START = """\
/* @NAME@: see @NAME@.h. Made by lagrangian_ff from the model @SOURCE@; not to be edited by hand. */

#include "@NAME@.h"

#include <math.h>

typedef @NAME@_real real;

enum { N = @MACRO@_JOINTS, EFFECTS = @MACRO@_EFFECTS };

#ifdef @MACRO@_FLOAT32
#define F(name) name##f
#else
#define F(name) name
#endif
#define R(number) ((real)(number))
#define STILL R(@STILL@)

"""
SQUARE = "static real square(real x) { return x * x; }\n\n"


def sources(model: Model, held: Portable, name: str) -> dict[str, str]:
    """Return the text of every file of the C package, by file name.

    Args:
        model: for the states that the check compares.  held: what is written.
        name: of the library, and the prefix of all that it defines.

    Raises:
        ExportError: it is no such name.
    """
    if not WORD.fullmatch(name) or name in TAKEN:
        raise ExportError(
            f"'{name}' cannot be the name of a C library: name a folder of small letters, digits "
            "and _, as in --output arm_model"
        )
    words = {
        "NAME": name,
        "MACRO": name.upper(),
        "SOURCE": held.source,
        "STILL": repr(STILL),
        "JOINTS": _comment(", ".join(held.joints)),
        "JOINT_COUNT": str(len(held.joints)),
        "EFFECTS": ", ".join(held.effects) or "none",
        "EFFECT_COUNT": str(len(held.effects)),
        "EFFECT_ENUM": _effect_enum(held, name),
        "SETTLED": "".join(
            f"    settled   {effect}: {why}\n" for effect, why in held.settled.items()
        ),
        "FORMS": _forms(held),
        "TERMS": "".join([*_terms(held, follows=False), *_curves(held)]),
        "FOLLOWING": "".join(_terms(held, follows=True)),
        "STATES": str(CHECKED),
        "TABLES": _checked(model),
        **ALLOWED,
    }
    return {
        f"{name}.h": _filled("header.h", words),
        f"{name}.c": _source(held, words),
        "check.c": _filled("check.c", words),
        "CMakeLists.txt": _filled("CMakeLists.txt", words),
        f"{name}.pc.in": _filled("package.pc.in", words),
    }


def _source(held: Portable, words: Mapping[str, str]) -> str:
    parts = [_replaced(START, words), _constants(held, words["NAME"])]
    interface = _filled("interface.c", words)
    if "square(" in interface:
        parts.append(SQUARE)
    parts += [form_in_c(form) + "\n" for form in held.forms]
    if held.curves:
        parts.append(curves_in_c(held.curves) + "\n")
    return "".join([*parts, interface])


def _filled(template: str, words: Mapping[str, str]) -> str:
    text = (files("lagrangian_ff.export") / "c" / template).read_text(encoding="utf-8")
    return _replaced(text, words)


def _replaced(text: str, words: Mapping[str, str]) -> str:
    """Return a text with @WORD@ replaced; CMake's own stay."""
    return re.sub(r"@(\w+)@", lambda found: words.get(found[1], found[0]), text)


def _constants(held: Portable, name: str) -> str:
    joints = len(held.joints)
    constant = np.zeros(joints)
    for term in held.terms:
        if term.constant:
            constant += term.coefficients[0] * term.on
    kind = f"const {name}_real"
    tables = [
        table(f"{name}_{limit}", getattr(held.range, limit), kind, "").lstrip()
        for limit in ("q_low", "q_high", "qd_max", "qdd_max", "tau_max")
    ]
    tables.append(table("constant", constant))
    if held.forms:
        tables.append(table("unit", held.unit))
    for what, listed in (("joint", held.joints), ("effect", held.effects or ("",))):
        quoted = ", ".join(_quoted(one) for one in listed)
        tables.append(f"const char *const {name}_{what}_names[{len(listed)}] = {{{quoted}}};\n")
    return "".join(tables) + "\n"


def _effect_enum(held: Portable, name: str) -> str:
    """Return names for the places of the effects in `effect`."""
    if not held.effects:
        return ""
    macro = name.upper()
    listed = ", ".join(f"{macro}_{one.upper()} = {n}" for n, one in enumerate(held.effects))
    return f"enum {{ {listed} }};\n"


def _forms(held: Portable) -> str:
    return "".join(
        f"    {{\n        real part[N];\n        {form.kind}_torque(q, qd, qdd, part);\n"
        "        for (int n = 0; n < N; ++n)\n            tau[n] += unit[n] * part[n];\n    }\n"
        for form in held.forms
    )


def _terms(held: Portable, *, follows: bool) -> Iterator[str]:
    """Yield the code of every effect on its joint."""
    for term in held.terms:
        if term.follows == follows:
            place = held.effects.index(term.effect)
            yield f"    {{ /* {term.effect} on {_comment(held.joints[term.joint])} */\n"
            yield f"        const real found = {_sum(term)};\n"
            for joint in np.flatnonzero(term.on):
                factor = float(term.on[joint])
                value = "found" if factor == 1.0 else f"{number_in_c(factor)} * found"
                yield f"        effect[{place}][{joint}] += {value};\n"
            yield "    }\n"


def _curves(held: Portable) -> Iterator[str]:
    """Yield the code of every curve on its joint."""
    for number, curve in enumerate(held.curves):
        place = held.effects.index(curve.effect)
        yield f"    effect[{place}][{curve.joint}] += {curve.call(number)};\n"


def _sum(term: PortableTerm) -> str:
    inputs = ("q", "qd", "qdd", "load", "torque")
    names = {one: f"{one}[{term.joint}]" for one in inputs}
    names |= {one: number_in_c(value) for one, value in term.values.items()}
    names |= {name: f"{what}[{joint}]" for name, (what, joint) in term.others.items()}
    parts = (
        f"{number_in_c(float(factor))} * {in_c(parsed(text), names)}"
        for text, factor in zip(term.columns, term.coefficients, strict=True)
    )
    return "\n            + ".join(parts)


def _checked(model: Model) -> str:
    names = "positions", "velocities", "accelerations", "torques"
    named = zip(names, checked(model), strict=True)
    return "\n".join(table(name, values, "double") for name, values in named)


def _quoted(text: str) -> str:
    """Return a text as a C string; bytes beyond ASCII as octal."""
    plain = "".join(
        chr(one) if 32 <= one < 127 and chr(one) not in '"\\?' else f"\\{one:03o}"
        for one in text.encode()
    )
    return f'"{plain}"'


def _comment(text: str) -> str:
    """Return a text that cannot end a comment."""
    return re.sub(r"[^ \w,.:-]", "_", text, flags=re.ASCII)
