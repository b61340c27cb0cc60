/* Rigid links as trigonometric polynomials: M(q), V(q) and rotors.

M_jk, j <= k, is of first degree in cosine and sine of the joints j+1 .. k and of second degree in
those beyond. Its coefficients for one k are an array whose slowest index is that of the last joint: a
joint is taken out of it by adding blocks, each times a function of the joint, or times its slope. */

/* Write the sum of 3 or 5 blocks (count,), each times value[f], to `to`, and times slope[f] to `bent`.
value[0] is 1 and slope[0] is 0. */
static void take_out(const real *restrict from, int count, int functions, const real *value,
                     const real *slope, real *restrict to, real *restrict bent)
{
    const real *one = from + count, *two = one + count;
    const real v1 = value[1], v2 = value[2], s1 = slope[1], s2 = slope[2];
    if (functions == 3) {
        for (int r = 0; r < count; ++r) {
            to[r] = from[r] + (v1 * one[r] + v2 * two[r]);
            bent[r] = s1 * one[r] + s2 * two[r];
        }
    } else {
        const real *three = two + count, *four = three + count;
        const real v3 = value[3], v4 = value[4], s3 = slope[3], s4 = slope[4];
        for (int r = 0; r < count; ++r) {
            to[r] = from[r] + ((v1 * one[r] + v2 * two[r]) + (v3 * three[r] + v4 * four[r]));
            bent[r] = (s1 * one[r] + s2 * two[r]) + (s3 * three[r] + s4 * four[r]);
        }
    }
}

/* Do the same without slopes. */
static void take_out_value(const real *restrict from, int count, int functions, const real *value,
                           real *restrict to)
{
    const real *one = from + count, *two = one + count;
    const real v1 = value[1], v2 = value[2];
    if (functions == 3) {
        for (int r = 0; r < count; ++r)
            to[r] = from[r] + (v1 * one[r] + v2 * two[r]);
    } else {
        const real *three = two + count, *four = three + count;
        const real v3 = value[3], v4 = value[4];
        for (int r = 0; r < count; ++r)
            to[r] = from[r] + ((v1 * one[r] + v2 * two[r]) + (v3 * three[r] + v4 * four[r]));
    }
}

/* Take a joint out of `had` arrays, each `stride` long: the first is a value, the others are its slopes
by joints that were taken out before. One more slope is behind those that are written. */
static void take_joint(const real *from, int had, int stride, int count, int functions,
                       const real *value, const real *slope, real *to)
{
    take_out(from, count, functions, value, slope, to, to + had * count);
    for (int one = 1; one < had; ++one)
        take_out_value(from + one * stride, count, functions, value, to + one * count);
}

/* Add what the entry M_jk adds to the torque. value: M_jk, and `stride` further on each its slope by
joint N-1, N-2 .. j+1. */
static void add_entry(int j, int k, const real *value, int stride, const real *qd, const real *qdd,
                      real *tau)
{
    const real share = j < k ? qd[j] * qd[k] : R(0.5) * qd[k] * qd[k];
    real rate = R(0.0);
    for (int n = N - 1; n > j; --n) {
        const real slope = value[(N - n) * stride];
        rate += slope * qd[n];
        tau[n] -= share * slope;
    }
    tau[j] += value[0] * qdd[k] + rate * qd[k];
    if (j < k)
        tau[k] += value[0] * qdd[j] + rate * qd[j];
}

static void trigonometric_torque(const real *q, const real *qd, const real *qdd, real *tau)
{
    /* Functions of each joint and their slopes; what two joints in turn leave of the coefficients. */
    real value[N][5], slope[N][5], room[2][TRIGONOMETRIC_ROOM];
    for (int n = 0; n < N; ++n) {
        const real c = F(cos)(q[n]), s = F(sin)(q[n]), c2 = c * c - s * s, s2 = R(2.0) * s * c;
        value[n][0] = R(1.0), value[n][1] = c, value[n][2] = s, value[n][3] = c2, value[n][4] = s2;
        slope[n][0] = R(0.0), slope[n][1] = -s, slope[n][2] = c;
        slope[n][3] = R(-2.0) * s2, slope[n][4] = R(2.0) * c2;
        tau[n] = trigonometric_rotor[n] * qdd[n];
    }
    const real *mass = trigonometric_mass;
    int rows = 1;
    for (int k = 0; k < N; ++k) {
        int size = rows, had = 1, side = 0, stride;
        for (int n = N - 1; n > k; --n)
            size *= 5;
        const real *from = mass;
        mass += size;
        stride = size;
        for (int n = N - 1; n > k; --n) {
            const int count = stride / 5;
            take_joint(from, had++, stride, count, 5, value[n], slope[n], room[side]);
            from = room[side], side = 1 - side, stride = count;
        }
        for (int j = k; j >= 0; --j) {
            add_entry(j, k, from + stride - 1, stride, qd, qdd, tau);
            if (j > 0) {
                const int count = stride / 3;
                take_joint(from, had++, stride, count, 3, value[j], slope[j], room[side]);
                from = room[side], side = 1 - side, stride = count;
            }
        }
        rows = 3 * rows + 1;
    }
    const real *from = trigonometric_potential;
    int had = 1, side = 0, stride = TRIGONOMETRIC_HEIGHTS;
    for (int n = N - 1; n >= 0; --n) {
        const int count = stride / 3;
        take_joint(from, had++, stride, count, 3, value[n], slope[n], room[side]);
        from = room[side], side = 1 - side, stride = count;
    }
    for (int n = 0; n < N; ++n)
        tau[n] += from[N - n];
}
