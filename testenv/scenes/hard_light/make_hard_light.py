#!/usr/bin/env python3
"""Makes hard_light.glb: a sleeping head of marble, a pebble and a slab, as quad cages (FB_ngon_encoding) for subdivision.

Everything is modelled here, in metres, y up. Run: python3 testenv/scenes/hard_light/make_hard_light.py [output.glb]
"""
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from gltf_writer import Document  # noqa: E402
from shapes import backdrop, box, cube_sphere, placed, unit  # noqa: E402

SIZE = 0.10          # half the length of the head
LIE, NOD = 1.12, -0.50  # radians: the head lies down to its left, the face turns upwards


def bump(x, width):
    return math.exp(-(x / width) ** 2)


def ramp(x, a, b):
    t = min(1.0, max(0.0, (x - a) / (b - a)))
    return t * t * (3 - 2 * t)


def nose(u, v):
    """A ridge that grows from between the brows to the tip, where it ends."""
    along = ramp(v, 0.34, -0.17) * ramp(v, -0.27, -0.17)
    return (0.05 + 0.17 * along) * along * bump(u, 0.055 + 0.075 * along)


def brow(u, v):
    """A cut arc from the nose outwards: sockets below it, the forehead above."""
    arc = 0.25 - 0.55 * (abs(u) - 0.28) ** 2
    socket = ramp(v, arc + 0.035, arc - 0.035) * ramp(v, arc - 0.34, arc - 0.06) * bump(abs(u) - 0.27, 0.24)
    lid = bump(abs(u) - 0.27, 0.135) * bump(v - 0.075, 0.085)
    slit = bump(abs(u) - 0.27, 0.15) * bump(v - 0.025 - 0.5 * (abs(u) - 0.27) ** 2, 0.028)
    return -0.085 * socket + 0.062 * lid - 0.022 * slit


def mouth(u, v):
    upper = bump(u, 0.125) * bump(v + 0.375 - 0.25 * u * u, 0.042)
    lower = bump(u, 0.105) * bump(v + 0.475 - 0.4 * u * u, 0.050)
    slit = bump(u, 0.16) * bump(v + 0.422 - 0.3 * u * u, 0.024)
    return 0.048 * upper + 0.055 * lower - 0.030 * slit + 0.05 * bump(u, 0.16) * bump(v + 0.70, 0.12)


def head(d):
    # More quads where the face is.
    x, y, z = unit((d[0], d[1], d[2] + 0.45))
    narrow = 1 - 0.20 * ramp(y, 0.1, -1.0)
    u, v, w = 0.72 * x * narrow, y, 0.84 * z
    face = ramp(z, 0.15, 0.6)
    w += face * (nose(u, v) + brow(u, v) + mouth(u, v))
    # Hair: combed back from a hairline in shallow waves.
    hair = ramp(v - 0.55 * z + 0.10, 0.12, 0.20)
    wave = math.cos(26 * math.atan2(u, v + 1.1))
    swell = 1 + hair * (0.035 + 0.010 * wave)
    u, v, w = u * swell, v * swell, w * swell
    u, v = u * math.cos(LIE) + v * math.sin(LIE), v * math.cos(LIE) - u * math.sin(LIE)
    v, w = v * math.cos(NOD) - w * math.sin(NOD), v * math.sin(NOD) + w * math.cos(NOD)
    return (u * SIZE, v * SIZE, w * SIZE)


def pebble(d):
    x, y, z = d
    r = 1 + 0.10 * max(0.0, x * 0.8 + z * 0.6) ** 2 - 0.06 * max(0.0, y) ** 2
    return (0.024 * r * x, 0.015 * r * y, 0.020 * r * z)


def build(path):
    doc = Document("Alabaster make_hard_light.py")
    marble = doc.add_material("marble", {
        "baseColor": [0.93, 0.885, 0.83], "roughness": 0.30, "specular": 0.8,
        "scatterDistance": [0.0018, 0.0012, 0.0008]})
    rose = doc.add_material("rose_quartz", {
        "baseColor": [0.90, 0.45, 0.42], "roughness": 0.16, "scatterDistance": [0.0050, 0.0026, 0.0022]})
    slate = doc.add_material("slate", {"baseColor": [0.16, 0.17, 0.19], "roughness": 0.38, "specular": 0.8})
    wall = doc.add_material("wall", {"baseColor": [0.36, 0.30, 0.25], "roughness": 0.7})
    muse = cube_sphere(34, head)
    low = min(p[1] for p in muse.points)
    doc.add_node("head", doc.add_mesh("head", muse, marble), placed(-0.12, at=(0.0, 0.02 - low - 0.0012, 0.0)))
    doc.add_node("pebble", doc.add_mesh("pebble", cube_sphere(5, pebble), rose), placed(0.6, at=(-0.125, 0.0145, 0.105)))
    doc.add_node("slab", doc.add_mesh("slab", box(0.26, 0.02, 0.17, 0.0016), slate), placed(0.12))
    doc.add_node("backdrop", doc.add_mesh("backdrop", backdrop(), wall))
    doc.write_glb(path)


if __name__ == "__main__":
    build(sys.argv[1] if len(sys.argv) > 1 else HERE / "hard_light.glb")
