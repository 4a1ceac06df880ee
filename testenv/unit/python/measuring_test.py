#!/usr/bin/env python3
"""Tests of media by their coefficients, and of what the manual's page "Measuring" says of them: its blocks against theory. With the
hdalabaster that is first in PYTHONPATH. Exit code 77: what ran holds, and NumPy or colour-science, which the rest needs, is not there.
"""
import importlib.util
import math
import pathlib
import re
import sys
import unittest
import warnings

import hdalabaster

try:
    import numpy
except ImportError:
    numpy = None

COLOUR = numpy and importlib.util.find_spec("colour")
PAGE = pathlib.Path(__file__).resolve().parents[3] / "delegate/manual/measuring.md"
EDGE = ((-1, 0.0673), (-0.5, 0.1216), (0.5, 0.3825), (1, 0.4367))  # 600,000 photons


def chandrasekhar(alphas):
    """H(1), and the albedo 1 - 2 sqrt(1 - alpha) Int_0^1 mu H(mu) dmu, of isotropic half-spaces (Radiative Transfer, 1960)."""
    nodes, weights = numpy.polynomial.legendre.leggauss(200)
    mu, weights = numpy.append((nodes + 1) / 2, 1.0), numpy.append(weights / 2, 0.0)
    rows = []
    for alpha in alphas:
        s, h = math.sqrt(1 - alpha), numpy.ones_like(mu)
        for _ in range(1000):
            before, h = h, 1 / (s + alpha / 2 * (weights * mu * h / (mu[:, None] + mu)).sum(axis=1))
            if abs(h - before).max() < 1e-12:
                break
        rows.append((h[-1], 1 - 2 * s * (weights * mu * h).sum()))
    return numpy.array(rows).T


class Medium(unittest.TestCase):
    @unittest.skipUnless(numpy, "no numpy")
    def test_the_color_is_the_albedo_of_the_half_space(self):
        alphas = (0.01, 0.3, 0.5, 0.9, 0.99, 0.9999)
        for alpha, albedo in zip(alphas, chandrasekhar(alphas)[1]):
            color = hdalabaster.medium(1 - alpha, alpha, 0, 1.5)["subsurfaceColor"]
            self.assertEqual(len(set(color)), 1)
            self.assertAlmostEqual(color[0], albedo, delta=1e-5)

    def test_lengths(self):
        paths = {given: hdalabaster.medium(*given[:2], 0.5, 1.4, per=given[2], unit=given[3])["meanFreePath"][0]
                 for given in ((1, 9, "mm", 1e-3), (10, 90, "cm", 1e-3), (1, 9, "mm", 1.0), (1000, 9000, "m", 0.01))}
        for path, expected in zip(paths.values(), (0.1, 0.1, 1e-4, 0.01)):
            self.assertAlmostEqual(path / expected, 1, places=12)
        self.assertEqual(hdalabaster.medium(1, 9, 0.5, 1.4), hdalabaster.medium((1, 1, 1), [9, 9, 9], 0.5, 1.4, "mm", 1))
        bands = hdalabaster.medium((0.5, 1, 0), (9.5, 4, 10), 0.5, 1.4)
        for band, (a, s) in enumerate(((0.5, 9.5), (1, 4), (0, 10))):
            one = hdalabaster.medium(a, s, 0.5, 1.4)
            for name in ("subsurfaceColor", "meanFreePath"):
                self.assertEqual(bands[name][band], one[name][0])
        self.assertEqual(bands["subsurfaceColor"][2], 1)

    def test_more_anisotropy_than_there_is(self):
        for g, nearest in ((0.95, 0.9), (-0.95, -0.9)):
            with self.assertWarnsRegex(UserWarning, rf"g {g} becomes {nearest}"):
                found = hdalabaster.medium(1, 90, g, 1.4)
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                self.assertEqual(found, hdalabaster.medium(1, 90 * (1 - g) / (1 - nearest), nearest, 1.4))

    def test_refusals_name_the_argument(self):
        good = {"mu_a": 1.0, "mu_s": 9.0, "g": 0.5, "n": 1.4}
        for name, values in {"mu_a": (-1, math.nan, math.inf, (1, 2), (1, 1, -1)),
                             "mu_s": (0, -1, math.nan, math.inf, (1, 0, 1), 1e300, 1e-300),
                             "g": (1, -1, math.nan, (0, 0, 0)), "n": (0.9, 5, math.nan, math.inf, [1.4]), "per": ("inch", None, 1),
                             "unit": (0, -1, math.nan, math.inf, (1,))}.items():
            for value in values:
                given = {**good, name: value, **({"mu_a": 0} if value == 1e-300 else {})}
                with self.subTest(given), self.assertRaisesRegex(ValueError, rf"\b{name}\b"):
                    hdalabaster.medium(**given)
        for name in ("mu_a", "mu_s", "g", "n", "unit"):
            with self.subTest(name), self.assertRaisesRegex((TypeError, ValueError), rf"\b{name}\b"):
                hdalabaster.medium(**{**good, name: "1"})


@unittest.skipUnless(numpy, "no numpy")
class Measuring(unittest.TestCase):
    """The blocks of the page in turn, as a reader runs them."""

    @classmethod
    def setUpClass(cls):
        cls.names = {}
        cls.blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.S)
        while cls.blocks and "import colour" not in cls.blocks[0]:
            exec(compile(cls.blocks.pop(0), PAGE.name, "exec"), cls.names)

    def assertTruth(self, found, truth, error=0.0):
        value, interval = found
        deviation = math.hypot(interval / 1.96, error)
        self.assertLess(deviation, 0.0016)
        self.assertLessEqual(abs(value - truth), 3 * deviation)

    def test_reflectance_and_transmittance(self):
        """Van de Hulst 1980, and of index 1.5 a photon Monte Carlo."""
        above, below, slab = self.names["ABOVE"], self.names["BELOW"], self.names["slab"]
        self.assertTruth(self.names["reflectance"], 0.09739)
        self.assertTruth(self.names["transmittance"], 0.66096)
        self.assertTruth(slab(above, n=1.5), 0.12668, 3e-4)
        self.assertTruth(slab(below, n=1.5), 0.49333, 6e-4)

    def test_spread(self):
        """A photon Monte Carlo."""
        for distance, truth in EDGE:
            with self.subTest(distance):
                self.assertTruth(self.names["spread"][distance], truth, 3e-4)

    def test_intervals(self):
        held = 0
        for seed in range(40):
            value, interval = self.names["slab"](self.names["ABOVE"], seed, samples=64)
            held += abs(value - 0.09739) <= interval
        self.assertGreaterEqual(held, 36)

    def truth(self, name):
        """Chandrasekhar's R = 1 - sqrt(1 - alpha) H(1) of a medium of the page."""
        scattering, absorption = self.names["scattering"], {"pale": 1.0, "dark": 1.5}[name] * self.names["pale"]
        alpha = scattering / (scattering + absorption)
        return 1 - numpy.sqrt(1 - alpha) * chandrasekhar(alpha)[0]

    def test_bands(self):
        for name, found in self.names["spectra"].items():
            off = found - self.truth(name)
            self.assertEqual(len(off), 36)
            self.assertLess(numpy.sqrt((off ** 2).mean()), 0.0015, name)
            self.assertLess(abs(off.mean()), 0.0006, name)

    @unittest.skipUnless(COLOUR, "no colour-science")
    def test_colors(self):
        self.assertEqual(len(self.blocks), 1)
        names = {**self.names}
        exec(compile(self.blocks[0], PAGE.name, "exec"), names)
        for name, found in names["spectra"].items():
            difference = names["colour"].delta_E(names["lab"](found), names["lab"](self.truth(name)), method="CIE 2000")
            self.assertLess(difference, 0.3, name)


if __name__ == "__main__":
    done = unittest.main(exit=False).result
    sys.exit(0 if done.wasSuccessful() and COLOUR else 77 if done.wasSuccessful() else 1)
