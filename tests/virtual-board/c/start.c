/* From reset to the law, over and over, on the paper's helicopter with the paper's gains: states that a step of 15 and 40
   degrees goes through. */
#include "law.h"

extern char stack_top[];

static const struct controller controller = {
    .weight = 1.075f * 0.002f * 9.8f, .stiffness = 0.0f, .coupling = 1.075f * 0.002f * 0.002f,
    .pitch_inertia = 0.0215f, .yaw_inertia = 0.0237f, .pitch_damping = 0.0071f, .yaw_damping = 0.022f,
    .mu1 = 4.2f, .mu2 = 24.6f, .mu3 = 2.28f, .mu4 = 10.8f,
    .kpp = 0.022f, .kpy = 0.0221f, .kyp = -0.0227f, .kyy = 0.0022f,
    .inverse_determinant = 1.0f / (0.022f * 0.0022f - 0.0221f * -0.0227f),
    .main_limit = 24.0f, .tail_limit = 24.0f,
};

volatile struct volts answer;

static __attribute__((noinline, noreturn)) void run(void) {
    const struct reference want = {.pitch = 0.261799f, .yaw = 0.698132f};
    for (unsigned tick = 0;; tick++) {
        float part = (float)(tick % 100) * 0.01f;
        struct state now = {
            .pitch = want.pitch * part, .yaw = want.yaw * part, .pitch_rate = 1.0f - part, .yaw_rate = 2.0f * (1.0f - part),
        };
        struct volts volts;
        law(&controller, &now, &want, &volts);
        answer = volts;
    }
}

/* A function of its own: what uses the floating-point unit may use it on entry already. */
void reset(void) {
    *(volatile unsigned *)0xE000ED88 = 0xFu << 20; /* CPACR: the unit is on */
    __asm__ volatile("dsb\n isb");
    run();
}

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {stack_top, reset};
