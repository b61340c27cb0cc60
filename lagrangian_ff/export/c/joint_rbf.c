/* A Lagrangian for each joint as a sum over centres, Cheng and Huang 2016, eqs. (30), (35). */

static void joint_rbf_torque(const real *q, const real *qd, const real *qdd, real *tau)
{
    real sine[N], cosine[N];
    for (int n = 0; n < N; ++n) {
        sine[n] = joint_rbf_angles ? F(sin)(q[n]) : q[n];
        cosine[n] = joint_rbf_angles ? F(cos)(q[n]) : R(1.0);
        tau[n] = R(0.0);
    }
    for (int at = 0; at < JOINT_RBF_CENTRES; ++at) {
        const real *s = joint_rbf_sine[at], *c = joint_rbf_cosine[at];
        const real *vu = joint_rbf_qd[at], *au = joint_rbf_qdd[at];
        const real *b = joint_rbf_weights[at];
        for (int joint = 0; joint < N; ++joint) {
            const real alpha = joint_rbf_alpha[joint], w = joint_rbf_w[joint];
            real log_k = R(0.0), cx = R(0.0), cu = R(0.0), cxu = R(0.0);
            real own_p = R(0.0), own_r = R(0.0);
            for (int n = 0; n < N; ++n) {
                const real gap = qd[n] - vu[n], e = w * gap;
                const real p = alpha * (sine[n] * c[n] - cosine[n] * s[n]);
                real r = alpha;
                if (joint_rbf_angles) {
                    r = alpha * (cosine[n] * c[n] + sine[n] * s[n]);
                    log_k += r - alpha;
                } else {
                    log_k -= R(0.5) * p * p / alpha;
                }
                log_k -= R(0.5) * e * gap;
                cx += p * qd[n] + e * qdd[n];
                cu += p * vu[n] + e * au[n];
                cxu += r * qd[n] * vu[n] + w * qdd[n] * au[n];
                if (n == joint) {
                    own_p = p;
                    own_r = r;
                }
            }
            const real e = w * (qd[joint] - vu[joint]), x = w * qdd[joint], u = w * au[joint];
            const real entry = (cx * e - x + own_p) * (cu * e - u - own_p)
                               - (cxu * e + cx * u + own_r * vu[joint]) * e
                               - e * (cu * x - own_r * qd[joint]) + u * x + own_r
                               + w * (cxu - cx * cu);
            tau[joint] += F(exp)(log_k) * entry * b[joint];
        }
    }
}
