"""Loops over states, samples and the steps of the arm, in C: compiled at installation, never later.

`loop("name")` is the function of that name in one of the C files, for NumPy arrays. To add one,
write it, with `EXPORT` before it, and name its arguments in `binding.py`; `make install` compiles
it.
"""

from lagrangian_ff.loops.binding import LoopsError, loop

__all__ = ["LoopsError", "loop"]
