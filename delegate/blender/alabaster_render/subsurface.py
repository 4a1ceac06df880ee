"""Blender's subsurface radius as a mean free path, so that both walk with the same."""
import bpy
import math

VERSION = bpy.app.version
SKIN = "RANDOM_WALK_SKIN" if VERSION >= (4, 0, 0) else "RANDOM_WALK"  # the radius is that of a dipole
MEAN_FREE_PATH = "RANDOM_WALK" if VERSION >= (5, 2, 0) else None  # the radius is the mean free path itself
SIGNED = VERSION >= (5, 2, 0)  # anisotropy may be negative
LARGEST_ANISOTROPY = 0.9


def _transport_albedo(albedo, bounce):
    """alpha' of a dipole of this reflectance (Jensen et al. 2001, eq. 15), by bisection with the number of steps of Cycles."""
    def reflectance(alpha):
        root = math.sqrt(max(3 * (1 - alpha), 0.0))
        return 0.5 * alpha * (1 + math.exp(-bounce * root)) * math.exp(-root)
    if albedo < 1e-4:
        return 0.0
    if albedo >= 0.995:
        return 0.999999
    low, high = 0.0, 1.0
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if reflectance(middle) < albedo else (low, middle)
    return middle


def mean_free_path(method, radius, albedo, ior):
    """The mean free path that Cycles walks with; for Christensen and Burley's profile, which is as wide for every albedo, that of a
    walk as wide."""
    if method == MEAN_FREE_PATH:
        return radius
    if method == "BURLEY":
        return radius / (4 * math.pi) * distance_scale(albedo)
    if method != SKIN:
        return radius / (4 * math.pi)
    ior = min(max(ior, 1.01), 3.8)
    inverse = 1 / ior
    diffuse = inverse * (-1.440 * inverse + 0.710) + 0.668 + 0.0636 * ior
    bounce = (4 / 3) * (1 + diffuse) / (1 - diffuse)
    return radius * math.sqrt(3 * (1 - _transport_albedo(albedo, bounce)))


def distance_scale(albedo):
    """mfp / d = 1.9 - A + 3.5 (A - 0.8)^2: Chiang, Kutz, Burley 2016, eq. 2 and 3."""
    return 1.9 - albedo + 3.5 * (albedo - 0.8) ** 2


def anisotropy(method, asked):
    """scatterAnisotropy. Cycles' limits; Christensen and Burley's profile has none."""
    lowest = -LARGEST_ANISOTROPY if SIGNED else 0.0
    return 0.0 if method == "BURLEY" else min(max(asked, lowest), LARGEST_ANISOTROPY)


def depends_on_color(method):
    return method in ("BURLEY", SKIN)


def path_factors(method, albedos, ior, asked=0.0):
    """The mean free path over the radius, by channel. asked: the anisotropy. Cycles' own is the reduced one, which it leaves alone, but
    where it inverts albedos by van de Hulst's formula."""
    whole = method == MEAN_FREE_PATH or (SIGNED and method != "BURLEY" and asked < 0)
    shorter = 1.0 if whole else 1 - anisotropy(method, asked)
    return tuple(shorter * mean_free_path(method, 1.0, min(max(a, 0.0), 1.0), ior) for a in albedos)
