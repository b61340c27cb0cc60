/* A learned Lagrangian of rigid links as the trigonometric polynomial that it is.

With cosine factors, entry (j, k), j <= k, of the mass matrix is of first degree in cosine and sine
of the joints j+1 .. k and of second degree in those beyond (see serial.c), and the potential of
first degree in all. From however many states it was learned, its coefficients are as many:

    M_jk(q) = mu_jk(q)^T B_jk tau_k(q),     mu_jk = prod_{j<l<=k} (1, cos, sin)(q_l),
                                            tau_k = prod_{l>k} (1, cos, sin, cos 2, sin 2)(q_l),

with products of Kronecker's. The blocks B_jk of one k stand on each other, j = 0 first, as do the
mu_jk: a row more for every k. */

#include "tiles.h"

enum { SHORT = 3, LONG = 5 }; /* functions of a joint of first and of second degree */

/* Where the work is done: functions of each joint and their slopes (N, LONG); tails tau, their
change along the motion, and what the kinetic energy gains with each (columns,); rows mu likewise
(rows,); products of the potential's functions. */
typedef struct {
    int joints, columns, rows;
    double *function, *slope;
    double *tail, *tail_change, *tail_gain;
    double *row, *row_change, *row_gain;
    double *head, *rest;
} Work;

static int power(int base, int exponent)
{
    int found = 1;
    for (int n = 0; n < exponent; ++n)
        found *= base;
    return found;
}

/* Write 1, cos q, sin q, cos 2q, sin 2q of every joint, and their slopes. */
static void write_functions(const double *q, Work *work)
{
    for (int n = 0; n < work->joints; ++n) {
        double cosine = cos(q[n]), sine = sin(q[n]);
        double twice_cosine = cosine * cosine - sine * sine, twice_sine = 2.0 * sine * cosine;
        double *f = work->function + n * LONG, *g = work->slope + n * LONG;
        f[0] = 1.0, f[1] = cosine, f[2] = sine, f[3] = twice_cosine, f[4] = twice_sine;
        g[0] = 0.0, g[1] = -sine, g[2] = cosine;
        g[3] = -2.0 * twice_sine, g[4] = 2.0 * twice_cosine;
    }
}

/* Write tau_k, all k one after the other, k = 0 first, and how they change along v. */
static void write_tails(const double *v, Work *work)
{
    int width = 1, source = work->columns - 1;
    work->tail[source] = 1.0, work->tail_change[source] = 0.0;
    for (int k = work->joints - 2; k >= 0; --k) {
        int first = source - LONG * width;
        const double *old = work->tail + source, *rate = work->tail_change + source;
        for (int f = 0; f < LONG; ++f) {
            double b = work->function[(k + 1) * LONG + f];
            double db = work->slope[(k + 1) * LONG + f] * v[k + 1];
            double *new = work->tail + first + f * width;
            double *change = work->tail_change + first + f * width;
            _Pragma("omp simd")
            for (int r = 0; r < width; ++r) {
                new[r] = b * old[r];
                change[r] = b * rate[r] + db * old[r];
            }
        }
        source = first;
        width *= LONG;
    }
}

/* Write mu_jk, all k one after the other, and how they change along v. */
static void write_rows(const double *v, Work *work)
{
    double *value = work->row, *change = work->row_change;
    value[0] = 1.0, change[0] = 0.0;
    int before = 0, count = 1;
    for (int k = 1; k < work->joints; ++k) {
        int first = before + count;
        for (int r = 0; r < count; ++r)
            for (int f = 0; f < SHORT; ++f) {
                double b = work->function[k * LONG + f], db = work->slope[k * LONG + f] * v[k];
                value[first + SHORT * r + f] = b * value[before + r];
                change[first + SHORT * r + f] = b * change[before + r] + db * value[before + r];
            }
        before = first;
        count = SHORT * count + 1;
        value[before + count - 1] = 1.0, change[before + count - 1] = 0.0;
    }
}

/* Products of rows of coefficients with tau and with its change. */
typedef struct {
    double total[SHORT], change[SHORT];
} Products;

/* Return the products of one row of coefficients (width,), and add weight times it to gained. */
static Products one_row(int width, const double *mass, const double *value, const double *slope,
                        const double *weight, double *gained)
{
    double total = 0.0, change = 0.0, own = weight[0];
    _Pragma("omp simd reduction(+ : total, change)")
    for (int c = 0; c < width; ++c) {
        total += mass[c] * value[c];
        change += mass[c] * slope[c];
        gained[c] += own * mass[c];
    }
    return (Products){.total = {total}, .change = {change}};
}

/* Do the same for three rows, with one pass over the rest. */
static Products three_rows(int width, const double *mass, const double *value, const double *slope,
                           const double *weight, double *gained)
{
    double t0 = 0.0, t1 = 0.0, t2 = 0.0, c0 = 0.0, c1 = 0.0, c2 = 0.0;
    double w0 = weight[0], w1 = weight[1], w2 = weight[2];
    const double *first = mass, *second = mass + width, *third = mass + 2 * width;
    _Pragma("omp simd reduction(+ : t0, t1, t2, c0, c1, c2)")
    for (int c = 0; c < width; ++c) {
        double x = value[c], y = slope[c];
        t0 += first[c] * x;
        t1 += second[c] * x;
        t2 += third[c] * x;
        c0 += first[c] * y;
        c1 += second[c] * y;
        c2 += third[c] * y;
        gained[c] += w0 * first[c] + w1 * second[c] + w2 * third[c];
    }
    return (Products){.total = {t0, t1, t2}, .change = {c0, c1, c2}};
}

/* Write M a + dM/dt v to out, and what v^T M v / 2 gains with each mu and tau. */
static void write_momenta(const double *v, const double *a, const double *mass, Work *work,
                          double *out)
{
    int column = 0, row = 0, width = power(LONG, work->joints - 1);
    for (int n = 0; n < work->joints; ++n)
        out[n] = 0.0;
    for (int c = 0; c < work->columns; ++c)
        work->tail_gain[c] = 0.0;
    for (int k = 0; k < work->joints; ++k) {
        const double *value = work->tail + column, *slope = work->tail_change + column;
        double *gained = work->tail_gain + column;
        for (int j = 0; j <= k; ++j) {
            double share = j < k ? v[j] * v[k] : 0.5 * v[k] * v[k], inertia = 0.0, rate = 0.0;
            int count = power(SHORT, k - j), step = j < k ? SHORT : 1;
            for (int first = 0; first < count; first += step) {
                double weight[SHORT];
                for (int r = 0; r < step; ++r)
                    weight[r] = share * work->row[row + r];
                Products found = step == 1 ? one_row(width, mass, value, slope, weight, gained)
                                           : three_rows(width, mass, value, slope, weight, gained);
                for (int r = 0; r < step; ++r, ++row) {
                    inertia += work->row[row] * found.total[r];
                    rate += work->row_change[row] * found.total[r]
                            + work->row[row] * found.change[r];
                    work->row_gain[row] = share * found.total[r];
                }
                mass += step * width;
            }
            out[j] += inertia * a[k] + rate * v[k];
            if (j < k)
                out[k] += inertia * a[j] + rate * v[j];
        }
        column += width;
        width /= LONG;
    }
}

/* Subtract from out how v^T M v / 2 changes with each joint, by what it gains with mu and tau. */
static void subtract_slopes(Work *work, double *out)
{
    int joints = work->joints, count = (power(SHORT, joints) - 1) / 2;
    int first = work->rows - count;
    for (int k = joints - 1; k > 0; --k) {
        count = (count - 1) / SHORT;
        int before = first - count;
        double slope = 0.0;
        for (int r = 0; r < count; ++r) {
            double gained = 0.0;
            for (int f = 0; f < SHORT; ++f) {
                double one = work->row_gain[first + SHORT * r + f];
                gained += work->function[k * LONG + f] * one;
                slope += work->row[before + r] * work->slope[k * LONG + f] * one;
            }
            work->row_gain[before + r] += gained;
        }
        out[k] -= slope;
        first = before;
    }
    first = 0;
    int width = power(LONG, joints - 1);
    for (int k = 0; k < joints - 1; ++k) {
        int source = first + width;
        width /= LONG;
        const double *value = work->tail + source;
        double *below = work->tail_gain + source, slope = 0.0;
        for (int f = 0; f < LONG; ++f) {
            const double *gained = work->tail_gain + first + f * width;
            double b = work->function[(k + 1) * LONG + f], db = work->slope[(k + 1) * LONG + f];
            double part = 0.0;
            _Pragma("omp simd reduction(+ : part)")
            for (int r = 0; r < width; ++r) {
                below[r] += b * gained[r];
                part += gained[r] * value[r];
            }
            slope += db * part;
        }
        out[k + 1] -= slope;
        first = source;
    }
}

/* Subtract from out how the potential part of the Lagrangian changes with each joint. */
static void subtract_potential(const double *potential, Work *work, double *out)
{
    int joints = work->joints, first = 0, width = 1;
    /* Products of the first joints' functions, n = 0 first; what the last joints make of the rest. */
    double *head = work->head, *rest = work->rest;
    head[0] = 1.0;
    for (int n = 0; n < joints - 1; ++n) {
        for (int r = 0; r < width; ++r)
            for (int f = 0; f < SHORT; ++f)
                head[first + width + SHORT * r + f] = head[first + r] * work->function[n * LONG + f];
        first += width;
        width *= SHORT;
    }
    const double *above = potential;
    double *here = rest;
    for (int n = joints - 1; n >= 0; --n) {
        double slope = 0.0;
        for (int r = 0; r < width; ++r) {
            double value = 0.0, change = 0.0;
            for (int f = 0; f < SHORT; ++f) {
                value += work->function[n * LONG + f] * above[SHORT * r + f];
                change += work->slope[n * LONG + f] * above[SHORT * r + f];
            }
            here[r] = value;
            slope += head[first + r] * change;
        }
        out[n] -= slope;
        above = here;
        here += width;
        width /= SHORT;
        first -= width;
    }
}

/* Write the torques of states q, qd, qdd (samples, N) to out (samples, N).

mass: the B_k, one after the other, row by row. potential: (3^N,). rotor: (N,). Return whether there
was memory. */
EXPORT int polynomial_torques(int joints, const double *q, const double *qd, const double *qdd,
                              int samples, const double *mass, const double *potential,
                              const double *rotor, double *out)
{
    Work work = {.joints = joints};
    for (int k = 0; k < joints; ++k) {
        work.columns += power(LONG, joints - 1 - k);
        work.rows += (power(SHORT, k + 1) - 1) / 2;
    }
    int heads = (power(SHORT, joints) - 1) / 2;
    size_t size = 2 * LONG * joints + 3 * work.columns + 3 * work.rows + 2 * heads;
    double *room = malloc(size * sizeof(double));
    if (!room)
        return 0;
    double **places[] = {&work.function, &work.slope, &work.tail, &work.tail_change,
                         &work.tail_gain, &work.row, &work.row_change, &work.row_gain,
                         &work.head, &work.rest};
    int sizes[] = {LONG * joints, LONG * joints, work.columns, work.columns, work.columns,
                   work.rows, work.rows, work.rows, heads, heads};
    double *next = room;
    for (int one = 0; one < 10; ++one) {
        *places[one] = next;
        next += sizes[one];
    }
    for (int i = 0; i < samples; ++i) {
        size_t at = (size_t)i * joints;
        double *torque = out + at;
        write_functions(q + at, &work);
        write_tails(qd + at, &work);
        write_rows(qd + at, &work);
        write_momenta(qd + at, qdd + at, mass, &work, torque);
        subtract_slopes(&work, torque);
        subtract_potential(potential, &work, torque);
        for (int n = 0; n < joints; ++n)
            torque[n] += rotor[n] * qdd[at + n];
    }
    free(room);
    return 1;
}
