/* The rigid-body torque, N*m. */
static void rigid_torque(const real *q, const real *qd, const real *qdd, real *tau)
{
    for (int n = 0; n < N; ++n)
        tau[n] = R(0.0);
@FORMS@    (void)q, (void)qd, (void)qdd;
}

/* Write the torque of each effect, N*m, beside a rigid-body torque. */
static void effect_torques(const real *q, const real *qd, const real *qdd, const real *rigid,
                           real (*effect)[N])
{
    real load[N], torque[N];
    for (int n = 0; n < N; ++n)
        for (int e = 0; e < EFFECTS; ++e)
            effect[e][n] = R(0.0);
    for (int n = 0; n < N; ++n)
        load[n] = rigid[n] + constant[n];
@TERMS@    for (int n = 0; n < N; ++n) {
        torque[n] = load[n] - constant[n];
        for (int e = 0; e < EFFECTS; ++e)
            torque[n] += effect[e][n];
    }
@FOLLOWING@    (void)q, (void)qd, (void)qdd, (void)torque;
}

void @NAME@_tau(const real *q, const real *qd, const real *qdd, real *tau)
{
    real effect[EFFECTS > 0 ? EFFECTS : 1][N];
    rigid_torque(q, qd, qdd, tau);
    effect_torques(q, qd, qdd, tau, effect);
    for (int e = 0; e < EFFECTS; ++e)
        for (int n = 0; n < N; ++n)
            tau[n] += effect[e][n];
}

void @NAME@_terms(const real *q, const real *qd, const real *qdd, @NAME@_parts *parts)
{
    const real still[N] = {0};
    real rigid[N];
    rigid_torque(q, still, still, parts->gravity);
    rigid_torque(q, still, qdd, parts->inertia);
    rigid_torque(q, qd, qdd, rigid);
    effect_torques(q, qd, qdd, rigid, parts->effect);
    for (int n = 0; n < N; ++n) {
        parts->coriolis[n] = rigid[n] - parts->inertia[n];
        parts->inertia[n] -= parts->gravity[n];
        parts->tau[n] = rigid[n];
        for (int e = 0; e < EFFECTS; ++e)
            parts->tau[n] += parts->effect[e][n];
    }
}

/* Return how far a rate is beyond its limit. */
static real beyond(real rate, real limit)
{
    const real most = limit > STILL ? limit : STILL;
    return F(fabs)(rate) / most - R(1.0);
}

void @NAME@_excess(const real *q, const real *qd, const real *qdd, real *over)
{
    for (int n = 0; n < N; ++n) {
        const real low = @NAME@_q_low[n], high = @NAME@_q_high[n];
        const real width = high - low > R(2.0) * STILL ? high - low : R(2.0) * STILL;
        const real speed = beyond(qd[n], @NAME@_qd_max[n]);
        const real hardness = beyond(qdd[n], @NAME@_qdd_max[n]);
        real most = R(0.0);
        if (low - q[n] > most * width)
            most = (low - q[n]) / width;
        if (q[n] - high > most * width)
            most = (q[n] - high) / width;
        if (speed > most)
            most = speed;
        if (hardness > most)
            most = hardness;
        over[n] = q[n] == q[n] && qd[n] == qd[n] && qdd[n] == qdd[n] ? most : (real)HUGE_VAL;
    }
}

int @NAME@_in_range(const real *q, const real *qd, const real *qdd)
{
    real over[N];
    int inside = 1;
    @NAME@_excess(q, qd, qdd, over);
    for (int n = 0; n < N; ++n)
        inside = inside && over[n] <= R(0.0);
    return inside;
}

int @NAME@_limit(real *tau)
{
    int limited = 0;
    for (int n = 0; n < N; ++n) {
        const real most = @NAME@_tau_max[n];
        if (F(fabs)(tau[n]) <= most)
            continue;
        ++limited;
        tau[n] = tau[n] > most ? most : tau[n] < -most ? -most : R(0.0);
    }
    return limited;
}
