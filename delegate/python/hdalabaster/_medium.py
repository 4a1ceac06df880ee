"""Media by their coefficients."""
from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Any, Literal, Union

from ._hdalabaster import ArgumentError, _absorbed_share, _shape_of

if TYPE_CHECKING:
    from . import _Array

_METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
_MOST_ANISOTROPY = 0.9  # of scatterAnisotropy


def _bands(values: Any, name: str) -> list[float]:
    shape = _shape_of(values, name)
    if shape not in ([], [3]):
        raise ArgumentError(f"{name} must be one number, or three for three bands, and has the shape {tuple(shape)}")
    numbers = [float(value) for value in values] if shape else [float(values)] * 3
    for number in numbers:
        if not 0 <= number < math.inf:
            raise ArgumentError(f"{name} must be finite and at least 0, and is {number}")
    return numbers


def _number(value: Any, name: str) -> float:
    if _shape_of(value, name):
        raise ArgumentError(f"{name} must be one number")
    if not math.isfinite(value):
        raise ArgumentError(f"{name} must be finite, and is {float(value)}")
    return float(value)


def _color_of(absorbed: float, g: float) -> float:
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if _absorbed_share(middle, g) > absorbed else (low, middle)
    return high


def medium(mu_a: Union[float, _Array], mu_s: Union[float, _Array], g: float, n: float, per: Literal["mm", "cm", "m"] = "mm",
           unit: float = 1.0) -> dict[str, Any]:
    """Parameters of a material, as set_material takes them, of a medium behind a smooth wall: mu_a and mu_s are its coefficients of
    absorption and scattering, one number or one for each of three bands, g is the mean cosine of scattering (Henyey-Greenstein), n the
    index of refraction. per: the length that the coefficients are for. unit: metres per unit of the scene. The mesh must be closed. The
    manual's page "Measuring" has examples. g beyond 0.9 or -0.9 becomes that, with the same mu_s (1 - g), and one Python warning."""
    absorption, scattering = _bands(mu_a, "mu_a"), _bands(mu_s, "mu_s")
    g, n, unit = _number(g, "g"), _number(n, "n"), _number(unit, "unit")
    if 0 in scattering:
        raise ArgumentError("mu_s must be above 0: a medium without scattering is clear, with attenuationColor and attenuationDistance")
    if not -1 < g < 1:
        raise ArgumentError(f"g must be above -1 and below 1, and is {g}")
    if not 1 <= n <= 4:
        raise ArgumentError(f"n must be within 1 and 4, and is {n}")
    if per not in _METRES:
        raise ArgumentError(f"per must be 'mm', 'cm' or 'm', and is {per!r}")
    if unit <= 0:
        raise ArgumentError(f"unit must be above 0, and is {unit}")
    if abs(g) > _MOST_ANISOTROPY:
        nearest = math.copysign(_MOST_ANISOTROPY, g)
        warnings.warn(f"g {g} becomes {nearest}, and mu_s is changed to keep mu_s (1 - g)", stacklevel=2)
        scattering = [s * (1 - g) / (1 - nearest) for s in scattering]
        g = nearest
    paths = [_METRES[per] / unit / (a + s) for a, s in zip(absorption, scattering)]
    if not 1e-30 < min(paths) <= max(paths) < 1e30:
        raise ArgumentError(f"mu_a, mu_s, per and unit give mean free paths of {paths} scene units, which are out of range")
    colors = [_color_of(a / (a + s), g) for a, s in zip(absorption, scattering)]
    return {"baseColor": (1.0, 1.0, 1.0), "subsurfaceColor": tuple(colors), "meanFreePath": tuple(paths), "scatterAnisotropy": g, "ior": n,
            "specTrans": 1.0, "roughness": 0.0}
