/* What the law is given, and what it gives. SI units. */
struct controller {
    float weight, stiffness, coupling;
    float pitch_inertia, yaw_inertia, pitch_damping, yaw_damping;
    float mu1, mu2, mu3, mu4;
    float kpp, kpy, kyp, kyy, inverse_determinant;
    float main_limit, tail_limit;
};

struct state {
    float pitch, yaw, pitch_rate, yaw_rate;
};

struct reference {
    float pitch, yaw, pitch_rate, yaw_rate, pitch_accel, yaw_accel;
};

struct volts {
    float main, tail;
    int fault;
};

void law(const struct controller *k, const struct state *now, const struct reference *want, struct volts *volts);
