/* Each joint's torque a sum of bells over the state, Cheng and Huang 2016, eqs. (52), (53). */

static void state_rbf_torque(const real *q, const real *qd, const real *qdd, real *tau)
{
    real sine[N], cosine[N];
    for (int n = 0; n < N; ++n) {
        sine[n] = state_rbf_angles ? F(sin)(q[n]) : q[n];
        cosine[n] = state_rbf_angles ? F(cos)(q[n]) : R(1.0);
        tau[n] = R(0.0);
    }
    for (int at = 0; at < STATE_RBF_CENTRES; ++at) {
        real place = R(0.0), speed = R(0.0), hardness = R(0.0);
        for (int n = 0; n < N; ++n) {
            const real s = sine[n] - state_rbf_sine[at][n], c = cosine[n] - state_rbf_cosine[at][n];
            const real v = qd[n] - state_rbf_qd[at][n], a = qdd[n] - state_rbf_qdd[at][n];
            place += s * s + c * c;
            speed += v * v;
            hardness += a * a;
        }
        for (int n = 0; n < N; ++n) {
            const real v = state_rbf_velocity_scale[n], a = state_rbf_acceleration_scale[n];
            const real distance = place + v * v * speed + a * a * hardness;
            tau[n] += F(exp)(-distance * state_rbf_half[n]) * state_rbf_weights[at][n];
        }
    }
}
