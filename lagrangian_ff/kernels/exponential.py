"""Exponentials of many numbers side by side: the mathematics library's takes them one by one.

exp(x) = 2ⁿ exp(r) with n the integer nearest to x / log 2: then |r| ≤ ½ log 2, where Taylor's
series of degree 13 errs less than rounding does. n is read off the last bits of the sum with
1.5·2⁵², and 2ⁿ is made by writing n where a double keeps its exponent (Cody and Waite 1980,
Software Manual for the Elementary Functions).
"""

from math import factorial

import numpy as np
from numba import njit

from lagrangian_ff.kernels.options import APART

_LEAST = -700.0
"""Below it everything counts as this: 1e-304, still a normal number."""
_ROUND = 1.5 * 2.0**52
_PER_LOG_2 = 1.4426950408889634
_LOG_2, _LOG_2_REST = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""log 2 in two parts, the first so short that n times it is exact."""
_MANTISSA, _BIAS = 52, 1023
_C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10, _C11, _C12, _C13 = (
    1.0 / factorial(degree) for degree in range(2, 14)
)


# Where sums may be done in another order, the rounding that is wanted is done away with.
@njit(**APART | {"fastmath": {"contract", "nsz"}})
def exponentials(x, n, out):  # type: ignore[no-untyped-def]
    """Write exp(x) to out, for x ≤ 0.

    Args:
        x: (L,).  n: (L,) to work in.  out: (L,).
    """
    for z in range(x.shape[0]):
        n[z] = max(x[z], _LEAST) * _PER_LOG_2 + _ROUND
    for z in range(x.shape[0]):
        whole = n[z] - _ROUND
        r = max(x[z], _LEAST) - whole * _LOG_2 - whole * _LOG_2_REST
        high = ((((_C13 * r + _C12) * r + _C11) * r + _C10) * r + _C9) * r + _C8
        low = ((((high * r + _C7) * r + _C6) * r + _C5) * r + _C4) * r + _C3
        out[z] = ((low * r + _C2) * r + 1.0) * r + 1.0
    bits = n.view(np.int64)
    for z in range(x.shape[0]):
        bits[z] = (bits[z] << _MANTISSA) + (_BIAS << _MANTISSA)
    for z in range(x.shape[0]):
        out[z] *= n[z]
