/* The regressor of rigid bodies on joints, sample by sample; see kernels/rigid/tree.py. */

#include "tiles.h"

enum { INERTIAL = 10 }; /* m, m c (3), Ixx, Ixy, Iyy, Ixz, Iyz, Izz */

typedef double Vector[3];
typedef double Wrench[2][3][INERTIAL]; /* force and moment per unit of each parameter */

/* A body in the frame of its parent, and its motion in its own frame: w, dw/dt, and a less g. */
typedef struct {
    double turn[3][3];
    Vector place, omega, alpha, push;
} Frame;

typedef struct {
    int bodies;
    const int64_t *parent, *driver;
    const double *rotation, *offset, *axis, *sliding, *ratio, *shift;
} Tree;

/* Add a x b to out. */
static void add_cross(const Vector a, const Vector b, double weight, Vector out)
{
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] += weight * (a[j] * b[k] - a[k] * b[j]);
    }
}

/* Write the frame of a body whose joint is at `position`, with its rates. */
static void write_frame(const Tree *tree, int body, double position, double rate, double change,
                        const double *gravity, Frame *frames)
{
    const double *rotation = tree->rotation + 9 * body, *own = tree->axis + 3 * body;
    int slides = tree->sliding[body] > 0.0;
    double sine = slides ? 0.0 : sin(position), cosine = slides ? 1.0 : cos(position);
    Frame *frame = frames + body;
    for (int i = 0; i < 3; ++i) {
        frame->place[i] = tree->offset[3 * body + i];
        for (int j = 0; j < 3; ++j) {
            /* Rodrigues' formula, column by column. */
            double total = 0.0;
            for (int k = 0; k < 3; ++k) {
                double about = (1.0 - cosine) * own[k] * own[j];
                if (k == j)
                    about += cosine;
                else if ((k + 1) % 3 == j)
                    about -= sine * own[(k + 2) % 3];
                else
                    about += sine * own[(k + 1) % 3];
                total += rotation[3 * i + k] * about;
            }
            frame->turn[i][j] = total;
            if (slides)
                frame->place[i] += position * rotation[3 * i + j] * own[j];
        }
    }
    Vector omega = {0.0}, alpha = {0.0}, push = {-gravity[0], -gravity[1], -gravity[2]};
    if (tree->parent[body] >= 0) {
        const Frame *below = frames + tree->parent[body];
        Vector swing = {0.0};
        memcpy(omega, below->omega, sizeof omega);
        memcpy(alpha, below->alpha, sizeof alpha);
        memcpy(push, below->push, sizeof push);
        add_cross(omega, frame->place, 1.0, swing);
        add_cross(alpha, frame->place, 1.0, push);
        add_cross(omega, swing, 1.0, push);
    }
    for (int j = 0; j < 3; ++j) {
        frame->omega[j] = frame->alpha[j] = frame->push[j] = 0.0;
        for (int i = 0; i < 3; ++i) {
            frame->omega[j] += frame->turn[i][j] * omega[i];
            frame->alpha[j] += frame->turn[i][j] * alpha[i];
            frame->push[j] += frame->turn[i][j] * push[i];
        }
    }
    Vector carried;
    memcpy(carried, frame->omega, sizeof carried);
    add_cross(carried, own, slides ? 2.0 * rate : rate, slides ? frame->push : frame->alpha);
    for (int k = 0; k < 3; ++k) {
        if (slides) {
            frame->push[k] += change * own[k];
        } else {
            frame->alpha[k] += change * own[k];
            frame->omega[k] += rate * own[k];
        }
    }
}

/* Write force and moment per unit of a body's parameters. */
static void write_wrench(const Frame *frame, Wrench wrench)
{
    const double *omega = frame->omega, *alpha = frame->alpha, *push = frame->push;
    memset(wrench, 0, sizeof(Wrench));
    double square = omega[0] * omega[0] + omega[1] * omega[1] + omega[2] * omega[2];
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        wrench[0][i][0] = push[i];
        for (int n = 0; n < 3; ++n)
            wrench[0][i][1 + n] += omega[i] * omega[n];
        wrench[0][i][1 + i] -= square;
        wrench[0][i][1 + j] -= alpha[k];
        wrench[0][i][1 + k] += alpha[j];
        wrench[1][i][1 + j] += push[k];
        wrench[1][i][1 + k] -= push[j];
    }
    /* I v for I = (Ixx, Ixy, Iyy, Ixz, Iyz, Izz): which entry of it stands in row i, column n. */
    for (int i = 0; i < 3; ++i)
        for (int n = 0; n < 3; ++n) {
            int low = i < n ? i : n, high = i < n ? n : i;
            int entry = 4 + high * (high + 1) / 2 + low;
            wrench[1][i][entry] += alpha[n];
            /* w x (I w): row i of I w adds to the two other rows. */
            wrench[1][(i + 1) % 3][entry] += omega[(i + 2) % 3] * omega[n];
            wrench[1][(i + 2) % 3][entry] -= omega[(i + 1) % 3] * omega[n];
        }
}

/* Rotate and move a wrench into the frame of the parent. */
static void to_parent(const Frame *frame, Wrench wrench)
{
    Wrench moved;
    for (int which = 0; which < 2; ++which)
        for (int i = 0; i < 3; ++i)
            for (int p = 0; p < INERTIAL; ++p) {
                double total = 0.0;
                for (int j = 0; j < 3; ++j)
                    total += frame->turn[i][j] * wrench[which][j][p];
                moved[which][i][p] = total;
            }
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        for (int p = 0; p < INERTIAL; ++p)
            moved[1][i][p] += frame->place[j] * moved[0][k][p] - frame->place[k] * moved[0][j][p];
    }
    memcpy(wrench, moved, sizeof moved);
}

/* Add the torque of each joint per unit of each body's parameters to out (samples, N, B, 10).

q, qd, qdd: (samples, N). parent, driver, sliding, ratio, shift: (B,); rotation: (B, 3, 3); offset,
axis: (B, 3); see `Tree`. gravity: (3,). Return whether there was memory. */
EXPORT int rigid_regressor(int joints, int bodies, int samples, const double *q, const double *qd,
                           const double *qdd, const int64_t *parent, const double *rotation,
                           const double *offset, const double *axis, const double *sliding,
                           const int64_t *driver, const double *ratio, const double *shift,
                           const double *gravity, double *out)
{
    Tree tree = {bodies, parent, driver, rotation, offset, axis, sliding, ratio, shift};
    Frame *frames = malloc((size_t)bodies * sizeof(Frame));
    if (!frames)
        return 0;
    for (int m = 0; m < samples; ++m) {
        for (int body = 0; body < bodies; ++body) {
            double position = shift[body], rate = 0.0, change = 0.0;
            if (driver[body] >= 0) {
                size_t at = (size_t)m * joints + driver[body];
                position += ratio[body] * q[at];
                rate = ratio[body] * qd[at];
                change = ratio[body] * qdd[at];
            }
            write_frame(&tree, body, position, rate, change, gravity, frames);
        }
        for (int body = 0; body < bodies; ++body) {
            Wrench wrench;
            write_wrench(frames + body, wrench);
            for (int at = body; at >= 0; at = (int)parent[at]) {
                if (driver[at] >= 0) {
                    size_t row = (size_t)m * joints + driver[at];
                    double *to = out + (row * bodies + body) * INERTIAL;
                    double(*along)[INERTIAL] = sliding[at] > 0.0 ? wrench[0] : wrench[1];
                    for (int k = 0; k < 3; ++k)
                        for (int p = 0; p < INERTIAL; ++p)
                            to[p] += ratio[at] * axis[3 * at + k] * along[k][p];
                }
                to_parent(frames + at, wrench);
            }
        }
    }
    free(frames);
    return 1;
}
