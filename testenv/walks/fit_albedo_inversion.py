#!/usr/bin/env python3
"""Derives the rational inverse of the half-space albedo that core/subsurface/medium.cpp uses (needs numpy).

Reference: A(s) = 1 - 2 s Int_0^1 mu H(mu) dmu, s = sqrt(1 - alpha), with Chandrasekhar's H in closed form and both
integrals by the tanh-sinh rule. Sought: s = (1 - A) P(A)/Q(A), P and Q cubic, exact at both ends by construction:
  P(0)/Q(0) = 1                 (alpha = 0 gives A = 0)
  (P/Q)'(0) = 1 - 1/(2c)        (A -> c alpha, c = 2/3 (1 - ln 2): single scattering)
  P(1)/Q(1) = sqrt(3)/4         (1 - A -> 4/sqrt(3) s: diffusion)
The three remaining coefficients minimize the largest error of A, relative to min(A, 1 - A), by iteratively reweighted least
squares (Lawson) on the linearized problem. Prints the coefficients and the errors.
"""
import numpy as np

# The result, as in core/subsurface/medium.cpp. fit_anisotropic_inversion.py starts from it.
P = (1, 1.90590733792, 0.722472222151, 0.00527736903751)
Q = (1, 3.35007585287, 3.22823189382, 0.813263477961)


def tanh_sinh(length, step=1 / 16, steps=72):
    x = step * np.arange(-steps, steps + 1)
    q = np.exp(-np.pi * np.sinh(np.abs(x)))
    near, far = length * q / (1 + q), length / (1 + q)
    weight = step * length * np.pi * np.cosh(x) * q / (1 + q) ** 2
    keep = near > 0
    left, right = np.where(x < 0, near, far), np.where(x < 0, far, near)
    return left[keep], right[keep], weight[keep]


T, T_RIGHT, T_WEIGHT = tanh_sinh(np.pi / 2)
MU, _, MU_WEIGHT = tanh_sinh(1.0)
SINE, COSINE = np.where(T < T_RIGHT, np.sin(T), np.cos(T_RIGHT)), np.where(T < T_RIGHT, np.cos(T), np.sin(T_RIGHT))
T2 = T * T
SERIES = T2 * (1 / 3 + T2 * (1 / 45 + T2 * (2 / 945 + T2 * (1 / 4725 + T2 * (2 / 93555 + T2 * 1382 / 638512875)))))
ONE_MINUS_T_COT_T = np.where(T > 0.25, 1 - T * COSINE / SINE, SERIES)
KERNEL = T_WEIGHT / (COSINE**2 + MU[:, None] ** 2 * SINE**2)


def albedo(s):
    logarithm = np.log(s * s + (1 - s * s) * ONE_MINUS_T_COT_T)
    h = np.exp(-MU / np.pi * (KERNEL @ logarithm))
    return 1 - 2 * s * np.sum(MU_WEIGHT * MU * h)


def main():
    # Chebyshev-like in s, and dense towards both ends.
    s = np.concatenate([0.5 - 0.5 * np.cos(np.pi * (np.arange(600) + 0.5) / 600), np.logspace(-7, -3, 40)])
    a = np.array([albedo(x) for x in s])
    r = s / (1 - a)
    slope = np.array([(albedo(x * (1 + 1e-5)) - albedo(x * (1 - 1e-5))) / (2e-5 * x) for x in s])
    gain = np.abs(slope) * (1 - a) / np.minimum(a, 1 - a)  # d(error measure)/d(P/Q)

    c = 2 / 3 * (1 - np.log(2))
    b = 1 - 1 / (2 * c)
    end = np.sqrt(3) / 4
    # The unknowns are q1, q2, q3 and p2, with p1 = q1 + b and p3 = end (1 + q1 + q2 + q3) - 1 - p1 - p2.
    weights = np.ones_like(a)
    denominator = np.ones_like(a)
    for _ in range(400):
        # P - r Q = 0, linear in (q1, q2, q3, p2).
        columns = np.stack(
            [
                a - r * a + a**3 * (end - 1),
                -r * a**2 + a**3 * end,
                -r * a**3 + a**3 * end,
                a**2 - a**3,
            ],
            axis=1,
        )
        constant = 1 + b * a + a**3 * (end - 1 - b) - r
        row = np.sqrt(weights) * gain / denominator
        x, *_ = np.linalg.lstsq(columns * row[:, None], -constant * row, rcond=None)
        q1, q2, q3, p2 = x
        p1 = q1 + b
        p3 = end * (1 + q1 + q2 + q3) - 1 - p1 - p2
        denominator = 1 + a * (q1 + a * (q2 + a * q3))
        error = np.abs((1 + a * (p1 + a * (p2 + a * p3))) / denominator - r) * gain
        weights *= np.sqrt(error / error.max()) + 1e-3
        weights /= weights.sum()
    print("P =", ", ".join(f"{v:.12g}" for v in (1, p1, p2, p3)))
    print("Q =", ", ".join(f"{v:.12g}" for v in (1, q1, q2, q3)))

    grid = np.linspace(0, 1, 2001)[1:-1]
    fitted = (1 - grid) * (1 + grid * (p1 + grid * (p2 + grid * p3))) / (1 + grid * (q1 + grid * (q2 + grid * q3)))
    back = np.array([albedo(x) for x in fitted])
    print(f"largest |A obtained - A requested| = {np.abs(back - grid).max():.3g}")
    print(f"largest relative to min(A, 1-A) = {(np.abs(back - grid) / np.minimum(grid, 1 - grid)).max():.3g}")


if __name__ == "__main__":
    main()
