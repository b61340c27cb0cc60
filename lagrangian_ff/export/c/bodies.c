/* Rigid bodies on joints, by Newton and Euler, each with ten parameters about the origin of its frame. */

/* Add weight a x b to out. */
static void add_cross(const real *a, const real *b, real weight, real *out)
{
    out[0] += weight * (a[1] * b[2] - a[2] * b[1]);
    out[1] += weight * (a[2] * b[0] - a[0] * b[2]);
    out[2] += weight * (a[0] * b[1] - a[1] * b[0]);
}

/* Write the frame of a body in that of its parent for a position of its joint. */
static void write_frame(int body, real position, real (*turn)[3], real *place)
{
    const real *rotation = bodies_rotation[body], *axis = bodies_axis[body];
    const int slides = bodies_sliding[body] > 0;
    const real s = slides ? R(0.0) : F(sin)(position), c = slides ? R(1.0) : F(cos)(position);
    for (int i = 0; i < 3; ++i) {
        place[i] = bodies_offset[body][i];
        for (int j = 0; j < 3; ++j) {
            turn[i][j] = R(0.0);
            for (int k = 0; k < 3; ++k) {
                real about = (R(1.0) - c) * axis[k] * axis[j];
                if (k == j)
                    about += c;
                else if ((k + 1) % 3 == j)
                    about -= s * axis[(k + 2) % 3];
                else
                    about += s * axis[(k + 1) % 3];
                turn[i][j] += rotation[3 * i + k] * about;
            }
            if (slides)
                place[i] += position * rotation[3 * i + j] * axis[j];
        }
    }
}

/* Write a vector of the parent's frame in the body's own. */
static void to_own(real (*turn)[3], const real *given, real *out)
{
    for (int j = 0; j < 3; ++j)
        out[j] = turn[0][j] * given[0] + turn[1][j] * given[1] + turn[2][j] * given[2];
}

/* Add a vector of the body's frame to one of the parent's. */
static void add_to_parent(real (*turn)[3], const real *given, real *out)
{
    for (int i = 0; i < 3; ++i)
        out[i] += turn[i][0] * given[0] + turn[i][1] * given[1] + turn[i][2] * given[2];
}

static void bodies_torque(const real *q, const real *qd, const real *qdd, real *tau)
{
    real turn[BODIES][3][3], place[BODIES][3];
    real omega[BODIES][3], alpha[BODIES][3], push[BODIES][3]; /* push: acceleration less gravity */
    real force[BODIES][3], moment[BODIES][3];
    for (int n = 0; n < N; ++n)
        tau[n] = bodies_rotor[n] * qdd[n];
    for (int b = 0; b < BODIES; ++b) {
        const int driver = bodies_driver[b], parent = bodies_parent[b];
        const int slides = bodies_sliding[b] > 0;
        const real *axis = bodies_axis[b];
        real position = bodies_shift[b], rate = R(0.0), change = R(0.0);
        real w[3] = {0}, dw[3] = {0}, a[3], swing[3] = {0};
        if (driver >= 0) {
            position += bodies_ratio[b] * q[driver];
            rate = bodies_ratio[b] * qd[driver];
            change = bodies_ratio[b] * qdd[driver];
        }
        write_frame(b, position, turn[b], place[b]);
        for (int i = 0; i < 3; ++i)
            a[i] = -bodies_gravity[i];
        if (parent >= 0) {
            for (int i = 0; i < 3; ++i) {
                w[i] = omega[parent][i];
                dw[i] = alpha[parent][i];
                a[i] = push[parent][i];
            }
            add_cross(w, place[b], R(1.0), swing);
            add_cross(dw, place[b], R(1.0), a);
            add_cross(w, swing, R(1.0), a);
        }
        to_own(turn[b], w, omega[b]);
        to_own(turn[b], dw, alpha[b]);
        to_own(turn[b], a, push[b]);
        const real carried[3] = {omega[b][0], omega[b][1], omega[b][2]};
        add_cross(carried, axis, slides ? R(2.0) * rate : rate, slides ? push[b] : alpha[b]);
        for (int i = 0; i < 3; ++i) {
            if (slides) {
                push[b][i] += change * axis[i];
            } else {
                alpha[b][i] += change * axis[i];
                omega[b][i] += rate * axis[i];
            }
        }
        /* f = m a + dw x h + w x (w x h), n = h x a + I dw + w x (I w), h = m c. */
        const real *held = bodies_inertial[b], *h = held + 1;
        real turning[3] = {0}, spin[3], inertia[3][3];
        inertia[0][0] = held[4], inertia[1][1] = held[6], inertia[2][2] = held[9];
        inertia[0][1] = inertia[1][0] = held[5];
        inertia[0][2] = inertia[2][0] = held[7];
        inertia[1][2] = inertia[2][1] = held[8];
        add_cross(omega[b], h, R(1.0), turning);
        for (int i = 0; i < 3; ++i) {
            force[b][i] = held[0] * push[b][i];
            moment[b][i] = spin[i] = R(0.0);
            for (int j = 0; j < 3; ++j) {
                moment[b][i] += inertia[i][j] * alpha[b][j];
                spin[i] += inertia[i][j] * omega[b][j];
            }
        }
        add_cross(alpha[b], h, R(1.0), force[b]);
        add_cross(omega[b], turning, R(1.0), force[b]);
        add_cross(h, push[b], R(1.0), moment[b]);
        add_cross(omega[b], spin, R(1.0), moment[b]);
    }
    for (int b = BODIES - 1; b >= 0; --b) {
        const int driver = bodies_driver[b], parent = bodies_parent[b];
        const real *along = bodies_sliding[b] > 0 ? force[b] : moment[b], *axis = bodies_axis[b];
        if (driver >= 0)
            tau[driver] += bodies_ratio[b]
                           * (axis[0] * along[0] + axis[1] * along[1] + axis[2] * along[2]);
        if (parent >= 0) {
            real carried[3] = {0};
            add_to_parent(turn[b], force[b], carried);
            add_to_parent(turn[b], moment[b], moment[parent]);
            add_cross(place[b], carried, R(1.0), moment[parent]);
            for (int i = 0; i < 3; ++i)
                force[parent][i] += carried[i];
        }
    }
}
