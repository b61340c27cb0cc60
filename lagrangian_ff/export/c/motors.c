/* Each joint a motor: inertia and viscous loss. */

static void motors_torque(const real *q, const real *qd, const real *qdd, real *tau)
{
    (void)q;
    for (int n = 0; n < N; ++n)
        tau[n] = motors_inertia[n] * qdd[n] + motors_viscous[n] * qd[n];
}
