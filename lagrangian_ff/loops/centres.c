/* Applying the universal Lagrangian kernels to coefficients: a tile of centres at a time, no block.

With the names of universal.c, and for the coefficients a of a centre

    E = e.a,   P = p.a,   U = u.a,   X = x.a,   R = sum_j r_j qd_j a_j,

    K a / k = (c_x B - c_xu E - Y) e + B (p - x) - (c_x E - X) u
              - E r qd' + r a + (c_xu - c_x c_u) w a,     B = c_u E - U - P,   Y = c_u X - R. */

#include "tiles.h"

enum { SINE, COSINE, SPEED, ACCELERATION, WEIGHT, OF_CENTRE };

/* Write sum_j K(x_i, u_j) a_j to out[i].

x: (count, 5, N). parts: tiles of centres (parts, N, 5, L): of each the sine and cosine of the
position, or it and 1 where coordinates are linear, and qd, qdd and a. out: (count, N). Return whether
there was memory. */
EXPORT int centres_apply(int joints, int angles, const double *alpha, const double *w,
                         const double *x, int count, const double *centres, int parts, double *out)
{
    Tile *room = new_tiles((size_t)3 * joints + 14);
    if (!room)
        return 0;
    Tile *e = room, *p = e + joints, *r = p + joints, *sums = r + joints;
    double *log_k = sums[0], *cx = sums[1], *cu = sums[2], *cxu = sums[3];
    double *ea = sums[4], *sa = sums[5], *xa = sums[6], *ra = sums[7];
    /* What e, p - x, u, r qd', r a and w a are multiplied by. */
    double *of_e = sums[8], *of_p = sums[9], *of_u = sums[10], *of_v = sums[11], *of_a = sums[12];
    double *of_w = sums[13];
    for (int i = 0; i < count; ++i) {
        const double *state = x + (size_t)i * PARTS * joints;
        double *torque = out + (size_t)i * joints;
        for (int n = 0; n < joints; ++n)
            torque[n] = 0.0;
        for (int part = 0; part < parts; ++part) {
            const Tile *tile = (const Tile *)centres + (size_t)part * joints * OF_CENTRE;
            EACH_LANE {
                log_k[z] = cx[z] = cu[z] = cxu[z] = 0.0;
                ea[z] = sa[z] = xa[z] = ra[z] = 0.0;
            }
            for (int n = 0; n < joints; ++n) {
                /* p is the first times the centre's cosine less the second times its sine, r the
                second times its cosine plus the third times its sine, -rho / 2 = r - alpha - bend
                p^2. */
                double scale = alpha[n], weight = w[n], sine, cosine, turn, bend;
                double v = state[QD * joints + n], a = state[QDD * joints + n], b = weight * a;
                if (angles) {
                    sine = scale * state[SIN * joints + n];
                    cosine = scale * state[COS * joints + n];
                    turn = sine, bend = 0.0;
                } else {
                    sine = scale * state[Q * joints + n];
                    cosine = scale;
                    turn = 0.0, bend = 0.5 / scale;
                }
                const Tile *centre = tile + n * OF_CENTRE;
                const double *sines = centre[SINE], *cosines = centre[COSINE], *vu = centre[SPEED];
                const double *au = centre[ACCELERATION], *weights = centre[WEIGHT];
                double *en = e[n], *pn = p[n], *rn = r[n];
                EACH_LANE {
                    double pz = sine * cosines[z] - cosine * sines[z];
                    double rz = cosine * cosines[z] + turn * sines[z];
                    double difference = v - vu[z], ez = weight * difference, az = weights[z];
                    log_k[z] += rz - scale - bend * pz * pz - 0.5 * ez * difference;
                    cx[z] += pz * v + ez * a;
                    cu[z] += pz * vu[z] + ez * au[z];
                    cxu[z] += rz * v * vu[z] + b * au[z];
                    ea[z] += ez * az;
                    sa[z] += (weight * au[z] + pz) * az;
                    xa[z] += b * az;
                    ra[z] += rz * v * az;
                    en[z] = ez, pn[z] = pz, rn[z] = rz;
                }
            }
            EACH_LANE of_a[z] = exponential(log_k[z]);
            EACH_LANE {
                double k = of_a[z];
                double ba = cu[z] * ea[z] - sa[z];
                of_e[z] = k * (cx[z] * ba - cxu[z] * ea[z] - cu[z] * xa[z] + ra[z]);
                of_p[z] = k * ba;
                of_u[z] = k * (xa[z] - cx[z] * ea[z]);
                of_v[z] = k * ea[z];
                of_w[z] = k * (cxu[z] - cx[z] * cu[z]);
            }
            for (int n = 0; n < joints; ++n) {
                double weight = w[n], b = weight * state[QDD * joints + n], sum = 0.0;
                const Tile *centre = tile + n * OF_CENTRE;
                const double *vu = centre[SPEED], *au = centre[ACCELERATION], *az = centre[WEIGHT];
                double *en = e[n], *pn = p[n], *rn = r[n];
                _Pragma("omp simd reduction(+ : sum)")
                for (int z = 0; z < LANES; ++z)
                    sum += of_e[z] * en[z] + of_p[z] * (pn[z] - b) + of_u[z] * weight * au[z]
                           + rn[z] * (of_a[z] * az[z] - of_v[z] * vu[z]) + of_w[z] * weight * az[z];
                torque[n] += sum;
            }
        }
    }
    free(room);
    return 1;
}
