/* One Lagrangian of all joints as a sum over centres, Cheng and Huang 2016, eqs. (22), (36). */

static void lagrangian_rbf_torque(const real *q, const real *qd, const real *qdd, real *tau)
{
    real sine[N], cosine[N], e[N], p[N], r[N];
    for (int n = 0; n < N; ++n) {
        sine[n] = lagrangian_rbf_angles ? F(sin)(q[n]) : q[n];
        cosine[n] = lagrangian_rbf_angles ? F(cos)(q[n]) : R(1.0);
        tau[n] = R(0.0);
    }
    for (int at = 0; at < LAGRANGIAN_RBF_CENTRES; ++at) {
        const real *s = lagrangian_rbf_sine[at], *c = lagrangian_rbf_cosine[at];
        const real *vu = lagrangian_rbf_qd[at], *au = lagrangian_rbf_qdd[at];
        const real *b = lagrangian_rbf_weights[at];
        real log_k = R(0.0), cx = R(0.0), cu = R(0.0), cxu = R(0.0);
        real ea = R(0.0), sa = R(0.0), xa = R(0.0), ra = R(0.0);
        for (int n = 0; n < N; ++n) {
            const real alpha = lagrangian_rbf_alpha[n], w = lagrangian_rbf_w[n];
            const real gap = qd[n] - vu[n];
            e[n] = w * gap;
            p[n] = alpha * (sine[n] * c[n] - cosine[n] * s[n]);
            if (lagrangian_rbf_angles) {
                r[n] = alpha * (cosine[n] * c[n] + sine[n] * s[n]);
                log_k += r[n] - alpha;
            } else {
                r[n] = alpha;
                log_k -= R(0.5) * p[n] * p[n] / alpha;
            }
            log_k -= R(0.5) * e[n] * gap;
            cx += p[n] * qd[n] + e[n] * qdd[n];
            cu += p[n] * vu[n] + e[n] * au[n];
            cxu += r[n] * qd[n] * vu[n] + w * qdd[n] * au[n];
            ea += e[n] * b[n];
            sa += (w * au[n] + p[n]) * b[n];
            xa += w * qdd[n] * b[n];
            ra += r[n] * qd[n] * b[n];
        }
        const real k = F(exp)(log_k), left = cu * ea - sa;
        const real of_e = k * (cx * left - cxu * ea - cu * xa + ra), of_p = k * left;
        const real of_u = k * (xa - cx * ea), of_w = k * (cxu - cx * cu);
        for (int n = 0; n < N; ++n) {
            const real w = lagrangian_rbf_w[n];
            tau[n] += of_e * e[n] + of_p * (p[n] - w * qdd[n]) + of_u * w * au[n]
                      + k * r[n] * (b[n] - ea * vu[n]) + of_w * w * b[n];
        }
    }
}
