"""Renders of tiny pictures, means with their standard errors, and decisions that chance cannot make."""
import math
import os
from statistics import NormalDist
from typing import NamedTuple

import hdalabaster
import numpy as np

SEEDS = (12, 24, 48, 192)  # of a mean, until it is decided
SETTINGS = dict(maxDepth=512, threads=1, filter="box")
SIGNIFICANCE = 0.001  # that chance turns any row of the whole matrix red
FAMILY = 30000  # comparisons of the matrix that noise decides, rounded up
Z = NormalDist().inv_cdf(1 - (1 - (1 - SIGNIFICANCE) ** (1 / FAMILY)) / 2)  # Sidak 1967


class Verdict(NamedTuple):
    """The result of a check: `worst` is the deviation as a multiple of what the rule allows (1 and below hold)."""
    holds: bool
    worst: float
    text: str


def picture(renderer, camera, size=16, aov="color", window=None):
    given = {} if window is None else {"window": window}
    render = renderer.render(width=size, height=size, camera=camera, aovs=[aov], **given)
    if render.state != "converged":
        raise RuntimeError(f"the render ended as {render.state}: {renderer.stats().get('error')}")
    pixels = np.array(render[aov].numpy(), dtype=float)
    return pixels[..., :3] if pixels.ndim == 3 and pixels.shape[2] > 3 else pixels


def renderer_of(scene, **settings):
    return hdalabaster.Renderer(scene, **{**SETTINGS, **settings})


def same_bytes(make):
    """One thread, two threads and a crop give the same bytes. `make` gives a scene and a camera."""
    scene, camera = make()
    renderer = renderer_of(scene, samples=4)
    whole = picture(renderer, camera)
    crop = picture(renderer, camera, window=(5, 3, 13, 12))
    differ = int((crop != whole[3:12, 5:13]).sum())
    scene, camera = make()
    differ += int((picture(renderer_of(scene, samples=4, threads=2), camera) != whole).sum())
    return Verdict(differ == 0, float(2 * (differ > 0)), f"{differ} values differ")


def blocks(pixels, edge=4):
    """Means of blocks of edge x edge pixels, all channels together."""
    grey = pixels.mean(axis=2) if pixels.ndim == 3 else pixels
    n = grey.shape[0] // edge
    return grey.reshape(n, edge, n, edge).mean(axis=(1, 3)).ravel()


class Series:
    """Independent values of a vector, one for each seed."""

    def __init__(self, draw, first_seed=0):
        self.draw, self.values, self.next = draw, [], first_seed

    def extend(self, count):
        while len(self.values) < count:
            self.values.append(np.atleast_1d(self.draw(self.next)))
            self.next += 1

    @property
    def mean(self):
        return np.mean(self.values, axis=0)

    @property
    def error(self):
        return np.std(self.values, axis=0, ddof=1) / math.sqrt(len(self.values))


CLEAR = 3  # standard errors by which the last seeds must show a fault
PRECISION = int(os.environ.get("MATRIX_PRECISION", "1"))  # divides the standard errors that are asked for


def settle(off, lists, error, seeds):
    """Draws seeds until it is clear whether off() = (how far outside of what is allowed, standard errors), by component, is above 0:
    no component is and all errors are at most `error`, or one is by Z standard errors. The last seeds decide by CLEAR."""
    error /= PRECISION
    for count in seeds:
        for series in lists:
            series.extend(count * PRECISION ** 2)
        outside, se = off()
        i = int(np.argmax(outside))
        if (outside > Z * se).any() or (outside[i] <= 0 and se.max() <= error):
            break
    noisy = se.max() > 2.5 * error and not (outside > Z * se).any()
    return bool((outside <= CLEAR * se).all()) and not noisy, i, ", too noisy" if noisy else ""


def within(draw, low, high, error=0.0015, seeds=SEEDS):
    """Decides whether all components of a mean lie in [low, high]. Deviations count in units of .3 % beyond the middle."""
    series = Series(draw)

    def off():
        return np.maximum(low - series.mean, series.mean - high), np.maximum(series.error, 1e-9)
    holds, i, noise = settle(off, [series], error, seeds)
    mean, half = series.mean, min((high - low) / 2, 0.003)
    text = f"{mean.min():.4f} to {mean.max():.4f}" if len(mean) > 1 else f"{mean[0]:.4f}"
    return Verdict(holds, max(0.0, float(off()[0][i] + half) / half), f"{text} ± {series.error.max():.4f}{noise}")


def same(draw_a, draw_b, rule, error=0.001, seeds=SEEDS):
    """Decides whether two means agree to the share `rule`, component by component."""
    a, b = Series(draw_a), Series(draw_b, 1000)

    def ratio():
        scale = np.maximum(np.abs(b.mean), 1e-12)
        return a.mean / scale, np.maximum(np.hypot(a.error, b.error) / scale, 1e-9)

    def off():
        r, se = ratio()
        return np.abs(r - 1) - rule, se
    holds, i, noise = settle(off, [a, b], error, seeds)
    r, se = ratio()
    text = f"ratio {r[i]:.4f} ± {se[i]:.4f} ({a.mean[i]:.4f}, {b.mean[i]:.4f}){noise}"
    return Verdict(holds, float(abs(r[i] - 1) / rule), text)


def z_of(a, b):
    """Welch's t of two series as a normal deviate (Wallace 1959), by component."""
    va, vb = a.error ** 2, b.error ** 2
    both = np.maximum(va + vb, 1e-18)
    t = (a.mean - b.mean) / np.sqrt(both)
    freedom = (len(a.values) - 1) * both ** 2 / np.maximum(va ** 2 + vb ** 2, 1e-36)
    return np.sign(t) * (8 * freedom + 1) / (8 * freedom + 3) * np.sqrt(freedom * np.log1p(t ** 2 / freedom))


def same_blocks(draw_a, draw_b, limit=Z, seeds=24):
    """Decides whether two pictures have the same blocks: no |z| is above `limit`, or with other seeds, thrice as many, none is."""
    for first, count in ((0, seeds), (50000, 3 * seeds)):
        a, b = Series(draw_a, first), Series(draw_b, first + 5000)
        a.extend(count)
        b.extend(count)
        z = np.abs(z_of(a, b)).max()
        if z <= limit:
            break
    level = max(b.mean.mean(), 1e-12)
    return Verdict(bool(z <= limit), float(z / limit), f"largest z {z:.1f}, ratio {a.mean.mean() / level:.4f} ± "
                   f"{math.hypot(a.error[-1], b.error[-1]) / level:.4f}")


def same_noise(draw_a, draw_b, least_seeds=12, error=0.001, limit=1.3):
    """Decides whether two estimators have the same means in all blocks of a picture: the root mean square of z over the blocks
    is at most `limit`, and |z| of the picture's mean at most Z. A picture that fails is drawn again, with other seeds: both must."""
    for first in (0, 5000):
        a, b = Series(draw_a, first), Series(draw_b, first + 2500)
        for count in (least_seeds << doubled for doubled in range(6)):
            a.extend(count)
            b.extend(count)
            whole = [np.mean(s.values, axis=1) for s in (a, b)]
            level = max(whole[1].mean(), 1e-12)
            se = math.sqrt(sum(w.var(ddof=1) / len(w) for w in whole)) / level
            if se <= error:
                break
        z = (a.mean - b.mean) / np.maximum(np.hypot(a.error, b.error), 1e-9)
        # z has Student's distribution, whose variance is above 1.
        freedom = 2 * (len(a.values) - 1)
        rms = math.sqrt(np.mean(z ** 2) * (freedom - 2) / freedom)
        off = (whole[0].mean() - whole[1].mean()) / level
        holds = rms <= limit and abs(off) <= Z * se and se <= 1.05 * error
        text = f"z {rms:.2f}, ratio {1 + off:.4f} ± {se:.4f}"
        if holds:
            break
    return Verdict(holds, max(rms / limit, abs(off) / (Z * max(se, 1e-9))), text)
