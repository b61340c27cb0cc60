/* How many periods of a steady clock lie between samples that were stamped late. */

#include "tiles.h"

enum { WIDTH = 255, BINS = 4 };

/* Columns of a table of what delays cost: enough for every tick and every mean. */
enum { COLUMNS = 3 * WIDTH + 2 };

/* Write what delays cost so that ticks that follow each other find theirs side by side.

In row r, column `last` - m holds that of bin BINS m + r, of the first or last bin where there is
none. Return `last`. */
static int tabled(const double *unlikely, int reach, double table[BINS][COLUMNS])
{
    int width = 2 * reach + 1, last = width + 2 * reach, bins = 2 * BINS * reach;
    for (int r = 0; r < BINS; ++r)
        for (int k = 0; k < last + width + 1; ++k) {
            int bin = BINS * (last - k) + r;
            table[r][k] = unlikely[bin < 0 ? 0 : bin > bins ? bins : bin];
        }
    return last;
}

/* Return the bin of a delay in units of a period; of what is far away, or no number, an outer one. */
static int bin_of(double delay, int reach, int last)
{
    double bin = floor(BINS * (delay + reach) + 0.5);
    return !(bin > -BINS) ? -BINS : bin > BINS * last ? BINS * last : (int)bin;
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
    double cost[WIDTH], mean[WIDTH], next_cost[WIDTH], next_mean[WIDTH], least[WIDTH];
    double price[2 * WIDTH], table[BINS][COLUMNS];
    int64_t from[WIDTH];
    int alive[WIDTH], last = tabled(unlikely, reach, table);
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
            least[u] = 1e300;
            from[u] = -1;
        }
        /* What a step costs, from the last state to the first to the other way round. */
        for (int k = 0; k < 2 * width - 1; ++k) {
            int64_t step = low - first + k - (width - 1);
            double off = (double)step - moved[i], lost = step > 1 ? (double)(step - 1) : 0.0;
            price[k] = step < 1 - held[i] ? 1e300
                                          : fmin(0.5 * sure[i] * off * off, unlike)
                                                + (lost > 0.0 ? start + more * fmin(lost, far) : 0.0);
        }
        for (int k = 0; k < count; ++k) {
            int v = alive[k];
            int bin = bin_of(stamp[i] - (double)low - mean[v], reach, last) + BINS;
            const double *late = table[bin % BINS] + last - bin / BINS + 1;
            const double *step = price + width - 1 - v;
            for (int u = 0; u < width; ++u) {
                double by = cost[v] + step[u] + late[u];
                from[u] = by < least[u] ? v : from[u];
                least[u] = by < least[u] ? by : least[u];
            }
        }
        for (int u = 0; u < width; ++u) {
            came[(int64_t)i * width + u] = (uint8_t)(from[u] < 0 ? 0 : from[u]);
            next_cost[u] = least[u];
            double before = from[u] < 0 ? 0.0 : mean[from[u]];
            double delay = stamp[i] - (double)(low + u) - before;
            next_mean[u] = from[u] < 0 ? 0.0 : before + gain * delay;
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
