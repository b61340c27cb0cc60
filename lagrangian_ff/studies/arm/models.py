"""The models that are compared, in the order in which they are done: the most telling first."""

from collections.abc import Sequence

from lagrangian_ff.identification.spec import parse

OURS = ("auto+fri", "chain+fri", "energy+fri")
LAGRANGIAN = ("vrbfs+fri", "vrbf+fri", "srbfs+fri", "srbf+fri")
"""The paper's own, kernels on the Lagrangian with friction beside them."""
ALONE = ("vrbfs", "vrbf", "srbfs", "srbf", "rbfs", "rbf", "pol")
PAPER = ("motor+fri", *LAGRANGIAN, "pol+fri", "rbfs+fri", "rbf+fri", *ALONE)
"""Of section IV-B of the paper."""
MODELS = tuple(dict.fromkeys(("motor+fri", "vrbfs+fri", "auto+fri", *PAPER, *OURS)))
FRICTION = "+fri"


def asked(models: Sequence[str], usual: Sequence[str]) -> tuple[str, ...]:
    """The models that are asked for, each once; the usual ones where none is.

    Raises:
        ModelError: there is no such model.
    """
    for model in models:
        parse(model)
    return tuple(dict.fromkeys(models or usual))
