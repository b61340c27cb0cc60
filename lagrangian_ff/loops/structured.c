/* What one joint contributes to a structured kernel, the tiles it is worked out in, and the
potential part.

A factor is a function of d = q - q', with its slope and its curvature:

    COSINE   (1 + w cos d) / (1 + w)       a polynomial of first degree in cosine and sine
    BELL     exp(-w (1 - cos d))           universal on the circle, eqs. (36), (38)
    LINE     exp(-w d^2 / 2)               universal on the line, for a joint that slides

Each is 1 at d = 0 and positive definite for every w > 0. */

#include "structured.h"

enum { COSINE, BELL, LINE };

Arm arm_of(int joints, int serial, const int64_t *form, const double *numbers)
{
    return (Arm){
        .joints = joints,
        .serial = serial,
        .form = form,
        .inertia = numbers,
        .link = numbers + joints,
        .potential = numbers + 2 * joints,
        .wave = numbers + 3 * joints,
        .swing = numbers + 4 * joints,
        .rotor = numbers + 5 * joints,
    };
}

size_t pairs_tiles(int joints)
{
    return (size_t)joints * (PARTS + 4 * 3 + WORK + joints);
}

void pairs_place(Pairs *pairs, int joints, Tile *room)
{
    pairs->right = (Tile(*)[PARTS])room;
    room += joints * PARTS;
    for (int part = 0; part < 2; ++part) {
        pairs->factors[part] = (Tile(*)[3])room;
        pairs->squares[part] = (Tile(*)[3])(room + 3 * joints);
        room += 6 * joints;
    }
    pairs->work = room;
}

void right_load(int joints, const double *u, int first, int count, Tile (*right)[PARTS])
{
    for (int z = 0; z < LANES; ++z) {
        const double *state = u + (size_t)(first + least(z, count - 1)) * PARTS * joints;
        for (int part = 0; part < PARTS; ++part)
            for (int n = 0; n < joints; ++n)
                right[n][part][z] = state[part * joints + n];
    }
}

void pairs_load(const Arm *arm, const double *x, int i, const double *u, int first, int count,
                Pairs *pairs)
{
    int joints = arm->joints;
    pairs->left = x + (size_t)i * PARTS * joints;
    right_load(joints, u, first, count, pairs->right);
    for (int n = 0; n < joints; ++n)
        for (int part = 0; part < 2; ++part) {
            double omega = part == KINETIC ? arm->wave[n] : arm->swing[n];
            Tile *c = pairs->factors[part][n];
            factor((int)arm->form[n], omega, pairs->left + n, joints, pairs->right[n], c);
            factor_square(c, pairs->squares[part][n]);
        }
}

void factor(int form, double omega, const double *left, int joints, Tile *right, Tile *c)
{
    double place = left[Q * joints], sine = left[SIN * joints], cosine = left[COS * joints];
    if (form == LINE) {
        EACH_LANE {
            double d = place - right[Q][z];
            double value = exponential(-0.5 * omega * d * d);
            c[0][z] = value;
            c[1][z] = -omega * d * value;
            c[2][z] = omega * (omega * d * d - 1.0) * value;
        }
        return;
    }
    double scale = 1.0 / (1.0 + omega), share = omega * scale;
    EACH_LANE {
        double along = sine * right[COS][z] - cosine * right[SIN][z];
        double across = cosine * right[COS][z] + sine * right[SIN][z];
        c[1][z] = along;
        c[2][z] = across;
    }
    if (form == COSINE)
        EACH_LANE {
            c[0][z] = scale + share * c[2][z];
            c[1][z] = -share * c[1][z];
            c[2][z] = -share * c[2][z];
        }
    else
        EACH_LANE {
            double along = c[1][z], across = c[2][z];
            double value = exponential(omega * (across - 1.0));
            c[0][z] = value;
            c[1][z] = -omega * along * value;
            c[2][z] = omega * (omega * along * along - across) * value;
        }
}

void factor_rate(int form, double omega, const double *left, int joints, Tile *right, Tile *c,
                 Tile *out)
{
    double place = left[Q * joints], sine = left[SIN * joints], cosine = left[COS * joints];
    double scale = 1.0 / (omega * (1.0 + omega));
    if (form == COSINE) {
        EACH_LANE {
            out[0][z] = (c[0][z] - 1.0) * scale;
            out[1][z] = c[1][z] * scale;
            out[2][z] = c[2][z] * scale;
        }
        return;
    }
    EACH_LANE {
        /* With c = exp(-w b(d)): b, its slope and its curvature. */
        double value = c[0][z], b, rise, bend;
        if (form == LINE) {
            double d = place - right[Q][z];
            b = 0.5 * d * d, rise = d, bend = 1.0;
        } else {
            double across = cosine * right[COS][z] + sine * right[SIN][z];
            b = 1.0 - across, bend = across;
            rise = sine * right[COS][z] - cosine * right[SIN][z];
        }
        out[0][z] = -b * value;
        out[1][z] = rise * (omega * b - 1.0) * value;
        out[2][z] = (2.0 * omega * rise * rise - bend) * value - b * c[2][z];
    }
}

void factor_square(Tile *c, Tile *e)
{
    EACH_LANE {
        e[0][z] = c[0][z] * c[0][z];
        e[1][z] = 2.0 * c[0][z] * c[1][z];
        e[2][z] = 2.0 * (c[1][z] * c[1][z] + c[0][z] * c[2][z]);
    }
}

/* The potential part: sum_i lambda_i prod_{l<=i} g_l(d_l) over the links i. The height of link i's
centre of mass depends on the joints up to i. Its push-forward (22) is minus the matrix of second
derivatives in d. */

void add_potential(int joints, Tile (*g)[3], const double *weight, Tile *work, Tile *out)
{
    double *head = work[0], *rise = work[1];
    Tile *tail = work + 2;
    EACH_LANE {
        tail[joints - 1][z] = weight[joints - 1];
        head[z] = 1.0;
    }
    for (int n = joints - 1; n > 0; --n)
        EACH_LANE tail[n - 1][z] = weight[n - 1] + g[n][0][z] * tail[n][z];
    for (int n = 0; n < joints; ++n) {
        double *own = out[n * joints + n];
        EACH_LANE {
            own[z] -= head[z] * g[n][2][z] * tail[n][z];
            rise[z] = head[z] * g[n][1][z];
            head[z] *= g[n][0][z];
        }
        for (int m = n + 1; m < joints; ++m) {
            double *above = out[n * joints + m], *below = out[m * joints + n];
            EACH_LANE {
                double both = rise[z] * g[m][1][z] * tail[m][z];
                rise[z] *= g[m][0][z];
                above[z] -= both;
                below[z] -= both;
            }
        }
    }
}

void potential_slope(int joints, Tile (*g)[3], const double *weight, Tile *a, double *out)
{
    Tile product, rate;
    EACH_LANE product[z] = 1.0, rate[z] = 0.0, out[z] = 0.0;
    for (int n = 0; n < joints; ++n)
        EACH_LANE {
            rate[z] = rate[z] * g[n][0][z] + product[z] * g[n][1][z] * a[n][z];
            product[z] *= g[n][0][z];
            out[z] += weight[n] * rate[z];
        }
}
