#!/usr/bin/env python3
"""The paper's step in plain JAX, many flights at once, on whatever device JAX finds.

    closed_loop_jax.py [FLIGHTS]

One flight for each set of gains, f32, the arithmetic of closed_loop.c and closed_loop.py in the order in
which they have it; XLA may contract and reorder it. Prints, as `name value` lines: the device, the closed-
loop steps of 1 ms a second (the best of three runs after one that compiles), and the ISE of the paper's
gains, which differs from the project's by what XLA made of it.
"""

import math
import sys
import time

import jax
import jax.numpy as jnp
from jax import lax

M, L, G, IP, IY, DP, DY = 1.075, 0.002, 9.8, 0.0215, 0.0237, 0.0071, 0.022
KPP, KPY, KYP, KYY, LIMIT = 0.022, 0.0221, -0.0227, 0.0022, 24.0
ML2, DET = M * L * L, KPP * KYY - KPY * KYP
GOAL = (math.radians(15), math.radians(40))
PAPER = (4.2, 24.6, 2.28, 10.8)
TICKS, H = 5000, 1e-3


def accel(theta, theta_dot, psi_dot, u1, u2):
    s, c = jnp.sin(theta), jnp.cos(theta)
    return (
        (u1 - M * G * L * c - DP * theta_dot - ML2 * psi_dot * psi_dot * s * c) / (IP + ML2),
        (u2 - DY * psi_dot + 2 * ML2 * theta_dot * psi_dot * s * c) / (IY + ML2 * c * c),
    )


def torques(gains, theta, theta_dot, psi, psi_dot):
    k1, k2, k3, k4 = gains
    e1, e3 = GOAL[0] - theta, GOAL[1] - psi
    a1 = -k1 * theta_dot + e1 + k2 * (k1 * e1 - theta_dot)
    a2 = -k3 * psi_dot + e3 + k4 * (k3 * e3 - psi_dot)
    s, c = jnp.sin(theta), jnp.cos(theta)
    u1 = (IP + ML2) * a1 + M * G * L * c + DP * theta_dot + ML2 * psi_dot * psi_dot * s * c
    u2 = (IY + ML2 * c * c) * a2 + DY * psi_dot - 2 * ML2 * theta_dot * psi_dot * s * c
    vp = jnp.clip((KYY * u1 - KPY * u2) / DET, -LIMIT, LIMIT)
    vy = jnp.clip((KPP * u2 - KYP * u1) / DET, -LIMIT, LIMIT)
    return KPP * vp + KPY * vy, KYP * vp + KYY * vy


def tick(gains, t, state):
    theta, theta_dot, psi, psi_dot, ise = state
    e1, e3 = GOAL[0] - theta, GOAL[1] - psi
    ise = ise + jnp.where((t == 0) | (t == TICKS), 0.5, 1.0) * (e1 * e1 + e3 * e3)
    u1, u2 = torques(gains, theta, theta_dot, psi, psi_dot)
    a1, b1 = accel(theta, theta_dot, psi_dot, u1, u2)
    q2, r2 = theta_dot + H / 2 * a1, psi_dot + H / 2 * b1
    a2, b2 = accel(theta + H / 2 * theta_dot, q2, r2, u1, u2)
    q3, r3 = theta_dot + H / 2 * a2, psi_dot + H / 2 * b2
    a3, b3 = accel(theta + H / 2 * q2, q3, r3, u1, u2)
    q4, r4 = theta_dot + H * a3, psi_dot + H * b3
    a4, b4 = accel(theta + H * q3, q4, r4, u1, u2)
    return (
        theta + H / 6 * (theta_dot + 2 * q2 + 2 * q3 + q4),
        theta_dot + H / 6 * (a1 + 2 * a2 + 2 * a3 + a4),
        psi + H / 6 * (psi_dot + 2 * r2 + 2 * r3 + r4),
        psi_dot + H / 6 * (b1 + 2 * b2 + 2 * b3 + b4),
        ise,
    )


@jax.jit
def fly(gains):
    """The ISE of each flight; gains k1 to k4, an array each."""
    zero = jnp.zeros_like(gains[0])
    return lax.fori_loop(0, TICKS + 1, lambda t, x: tick(gains, t, x), (zero,) * 5)[4] * H


def main():
    flights = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    spread = jnp.linspace(0.0, 1e-3, flights, dtype=jnp.float32)
    gains = tuple(jnp.float32(k) + spread for k in PAPER)
    ise = fly(gains).block_until_ready()
    best = math.inf
    for _ in range(3):
        begun = time.perf_counter()
        fly(gains).block_until_ready()
        best = min(best, time.perf_counter() - begun)
    device = jax.devices()[0]
    print(f"jax {jax.__version__} on {device.platform}: {device.device_kind}")
    print(f"flights {flights}")
    print(f"steps_per_second {flights * (TICKS + 1) / best:.3g}")
    print(f"ise {float(ise[0]):.9g}")


if __name__ == "__main__":
    main()
