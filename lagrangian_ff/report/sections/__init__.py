"""Parts of a page: each file turns findings into one `Section`."""

from lagrangian_ff.lazy import attach

__getattr__, __all__ = attach(__name__, __file__)
