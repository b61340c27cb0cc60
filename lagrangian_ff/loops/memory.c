/* Recursions over the samples of a motion, for effects with a memory; and exponentials. */

#include "tiles.h"

/* Write the stop operator q - play(q) over its width to out; see effects/memory.py. */
EXPORT void memory_stop(int samples, const double *q, const int64_t *segment, const double *start,
                        double width, double *out)
{
    for (int i = 0; i < samples; ++i) {
        double next = i == 0 || segment[i] != segment[i - 1]
                          ? start[i]
                          : out[i - 1] + (q[i] - q[i - 1]) / width;
        out[i] = fmin(1.0, fmax(-1.0, next));
    }
}

/* Write what a gear with play carries of a part of its load to out; see effects/memory.py. */
EXPORT void memory_loose(int samples, const double *load, const double *part, double step,
                         double play, double blow, double *out)
{
    enum { SUBSTEPS = 8 };
    double h = step / SUBSTEPS, passed = 1.0 - exp(-h / blow);
    double ahead = load[0] > 0.0 ? 0.5 : -0.5, speed = 0.0, gained = 0.0, momentum = 0.0;
    for (int i = 0; i < samples; ++i) {
        int last = i + 1 == samples;
        double change = last ? 0.0 : load[i + 1] - load[i];
        double part_change = last ? 0.0 : part[i + 1] - part[i], carried = 0.0;
        for (int k = 0; k < SUBSTEPS; ++k) {
            double now = load[i] + change * k / SUBSTEPS;
            double share = part[i] + part_change * k / SUBSTEPS;
            if ((ahead >= 0.5 && now >= 0.0) || (ahead <= -0.5 && now <= 0.0)) {
                carried += share;
            } else {
                speed += h * now / play;
                ahead += h * speed;
                gained += h * share;
                if (fabs(ahead) >= 0.5) {
                    momentum += gained;
                    ahead = ahead > 0.0 ? 0.5 : -0.5;
                    speed = gained = 0.0;
                }
            }
            carried += momentum * passed / h;
            momentum -= momentum * passed;
        }
        out[i] = carried / SUBSTEPS;
    }
}

/* Write values through a filter of second order, at rest before them, to out; the coefficients are
   b0 b1 b2 a1 a2, a0 being one. */
EXPORT void memory_filter(int samples, const double *values, const double *of, double *out)
{
    double one = 0.0, two = 0.0;
    for (int i = 0; i < samples; ++i) {
        out[i] = of[0] * values[i] + one;
        one = of[1] * values[i] - of[3] * out[i] + two;
        two = of[2] * values[i] - of[4] * out[i];
    }
}

/* Write exp(x) to out, for x <= 0. */
EXPORT void exponentials(int count, const double *x, double *out)
{
    _Pragma("omp simd")
    for (int i = 0; i < count; ++i)
        out[i] = exponential(x[i]);
}
