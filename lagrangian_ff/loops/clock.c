/* How many periods of a steady clock lie between samples that were stamped late. */

#include "tiles.h"

enum { WIDTH = 255, BINS = 4 };

static int bin_of(double delay, int reach)
{
    double bin = BINS * (delay + reach) + 0.5;
    /* What is not a number must not become an index. */
    return !(bin > 0.0) ? 0 : bin > 2.0 * BINS * reach ? 2 * BINS * reach : (int)bin;
}

/* Write the number of the tick at which each sample was taken to out.

The likeliest path (Viterbi) through states that are ticks near the stamp. `stamp` is in periods,
`moved` the periods since the sample before as the motion shows them, `sure` one over their
variance; `held` is 1 where a sample repeats the one before, so that no tick need lie between. A
stamp departs from its tick by a delay around a mean that each path follows slowly, so that clocks
may drift; `unlikely` is what a delay costs, BINS to a period, for delays from -reach to reach.
`reach` are the ticks looked at to either side, at most 127. Return 0 if there is no memory. */
EXPORT int clock_ticks(int samples, const double *stamp, const double *moved, const double *sure,
                       const int64_t *held, const double *unlikely, int reach, int64_t *out)
{
    enum { MEMORY = 200 };
    const double start = 3.0, more = 0.3, far = 10.0, unlike = 200.0, hopeless = 300.0;
    int width = 2 * reach + 1;
    uint8_t *came = malloc((size_t)samples * (size_t)width);
    if (!came || width > WIDTH) {
        free(came);
        return 0;
    }
    double cost[WIDTH], mean[WIDTH], next_cost[WIDTH], next_mean[WIDTH];
    int alive[WIDTH];
    int64_t first = (int64_t)floor(stamp[0] + 0.5) - reach;
    for (int u = 0; u < width; ++u) {
        cost[u] = u == reach ? 0.0 : 1e300;
        mean[u] = stamp[0] - (double)(first + u);
    }
    out[0] = first; /* the lowest tick looked at, until the path is known */
    for (int i = 1; i < samples; ++i) {
        int best = 0, count = 0;
        for (int u = 0; u < width; ++u) {
            if (cost[u] < cost[best])
                best = u;
            if (cost[u] < hopeless)
                alive[count++] = u;
        }
        int64_t low = (int64_t)floor(stamp[i] - mean[best] + 0.5) - reach;
        double gain = 1.0 / (i < MEMORY ? i + 1.0 : MEMORY);
        for (int u = 0; u < width; ++u) {
            int from = -1;
            double least = 1e300;
            int64_t tick = low + u;
            for (int k = 0; k < count; ++k) {
                int v = alive[k];
                int64_t step = tick - first - v;
                if (step < 1 - held[i] || cost[v] >= least)
                    continue;
                double off = (double)step - moved[i];
                double lost = step > 1 ? (double)(step - 1) : 0.0;
                double by = cost[v] + fmin(0.5 * sure[i] * off * off, unlike)
                            + (lost > 0.0 ? start + more * fmin(lost, far) : 0.0)
                            + unlikely[bin_of(stamp[i] - (double)tick - mean[v], reach)];
                if (by < least) {
                    least = by;
                    from = v;
                }
            }
            came[(int64_t)i * width + u] = (uint8_t)(from < 0 ? 0 : from);
            next_cost[u] = least;
            if (from >= 0)
                next_mean[u] = mean[from] + gain * (stamp[i] - (double)tick - mean[from]);
            else
                next_mean[u] = 0.0;
        }
        double floor_cost = 1e300;
        for (int u = 0; u < width; ++u)
            floor_cost = fmin(floor_cost, next_cost[u]);
        for (int u = 0; u < width; ++u) {
            cost[u] = next_cost[u] < 1e299 ? next_cost[u] - floor_cost : 1e300;
            mean[u] = next_mean[u];
        }
        first = out[i] = low;
    }
    int u = 0;
    for (int v = 1; v < width; ++v)
        if (cost[v] < cost[u])
            u = v;
    for (int i = samples - 1; i >= 0; --i) {
        int64_t tick = out[i] + u;
        if (i > 0)
            u = came[(int64_t)i * width + u];
        out[i] = tick;
    }
    free(came);
    return 1;
}
