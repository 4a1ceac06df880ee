"""The same medium and the same light in the units of each renderer. Standard library only: Blender's Python imports it too."""
import math


def exact_alpha(albedo):
    """Single-scattering albedo for the surface albedo `albedo`: our inversion `exact` at g = 0 (core/subsurface/medium.cpp)."""
    a = min(max(albedo, 0.0), 1.0)
    p = 1 + a * (1.90590733792 + a * (0.722472222151 + a * 0.00527736903751))
    q = 1 + a * (3.35007585287 + a * (3.22823189382 + a * 0.813263477961))
    return 1 - ((1 - a) * p / q) ** 2


def mean_free_path(albedo, scatter_distance):
    """1 / sigma_t: Chiang, Kutz, Burley 2016, eq. 2 and 3."""
    return scatter_distance * (1.9 - albedo + 3.5 * (albedo - 0.8) ** 2)


def cycles_alpha(albedo):
    """Single-scattering albedo that Cycles 3.4 to 5.0 walks with for its colour `albedo` at anisotropy 0
    (subsurface_random_walk_remap). Cycles clamps it to 0.999999."""
    blend = albedo ** 0.25
    low = 1.8260523782 * math.atan((4.98511194385 + 0.127355959438) * albedo) ** 1.09686102424
    high = 0.496310210422 * math.atan((4.23190299701 + 0.00310603949088) * albedo) ** 2.40602999408
    return min((1 - blend) * low + blend * high, 0.999999)


def cycles_albedo(alpha):
    """The colour for which Cycles walks with `alpha`, by bisection; at most 1."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if cycles_alpha(middle) < alpha else (low, middle)
    return high


def cycles_radius(albedo, scatter_distance):
    """Cycles divides the radius of a random walk with fixed radius by 4 pi to obtain the mean free path (bssrdf_setup_radius)."""
    return 4 * math.pi * mean_free_path(albedo, scatter_distance)


def blender_rect_power(radiance, area):
    """Energy of an area light (one-sided, spread of 180 degrees): radiance = energy / (4 area)."""
    return 4 * area * radiance


def blender_sphere_power(radiance, radius):
    """Energy of a point light with a radius: radiance = energy / (4 pi^2 radius^2)."""
    return 4 * math.pi ** 2 * radius ** 2 * radiance


def f0_from_ior(ior):
    return ((ior - 1) / (ior + 1)) ** 2


def ior_from_f0(f0):
    root = math.sqrt(min(f0, 0.99))
    return (1 + root) / (1 - root)


def principled_specular(f0):
    """`Specular` (3.4) or `Specular IOR Level` at IOR 1.5 (from 4.0 on) of the Principled BSDF."""
    return f0 / 0.08


def coat_roughness(gloss):
    """Roughness whose square is the alpha of Disney's clearcoat, 0.1 to 0.001."""
    return math.sqrt(0.1 + gloss * (0.001 - 0.1))


def look_at(position, target, up=(0.0, 1.0, 0.0)):
    """Rows x, y, z of a frame at `position` whose -z axis points to `target` and whose y axis leans towards `up`."""
    z = normalized([p - t for p, t in zip(position, target)])
    x = normalized(cross(up, z))
    return x, cross(z, x), z


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def normalized(a):
    length = math.sqrt(sum(c * c for c in a))
    return [c / length for c in a] if length > 0 else [0.0, 0.0, 1.0]
