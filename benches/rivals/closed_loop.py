"""The paper's step as a control engineer would write it in Python.

Numba, SciPy, and mealpy's FPA around the Numba loop. Prints, as `name value` lines: the ISE of the paper's
gains and the closed-loop steps of 1 ms a second on one core for each, and the seconds that mealpy takes for
the paper's whole tune (1,550 evaluations of 5,001 ticks).
"""

import math
import sys
import time

import numba
import numpy as np
from scipy.integrate import solve_ivp

M, L, G, IP, IY, DP, DY = 1.075, 0.002, 9.8, 0.0215, 0.0237, 0.0071, 0.022
KPP, KPY, KYP, KYY, LIMIT = 0.022, 0.0221, -0.0227, 0.0022, 24.0
ML2, DET = M * L * L, KPP * KYY - KPY * KYP
GOAL = (math.radians(15), math.radians(40))
PAPER = (4.2, 24.6, 2.28, 10.8)
TICKS, H = 5000, 1e-3


@numba.njit(cache=False)
def accel(theta, theta_dot, psi_dot, u1, u2):
    s, c = math.sin(theta), math.cos(theta)
    return (
        (u1 - M * G * L * c - DP * theta_dot - ML2 * psi_dot * psi_dot * s * c) / (IP + ML2),
        (u2 - DY * psi_dot + 2 * ML2 * theta_dot * psi_dot * s * c) / (IY + ML2 * c * c),
    )


@numba.njit(cache=False)
def torques(k1, k2, k3, k4, theta, theta_dot, psi, psi_dot):
    e1, e3 = GOAL[0] - theta, GOAL[1] - psi
    a1 = -k1 * theta_dot + e1 + k2 * (k1 * e1 - theta_dot)
    a2 = -k3 * psi_dot + e3 + k4 * (k3 * e3 - psi_dot)
    s, c = math.sin(theta), math.cos(theta)
    u1 = (IP + ML2) * a1 + M * G * L * c + DP * theta_dot + ML2 * psi_dot * psi_dot * s * c
    u2 = (IY + ML2 * c * c) * a2 + DY * psi_dot - 2 * ML2 * theta_dot * psi_dot * s * c
    vp = min(max((KYY * u1 - KPY * u2) / DET, -LIMIT), LIMIT)
    vy = min(max((KPP * u2 - KYP * u1) / DET, -LIMIT), LIMIT)
    return KPP * vp + KPY * vy, KYP * vp + KYY * vy


@numba.njit(cache=False)
def fly(k1, k2, k3, k4):
    theta = theta_dot = psi = psi_dot = ise = 0.0
    for t in range(TICKS + 1):
        e1, e3 = GOAL[0] - theta, GOAL[1] - psi
        ise += (0.5 if t == 0 or t == TICKS else 1.0) * (e1 * e1 + e3 * e3)
        u1, u2 = torques(k1, k2, k3, k4, theta, theta_dot, psi, psi_dot)
        a1, b1 = accel(theta, theta_dot, psi_dot, u1, u2)
        q2, r2 = theta_dot + H / 2 * a1, psi_dot + H / 2 * b1
        a2, b2 = accel(theta + H / 2 * theta_dot, q2, r2, u1, u2)
        q3, r3 = theta_dot + H / 2 * a2, psi_dot + H / 2 * b2
        a3, b3 = accel(theta + H / 2 * q2, q3, r3, u1, u2)
        q4, r4 = theta_dot + H * a3, psi_dot + H * b3
        a4, b4 = accel(theta + H * q3, q4, r4, u1, u2)
        theta += H / 6 * (theta_dot + 2 * q2 + 2 * q3 + q4)
        psi += H / 6 * (psi_dot + 2 * r2 + 2 * r3 + r4)
        theta_dot += H / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        psi_dot += H / 6 * (b1 + 2 * b2 + 2 * b3 + b4)
    return ise * H


def scipy_flight(gains):
    """The continuous loop, as `solve_ivp` is commonly used: its own steps, the usual tolerance."""

    def slope(_t, x):
        u1, u2 = torques(*gains, x[0], x[1], x[2], x[3])
        a, b = accel(x[0], x[1], x[3], u1, u2)
        return [x[1], a, x[3], b, (GOAL[0] - x[0]) ** 2 + (GOAL[1] - x[2]) ** 2]

    return solve_ivp(slope, (0, TICKS * H), [0.0] * 5, rtol=1e-6, atol=1e-9).y[4, -1]


def rate(flight, seconds=1.0):
    begun, flights = time.perf_counter(), 0
    while time.perf_counter() - begun < seconds:
        flight((PAPER[0] + 1e-4 * flights, *PAPER[1:]))
        flights += 1
    return flights * TICKS / (time.perf_counter() - begun)


def mealpy_tune():
    from mealpy import FloatVar
    from mealpy.evolutionary_based.FPA import OriginalFPA

    problem = {
        "obj_func": lambda k: fly(*k),
        "bounds": FloatVar(lb=[1.0] * 4, ub=[25.0] * 4),
        "minmax": "min",
        "log_to": None,
    }
    begun = time.perf_counter()
    best = OriginalFPA(epoch=30, pop_size=50, p_s=0.8).solve(problem, seed=1)
    return time.perf_counter() - begun, best.target.fitness


if __name__ == "__main__":
    print("ise_numba %.9g" % fly(*PAPER))
    print("ise_scipy %.9g" % scipy_flight(PAPER))
    print("numba %.4g" % rate(lambda k: fly(*k)))
    print("scipy %.4g" % rate(scipy_flight))
    seconds, cost = mealpy_tune()
    print("mealpy_tune_s %.4g" % seconds)
    print("mealpy_ise %.6g" % cost)
    sys.exit(0)
