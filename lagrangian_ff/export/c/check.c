/* Compares @NAME@ with torques that lagrangian_ff computed, prints the largest difference in parts of
each joint's largest torque, and fails if it is more than rounding. */

#include <math.h>
#include <stdio.h>

#include "@NAME@.h"

enum { STATES = @STATES@, N = @MACRO@_JOINTS };

@TABLES@
int main(void)
{
    const double allowed = sizeof(@NAME@_real) < sizeof(double) ? @FLOAT32@ : @FLOAT64@;
    double worst = 0.0;
    for (int n = 0; n < N; ++n) {
        double largest = 1e-300, off = 0.0;
        for (int s = 0; s < STATES; ++s) {
            @NAME@_real q[N], qd[N], qdd[N], tau[N];
            for (int m = 0; m < N; ++m) {
                q[m] = (@NAME@_real)positions[s][m];
                qd[m] = (@NAME@_real)velocities[s][m];
                qdd[m] = (@NAME@_real)accelerations[s][m];
            }
            @NAME@_tau(q, qd, qdd, tau);
            const double apart = fabs((double)tau[n] - torques[s][n]);
            off = apart <= off ? off : apart;
            largest = fmax(largest, fabs(torques[s][n]));
        }
        printf("%-24s %.2e of %g\n", @NAME@_joint_names[n], off / largest, largest);
        worst = off / largest <= worst ? worst : off / largest;
    }
    printf("largest %.2e, allowed %.0e\n", worst, allowed);
    return worst <= allowed ? 0 : 1;
}
