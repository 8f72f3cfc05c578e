/* The paper's law, references to volts, as one writes it in C: the measure for the Rust one.

   Eqs (26)-(27) with K_sp sin(theta) beside the paper's gravity, V = K^-1 U by the determinant, saturation, and zero volts
   where anything is not finite; the polynomial sine of core/src/trig.rs. */
#include "law.h"

/* Sine and cosine of |r| <= pi/4 rad: Cephes' polynomials. */
static inline void polynomials(float r, float *sine, float *cosine) {
    float z = r * r;
    *sine = r + r * z * (-1.6666654611e-1f + z * (8.3321608736e-3f + z * -1.9515295891e-4f));
    *cosine = (1.0f - 0.5f * z)
        + z * z * (4.166664568298827e-2f + z * (-1.388731625493765e-3f + z * 2.443315711809948e-5f));
}

/* Sine and cosine for |x| up to 8,000 rad, reduced to a quadrant by Cody and Waite unless x is in the first. */
static inline void sin_cos(float x, float *sine, float *cosine) {
    if (__builtin_fabsf(x) < 0.785f) {
        polynomials(x, sine, cosine);
        return;
    }
    const float shift = 12582912.0f; /* 1.5 * 2^23: adding it rounds to a whole number */
    float quadrant = (x * 0.636619772f + shift) - shift;
    float s, c;
    polynomials(
        ((x - quadrant * 1.5703125f) - quadrant * 4.837512969970703e-4f) - quadrant * 7.549789954891e-8f, &s, &c);
    int turn = (int)quadrant;
    if (turn & 1) {
        float t = s;
        s = c;
        c = -t;
    }
    if (turn & 2) {
        s = -s;
        c = -c;
    }
    *sine = s;
    *cosine = c;
}

static inline int finite(float x) {
    return __builtin_isfinite(x);
}

static inline float saturated(float volts, float limit) {
    return volts > limit ? limit : volts < -limit ? -limit : volts;
}

void law(const struct controller *k, const struct state *now, const struct reference *want, struct volts *volts) {
    float sine, cosine;
    sin_cos(now->pitch, &sine, &cosine);
    float coriolis = k->coupling * now->yaw_rate * sine * cosine;
    float pitch_inertia = k->pitch_inertia + k->coupling;
    float yaw_inertia = k->yaw_inertia + k->coupling * (cosine * cosine);
    float pitch_opposing = k->weight * cosine + k->stiffness * sine + k->pitch_damping * now->pitch_rate
        + coriolis * now->yaw_rate;
    float yaw_opposing = k->yaw_damping * now->yaw_rate - 2.0f * coriolis * now->pitch_rate;

    float pitch_error = want->pitch - now->pitch;
    float yaw_error = want->yaw - now->yaw;
    float pitch_slope = want->pitch_rate - now->pitch_rate;
    float yaw_slope = want->yaw_rate - now->yaw_rate;
    float pitch_second = want->pitch_rate + k->mu1 * pitch_error - now->pitch_rate;
    float yaw_second = want->yaw_rate + k->mu3 * yaw_error - now->yaw_rate;
    float pitch_accel = want->pitch_accel + k->mu1 * pitch_slope + pitch_error + k->mu2 * pitch_second;
    float yaw_accel = want->yaw_accel + k->mu3 * yaw_slope + yaw_error + k->mu4 * yaw_second;
    float pitch_torque = pitch_inertia * pitch_accel + pitch_opposing;
    float yaw_torque = yaw_inertia * yaw_accel + yaw_opposing;

    float main = (k->kyy * pitch_torque - k->kpy * yaw_torque) * k->inverse_determinant;
    float tail = (k->kpp * yaw_torque - k->kyp * pitch_torque) * k->inverse_determinant;
    if (!finite(main) || !finite(tail)) {
        volts->main = 0.0f;
        volts->tail = 0.0f;
        volts->fault = 1;
        return;
    }
    volts->main = saturated(main, k->main_limit);
    volts->tail = saturated(tail, k->tail_limit);
    volts->fault = 0;
}
