/* The paper's step in plain C: eqs (1)-(2) by Runge-Kutta 4, the law of eqs (26)-(29), a clamp, the ISE. What one would write first.
 * Prints the ISE of the paper's gains and closed-loop steps a second of one core. */
#include <math.h>
#include <stdio.h>
#include <time.h>

typedef float real;

static const real M = 1.075f, L = .002f, G = 9.8f, IP = .0215f, IY = .0237f, DP = .0071f, DY = .022f;
static const real KPP = .022f, KPY = .0221f, KYP = -.0227f, KYY = .0022f, H = 1e-3f, LIMIT = 24;

static void accel(real theta, real theta_dot, real psi_dot, real u1, real u2, real *a) {
    const real s = sinf(theta), c = cosf(theta), ml2 = M * L * L;
    a[0] = (u1 - M * G * L * c - DP * theta_dot - ml2 * psi_dot * psi_dot * s * c) / (IP + ml2);
    a[1] = (u2 - DY * psi_dot + 2 * ml2 * theta_dot * psi_dot * s * c) / (IY + ml2 * c * c);
}

/* The ISE over `ticks` steps of 1 ms from rest, the goal 15 and 40 degrees. */
real fly(const real *mu, int ticks) {
    const real goal[2] = {15 * (real)M_PI / 180, 40 * (real)M_PI / 180};
    const real det = KPP * KYY - KPY * KYP, ml2 = M * L * L;
    real x[4] = {0, 0, 0, 0}, ise = 0;
    for (int t = 0;; t++) {
        const real e1 = goal[0] - x[0], e3 = goal[1] - x[1];
        ise += (t == 0 || t == ticks ? .5f : 1.f) * (e1 * e1 + e3 * e3);
        if (t == ticks) return ise * H;
        const real e2 = mu[0] * e1 - x[2], e4 = mu[2] * e3 - x[3];
        const real a1 = -mu[0] * x[2] + e1 + mu[1] * e2, a2 = -mu[2] * x[3] + e3 + mu[3] * e4;
        const real s = sinf(x[0]), c = cosf(x[0]);
        const real u1 = (IP + ml2) * a1 + M * G * L * c + DP * x[2] + ml2 * x[3] * x[3] * s * c;
        const real u2 = (IY + ml2 * c * c) * a2 + DY * x[3] - 2 * ml2 * x[2] * x[3] * s * c;
        const real vp = fminf(fmaxf((KYY * u1 - KPY * u2) / det, -LIMIT), LIMIT);
        const real vy = fminf(fmaxf((KPP * u2 - KYP * u1) / det, -LIMIT), LIMIT);
        const real t1 = KPP * vp + KPY * vy, t2 = KYP * vp + KYY * vy;
        real k[4][4], y[4];
        for (int i = 0; i < 4; i++) {
            const real part = i == 0 ? 0 : i == 3 ? H : H / 2;
            for (int j = 0; j < 4; j++) y[j] = i == 0 ? x[j] : x[j] + part * k[i - 1][j];
            k[i][0] = y[2], k[i][1] = y[3];
            accel(y[0], y[2], y[3], t1, t2, &k[i][2]);
        }
        for (int j = 0; j < 4; j++) x[j] += H / 6 * (k[0][j] + 2 * k[1][j] + 2 * k[2][j] + k[3][j]);
    }
}

int main(void) {
    const int ticks = 5000, flights = 1000;
    const real mu[4] = {4.2f, 24.6f, 2.28f, 10.8f};
    real sum = 0;
    printf("ise %.9g\n", fly(mu, ticks));
    struct timespec a, b;
    clock_gettime(CLOCK_MONOTONIC, &a);
    for (int i = 0; i < flights; i++) {
        const real other[4] = {mu[0] + 1e-4f * (real)i, mu[1], mu[2], mu[3]};
        sum += fly(other, ticks);
    }
    clock_gettime(CLOCK_MONOTONIC, &b);
    const double seconds = (double)(b.tv_sec - a.tv_sec) + 1e-9 * (double)(b.tv_nsec - a.tv_nsec);
    printf("steps_per_second %.4g\n", (double)ticks * flights / seconds);
    return sum > 0 ? 0 : 1;
}
