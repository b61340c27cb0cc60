/* What the loops share.

Pairs of states are worked on a tile at a time: LANES of them side by side, so that the processor
takes several at once and the work arrays stay in its nearest memory. The innermost loop of every
function runs over a tile.

States come as (samples, 5, joints): q, qd, qdd, sin q and cos q of each. Arrays are C-contiguous
doubles. With N joints and L lanes, (N, L) is `Tile *` and (N, 3, L) is `Tile (*)[3]`. */

#pragma once

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { LANES = 32 };
enum { Q, QD, QDD, SIN, COS, PARTS };

typedef double Tile[LANES];

#define EACH_LANE _Pragma("omp simd") for (int z = 0; z < LANES; ++z)
#define EXPORT __attribute__((visibility("default")))

/* Return room for tiles, to be given to `free`; NULL where there is none. */
static inline Tile *new_tiles(size_t count) { return aligned_alloc(64, count * sizeof(Tile)); }

static inline int least(int one, int other) { return one < other ? one : other; }

/* Return exp(x) for x up to 700; what is below -700 counts as that: 1e-304, still a normal number.

exp(x) = 2^n exp(r) with n the integer nearest to x / log 2: then |r| <= log 2 / 2, where Taylor's
series of degree 13 errs less than rounding does. n is read off the last bits of the sum with
1.5 2^52, and 2^n is made by writing n where a double keeps its exponent (Cody and Waite 1980,
Software Manual for the Elementary Functions). Loops over it run side by side; the mathematics
library takes one number at a time. */
static inline double exponential(double x)
{
    const double rounding = 0x1.8p52;
    const double log_2 = 6.93147180369123816490e-01, log_2_rest = 1.90821492927058770002e-10;
    double at_least = x < -700.0 ? -700.0 : x; /* NaN stays */
    double shifted = at_least * 1.4426950408889634 + rounding, power;
    double whole = shifted - rounding;
    int64_t bits;
    double r = at_least - whole * log_2 - whole * log_2_rest;
    double sum = 1.0 / 6227020800.0;
    sum = sum * r + 1.0 / 479001600.0;
    sum = sum * r + 1.0 / 39916800.0;
    sum = sum * r + 1.0 / 3628800.0;
    sum = sum * r + 1.0 / 362880.0;
    sum = sum * r + 1.0 / 40320.0;
    sum = sum * r + 1.0 / 5040.0;
    sum = sum * r + 1.0 / 720.0;
    sum = sum * r + 1.0 / 120.0;
    sum = sum * r + 1.0 / 24.0;
    sum = sum * r + 1.0 / 6.0;
    sum = sum * r + 1.0 / 2.0;
    sum = sum * r + 1.0;
    sum = sum * r + 1.0;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (int64_t)((uint64_t)bits << 52) + ((int64_t)1023 << 52);
    memcpy(&power, &bits, sizeof power);
    return sum * power;
}
