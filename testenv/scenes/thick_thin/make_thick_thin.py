#!/usr/bin/env python3
"""Makes thick_thin.glb: one closed body with a solid core and thin twisted fins, as a quad cage (FB_ngon_encoding) for subdivision. Light passes through the fins and is absorbed in the core.

Everything is modelled here, in metres, y up. Run: python3 testenv/scenes/thick_thin/make_thick_thin.py [PATH.glb]
"""
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from gltf_writer import Document, Mesh  # noqa: E402
from shapes import backdrop, fan_cap, lathe, placed  # noqa: E402

FINS, RINGS = 7, 33
HEIGHT, CORE, REACH = 0.150, 0.024, 0.060  # reach: the part of the radius that a fin adds to the core at its widest
THICKNESS = 0.0018
TWIST = 0.75  # radians from the foot to the tip


def ring(s):
    """The outline at height s in 0..1, counter-clockwise from above: for each fin out along one side and back along the other."""
    core = CORE * (0.22 + 0.78 * math.sin(math.pi * (0.10 + 0.82 * s)) ** 1.3)
    points = []
    for fin in range(FINS):
        angle = 2 * math.pi * fin / FINS + TWIST * s * s + 0.06 * math.sin(9.0 * s + fin)
        reach = REACH * math.sin(math.pi * (0.02 + 0.95 * s ** 0.85)) ** 0.9 * (1.0 + 0.16 * math.sin(30.0 * s))
        direction, side = (math.cos(angle), -math.sin(angle)), (-math.sin(angle), -math.cos(angle))
        # Radius and half the thickness: a fillet at the root, then an even sheet with a round rim.
        half = 0.5 * THICKNESS
        outline = [(core, 2.6 * half), (core + 0.12 * reach, 1.3 * half), (core + 0.45 * reach, half),
                   (core + 0.80 * reach, 0.9 * half), (core + reach, 0.7 * half)]
        for sign, steps in ((-1, outline), (1, outline[::-1])):
            for radius, offset in steps:
                # Fins lean over towards their rims, more at the top.
                curl = 0.20 * s * ((radius - core) / (REACH + 1e-9)) ** 2
                c, n = math.cos(curl), math.sin(curl)
                out = (direction[0] * c + side[0] * n, direction[1] * c + side[1] * n)
                across = (side[0] * c - direction[0] * n, side[1] * c - direction[1] * n)
                points.append((radius * out[0] + sign * offset * across[0], HEIGHT * s,
                               radius * out[1] + sign * offset * across[1]))
    return points


def body():
    mesh = Mesh()
    rings = [ring(i / (RINGS - 1)) for i in range(RINGS)]
    first = mesh.add_grid(rings, closed_u=True)
    sides = len(rings[0])
    fan_cap(mesh, first, sides, (0.0, -0.0015, 0.0), bottom=True)
    fan_cap(mesh, first + (RINGS - 1) * sides, sides, (0.0, HEIGHT + 0.004, 0.0), bottom=False)
    return mesh


def build(path):
    document = Document("Alabaster make_thick_thin.py")
    wax = document.add_material("wax", {
        "baseColor": [0.95, 0.66, 0.42], "roughness": 0.32, "scatterDistance": [0.0040, 0.0018, 0.0009]})
    stone = document.add_material("stone", {"baseColor": [0.10, 0.11, 0.13], "roughness": 0.28})
    paper = document.add_material("paper", {"baseColor": [0.20, 0.23, 0.27], "roughness": 0.7})
    document.add_node("body", document.add_mesh("body", body(), wax), placed(-0.47, at=(0.0, 0.0215, 0.0)))
    foot = [(0.030, 0.0), (0.050, 0.0), (0.052, 0.003), (0.050, 0.006), (0.030, 0.011), (0.026, 0.017), (0.030, 0.0212),
            (0.026, 0.0222), (0.012, 0.0222)]
    document.add_node("foot", document.add_mesh("foot", lathe(foot, 24), stone))
    document.add_node("ground", document.add_mesh("ground", backdrop(), paper))
    document.write_glb(path)


if __name__ == "__main__":
    build(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "thick_thin.glb")
