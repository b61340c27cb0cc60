/* Blocks of a structured kernel, and what its pieces do to weights and to a vector. */

#include "structured.h"

enum { ALL, LOWER, DIAGONAL }; /* pairs: each with each, with those up to itself, with itself */

/* Write the blocks of the kinetic part of the joints from `first` up to `stop`. */
static void kinetic(const Arm *arm, Pairs *pairs, int first, int stop, const double *inertia,
                    const double *link, Tile *out)
{
    const double *v = pairs->left + QD * arm->joints + first;
    const double *a = pairs->left + QDD * arm->joints + first;
    Tile (*right)[PARTS] = pairs->right + first;
    Tile (*c)[3] = pairs->factors[KINETIC] + first, (*e)[3] = pairs->squares[KINETIC] + first;
    if (arm->serial)
        serial_kinetic(stop - first, v, a, right, c, e, inertia + first, link + first, pairs->work,
                       out);
    else
        product_kinetic(stop - first, v, a, right, e, inertia + first, link + first, pairs->work,
                        out);
}

/* Write K(x_i, u_j)_nm to out[i - rows[0], n, j, m]; of the diagonal, j is 0.

x, u: states. rows: which i, from the first up to the second. many: states in u. which: ALL, LOWER or
DIAGONAL. numbers: see `arm_of`. out: (I, N, many or 1, N). Return whether there was memory. */
EXPORT int structured_blocks(int joints, int serial, const int64_t *form, const double *numbers,
                             const double *x, const double *u, const int64_t *rows, int many,
                             int which, double *out)
{
    Arm arm = arm_of(joints, serial, form, numbers);
    Tile *room = new_tiles(pairs_tiles(joints) + joints * joints);
    if (!room)
        return 0;
    Pairs pairs;
    pairs_place(&pairs, joints, room);
    Tile *block = room + pairs_tiles(joints);
    size_t columns = which == DIAGONAL ? 1 : (size_t)many;
    for (int i = (int)rows[0]; i < rows[1]; ++i) {
        int begin = which == DIAGONAL ? i : 0, end = which == ALL ? many : i + 1;
        double *row = out + (size_t)(i - rows[0]) * joints * columns * joints;
        for (int first = begin; first < end; first += LANES) {
            int count = least(LANES, end - first);
            pairs_load(&arm, x, i, u, first, count, &pairs);
            kinetic(&arm, &pairs, 0, joints, arm.inertia, arm.link, block);
            add_potential(joints, pairs.factors[POTENTIAL], arm.potential, pairs.work, block);
            for (int n = 0; n < joints; ++n) {
                double *own = block[n * joints + n], *au = pairs.right[n][QDD];
                double weight = arm.rotor[n] * arm.inertia[n] * arm.inertia[n]
                                * pairs.left[QDD * joints + n];
                EACH_LANE own[z] += weight * au[z];
            }
            for (int n = 0; n < joints; ++n) {
                double *to = row + (n * columns + (first - begin)) * joints;
                for (int z = 0; z < count; ++z)
                    for (int m = 0; m < joints; ++m)
                        to[z * joints + m] = block[n * joints + m][z];
            }
        }
    }
    free(room);
    return 1;
}

/* Write sum_j sum_m T_m,u of the potential part (x_i, u_j) a_jm to out[i]: it is d/dd there.

a: (J, N). out: (I,). Return whether there was memory. */
EXPORT int structured_potential(int joints, int serial, const int64_t *form, const double *numbers,
                                const double *x, int count, const double *u, int many,
                                const double *a, double *out)
{
    Arm arm = arm_of(joints, serial, form, numbers);
    Tile *room = new_tiles((size_t)joints * (PARTS + 3 + 1));
    if (!room)
        return 0;
    Tile (*right)[PARTS] = (Tile(*)[PARTS])room;
    Tile (*factors)[3] = (Tile(*)[3])(room + PARTS * joints);
    Tile *along = room + (PARTS + 3) * joints, found;
    for (int i = 0; i < count; ++i) {
        const double *left = x + (size_t)i * PARTS * joints;
        out[i] = 0.0;
        for (int first = 0; first < many; first += LANES) {
            int here = least(LANES, many - first);
            right_load(joints, u, first, here, right);
            for (int n = 0; n < joints; ++n) {
                factor((int)form[n], arm.swing[n], left + n, joints, right[n], factors[n]);
                for (int z = 0; z < LANES; ++z)
                    along[n][z] = a[(size_t)(first + least(z, here - 1)) * joints + n];
            }
            potential_slope(joints, factors, arm.potential, along, found);
            for (int z = 0; z < here; ++z)
                out[i] += found[z];
        }
    }
    free(room);
    return 1;
}

/* Exchange two factors (3, L). */
static void swap(Tile *one, Tile *other)
{
    for (int d = 0; d < 3; ++d)
        EACH_LANE {
            double held = one[d][z];
            one[d][z] = other[d][z];
            other[d][z] = held;
        }
}

/* Write what factors and their squares become by a step of 1 + w along their derivative by w: lost
beside the factor for neither a small nor a large w. */
static void load_moved(const Arm *arm, Pairs *pairs, Tile (*moved[2])[3], Tile (*moved_square[2])[3])
{
    Tile slope[3];
    for (int n = 0; n < arm->joints; ++n)
        for (int part = 0; part < 2; ++part) {
            double omega = part == KINETIC ? arm->wave[n] : arm->swing[n], step = 1.0 + omega;
            Tile *c = pairs->factors[part][n], *e = pairs->squares[part][n];
            Tile *to = moved[part][n], *square = moved_square[part][n];
            factor_rate((int)arm->form[n], omega, pairs->left + n, arm->joints, pairs->right[n], c,
                        slope);
            EACH_LANE {
                double c0 = c[0][z], c1 = c[1][z], c2 = c[2][z];
                double d0 = step * slope[0][z], d1 = step * slope[1][z], d2 = step * slope[2][z];
                to[0][z] = c0 + d0, to[1][z] = c1 + d1, to[2][z] = c2 + d2;
                square[0][z] = e[0][z] + 2.0 * c0 * d0;
                square[1][z] = e[1][z] + 2.0 * (c0 * d1 + c1 * d0);
                square[2][z] = e[2][z] + 2.0 * (2.0 * c1 * d1 + c0 * d2 + c2 * d0);
            }
        }
}

/* Fetch the weights of a state's pairs to (N, N, L), the vector's part to right (N, L).

A pair counts for its mirror image too; where a state meets itself, what stands above the diagonal
counts with what stands below. Lanes beyond the count weigh nothing. */
static void load_weights(int joints, int i, int first, int count, size_t stride,
                         const double *weights, const double *vector, Tile *weighed, Tile *right)
{
    memset(weighed, 0, (size_t)joints * joints * sizeof(Tile));
    memset(right, 0, (size_t)joints * sizeof(Tile));
    for (int n = 0; n < joints; ++n)
        for (int z = 0; z < count; ++z) {
            int j = first + z;
            const double *row = weights + ((size_t)i * joints + n) * stride + (size_t)j * joints;
            right[n][z] = vector[(size_t)j * joints + n];
            for (int m = 0; m < (j < i ? joints : n); ++m)
                weighed[n * joints + m][z] = 2.0 * row[m];
            if (j == i)
                weighed[n * joints + n][z] = row[n];
        }
}

/* Write sum_nm W_nm K_nm to total (L,), K a to by_row (N, L), K^T a to by_column (N, L).

block: (count, count, L) K, of the joints from `first` on. weights: (N, N, L) W. left: (N,) a of the
state on the left. right: (N, L) a of those on the right. */
static void weigh(int joints, int first, int count, Tile *block, Tile *weights, const double *left,
                  Tile *right, double *total, Tile *by_row, Tile *by_column)
{
    EACH_LANE total[z] = 0.0;
    memset(by_column, 0, (size_t)count * sizeof(Tile));
    for (int n = 0; n < count; ++n) {
        double *row = by_row[n], an = left[first + n];
        EACH_LANE row[z] = 0.0;
        for (int m = 0; m < count; ++m) {
            double *entries = block[n * count + m], *column = by_column[m], *am = right[first + m];
            double *weight = weights[(first + n) * joints + first + m];
            EACH_LANE {
                double entry = entries[z];
                total[z] += weight[z] * entry;
                row[z] += entry * am[z];
                column[z] += entry * an;
            }
        }
    }
}

/* Add sum_ab W_ab K_ab and K a of every piece K to totals (E,) and products (E, N, M).

Of the pairs of some rows with themselves and the states before them, and their mirror images.

x: (M, 5, N). rows: the first one, and how far on is the next. pieces: E; whats (E, 4): kind, first
joint, the one after the last, the one whose factor is moved, or -1; inertias (E, N); shares (E, N) of
the links. weights: (M N, M N) symmetric W, of which the lower triangle is read. vector: (M, N) a.
Return whether there was memory. */
EXPORT int structured_contract(int joints, int serial, const int64_t *form, const double *numbers,
                               const double *x, int samples, const int64_t *rows, int pieces,
                               const int64_t *whats, const double *inertias, const double *shares,
                               const double *weights, const double *vector, double *totals,
                               double *products)
{
    Arm arm = arm_of(joints, serial, form, numbers);
    size_t square = (size_t)joints * joints;
    Tile *room = new_tiles(pairs_tiles(joints) + 12 * joints + 2 * square + 3 * joints);
    if (!room)
        return 0;
    Pairs pairs;
    pairs_place(&pairs, joints, room);
    Tile *next = room + pairs_tiles(joints), total;
    Tile (*moved[2])[3] = {(Tile(*)[3])next, (Tile(*)[3])(next + 3 * joints)};
    next += 6 * joints;
    Tile (*moved_square[2])[3] = {(Tile(*)[3])next, (Tile(*)[3])(next + 3 * joints)};
    next += 6 * joints;
    Tile *block = next, *weighed = next + square, *right = weighed + square;
    Tile *by_row = right + joints, *by_column = by_row + joints;
    for (int i = (int)rows[0]; i < samples; i += (int)rows[1])
        for (int first = 0; first <= i; first += LANES) {
            int count = least(LANES, i + 1 - first);
            pairs_load(&arm, x, i, x, first, count, &pairs);
            load_moved(&arm, &pairs, moved, moved_square);
            load_weights(joints, i, first, count, (size_t)samples * joints, weights, vector,
                         weighed, right);
            for (int p = 0; p < pieces; ++p) {
                const double *inertia = inertias + p * joints, *share = shares + p * joints;
                int kind = (int)whats[4 * p], begin = (int)whats[4 * p + 1];
                int end = (int)whats[4 * p + 2], joint = (int)whats[4 * p + 3];
                int own = end - begin;
                if (joint >= 0) {
                    swap(pairs.factors[kind][joint], moved[kind][joint]);
                    swap(pairs.squares[kind][joint], moved_square[kind][joint]);
                }
                if (kind == KINETIC) {
                    kinetic(&arm, &pairs, begin, end, inertia, share, block);
                } else {
                    memset(block, 0, (size_t)own * own * sizeof(Tile));
                    double a = pairs.left[QDD * joints + begin];
                    if (kind == POTENTIAL)
                        add_potential(own, pairs.factors[POTENTIAL] + begin, share + begin,
                                      pairs.work, block);
                    else
                        EACH_LANE block[0][z] = a * pairs.right[begin][QDD][z];
                }
                if (joint >= 0) {
                    swap(pairs.factors[kind][joint], moved[kind][joint]);
                    swap(pairs.squares[kind][joint], moved_square[kind][joint]);
                }
                weigh(joints, begin, own, block, weighed, vector + (size_t)i * joints, right,
                      total, by_row, by_column);
                for (int z = 0; z < LANES; ++z)
                    totals[p] += total[z];
                for (int n = 0; n < own; ++n) {
                    double *to = products + ((size_t)p * joints + begin + n) * samples;
                    for (int z = 0; z < LANES; ++z)
                        to[i] += by_row[n][z];
                    /* A state paired with itself has no mirror image. */
                    for (int z = 0; z < least(count, i - first); ++z)
                        to[first + z] += by_column[n][z];
                }
            }
        }
    free(room);
    return 1;
}
