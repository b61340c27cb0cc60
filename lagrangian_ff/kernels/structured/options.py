"""How the loops over pairs of states are compiled."""

from typing import Any

OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract", "nsz", "arcp", "reassoc"},
}

INNER: dict[str, Any] = OPTIONS | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""For loops that only other compiled loops call: what would call them from Python takes as long to
compile as a small loop."""

LANES = 32
"""Pairs of states worked on side by side: the innermost loops run over them, so that the processor
takes several at a time and the work arrays stay in its nearest memory."""
