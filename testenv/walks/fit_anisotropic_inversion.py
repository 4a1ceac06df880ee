#!/usr/bin/env python3
"""Derives the correction of similarity that core/subsurface/medium.cpp uses for anisotropic scattering.

Needs numpy, unlike the tests (Debian: python3-numpy). --check skips the fit, compares the solver with Chandrasekhar's H
function, and prints the change from twice the number of directions.

Reference: an index-matched half-space of Henyey-Greenstein scatterers (Legendre moments g^l), entered through a cosine lobe, with all exits counted. Because the entering radiance is the same in all directions, only the
azimuthal mean matters:
  mu dI/dx = -I + (alpha/2) Int_-1^1 sum_l (2l+1) g^l P_l(mu) P_l(mu') I(mu') dmu',  I(0, mu > 0) = 1,
  A = 2 Int_0^1 mu I(0, -mu) dmu.
Discrete ordinates (Chandrasekhar 1960, chapter VI) with Gauss-Legendre directions on each half range (Sykes 1951); N of
them integrate the products of the first N Legendre polynomials exactly, so the truncated phase function conserves energy.
Sums and differences of opposite directions decouple (Stamnes and Swanson 1981): an eigenproblem of size N, symmetric after
Cholesky factoring; decaying modes are matched to the entering radiance. No beam source and no delta-M scaling are needed.

Fitted: with s_g = sqrt((1-alpha)/(1-alpha g)), similarity (van de Hulst 1980, chapter 14) gives s_g(A) = s(A), the isotropic one, within 0.03 of A. It is exact at A = 1
(diffusion), and s_g(0) = 1 holds always. So
  s_g = s(A) (1 + g A (1-A) N(A,g)/D(A,g)),   N of degree 2 in A and g, D of 4 in A and 2 in g,
minimizing the largest error of A, relative to sqrt(min(A, 1-A)), by iteratively reweighted least squares (Lawson).
"""
import sys

import numpy as np

import fit_albedo_inversion

NUMERATOR, DENOMINATOR = (2, 2), (4, 2)  # degrees in A, g


class HalfSpace:
    def __init__(self, g, directions=64):
        x, w = np.polynomial.legendre.leggauss(directions)
        self.mu, weight = (x + 1) / 2, w / 2
        p = np.ones((directions, directions))  # P_l(mu_i)
        p[1] = self.mu
        for l in range(1, directions - 1):
            p[l + 1] = ((2 * l + 1) * self.mu * p[l] - l * p[l - 1]) / (l + 1)
        order = np.arange(directions)
        moment = (2 * order + 1) * float(g) ** order
        self.root_weight = np.sqrt(weight)
        p *= self.root_weight
        self.even = (p[0::2].T * moment[0::2]) @ p[0::2]
        self.odd = (p[1::2].T * moment[1::2]) @ p[1::2]

    def albedo(self, one_minus_alpha):
        alpha, identity = 1 - one_minus_alpha, np.eye(len(self.mu))
        # S = I+ + I-, D = I+ - I-, each times sqrt(weight), for modes exp(-k x):
        #   k mu D = (1 - alpha even) S,  k mu S = (1 - alpha odd) D.
        factor = np.linalg.cholesky(identity - alpha * self.even)
        half = factor.T / self.mu
        k2, vectors = np.linalg.eigh(half @ (identity - alpha * self.odd) @ half.T)
        total = np.linalg.solve(factor.T, vectors)
        difference = (factor @ vectors) / self.mu[:, None] / np.sqrt(k2)
        amplitude = np.linalg.solve((total + difference) / 2, self.root_weight)
        return 2 * np.sum(self.mu * self.root_weight * ((total - difference) @ amplitude / 2))


def complement(s, g):
    """1 - alpha from s_g."""
    return s * s * (1 - g) / (1 - g * s * s)


def isotropic_s(a):
    p, q = fit_albedo_inversion.P, fit_albedo_inversion.Q
    return (1 - a) * np.polyval(p[::-1], a) / np.polyval(q[::-1], a)


def check():
    print("1 - alpha, largest difference from the H function at g = 0, and of 64 from 128 directions over g:")
    spectrum = (0.9, 0.5, 0.1, 1e-2, 1e-4, 1e-6)
    for c in spectrum:
        exact = abs(HalfSpace(0.0).albedo(c) - fit_albedo_inversion.albedo(np.sqrt(c)))
        converged = max(abs(HalfSpace(g).albedo(c) - HalfSpace(g, 128).albedo(c)) for g in (-0.9, -0.5, 0.3, 0.7, 0.9))
        print(f"  {c:7g}  {exact:.2g}  {converged:.2g}")


def solve_all():
    """Columns g, s_g, A, dA/ds_g over the domain."""
    gs = 0.9 * np.cos(np.pi * (np.arange(24) + 0.5) / 24)
    s = np.concatenate([0.5 + 0.5 * np.cos(np.pi * (np.arange(60) + 0.5) / 60), [1e-4, 1e-3]])
    s = np.sort(s)
    rows = []
    for g in np.concatenate([gs, [-0.9, 0.9]]):
        solver = HalfSpace(g)
        a = np.array([solver.albedo(complement(x, g)) for x in s])
        slope = np.array([solver.albedo(complement(x * (1 + 1e-5), g)) - solver.albedo(complement(x * (1 - 1e-5), g)) for x in s])
        rows.append(np.stack([np.full_like(s, g), s, a, slope / (2e-5 * s)], axis=1))
    return np.concatenate(rows)


def powers(degrees, a, g):
    return np.stack([a**i * g**j for i in range(degrees[0] + 1) for j in range(degrees[1] + 1)], axis=1)


def fit(g, s, a, slope):
    bend = g * a * (1 - a) * isotropic_s(a)
    wanted = (s - isotropic_s(a)) / bend
    gain = np.abs(slope * bend) / np.sqrt(np.minimum(a, 1 - a))
    n, d = powers(NUMERATOR, a, g), powers(DENOMINATOR, a, g)[:, 1:]
    weights, denominator, best = np.ones_like(a), np.ones_like(a), (np.inf, None, None)
    for _ in range(200):
        row = (np.sqrt(weights) * gain / np.abs(denominator))[:, None]
        columns = np.concatenate([n, -wanted[:, None] * d], axis=1) * row
        size = np.linalg.norm(columns, axis=0)
        x = np.linalg.lstsq(columns / size, wanted * row[:, 0], rcond=1e-15)[0] / size
        p, q = x[: n.shape[1]], np.concatenate([[1], x[n.shape[1] :]])
        denominator = 1 + d @ q[1:]
        error = np.abs(n @ p / denominator - wanted) * gain
        if error.max() < best[0] and denominator.min() > 0.1:
            best = (error.max(), p, q)
        weights *= np.sqrt(error / error.max()) + 1e-3
        weights /= weights.sum()
    return best[1], best[2]


def report(p, q):
    for name, degrees, values in (("N", NUMERATOR, p), ("D", DENOMINATOR, q)):
        print(f"{name}, a row per power of A, in it the powers of g:")
        for row in values.reshape(degrees[0] + 1, degrees[1] + 1):
            print("  {" + ", ".join(f"{v:.12g}" for v in row) + "},")
    a = np.linspace(0, 1, 201)[1:-1]
    print("       g   similarity alone   fitted: largest |A obtained - A requested|, and relative to min(A, 1-A)")
    for g in np.linspace(-0.9, 0.9, 37):
        solver = HalfSpace(g)
        s = isotropic_s(a)
        ratio = (powers(NUMERATOR, a, g) @ p) / (powers(DENOMINATOR, a, g) @ q)
        alone, fitted = (
            np.array([solver.albedo(complement(x, g)) for x in t]) - a for t in (s, s * (1 + g * a * (1 - a) * ratio))
        )
        relative = np.abs(fitted) / np.minimum(a, 1 - a)
        print(f"  {g:6.3f}   {np.abs(alone).max():.2e}   {np.abs(fitted).max():.2e}   {relative.max():.2e}")


def main():
    if sys.argv[1:] == ["--check"]:
        return check()
    p, q = fit(*solve_all().T)
    report(p, q)


if __name__ == "__main__":
    main()
