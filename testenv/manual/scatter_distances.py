#!/usr/bin/env python3
"""Computes the table of delegate/manual/recipes.md: baseColor and scatterDistance of published media.

  scatter_distances.py            prints the table
  scatter_distances.py --check    fails if the page holds another table, or if a medium does not reflect what its source publishes

rows.json has the media: reduced scattering and absorption per mm, the index of refraction and the diffuse reflectance of Jensen,
Marschner, Levoy, Hanrahan 2001, figure 5. Their dipole gives how far from its entry light leaves such a medium, the internal
reflection at its surface included. Ours has none, so baseColor is the published reflectance, and scatterDistance is the d of
Burley's profile whose light leaves at the same median distance.
"""
import json
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
PAGE = HERE.parents[1] / "delegate/manual/recipes.md"
REFLECTANCE_ERROR = 0.011  # the source rounds to two digits, and to multiples of its own fit


def root(function, low, high):
    """Where a function that grows passes 0."""
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) < 0 else (low, middle)
    return low


MEDIAN_OF_BURLEY = root(lambda r: 0.5 - math.exp(-r) / 4 - 0.75 * math.exp(-r / 3), 0, 10)  # in units of d


class Dipole:
    """The classical dipole of a medium: the light that leaves within a radius of its entry."""

    def __init__(self, scattering, absorption, ior):
        fresnel = -1.440 / ior ** 2 + 0.710 / ior + 0.668 + 0.0636 * ior
        extinction = scattering + absorption
        self.albedo = scattering / extinction
        self.transport = math.sqrt(3 * absorption * extinction)
        depth = 1 / extinction
        self.sources = depth, depth * (1 + 4 / 3 * (1 + fresnel) / (1 - fresnel))

    def within(self, radius):
        def source(z):
            far = math.hypot(radius, z)
            return math.exp(-self.transport * z) - z / far * math.exp(-self.transport * far)
        return self.albedo / 2 * sum(source(z) for z in self.sources)

    def reflectance(self):
        return self.within(1e9)

    def median(self):
        half = self.reflectance() / 2
        return root(lambda r: self.within(r) - half, 0, 1e4)


def rounded(value):
    """To two digits."""
    return float(f"{value:.2g}")


def media():
    return json.loads((HERE / "rows.json").read_text())["recipes"]


def channels(medium):
    return [Dipole(*numbers, medium["ior"]) for numbers in zip(medium["scattering"], medium["absorption"])]


def distance_of(medium):
    """scatterDistance in mm per channel."""
    if "distance" in medium:
        return medium["distance"]
    return [rounded(dipole.median() / MEDIAN_OF_BURLEY) for dipole in channels(medium)]


def colour_of(medium):
    return medium.get("colour") or medium["reflectance"]


def material_of(medium, unit=1000):
    """Parameters of AlabasterDisney for a scene whose unit has that many mm."""
    return {**medium["surface"], "baseColor": colour_of(medium), "scatterDistance": [round(mm / unit, 8) for mm in distance_of(medium)]}


def table():
    lines = ["| material | mean free path, mm | `baseColor` | `scatterDistance`, mm | `roughness`, `ior` |", "| --- | --- | --- | --- | --- |"]
    for medium in media():
        paths = [1 / (s + a) for s, a in zip(medium["scattering"], medium["absorption"])] if "scattering" in medium else []
        lines.append("| {} | {} | {} | {} | {} |".format(
            medium["name"], ", ".join(f"{rounded(path):g}" for path in paths) or "chosen by eye",
            *(", ".join(f"{value:g}" for value in values) for values in (colour_of(medium), distance_of(medium))),
            ", ".join(f"{medium['surface'][key]:g}" for key in ("roughness", "ior"))))
    return "\n".join(lines)


def main():
    if sys.argv[1:] != ["--check"]:
        print(table())
        return 0
    found = [f"{medium['name']}: the dipole reflects {dipole.reflectance():.3f}, its source says {published}"
             for medium in media() if "scattering" in medium for dipole, published in zip(channels(medium), medium["reflectance"])
             if abs(dipole.reflectance() - published) > REFLECTANCE_ERROR]
    if table() not in PAGE.read_text():
        found.append(f"{PAGE} holds another table: scatter_distances.py prints the right one")
    print("\n".join(found) or "the table is that of the published media")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
