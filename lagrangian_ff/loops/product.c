/* The kinetic part of an arm of any topology: s^2 h / 2, s = sum_j I_j qd_j qd'_j, h = prod_l c_l^2.

Every entry of the mass matrix may depend on every joint. With e_l = c_l^2, w = I qd', b = I qdd',
v = qd, a = qdd, subscripts of h its derivatives in d, and along qd and qd'

    h_v = sum_l h_l v_l,   h_u = sum_l h_l qd'_l,   h_vu = sum_lm h_lm v_l qd'_m,

the push-forward (22) of the kernel is

    delta_nm I_n sum_k (b_k (h a_k + h_v v_k) - w_k (h_u a_k + h_vu v_k))
    + I_m (b_n (h a_m + h_v v_m) - w_n (h_u a_m + h_vu v_m))
    - I_m v_m (h_n b.v - sum_l h_nl qd'_l w.v) + w_n (h_m w.a + sum_l h_ml v_l w.v)
    - h_nm (w.v)^2 / 2. */

#include "structured.h"

typedef struct {
    Tile *w, *b, *first, *along_v, *along_u, *bend; /* (N, L), bend (N, N, L) */
    double *h, *hv, *hu, *hvu, *wa, *wv, *ba, *bv;  /* (L,) */
} Sums;

/* Write I qd', I qdd' and their products with velocity and acceleration on the left. */
static void write_products(int joints, const double *v, const double *a, Tile (*right)[PARTS],
                           const double *inertia, Sums s)
{
    EACH_LANE s.wa[z] = s.wv[z] = s.ba[z] = s.bv[z] = 0.0;
    for (int n = 0; n < joints; ++n) {
        double own = inertia[n], vn = v[n], an = a[n];
        EACH_LANE {
            double w = own * right[n][QD][z], b = own * right[n][QDD][z];
            s.w[n][z] = w;
            s.b[n][z] = b;
            s.wa[z] += w * an;
            s.wv[z] += w * vn;
            s.ba[z] += b * an;
            s.bv[z] += b * vn;
        }
    }
}

/* Write scale h and its first and second derivatives. head and tail are left as the products of the
factors before and beyond each; run is to work in. */
static void write_bends(int joints, Tile (*e)[3], double scale, Tile *head, Tile *tail, double *run,
                        Sums s)
{
    EACH_LANE {
        s.h[z] = scale;
        tail[joints - 1][z] = 1.0;
    }
    for (int n = 0; n < joints; ++n)
        EACH_LANE {
            head[n][z] = s.h[z];
            s.h[z] *= e[n][0][z];
        }
    for (int n = joints - 1; n > 0; --n)
        EACH_LANE tail[n - 1][z] = tail[n][z] * e[n][0][z];
    for (int n = 0; n < joints; ++n) {
        double *own = s.bend[n * joints + n];
        EACH_LANE {
            run[z] = head[n][z] * e[n][1][z];
            s.first[n][z] = run[z] * tail[n][z];
            own[z] = head[n][z] * e[n][2][z] * tail[n][z];
        }
        for (int m = n + 1; m < joints; ++m) {
            double *above = s.bend[n * joints + m], *below = s.bend[m * joints + n];
            EACH_LANE {
                double both = run[z] * e[m][1][z] * tail[m][z];
                above[z] = both;
                below[z] = both;
                run[z] *= e[m][0][z];
            }
        }
    }
}

/* Write the derivatives of h and of its first derivatives along the velocities. */
static void write_rates(int joints, const double *v, Tile (*right)[PARTS], Sums s)
{
    EACH_LANE s.hv[z] = s.hu[z] = s.hvu[z] = 0.0;
    for (int n = 0; n < joints; ++n) {
        double vn = v[n];
        EACH_LANE {
            s.hv[z] += s.first[n][z] * vn;
            s.hu[z] += s.first[n][z] * right[n][QD][z];
            s.along_v[n][z] = s.along_u[n][z] = 0.0;
        }
        for (int m = 0; m < joints; ++m) {
            double vm = v[m], *bend = s.bend[n * joints + m];
            EACH_LANE {
                s.along_v[n][z] += bend[z] * vm;
                s.along_u[n][z] += bend[z] * right[m][QD][z];
            }
        }
        EACH_LANE s.hvu[z] += s.along_v[n][z] * right[n][QD][z];
    }
}

void product_kinetic(int joints, const double *v, const double *a, Tile (*right)[PARTS],
                     Tile (*e)[3], const double *inertia, const double *link, Tile *work,
                     Tile *out)
{
    Sums s = {
        .w = work, .b = work + joints, .first = work + 2 * joints,
        .along_v = work + 3 * joints, .along_u = work + 4 * joints, .bend = work + 15 * joints,
        .h = work[5 * joints], .hv = work[6 * joints], .hu = work[7 * joints],
        .hvu = work[8 * joints], .wa = work[9 * joints], .wv = work[10 * joints],
        .ba = work[11 * joints], .bv = work[12 * joints],
    };
    Tile *head = work + 13 * joints, *tail = work + 14 * joints;
    write_products(joints, v, a, right, inertia, s);
    write_bends(joints, e, link[joints - 1], head, tail, s.along_v[0], s);
    write_rates(joints, v, right, s);
    for (int n = 0; n < joints; ++n) {
        for (int m = 0; m < joints; ++m) {
            double *block = out[n * joints + m], *bend = s.bend[n * joints + m];
            double own = inertia[m], vm = v[m], am = a[m];
            EACH_LANE {
                double straight = s.h[z] * am + s.hv[z] * vm;
                double turned = s.hu[z] * am + s.hvu[z] * vm;
                double fall = s.first[n][z] * s.bv[z] - s.along_u[n][z] * s.wv[z];
                double rise = s.first[m][z] * s.wa[z] + s.along_v[m][z] * s.wv[z];
                block[z] = own * (s.b[n][z] * straight - s.w[n][z] * turned - vm * fall)
                           + s.w[n][z] * rise - 0.5 * bend[z] * s.wv[z] * s.wv[z];
            }
        }
        double *block = out[n * joints + n], own = inertia[n];
        EACH_LANE
            block[z] += own * (s.h[z] * s.ba[z] + s.hv[z] * s.bv[z] - s.hu[z] * s.wa[z]
                               - s.hvu[z] * s.wv[z]);
    }
}
