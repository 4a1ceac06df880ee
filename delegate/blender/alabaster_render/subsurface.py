"""Blender's subsurface radius as scatterDistance, so that both walk with the same mean free path."""
import bpy
import math

MODERN = bpy.app.version >= (4, 0, 0)


def _transport_albedo(albedo, bounce):
    """alpha' of a dipole of this reflectance, by bisection (Jensen et al. 2001, eq. 15)."""
    def reflectance(alpha):
        root = math.sqrt(max(3 * (1 - alpha), 0.0))
        return 0.5 * alpha * (1 + math.exp(-bounce * root)) * math.exp(-root)
    if albedo < 1e-4:
        return 0.0
    if albedo >= 0.995:
        return 0.999852
    low, high = 0.0, 1.0
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if reflectance(middle) < albedo else (low, middle)
    return 0.5 * (low + high)


def mean_free_path(method, radius, albedo, ior):
    """The mean free path that Cycles walks with (bssrdf_setup_radius). Christensen and Burley's profile has none; a walk that looks like it has."""
    skin = method == "RANDOM_WALK_SKIN" if MODERN else method == "RANDOM_WALK"
    if method in {"BURLEY", "RANDOM_WALK_FIXED_RADIUS"}:
        return radius / (4 * math.pi)
    if not skin:
        return radius
    inverse = 1 / ior
    diffuse = inverse * (-1.440 * inverse + 0.710) + 0.668 + 0.0636 * ior
    bounce = (4 / 3) * (1 + diffuse) / (1 - diffuse)
    return radius * math.sqrt(3 * (1 - _transport_albedo(albedo, bounce)))


def scatter_distance(mfp, albedo):
    """mfp = d (1.9 - A + 3.5 (A - 0.8)^2): Chiang, Kutz, Burley 2016, eq. 2 and 3."""
    return mfp / (1.9 - albedo + 3.5 * (albedo - 0.8) ** 2)


def distances(method, radii, albedos, ior):
    return tuple(scatter_distance(mean_free_path(method, max(r, 0.0), a, ior), a)
                 for r, a in zip(radii, (min(max(a, 0.0), 1.0) for a in albedos)))
