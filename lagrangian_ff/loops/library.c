/* What the library says of itself. */

#include "tiles.h"

/* Return a digest of the sources that the library was compiled from. */
EXPORT const char *loops_sources(void) { return SOURCES; }

/* Return the name of the fastest library that this processor runs; see build.py. */
EXPORT const char *loops_level(void)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma"))
        return "plain";
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")
        && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl"))
        return "avx512";
    return "avx2";
#else
    return "plain";
#endif
}
