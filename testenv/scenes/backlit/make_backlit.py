#!/usr/bin/env python3
"""Makes backlit.glb: a ribbed lantern of alabaster and a small bowl, as quad cages (FB_ngon_encoding) for subdivision.

Everything is modelled here, in metres, y up. Run: python3 testenv/scenes/backlit/make_backlit.py [output.glb]
"""
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from gltf_writer import Document, png  # noqa: E402
from shapes import backdrop, lathe, placed, torus  # noqa: E402

# (radius, height): outside from the foot to the lip, inside from the lip to the floor.
LANTERN = [(0.030, 0.0), (0.044, 0.0005), (0.047, 0.004), (0.044, 0.010), (0.046, 0.016), (0.062, 0.032), (0.073, 0.055),
           (0.077, 0.080), (0.072, 0.108), (0.060, 0.134), (0.049, 0.150), (0.047, 0.158), (0.051, 0.167), (0.055, 0.1705),
           (0.0535, 0.1725), (0.049, 0.170), (0.0425, 0.158), (0.044, 0.149), (0.054, 0.132), (0.065, 0.108), (0.069, 0.080),
           (0.066, 0.056), (0.055, 0.034), (0.040, 0.021), (0.020, 0.018)]
OUTSIDE = range(5, 11)
RIBS, SIDES = 14, 112


def ribbed(angle, k, radius):
    """Ribs that wind about the belly; they fade at the neck and at the foot, and the inside is smooth."""
    if k not in OUTSIDE:
        return radius
    s = (k - OUTSIDE[0]) / (len(OUTSIDE) - 1)
    c = math.cos(RIBS * (angle + 0.34 * s))
    # Round ribs with narrow valleys between.
    return radius + 0.0060 * math.sin(math.pi * (0.10 + 0.8 * s)) * (math.sqrt(0.5 + 0.5 * c) - 0.55)


BOWL = [(0.012, 0.0), (0.017, 0.0005), (0.018, 0.004), (0.026, 0.010), (0.036, 0.020), (0.041, 0.030), (0.042, 0.0335),
        (0.0405, 0.034), (0.0385, 0.030), (0.034, 0.0215), (0.024, 0.0125), (0.010, 0.0085)]


def fluted(angle, k, radius):
    return radius * (1 + 0.045 * math.cos(9 * angle)) if 4 <= k <= 9 else radius


def alabaster(x, y, width=256, height=128):
    """Milky bands with veins of iron, closed around the lantern."""
    a, s = 2 * math.pi * x / width, y / height
    warp = math.sin(2 * a + 5.1 * s) + 0.6 * math.sin(3 * a - 8.3 * s + 1.0) + 0.35 * math.sin(7 * a + 13.0 * s + 2.0)
    cloud = 0.5 + 0.5 * math.sin(9.0 * s + 0.9 * warp)
    vein = max(0.0, 1 - abs(math.sin(a + 6.0 * s + 0.75 * warp)) / 0.085) ** 1.5
    fine = max(0.0, 1 - abs(math.sin(2 * a - 9.0 * s + 1.1 * warp)) / 0.05)
    milk, honey, iron = (0.97, 0.95, 0.90), (0.93, 0.86, 0.74), (0.66, 0.36, 0.22)
    rust = min(1.0, 0.85 * vein + 0.45 * fine)
    return tuple((m * (1 - cloud) + h * cloud) * (1 - rust) + i * rust for m, h, i in zip(milk, honey, iron))


def build(path):
    doc = Document("Alabaster make_backlit.py")
    bands = doc.add_texture("alabaster", png(256, 128, alabaster))
    stone = doc.add_material("alabaster", {
        "baseColor": [1.0, 1.0, 1.0], "roughness": 0.28, "specular": 0.9,
        "scatterDistance": [0.0052, 0.0037, 0.0025]}, texture=bands)
    jade = doc.add_material("jade", {
        "baseColor": [0.62, 0.90, 0.70], "roughness": 0.18, "scatterDistance": [0.0022, 0.0044, 0.0027]})
    wood = doc.add_material("table", {"baseColor": [0.115, 0.085, 0.065], "roughness": 0.42, "specular": 0.7})
    brass = doc.add_material("brass", {"baseColor": [0.86, 0.64, 0.34], "metallic": 1.0, "roughness": 0.28})
    lantern = doc.add_mesh("lantern", lathe(LANTERN, SIDES, ribbed), stone)
    doc.add_node("lantern", lantern, placed(0.4, at=(0.02, 0.003, 0.0)))
    doc.add_node("ring", doc.add_mesh("ring", torus(0.050, 0.0035, 24, 8), brass), placed(at=(0.02, 0.0034, 0.0)))
    doc.add_node("bowl", doc.add_mesh("bowl", lathe(BOWL, 54, fluted), jade), placed(0.2, at=(-0.115, 0.0, 0.055)))
    doc.add_node("backdrop", doc.add_mesh("backdrop", backdrop(), wood))
    doc.write_glb(path)


if __name__ == "__main__":
    build(sys.argv[1] if len(sys.argv) > 1 else HERE / "backlit.glb")
