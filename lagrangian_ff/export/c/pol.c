/* The benchmark `pol`: (1 + qdd.qdd' + (qd.qd')^2) prod ((1 + cos(q - q')) / 2)^2, over centres. */

static void pol_torque(const real *q, const real *qd, const real *qdd, real *tau)
{
    real sine[N], cosine[N];
    for (int n = 0; n < N; ++n) {
        sine[n] = F(sin)(q[n]);
        cosine[n] = F(cos)(q[n]);
        tau[n] = R(0.0);
    }
    for (int at = 0; at < POL_CENTRES; ++at) {
        real place = R(1.0), speed = R(0.0), hardness = R(0.0);
        for (int n = 0; n < N; ++n) {
            const real across = cosine[n] * pol_cosine[at][n] + sine[n] * pol_sine[at][n];
            const real factor = R(0.5) + R(0.5) * across;
            place *= factor * factor;
            speed += qd[n] * pol_qd[at][n];
            hardness += qdd[n] * pol_qdd[at][n];
        }
        for (int n = 0; n < N; ++n) {
            const real v = pol_velocity_scale[n], a = pol_acceleration_scale[n];
            const real rate = v * v * speed;
            tau[n] += (R(1.0) + a * a * hardness + rate * rate) * place * pol_weights[at][n];
        }
    }
}
