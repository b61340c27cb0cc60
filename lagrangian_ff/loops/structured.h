/* A structured kernel: its numbers, its factors, and the parts that blocks are made of. */

#pragma once

#include "tiles.h"

enum { KINETIC, POTENTIAL, ROTOR }; /* parts of the kernel */
enum { WORK = 21 };                 /* (N, L) arrays that the parts work in, besides N more */

/* The numbers of a kernel of N joints; see `Structured` in kernels/structured/base.py. */
typedef struct {
    int joints, serial;
    const int64_t *form;                                             /* COSINE, BELL or LINE */
    const double *inertia, *link, *potential, *wave, *swing, *rotor; /* (N,) */
} Arm;

/* One state on the left, a tile of states on the right, and the factors between them. */
typedef struct {
    const double *left;    /* (5, N) */
    Tile (*right)[PARTS];  /* (N, 5, L) */
    Tile (*factors[2])[3]; /* (N, 3, L) of the kinetic and the potential part */
    Tile (*squares[2])[3]; /* (N, 3, L) and their squares */
    Tile *work;            /* (WORK + N, N, L) */
} Pairs;

/* Return the numbers of an arm: `numbers` are (6, N) in the order of `Arm`. */
Arm arm_of(int joints, int serial, const int64_t *form, const double *numbers);

/* Return how many tiles `Pairs` need, and place them in `room`. */
size_t pairs_tiles(int joints);
void pairs_place(Pairs *pairs, int joints, Tile *room);

/* Fetch state i of x, the states of u from `first` on, and the factors between them. Lanes beyond
`count` repeat the last state, so that every loop over lanes has one length. */
void pairs_load(const Arm *arm, const double *x, int i, const double *u, int first, int count,
                Pairs *pairs);

/* Fetch states of u (J, 5, N) to `right` (N, 5, L). */
void right_load(int joints, const double *u, int first, int count, Tile (*right)[PARTS]);

/* Write the factor of a joint, its slope and its curvature in d = q - q' to c. */
void factor(int form, double omega, const double *left, int joints, Tile *right, Tile *c);

/* Write the derivatives in omega of what `factor` wrote to out. */
void factor_rate(int form, double omega, const double *left, int joints, Tile *right, Tile *c,
                 Tile *out);

/* Write the square of a factor c, and its derivatives in d, to e. */
void factor_square(Tile *c, Tile *e);

/* Write the blocks of the kinetic part of one state with a tile of others to out (N, N, L).

v, a: velocity and acceleration on the left. c, e: factors and their squares. */
void serial_kinetic(int joints, const double *v, const double *a, Tile (*right)[PARTS],
                    Tile (*c)[3], Tile (*e)[3], const double *inertia, const double *link,
                    Tile *work, Tile *out);
void product_kinetic(int joints, const double *v, const double *a, Tile (*right)[PARTS],
                     Tile (*e)[3], const double *inertia, const double *link, Tile *work,
                     Tile *out);

/* Add the blocks of the potential part to out (N, N, L); work is (N + 2, L). */
void add_potential(int joints, Tile (*g)[3], const double *weight, Tile *work, Tile *out);

/* Write the derivative of the potential part along a (N, L), as d moves, to out. */
void potential_slope(int joints, Tile (*g)[3], const double *weight, Tile *a, double *out);
