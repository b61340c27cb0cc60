"""How the loops over pairs of states are compiled."""

from typing import Any

from numba.core.compiler import CompilerBase, DefaultPassBuilder


class Apart(CompilerBase):
    """Compiles functions whose arrays do not overlap where one of them is written.

    Told so, the compiler works on several lanes at a time; else it must fear that what it writes
    is what it reads next.
    """

    def define_pipelines(self) -> list[Any]:
        """See `CompilerBase.define_pipelines`."""
        self.state.flags.noalias = True
        return [DefaultPassBuilder.define_nopython_pipeline(self.state)]


OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract", "nsz", "arcp", "reassoc"},
}
INNER: dict[str, Any] = OPTIONS | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""For loops that only other compiled loops call: what would call them from Python takes as long to
compile as a small loop."""
APART = OPTIONS | {"pipeline_class": Apart}
APART_INNER = INNER | {"pipeline_class": Apart}

LANES = 32
"""Pairs of states worked on side by side: the innermost loops run over them, so that the processor
takes several at a time and the work arrays stay in its nearest memory."""
