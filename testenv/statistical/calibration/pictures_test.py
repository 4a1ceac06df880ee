#!/usr/bin/env python3
"""Tests that a noisy reference still gives the true error."""
import math
import pathlib
import random
import statistics
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from pictures import ERROR_FLOOR, Picture, Reference  # noqa: E402

WIDTH, HEIGHT, LEVEL = 6, 5, 2.0


def noisy(rng, sigma):
    return Picture(WIDTH, HEIGHT, [[rng.gauss(LEVEL, sigma) for _ in range(WIDTH * HEIGHT)] for _ in range(3)])


class TrueError(unittest.TestCase):
    def test_the_noise_of_the_reference_is_no_error(self):
        """Parts as noisy as the picture leave a quarter of its variance in the reference, which must not affect the error."""
        rng, sigma = random.Random(1), 0.1
        found = [Reference([noisy(rng, sigma) for _ in range(4)]).squared_error(noisy(rng, sigma)) for _ in range(300)]
        expected = sigma ** 2 / (LEVEL ** 2 * (1 + ERROR_FLOOR ** 2))
        z = (statistics.fmean(found) - expected) / (statistics.stdev(found) / math.sqrt(len(found)))
        self.assertLess(abs(z), 3.5)
        self.assertLess(statistics.stdev(found) / math.sqrt(len(found)), 0.05 * expected, "or the test proves nothing")

    def test_own_error_is_what_the_parts_leave(self):
        rng, sigma = random.Random(2), 0.1
        own = [Reference([noisy(rng, sigma) for _ in range(4)]).own_squared_error() for _ in range(300)]
        self.assertAlmostEqual(statistics.fmean(own) / (sigma ** 2 / 4 / (LEVEL ** 2 * (1 + ERROR_FLOOR ** 2))), 1, delta=0.03)

    def test_scales_are_levels_of_three_by_three_pixels_and_a_floor(self):
        planes = [[1.0] * (WIDTH * HEIGHT) for _ in range(3)]
        planes[0][0] = 4.0  # the corner's level becomes 2, in the neighbourhood of four pixels
        reference = Reference([Picture(WIDTH, HEIGHT, planes)] * 2)
        floor = ERROR_FLOOR * (1 + 1 / (WIDTH * HEIGHT))
        self.assertAlmostEqual(reference.scales[0], (5 / 4) ** 2 + floor ** 2)
        self.assertAlmostEqual(reference.scales[1], (7 / 6) ** 2 + floor ** 2)
        self.assertAlmostEqual(reference.scales[2], 1 + floor ** 2)


if __name__ == "__main__":
    unittest.main()
