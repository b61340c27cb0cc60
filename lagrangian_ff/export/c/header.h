/* @NAME@: the inverse dynamics of @JOINT_COUNT@ joints, exported from the model @SOURCE@ of lagrangian_ff.

    joints    @JOINTS@
    effects   @EFFECTS@
@SETTLED@
Positions in rad, velocities in rad/s, accelerations in rad/s^2, torques in N*m; m, m/s, m/s^2 and N of
a joint that slides. Every array has one number for each joint, in the order above.

Nothing here allocates, keeps state, reads a file or calls anything but the mathematics library.
Loops have fixed bounds. All functions may be called from several threads at once.

Compile everything with -D@MACRO@_FLOAT32 for numbers of 32 bits: `@NAME@_check` prints what that costs. */

#ifndef @MACRO@_H
#define @MACRO@_H

#ifdef __cplusplus
extern "C" {
#endif

#ifdef @MACRO@_FLOAT32
typedef float @NAME@_real;
#else
typedef double @NAME@_real;
#endif

enum { @MACRO@_JOINTS = @JOINT_COUNT@, @MACRO@_EFFECTS = @EFFECT_COUNT@ };
@EFFECT_ENUM@
/* A torque in parts by cause, N*m; tau is their sum. */
typedef struct {
    @NAME@_real gravity[@MACRO@_JOINTS];
    @NAME@_real inertia[@MACRO@_JOINTS];  /* what acceleration adds */
    @NAME@_real coriolis[@MACRO@_JOINTS]; /* what velocity adds */
    @NAME@_real effect[@MACRO@_EFFECTS > 0 ? @MACRO@_EFFECTS : 1][@MACRO@_JOINTS];
    @NAME@_real tau[@MACRO@_JOINTS];
} @NAME@_parts;

extern const char *const @NAME@_joint_names[@MACRO@_JOINTS];
extern const char *const @NAME@_effect_names[@MACRO@_EFFECTS > 0 ? @MACRO@_EFFECTS : 1];

/* The motion that the model was identified on: beyond it, the torque is a guess. */
extern const @NAME@_real @NAME@_q_low[@MACRO@_JOINTS], @NAME@_q_high[@MACRO@_JOINTS];
extern const @NAME@_real @NAME@_qd_max[@MACRO@_JOINTS], @NAME@_qdd_max[@MACRO@_JOINTS];
/* The largest torque that was credible there. */
extern const @NAME@_real @NAME@_tau_max[@MACRO@_JOINTS];

/* Write the torque of a state to tau. It is not finite where the state is not. */
void @NAME@_tau(const @NAME@_real *q, const @NAME@_real *qd, const @NAME@_real *qdd,
        @NAME@_real *tau);

/* Write the torque in parts; takes up to three times as long. */
void @NAME@_terms(const @NAME@_real *q, const @NAME@_real *qd, const @NAME@_real *qdd,
        @NAME@_parts *parts);

/* Write how far each joint is outside that motion, in parts of its range; 0 inside, huge for NaN. */
void @NAME@_excess(const @NAME@_real *q, const @NAME@_real *qd, const @NAME@_real *qdd,
        @NAME@_real *over);

/* Return 1 if every joint is inside that motion, else 0; 0 for NaN. */
int @NAME@_in_range(const @NAME@_real *q, const @NAME@_real *qd, const @NAME@_real *qdd);

/* Bring each torque within tau_max, and to 0 if it is NaN; return how many were not. */
int @NAME@_limit(@NAME@_real *tau);

#ifdef __cplusplus
}
#endif

#endif
