/* The kinetic part of a serial arm: what its mass matrix can depend on, and on nothing else.

Entry (j, k), j <= k, of the mass matrix collects the links i >= k. Seen from joint j, link i moves
with the angles of the joints j+1 .. i only: with first degree in cosine and sine of those up to k,
of second degree in those beyond, since two Jacobian columns are multiplied there. A kernel that
says so, each entry apart, is sum_jk t_j t_k F_jk / 2 with t_j = I_j qd_j qd'_j and

    F_jk = prod_{j<l<=k} c_l H_k,      H_k = kappa_k + c_{k+1}^2 H_{k+1},      j <= k,

where kappa_i is the weight of link i and c_l the factor of joint l. With w = I qd', b = I qdd',
v = qd, a = qdd, Fv and Fu the derivatives of F along qd and qd' (in d), the push-forward (22) is

    delta_nm I_n sum_k (b_k (F_nk a_k + Fv_nk v_k) - w_k (Fu_nk a_k + Fvu_nk v_k))
    + I_m (b_n (F_nm a_m + Fv_nm v_m) - w_n (Fu_nm a_m + Fvu_nm v_m))
    - I_m v_m sum_k d_n (F_mk b_k v_k - Fu_mk w_k v_k)
    + w_n sum_k d_m (F_nk w_k a_k + Fv_nk w_k v_k)
    - d_n d_m sum_jk F_jk w_j v_j w_k v_k / 2.

Sums over k are recursions along the chain, so that a block costs O(N^2), as much as writing it:

    sum_k t_k F_mk = P_m H_m + S_m,
    P_m = c_m (t_{m-1} + P_{m-1}),      S_m = t_m H_m + c_{m+1} S_{m+1}.

Beside a value x stand its changes in time, xv on the left and xu on the right: those of t with the
acceleration, those of F and H along the velocity. The factors c_l and their squares e_l = c_l^2 come
apart: every term has one of the two of a joint, once, or none, so that K is affine in each joint's. */

#include "structured.h"

typedef struct {
    int joints;
    const double *v, *a, *inertia, *link; /* (N,) */
    Tile (*right)[PARTS], (*c)[3], (*e)[3];
    /* (N, L), as above; g and r are to work in. */
    Tile *w, *b, *t, *tv, *tu, *h, *hv, *hu, *hvu, *p, *pv, *pu, *s, *sv, *su, *r, *rv, *ru, *g,
        *gv, *gu;
} Chain;

/* Write I qd', I qdd', t and its changes; that on the right with the sign it has in d. */
static void write_products(const Chain *k)
{
    for (int n = 0; n < k->joints; ++n) {
        double own = k->inertia[n], v = k->v[n], a = k->a[n];
        double *vu = k->right[n][QD], *au = k->right[n][QDD];
        double *w = k->w[n], *b = k->b[n], *t = k->t[n], *tv = k->tv[n], *tu = k->tu[n];
        EACH_LANE {
            w[z] = own * vu[z];
            b[z] = own * au[z];
            t[z] = w[z] * v;
            tv[z] = w[z] * a;
            tu[z] = -b[z] * v;
        }
    }
}

/* Write P. */
static void write_heads(const Chain *k)
{
    EACH_LANE k->p[0][z] = k->pv[0][z] = k->pu[0][z] = 0.0;
    for (int m = 1; m < k->joints; ++m) {
        double x = k->v[m], *vu = k->right[m][QD], *c0 = k->c[m][0], *c1 = k->c[m][1];
        double *t = k->t[m - 1], *tv = k->tv[m - 1], *tu = k->tu[m - 1];
        double *before = k->p[m - 1], *before_v = k->pv[m - 1], *before_u = k->pu[m - 1];
        double *p = k->p[m], *pv = k->pv[m], *pu = k->pu[m];
        EACH_LANE {
            double y = t[z] + before[z];
            p[z] = c0[z] * y;
            pv[z] = c0[z] * (tv[z] + before_v[z]) + c1[z] * x * y;
            pu[z] = c0[z] * (tu[z] + before_u[z]) + c1[z] * vu[z] * y;
        }
    }
}

/* Write H. */
static void write_tails(const Chain *k)
{
    int last = k->joints - 1;
    EACH_LANE {
        k->h[last][z] = k->link[last];
        k->hv[last][z] = k->hu[last][z] = k->hvu[last][z] = 0.0;
    }
    for (int m = last; m > 0; --m) {
        double x = k->v[m], weight = k->link[m - 1];
        double *vu = k->right[m][QD], *e0 = k->e[m][0], *e1 = k->e[m][1], *e2 = k->e[m][2];
        double *below = k->h[m], *below_v = k->hv[m], *below_u = k->hu[m], *below_vu = k->hvu[m];
        double *h = k->h[m - 1], *hv = k->hv[m - 1], *hu = k->hu[m - 1], *hvu = k->hvu[m - 1];
        EACH_LANE {
            double y = vu[z], turned = x * below_u[z] + y * below_v[z];
            h[z] = weight + e0[z] * below[z];
            hv[z] = e0[z] * below_v[z] + e1[z] * x * below[z];
            hu[z] = e0[z] * below_u[z] + e1[z] * y * below[z];
            hvu[z] = e0[z] * below_vu[z] + e1[z] * turned + e2[z] * x * y * below[z];
        }
    }
}

/* Write S. */
static void write_sums(const Chain *k)
{
    for (int m = k->joints - 1; m >= 0; --m) {
        double *s = k->s[m], *sv = k->sv[m], *su = k->su[m];
        double *t = k->t[m], *tv = k->tv[m], *tu = k->tu[m];
        double *h = k->h[m], *hv = k->hv[m], *hu = k->hu[m];
        EACH_LANE {
            s[z] = t[z] * h[z];
            sv[z] = t[z] * hv[z] + tv[z] * h[z];
            su[z] = t[z] * hu[z] + tu[z] * h[z];
        }
        if (m == k->joints - 1)
            continue;
        double x = k->v[m + 1], *vu = k->right[m + 1][QD];
        double *c0 = k->c[m + 1][0], *c1 = k->c[m + 1][1];
        double *below = k->s[m + 1], *below_v = k->sv[m + 1], *below_u = k->su[m + 1];
        EACH_LANE {
            s[z] += c0[z] * below[z];
            sv[z] += c0[z] * below_v[z] + c1[z] * x * below[z];
            su[z] += c0[z] * below_u[z] + c1[z] * vu[z] * below[z];
        }
    }
}

/* Write the terms of F without its derivatives by joint, the sum over k on the diagonal. */
static void write_entries(const Chain *k, Tile *out)
{
    int joints = k->joints;
    const double *a = k->a, *v = k->v;
    Tile run, run_v, run_u, run_vu;
    Tile *diagonal = k->r;
    for (int j = 0; j < joints; ++j) {
        double *h = k->h[j], *hv = k->hv[j], *hu = k->hu[j], *hvu = k->hvu[j];
        double *b = k->b[j], *w = k->w[j], *own = diagonal[j], aj = a[j], vj = v[j];
        EACH_LANE {
            double straight = h[z] * aj + hv[z] * vj, turned = hu[z] * aj + hvu[z] * vj;
            own[z] = 2.0 * (b[z] * straight - w[z] * turned);
        }
    }
    for (int j = 0; j < joints; ++j) {
        EACH_LANE {
            run[z] = 1.0;
            run_v[z] = run_u[z] = run_vu[z] = 0.0;
        }
        double *bj = k->b[j], *wj = k->w[j], *own = diagonal[j], aj = a[j], vj = v[j];
        double mass_j = k->inertia[j];
        for (int m = j + 1; m < joints; ++m) {
            double x = v[m], am = a[m], mass_m = k->inertia[m], *vu = k->right[m][QD];
            double *c0 = k->c[m][0], *c1 = k->c[m][1], *c2 = k->c[m][2];
            double *h = k->h[m], *hv = k->hv[m], *hu = k->hu[m], *hvu = k->hvu[m];
            double *bm = k->b[m], *wm = k->w[m], *other = diagonal[m];
            double *above = out[j * joints + m], *below = out[m * joints + j];
            EACH_LANE {
                double y = vu[z], p = run[z], pv = run_v[z], pu = run_u[z];
                double next = p * c0[z];
                double next_v = pv * c0[z] + p * c1[z] * x;
                double next_u = pu * c0[z] + p * c1[z] * y;
                double next_vu
                    = run_vu[z] * c0[z] + c1[z] * (pv * y + pu * x) + p * c2[z] * x * y;
                double f = next * h[z];
                double fv = next_v * h[z] + next * hv[z];
                double fu = next_u * h[z] + next * hu[z];
                double fvu = next_vu * h[z] + next_v * hu[z] + next_u * hv[z] + next * hvu[z];
                double straight = f * am + fv * x, turned = fu * am + fvu * x;
                run[z] = next, run_v[z] = next_v, run_u[z] = next_u, run_vu[z] = next_vu;
                own[z] += bm[z] * straight - wm[z] * turned;
                above[z] = mass_m * (bj[z] * straight - wj[z] * turned);
                straight = f * aj + fv * vj;
                turned = fu * aj + fvu * vj;
                other[z] += bj[z] * straight - wj[z] * turned;
                below[z] = mass_j * (bm[z] * straight - wm[z] * turned);
            }
        }
    }
    for (int j = 0; j < joints; ++j) {
        double *block = out[j * joints + j], *own = diagonal[j], mass = k->inertia[j];
        EACH_LANE block[z] = mass * own[z];
    }
}

/* Add the derivatives of sum_k t_k F_mk by the joints n > m. At n, g is that of H_m, r of S_m. */
static void add_slopes_beyond(const Chain *k, Tile *out)
{
    int joints = k->joints;
    for (int i = joints - 1; i > 0; --i) {
        int m = i - 1;
        double x = k->v[i], own = k->inertia[m] * k->v[m], *vu = k->right[i][QD];
        double *c0 = k->c[i][0], *c1 = k->c[i][1], *c2 = k->c[i][2];
        double *e0 = k->e[i][0], *e1 = k->e[i][1], *e2 = k->e[i][2];
        double *h = k->h[i], *hv = k->hv[i], *hu = k->hu[i];
        double *s = k->s[i], *sv = k->sv[i], *su = k->su[i];
        double *t = k->t[m], *tv = k->tv[m], *tu = k->tu[m], *w = k->w[m];
        double *p = k->p[m], *pv = k->pv[m], *pu = k->pu[m];
        for (int n = i; n < joints; ++n) {
            double *g = k->g[n], *gv = k->gv[n], *gu = k->gu[n];
            double *r = k->r[n], *rv = k->rv[n], *ru = k->ru[n];
            if (n == i)
                EACH_LANE {
                    double y = vu[z];
                    g[z] = e1[z] * h[z];
                    gv[z] = e1[z] * hv[z] + e2[z] * x * h[z];
                    gu[z] = e1[z] * hu[z] + e2[z] * y * h[z];
                    r[z] = c1[z] * s[z];
                    rv[z] = c1[z] * sv[z] + c2[z] * x * s[z];
                    ru[z] = c1[z] * su[z] + c2[z] * y * s[z];
                }
            else
                EACH_LANE {
                    double y = vu[z];
                    gv[z] = e0[z] * gv[z] + e1[z] * x * g[z];
                    gu[z] = e0[z] * gu[z] + e1[z] * y * g[z];
                    g[z] = e0[z] * g[z];
                    rv[z] = c0[z] * rv[z] + c1[z] * x * r[z];
                    ru[z] = c0[z] * ru[z] + c1[z] * y * r[z];
                    r[z] = c0[z] * r[z];
                }
            double *above = out[m * joints + n], *below = out[n * joints + m];
            EACH_LANE {
                r[z] += t[z] * g[z];
                rv[z] += t[z] * gv[z] + tv[z] * g[z];
                ru[z] += t[z] * gu[z] + tu[z] * g[z];
                above[z] += w[z] * (rv[z] + p[z] * gv[z] + pv[z] * g[z]);
                below[z] += own * (ru[z] + p[z] * gu[z] + pu[z] * g[z]);
            }
        }
    }
}

/* Add the derivatives of sum_k t_k F_mk by the joints n <= m, and half the second ones of Q.

Q = sum_jk t_j t_k F_jk = sum_m X_m H_m with X_m = t_m (t_m + 2 P_m), and Y_m = X_m + e_m Y_{m-1}
gathers what H_m meets. At n, r is the derivative of P_m, bend that of Y_m. */
static void add_slopes_before(const Chain *k, Tile *out)
{
    int joints = k->joints;
    double *square = k->g[0];
    Tile *bends = k->gv;
    EACH_LANE square[z] = k->t[0][z] * k->t[0][z];
    for (int m = 1; m < joints; ++m) {
        double x = k->v[m], own = k->inertia[m] * k->v[m], *vu = k->right[m][QD];
        double *c0 = k->c[m][0], *c1 = k->c[m][1], *c2 = k->c[m][2];
        double *e0 = k->e[m][0], *e1 = k->e[m][1], *e2 = k->e[m][2];
        double *h = k->h[m], *hv = k->hv[m], *hu = k->hu[m], *s = k->s[m], *w = k->w[m];
        double *t = k->t[m], *p = k->p[m];
        for (int n = 1; n < m; ++n) {
            double *r = k->r[n], *rv = k->rv[n], *ru = k->ru[n], *bend = bends[n];
            double *below = out[m * joints + n], *above = out[n * joints + m];
            EACH_LANE {
                double both = c1[z] * r[z] * s[z] + 0.5 * e1[z] * bend[z] * h[z];
                rv[z] = c0[z] * rv[z] + c1[z] * x * r[z];
                ru[z] = c0[z] * ru[z] + c1[z] * vu[z] * r[z];
                r[z] = c0[z] * r[z];
                bend[z] = e0[z] * bend[z] + 2.0 * t[z] * r[z];
                below[z] += w[z] * (r[z] * hv[z] + rv[z] * h[z]) - both;
                above[z] += own * (r[z] * hu[z] + ru[z] * h[z]) - both;
            }
        }
        double *r = k->r[m], *rv = k->rv[m], *ru = k->ru[m], *bend = bends[m];
        double *t_before = k->t[m - 1], *tv = k->tv[m - 1], *tu = k->tu[m - 1];
        double *p_before = k->p[m - 1], *pv = k->pv[m - 1], *pu = k->pu[m - 1];
        double *block = out[m * joints + m];
        EACH_LANE {
            double before = t_before[z] + p_before[z];
            r[z] = c1[z] * before;
            rv[z] = c1[z] * (tv[z] + pv[z]) + c2[z] * x * before;
            ru[z] = c1[z] * (tu[z] + pu[z]) + c2[z] * vu[z] * before;
            bend[z] = 2.0 * t[z] * r[z] + e1[z] * square[z];
            block[z] += w[z] * (r[z] * hv[z] + rv[z] * h[z]) + own * (r[z] * hu[z] + ru[z] * h[z])
                        - c2[z] * before * s[z] - 0.5 * e2[z] * square[z] * h[z];
            square[z] = t[z] * (t[z] + 2.0 * p[z]) + e0[z] * square[z];
        }
    }
}

void serial_kinetic(int joints, const double *v, const double *a, Tile (*right)[PARTS],
                    Tile (*c)[3], Tile (*e)[3], const double *inertia, const double *link,
                    Tile *work, Tile *out)
{
    Chain chain = {.joints = joints, .v = v, .a = a, .inertia = inertia, .link = link,
                   .right = right, .c = c, .e = e};
    Tile **rooms[WORK] = {
        &chain.w, &chain.b, &chain.t, &chain.tv, &chain.tu, &chain.h, &chain.hv, &chain.hu,
        &chain.hvu, &chain.p, &chain.pv, &chain.pu, &chain.s, &chain.sv, &chain.su, &chain.r,
        &chain.rv, &chain.ru, &chain.g, &chain.gv, &chain.gu,
    };
    for (int one = 0; one < WORK; ++one)
        *rooms[one] = work + one * joints;
    write_products(&chain);
    write_heads(&chain);
    write_tails(&chain);
    write_sums(&chain);
    write_entries(&chain, out);
    add_slopes_beyond(&chain, out);
    add_slopes_before(&chain, out);
}
