/* The universal Lagrangian kernels (36), (37).

The scalar kernel on the Lagrangian is k = exp(-sum_j rho_j(q_j - q'_j) / 2 - sum_j w_j (qd_j -
qd'_j)^2 / 2) with rho_j = alpha_j d^2 for a linear coordinate and 2 alpha_j (1 - cos d) for an angle,
d = q_j - q'_j. Its push-forward through the Euler-Lagrange operator on both arguments is *diagonal
plus four outer products*. With e = w (qd - qd'), x = w qdd, u = w qdd', p_j = d rho_j / dd / 2,
r_j = d p_j / dd and

    c_x  = p.qd  + e.qdd          (minus the rate of log k along the first motion)
    c_u  = p.qd' + e.qdd'         (the rate of log k along the second)
    c_xu = sum_j r_j qd_j qd'_j + w_j qdd_j qdd'_j
    A    = c_x e - x + p          (T_n,x k = k A_n)
    B    = c_u e - u - p          (T_m,u k = k B_m, eq. (34))

it reads

    K / k = A B^T + diag(r + (c_xu - c_x c_u) w)
            - (c_xu e + c_x u + r qd') e^T - e (c_u x - r qd)^T + u x^T,

which equals eq. (37) of the paper with c_u read for its c_y, and the Jacobian at u for the last
factor of its K_2. How it is applied to coefficients without forming a block is in centres.c. */

#include "tiles.h"

/* The numbers of a kernel of N joints. */
typedef struct {
    int joints, angles;
    const double *alpha, *w; /* (N,) */
} Universal;

/* One pair of states, and what its block is made of. */
typedef struct {
    const double *x, *u; /* (5, N) */
    double k, cx, cu, cxu;
    double *e, *p, *r; /* (N,) */
} Pair;

static inline void meet(const Universal *kernel, const double *x, const double *u, Pair *pair)
{
    int joints = kernel->joints;
    double exponent = 0.0, cx = 0.0, cu = 0.0, cxu = 0.0;
    for (int n = 0; n < joints; ++n) {
        double alpha = kernel->alpha[n], w = kernel->w[n], p, r;
        double v = x[QD * joints + n], vu = u[QD * joints + n];
        double a = x[QDD * joints + n], au = u[QDD * joints + n];
        if (kernel->angles) {
            double sine = x[SIN * joints + n], cosine = x[COS * joints + n];
            double other_sine = u[SIN * joints + n], other_cosine = u[COS * joints + n];
            p = alpha * (sine * other_cosine - cosine * other_sine);
            r = alpha * (cosine * other_cosine + sine * other_sine);
            exponent += alpha - r;
        } else {
            double d = x[Q * joints + n] - u[Q * joints + n];
            p = alpha * d;
            r = alpha;
            exponent += 0.5 * p * d;
        }
        double e = w * (v - vu);
        exponent += 0.5 * e * (v - vu);
        cx += p * v + e * a;
        cu += p * vu + e * au;
        cxu += r * v * vu + w * a * au;
        pair->e[n] = e, pair->p[n] = p, pair->r[n] = r;
    }
    pair->x = x, pair->u = u;
    pair->k = exponential(-exponent);
    pair->cx = cx, pair->cu = cu, pair->cxu = cxu;
}

/* Write row n of the block to out (N,). */
static inline void write_row(const Universal *kernel, const Pair *pair, int n, double *out)
{
    int joints = kernel->joints;
    const double *w = kernel->w, *e = pair->e, *p = pair->p, *r = pair->r;
    const double *v = pair->x + QD * joints, *a = pair->x + QDD * joints;
    const double *vu = pair->u + QD * joints, *au = pair->u + QDD * joints;
    double k = pair->k, cx = pair->cx, cu = pair->cu, cxu = pair->cxu;
    double an = k * (cx * e[n] - w[n] * a[n] + p[n]), en = k * e[n], un = k * w[n] * au[n];
    double left = cxu * en + cx * un + k * r[n] * vu[n];
    for (int m = 0; m < joints; ++m) {
        double xm = w[m] * a[m];
        out[m] = an * (cu * e[m] - w[m] * au[m] - p[m]) - left * e[m]
                 - en * (cu * xm - r[m] * v[m]) + un * xm;
    }
    out[n] += k * (r[n] + w[n] * (cxu - cx * cu));
}

/* Return the entry K_nn of the block, the scalar Lagrangian kernel (30). */
static inline double diagonal(const Universal *kernel, const Pair *pair, int n)
{
    int joints = kernel->joints;
    double w = kernel->w[n], e = pair->e[n], p = pair->p[n], r = pair->r[n];
    double v = pair->x[QD * joints + n], vu = pair->u[QD * joints + n];
    double x = w * pair->x[QDD * joints + n], u = w * pair->u[QDD * joints + n];
    double cx = pair->cx, cu = pair->cu, cxu = pair->cxu;
    return pair->k
           * ((cx * e - x + p) * (cu * e - u - p) - (cxu * e + cx * u + r * vu) * e
              - e * (cu * x - r * v) + u * x + r + w * (cxu - cx * cu));
}

/* Write K(x_i, u_j)_nm to out[i - rows[0], n, j, m], of the rows from the first up to the second;
where `lower`, only of j up to i. out: (I, N, many, N). */
EXPORT void universal_blocks(int joints, int angles, const double *alpha, const double *w,
                             const double *x, const double *u, const int64_t *rows, int many,
                             int lower, double *out)
{
    Universal kernel = {joints, angles, alpha, w};
    double room[3 * joints];
    Pair pair = {.e = room, .p = room + joints, .r = room + 2 * joints};
    size_t stride = (size_t)PARTS * joints, columns = (size_t)many * joints;
    for (int i = (int)rows[0]; i < rows[1]; ++i)
        for (int j = 0; j < (lower ? i + 1 : many); ++j) {
            meet(&kernel, x + i * stride, u + j * stride, &pair);
            double *to = out + (i - rows[0]) * joints * columns + (size_t)j * joints;
            for (int n = 0; n < joints; ++n)
                write_row(&kernel, &pair, n, to + n * columns);
        }
}

/* Write the scalar kernel K_nn(x_i, u_j) of joint n to out[i, j]. */
EXPORT void universal_diagonal(int joints, int angles, const double *alpha, const double *w,
                               const double *x, int count, const double *u, int many, int joint,
                               double *out)
{
    Universal kernel = {joints, angles, alpha, w};
    double room[3 * joints];
    Pair pair = {.e = room, .p = room + joints, .r = room + 2 * joints};
    size_t stride = (size_t)PARTS * joints;
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < many; ++j) {
            meet(&kernel, x + i * stride, u + j * stride, &pair);
            out[(size_t)i * many + j] = diagonal(&kernel, &pair, joint);
        }
}

/* Write sum_j K_nn(x_i, u_j) a_jn of joint n to out[i, n]. a: (many, N). out: (count, N). */
EXPORT void universal_diagonal_apply(int joints, int angles, const double *alpha, const double *w,
                                     const double *x, int count, const double *u, int many,
                                     int joint, const double *a, double *out)
{
    Universal kernel = {joints, angles, alpha, w};
    double room[3 * joints];
    Pair pair = {.e = room, .p = room + joints, .r = room + 2 * joints};
    size_t stride = (size_t)PARTS * joints;
    for (int i = 0; i < count; ++i) {
        double sum = 0.0;
        for (int j = 0; j < many; ++j) {
            meet(&kernel, x + i * stride, u + j * stride, &pair);
            sum += diagonal(&kernel, &pair, joint) * a[(size_t)j * joints + joint];
        }
        out[(size_t)i * joints + joint] = sum;
    }
}

/* Write K_nn(x_i, x_i) to out[i, n]. */
EXPORT void universal_variance(int joints, int angles, const double *alpha, const double *w,
                               const double *x, int count, double *out)
{
    Universal kernel = {joints, angles, alpha, w};
    double room[3 * joints];
    Pair pair = {.e = room, .p = room + joints, .r = room + 2 * joints};
    for (int i = 0; i < count; ++i) {
        const double *state = x + (size_t)i * PARTS * joints;
        meet(&kernel, state, state, &pair);
        for (int n = 0; n < joints; ++n)
            out[(size_t)i * joints + n] = diagonal(&kernel, &pair, n);
    }
}

/* Write T_m,u k(x_i, u_j) to out[i, j, m], eq. (34). */
EXPORT void universal_lagrangian_rows(int joints, int angles, const double *alpha, const double *w,
                                      const double *x, int count, const double *u, int many,
                                      double *out)
{
    Universal kernel = {joints, angles, alpha, w};
    double room[3 * joints];
    Pair pair = {.e = room, .p = room + joints, .r = room + 2 * joints};
    size_t stride = (size_t)PARTS * joints;
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < many; ++j) {
            meet(&kernel, x + i * stride, u + j * stride, &pair);
            double *to = out + ((size_t)i * many + j) * joints;
            for (int m = 0; m < joints; ++m)
                to[m] = pair.k
                        * (pair.cu * pair.e[m] - w[m] * pair.u[QDD * joints + m] - pair.p[m]);
        }
}

/* Write L = sum_j sum_m T_m,u k(x_i, u_j) a_jm to value[i], and dL/dqd to momentum[i]. a: (J, N). */
EXPORT void universal_lagrangian(int joints, int angles, const double *alpha, const double *w,
                                 const double *x, int count, const double *u, int many,
                                 const double *a, double *value, double *momentum)
{
    Universal kernel = {joints, angles, alpha, w};
    double room[3 * joints];
    Pair pair = {.e = room, .p = room + joints, .r = room + 2 * joints};
    size_t stride = (size_t)PARTS * joints;
    for (int i = 0; i < count; ++i) {
        double *rise = momentum + (size_t)i * joints;
        value[i] = 0.0;
        for (int n = 0; n < joints; ++n)
            rise[n] = 0.0;
        for (int j = 0; j < many; ++j) {
            meet(&kernel, x + i * stride, u + j * stride, &pair);
            const double *weight = a + (size_t)j * joints, *au = pair.u + QDD * joints;
            double along_b = 0.0, along_e = 0.0;
            for (int m = 0; m < joints; ++m) {
                along_b += (pair.cu * pair.e[m] - w[m] * au[m] - pair.p[m]) * weight[m];
                along_e += pair.e[m] * weight[m];
            }
            value[i] += pair.k * along_b;
            for (int n = 0; n < joints; ++n)
                rise[n] += pair.k
                           * (w[n] * (au[n] * along_e + pair.cu * weight[n]) - pair.e[n] * along_b);
        }
    }
}
