/* Kinetic and potential energy with factors of the angles, summed over centres; the loops above are
those that the model was learned with. */

static void mechanical_torque(const real *q, const real *qd, const real *qdd, real *tau)
{
    static const int64_t form[N] = MECHANICAL_FORMS;
    Tile right[N][PARTS], factors[2][N][3], squares[N][3], work[(WORK + N) * N], blocks[N * N];
    real left[PARTS * N];
    for (int n = 0; n < N; ++n) {
        left[Q * N + n] = q[n], left[QD * N + n] = qd[n], left[QDD * N + n] = qdd[n];
        left[SIN * N + n] = F(sin)(q[n]), left[COS * N + n] = F(cos)(q[n]);
        tau[n] = mechanical_rotors[n] * qdd[n];
    }
    for (int first = 0; first < MECHANICAL_CENTRES; first += LANES) {
        for (int n = 0; n < N; ++n) {
            for (int z = 0; z < LANES; ++z) {
                right[n][Q][z] = mechanical_q[first + z][n];
                right[n][QD][z] = mechanical_qd[first + z][n];
                right[n][QDD][z] = mechanical_qdd[first + z][n];
                right[n][SIN][z] = mechanical_sine[first + z][n];
                right[n][COS][z] = mechanical_cosine[first + z][n];
            }
            factor((int)form[n], mechanical_wave[n], left + n, N, right[n], factors[KINETIC][n]);
            factor((int)form[n], mechanical_swing[n], left + n, N, right[n], factors[POTENTIAL][n]);
            factor_square(factors[KINETIC][n], squares[n]);
        }
        MECHANICAL_KINETIC;
        add_potential(N, factors[POTENTIAL], mechanical_potential, work, blocks);
        for (int n = 0; n < N; ++n)
            for (int m = 0; m < N; ++m)
                for (int z = 0; z < LANES; ++z)
                    tau[n] += blocks[n * N + m][z] * mechanical_weights[first + z][m];
    }
}
