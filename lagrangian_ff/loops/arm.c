/* One step of the simulated arm, but for what PyBullet computes; see arm/plant.py. */

#include "tiles.h"

enum { JOINTS = 6, LARGEST = 2 * JOINTS };

typedef double Joints[JOINTS];

/* The plant's numbers, as `NUMBERS` in arm/plant.py lays them out; joint by joint, of links and of
rotors through their gears. A joint without stiffness is rigid: its rotor moves with the link. */
typedef struct {
    /* What holds for good. */
    double dt, tolerance;
    Joints lower, upper, armature, viscous, steepest, per_velocity, stiffness, damping, half_play;
    /* What effects take at the velocity `rotor_guess`, and its slope. */
    Joints added, slope;
    /* The velocities looked for, how much they changed last, and in the step before. */
    Joints guess, rotor_guess;
    double unsettled;
    Joints change, rotor_change;
    double at_stop;
    /* What each step is given: the links' mass matrix and bias, and the motors' torque. */
    double mass[JOINTS][JOINTS];
    Joints bias, motor;
    /* What comes of it, and the state. */
    Joints effect, added_torque, load, q, rotor_q, qd, rotor_qd, qdd;
} Plant;

/* The numbers of the windings, as `NUMBERS` in arm/servo.py lays them out. */
typedef struct {
    double map[JOINTS][3][4];
    Joints per_ampere, current, integrator, wanted, qd, mean;
} Windings;

/* Let the currents follow the torque wanted over one step; see `CurrentLoop`. */
EXPORT void arm_currents(Windings *w)
{
    for (int j = 0; j < JOINTS; ++j) {
        double from[4] = {w->current[j], w->integrator[j], w->wanted[j] / w->per_ampere[j],
                          w->qd[j] * w->per_ampere[j]};
        double to[3] = {0.0};
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 4; ++k)
                to[i] += w->map[j][i][k] * from[k];
        w->current[j] = to[0];
        w->integrator[j] = to[1];
        w->mean[j] = to[2] * w->per_ampere[j];
    }
}

/* Solve a x = b for a symmetric positive definite a by Cholesky's factor; x takes the place of b. */
static void solve(int n, double a[LARGEST][LARGEST], double *b)
{
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < j; ++k)
            a[j][j] -= a[j][k] * a[j][k];
        a[j][j] = sqrt(a[j][j]);
        for (int i = j + 1; i < n; ++i) {
            for (int k = 0; k < j; ++k)
                a[i][j] -= a[i][k] * a[j][k];
            a[i][j] /= a[j][j];
        }
        for (int k = 0; k < j; ++k)
            b[j] -= a[j][k] * b[k];
        b[j] /= a[j][j];
    }
    for (int j = n - 1; j >= 0; --j) {
        for (int i = j + 1; i < n; ++i)
            b[j] -= a[i][j] * b[i];
        b[j] /= a[j][j];
    }
}

/* Return viscous and Coulomb friction at a velocity, over that velocity. */
static double friction(const Plant *p, int joint, double velocity)
{
    double x = velocity * p->per_velocity[joint];
    return p->viscous[joint] + p->steepest[joint] * (x == 0.0 ? 1.0 : tanh(x) / x);
}

/* Take the velocities that the torques at the guess lead to as the next guess, until they settle.

seat[j] is the row of joint j's rotor: its link's, or one of its own behind the links. */
static void settle(Plant *p, const int *seat, int rows, const double *momentum, int iterations)
{
    double guess[LARGEST];
    for (int j = 0; j < JOINTS; ++j) {
        guess[j] = p->guess[j];
        guess[seat[j]] = p->rotor_guess[j];
    }
    p->unsettled = INFINITY;
    for (int n = 0; n < iterations && p->unsettled >= p->tolerance; ++n) {
        double system[LARGEST][LARGEST] = {{0}}, after[LARGEST];
        Joints chord;
        memcpy(after, momentum, sizeof after);
        for (int j = 0; j < JOINTS; ++j) {
            int r = seat[j];
            double v = guess[r];
            chord[j] = friction(p, j, v);
            for (int k = 0; k < JOINTS; ++k)
                system[j][k] += p->mass[j][k];
            system[r][r] += p->armature[j] + p->dt * (chord[j] + p->slope[j]);
            after[r] += p->dt * (p->slope[j] * v - p->added[j]);
            if (r == j)
                continue;
            double rate = v - guess[j], twist = p->rotor_q[j] - p->q[j] + p->dt * rate;
            double beyond = twist - fmin(fmax(twist, -p->half_play[j]), p->half_play[j]);
            int touching = beyond != 0.0 || p->half_play[j] == 0.0;
            double torque = p->stiffness[j] * beyond + p->damping[j] * rate * touching;
            double steep = p->dt * (p->stiffness[j] * p->dt + p->damping[j]) * touching;
            system[r][r] += steep;
            system[j][j] += steep;
            system[r][j] -= steep;
            system[j][r] -= steep;
            after[r] += steep * rate - p->dt * torque;
            after[j] -= steep * rate - p->dt * torque;
        }
        solve(rows, system, after);
        p->unsettled = 0.0;
        for (int i = 0; i < rows; ++i)
            p->unsettled = fmax(p->unsettled, fabs(after[i] - guess[i]));
        for (int j = 0; j < JOINTS; ++j) {
            double v = after[seat[j]];
            p->effect[j] = chord[j] * v + p->added[j] + p->slope[j] * (v - guess[seat[j]]);
        }
        memcpy(guess, after, sizeof guess);
    }
    for (int j = 0; j < JOINTS; ++j) {
        p->guess[j] = guess[j];
        p->rotor_guess[j] = guess[seat[j]];
    }
}

/* Guess the velocities at the end of the step from those before. */
EXPORT void arm_guess(Plant *p)
{
    for (int j = 0; j < JOINTS; ++j) {
        p->guess[j] = p->qd[j] + p->change[j];
        p->rotor_guess[j] = p->rotor_qd[j] + p->rotor_change[j];
    }
}

/* Improve the guess by at most `iterations` iterations. */
EXPORT void arm_settle(Plant *p, int iterations)
{
    int seat[JOINTS], rows = JOINTS;
    double momentum[LARGEST] = {0}; /* at the end of the step, but for friction, effects, gears */
    for (int j = 0; j < JOINTS; ++j)
        seat[j] = p->stiffness[j] > 0.0 ? rows++ : j;
    for (int j = 0; j < JOINTS; ++j) {
        for (int k = 0; k < JOINTS; ++k)
            momentum[j] += p->mass[j][k] * p->qd[k];
        momentum[j] -= p->dt * p->bias[j];
        momentum[seat[j]] += p->armature[j] * p->rotor_qd[j] + p->dt * p->motor[j];
    }
    settle(p, seat, rows, momentum, iterations);
}

/* End the step: let links and rotors move at the guess. `effects`: whether there are any. */
EXPORT void arm_move(Plant *p, int effects)
{
    p->at_stop = 0.0;
    for (int j = 0; j < JOINTS; ++j) {
        p->at_stop += p->q[j] <= p->lower[j] || p->q[j] >= p->upper[j];
        p->change[j] = p->guess[j] - p->qd[j];
        p->rotor_change[j] = p->rotor_guess[j] - p->rotor_qd[j];
        p->qd[j] = p->guess[j];
        p->rotor_qd[j] = p->rotor_guess[j];
        p->q[j] += p->dt * p->qd[j];
        p->rotor_q[j] += p->dt * p->rotor_qd[j];
        p->qdd[j] = p->change[j] / p->dt;
        if (effects)
            p->added_torque[j] = p->effect[j] - friction(p, j, p->rotor_qd[j]) * p->rotor_qd[j];
    }
    for (int j = 0; j < JOINTS; ++j) {
        p->load[j] = p->bias[j];
        for (int k = 0; k < JOINTS; ++k)
            p->load[j] += p->mass[j][k] * p->qdd[k];
    }
}

/* Make a whole step, where nothing but friction and gears is in the joints. */
EXPORT void arm_step(Plant *p, int iterations)
{
    arm_guess(p);
    arm_settle(p, iterations);
    arm_move(p, 0);
}
