#!/usr/bin/env python3
"""Makes wet_face.glb with side.json and behind.json beside it: a head of our own, wet: skin under a coat, drops of water that are half
sunk into it, eyeballs in the skin and corneas on them. All that the matrix has in pairs, in one picture.

  wet_face.py FOLDER [--cell 3.2] [--drops 120]
  alabaster render FOLDER/side.json -o side.png --size 600x720 --spp 256

Modelled in millimetres, y up, the face towards z; written in metres.
"""
import argparse
import json
import math
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scenes"))
from gltf_writer import Document, Mesh, png  # noqa: E402
from implicit import SurfaceNet, cone_chain, curve, ellipsoid, smooth_max, smooth_min  # noqa: E402
from shapes import cube_sphere, noise  # noqa: E402

MM = 0.001
EYE, EYE_RADIUS = (30.5, 10.0, 66.5), 12.3

# Joints (x, y, z, radius), of the right half; the left one is its mirror image.
BROW = curve([(2, 27, 84, 6), (14, 31, 84, 6.5), (28, 33, 79, 6), (42, 27, 66, 5), (50, 18, 56, 4)])
NOSE = curve([(0, 24, 82, 6), (0, 8, 88, 6), (0, -8, 96, 7), (0, -20, 104, 8)])
UPPER_LID = curve([(17.0, 7.5, 71.0, 2.0), (23, 14.2, 77.5, 2.4), (31, 16.8, 79.0, 2.6), (39, 14.0, 75.5, 2.4), (44.5, 8.0, 68.0, 2.0)])
LOWER_LID = curve([(17.0, 7.5, 71.0, 2.0), (24, 3.6, 76.0, 2.3), (32, 2.4, 77.4, 2.4), (39, 4.0, 74.0, 2.3), (44.5, 8.0, 68.0, 2.0)])
UPPER_LIP = curve([(0, -50.5, 90.5, 3.8), (6, -48.5, 90.5, 4.2), (14, -51, 86, 3.8), (25, -55, 76, 2.2)])
LOWER_LIP = curve([(0, -60.5, 90.0, 5.0), (8, -60.0, 88.5, 4.8), (16, -58, 84, 3.6), (24, -56, 76, 2.0)])
RIM = curve([(73, 2, 0, 3), (80, 22, -6, 3.4), (81, 30, -16, 3.4), (82, 22, -27, 3.2), (80, 2, -26, 3), (76, -18, -16, 3.4), (72, -26, -8, 3.6)])
JAW = curve([(64, -34, 0, 16), (56, -62, 16, 15), (34, -84, 46, 15), (0, -92, 62, 15)])


def head(p):
    x, y, z = abs(p[0]), p[1], p[2]
    q = (x, y, z)
    d = ellipsoid(q, (0, 34, -14), (76, 84, 96))
    d = smooth_min(d, ellipsoid(q, (0, -22, 20), (62, 76, 64)), 30)
    d = smooth_min(d, cone_chain(q, JAW), 22)
    d = smooth_min(d, ellipsoid(q, (0, -90, 66), (18, 14, 15)), 16)
    d = smooth_min(d, ellipsoid(q, (43, -14, 50), (19, 14, 18)), 22)
    d = smooth_min(d, ellipsoid(q, (0, -54, 68), (30, 20, 16)), 18)
    d = smooth_min(d, cone_chain(q, BROW), 14)
    d = smooth_max(d, -ellipsoid(q, (31, 9, 92), (18, 12, 17)), 12)
    if z > 30:
        d = smooth_min(d, cone_chain(q, NOSE), 12)
        d = smooth_min(d, ellipsoid(q, (11, -22, 92), (8, 7, 9)), 6)
        d = smooth_max(d, -ellipsoid(q, (6, -31, 94), (3.6, 6, 5)), 3)
        d = smooth_min(d, cone_chain(q, UPPER_LIP), 7)
        d = smooth_max(d, -ellipsoid(q, (0, -42, 97), (3.5, 9, 5)), 5)
        d = smooth_min(d, cone_chain(q, LOWER_LIP), 6)
        d = smooth_min(d, cone_chain(q, UPPER_LID), 5)
        d = smooth_min(d, cone_chain(q, LOWER_LID), 5)
    if x > 55:
        d = smooth_min(d, ellipsoid(q, (76, 4, -14), (6, 26, 15)), 8)
        d = smooth_max(d, -ellipsoid(q, (84, 2, -10), (6, 13, 8)), 4)
        d = smooth_min(d, cone_chain(q, RIM), 4)
    d = smooth_min(d, cone_chain(q, [(0, -70, -22, 50), (0, -150, -36, 54)]), 26)
    return smooth_max(d, -150 - y, 4)


def gradient(p):
    h = 0.5
    g = [(head(tuple(c + (h if a == k else 0) for a, c in enumerate(p))) - head(tuple(c - (h if a == k else 0) for a, c in enumerate(p))))
         for k in range(3)]
    n = math.sqrt(sum(c * c for c in g))
    return tuple(c / n for c in g)


def on_head(x, y):
    """The foremost point of the face at (x, y), or None."""
    z = 140.0
    for _ in range(200):
        d = head((x, y, z))
        if d < 0.02:
            return (x, y, z)
        z -= 0.6 * d
        if z < -20:
            return None
    return None


def add_ball(mesh, n, place):
    part = cube_sphere(n, place)
    first = len(mesh.points)
    mesh.points += part.points
    mesh.quads += [[first + i for i in quad] for quad in part.quads]
    mesh.uvs += part.uvs


def drop(p, size, stretch):
    """A cap of water: three tenths of its radius below the skin, drawn down by `stretch`."""
    n = gradient(p)
    down = tuple(a + b * n[1] for a, b in zip((0.0, -1.0, 0.0), n))  # along the skin
    length = math.sqrt(sum(c * c for c in down)) or 1.0
    down = tuple(c / length for c in down)
    side = (n[1] * down[2] - n[2] * down[1], n[2] * down[0] - n[0] * down[2], n[0] * down[1] - n[1] * down[0])

    def place(d):
        u, v, w = sum(a * b for a, b in zip(d, side)), sum(a * b for a, b in zip(d, down)), sum(a * b for a, b in zip(d, n))
        low = 0.18 * v if w > 0 else 0.0  # heavier below
        return tuple(MM * (c + size * (u * s * (1 + 0.25 * v * (stretch > 1)) + stretch * v * t + (0.62 * w * (1 + low) - 0.18) * m))
                     for c, s, t, m in zip(p, side, down, n))
    return place


def drops(count):
    mesh, chance, taken = Mesh(), random.Random(7), []
    runs = [(-47, -20, 3.2, 1.5), (-20, -16, 3.0, 1.7), (26, -14, 3.2, 1.6), (38, -40, 3.4, 1.5), (6, 52, 3.6, 1.3), (-24, 62, 3.2, 1.5),
            (0, -98, 4.0, 1.2), (2, -25.5, 3.0, 1.15), (-36, -46, 3.0, 1.6), (20, 46, 2.8, 1.5)]
    wanted = runs + [(chance.uniform(-66, 66), chance.uniform(-100, 100), 0.8 + 2.4 * chance.random() ** 3, 1.0 + 0.15 * chance.random()) for _ in range(count)]
    for x, y, size, stretch in wanted:
        p = on_head(x, y)
        reach = size * stretch
        if p is None or abs(gradient(p)[2]) < 0.15 or math.dist((abs(x), y, p[2]), EYE) < EYE_RADIUS + reach + 4:
            continue
        if any(math.dist(p, q) < reach + r + 0.4 for q, r in taken):
            continue
        taken.append((p, reach))
        add_ball(mesh, 8, drop(p, size, stretch))
    return mesh


def ball(centre, radii, tilt=0.0):
    """`tilt`: radians about y, of the way that a part of the eye looks."""
    c, s = math.cos(tilt), math.sin(tilt)

    def place(d):
        x, y, z = (r * a for r, a in zip(radii, d))
        return tuple(MM * v for v in (centre[0] + c * x + s * z, centre[1] + y, centre[2] - s * x + c * z))
    return place


def eyes(doc):
    parts = {name: Mesh() for name in ("sclera", "iris", "pupil", "cornea")}
    tilt = 0.10
    for sign in (-1, 1):
        centre = (sign * EYE[0], EYE[1], EYE[2])

        def ahead(distance):
            return (centre[0] + distance * math.sin(tilt), centre[1], centre[2] + distance * math.cos(tilt))
        add_ball(parts["sclera"], 16, ball(centre, (EYE_RADIUS,) * 3))
        add_ball(parts["iris"], 12, ball(ahead(10.75), (5.9, 5.9, 1.0), tilt))
        add_ball(parts["pupil"], 10, ball(ahead(11.35), (2.5, 2.5, 0.6), tilt))
        add_ball(parts["cornea"], 16, ball(ahead(5.9), (8.0,) * 3))
    looks = {
        "sclera": {"baseColor": [0.90, 0.85, 0.82], "roughness": 0.3, "scatterDistance": [0.0016, 0.0009, 0.0007], "ior": 1.4, "coat": 1.0,
                   "coatRoughness": 0.05},
        "iris": {"baseColor": [0.22, 0.27, 0.20], "roughness": 0.6},
        "pupil": {"baseColor": [0.01, 0.01, 0.01], "roughness": 0.5, "specular": 0.2},
        "cornea": {"baseColor": [1, 1, 1], "specTrans": 1.0, "ior": 1.376, "roughness": 0.0}}
    for name, mesh in parts.items():
        doc.add_node(name, doc.add_mesh(name, mesh, doc.add_material(name, looks[name])))


def skin_color(px, py, size=384):
    """From the front, 240 mm across."""
    x, y = 240 * ((px + 0.5) / size - 0.5), 240 * (0.5 - (py + 0.5) / size)
    mottle = 0.5 * noise(x / 9, y / 9, 11) + 0.3 * noise(x / 3.5, y / 3.5, 12) + 0.2 * noise(x / 1.2, y / 1.2, 13)
    red = 0.35 * max(0.0, mottle - 0.3)
    lips = math.exp(-((x / 25) ** 4)) * math.exp(-(((y + 55.5) / (8.5 - 0.004 * x * x)) ** 4))
    cheek = math.exp(-((abs(x) - 40) / 20) ** 2 - ((y + 22) / 18) ** 2)
    nose = math.exp(-(x / 14) ** 2 - ((y + 20) / 12) ** 2)
    lid = math.exp(-((abs(x) - 31) / 17) ** 4 - ((y - 10) / 12) ** 4)
    brow = math.exp(-(((y - 34 + 0.012 * (abs(x) - 26) ** 2) / 4.2) ** 4) - ((abs(x) - 31) / 19) ** 6)
    hairs = brow * (0.45 + 0.55 * noise(x / 1.1 + 0.5 * y, y / 2.6, 14))
    pale, ruddy, lip, dark = (0.86, 0.66, 0.55), (0.80, 0.44, 0.37), (0.66, 0.27, 0.26), (0.16, 0.10, 0.07)
    share = min(1.0, red + 0.5 * cheek + 0.4 * nose + 0.35 * lid)
    c = [a * (1 - share) + b * share for a, b in zip(pale, ruddy)]
    c = [a * (1 - 0.85 * lips) + 0.85 * lips * b for a, b in zip(c, lip)]
    c = [a * (1 - 0.8 * hairs) + 0.8 * hairs * b for a, b in zip(c, dark)]
    return tuple(v ** (1 / 2.2) for v in c)


def pores(px, py, size=512):
    x, y = px * 240 / size, py * 240 / size
    h = 0.5 * noise(x / 1.1, y / 1.1, 21) + 0.3 * noise(x / 0.6, y / 0.6, 22) + 0.2 * noise(x / 2.4, y / 2.4, 23)
    return (h, h, h)


def build(folder, cell, count):
    folder.mkdir(parents=True, exist_ok=True)
    doc = Document("Alabaster wet_face.py")
    skin = doc.add_material("skin", {
        "baseColor": [1.0, 1.0, 1.0], "roughness": 0.42, "specular": 0.6, "ior": 1.4, "coat": 0.7, "coatRoughness": 0.22,
        "scatterDistance": [0.00367, 0.00137, 0.00068]}, texture=doc.add_texture("skin", png(384, 384, skin_color)))
    net = SurfaceNet(lambda p: head(tuple(c / MM for c in p)) * MM, [c * MM for c in (-92, -156, -118)], [c * MM for c in (92, 124, 118)],
                     cell * MM)
    doc.add_node("head", doc.add_mesh("head", net.mesh(lambda p: (p[0] / 0.240 + 0.5, p[1] / 0.240 + 0.5)), skin))
    eyes(doc)
    water = doc.add_material("water", {"baseColor": [1, 1, 1], "specTrans": 1.0, "ior": 1.33, "roughness": 0.0})
    doc.add_node("drops", doc.add_mesh("drops", drops(count), water))
    wall = Mesh()
    wall.add_grid([[(x, y, -1.6) for x in (-3.0, 3.0)] for y in (-2.0, 2.0)], lambda i, j: (0.0, 0.0))
    doc.add_node("wall", doc.add_mesh("wall", wall, doc.add_material("wall", {"baseColor": [0.05, 0.055, 0.06], "roughness": 0.9})))
    doc.write_glb(folder / "wet_face.glb")
    (folder / "pores.png").write_bytes(png(512, 512, pores))
    for name, lights in LIGHTS.items():
        (folder / f"{name}.json").write_text(json.dumps({
            "gltf": [{"file": "wet_face.glb", "refineLevel": 1}],
            "materials": [{"match": "skin", "bump": {"file": "pores.png", "scale": 0.00035}}],
            "lights": lights, "camera": {"lookAt": {"eye": [-0.16, 0.0, 0.62], "target": [0.0, -0.008, 0.0]},
                                         "focalLength": 64, "horizontalAperture": 24, "verticalAperture": 29},
            "settings": {"samples": 128, "resolution": [480, 580], "studio": "off", "maxDepth": 24}}, indent=1))


def rect(name, position, intensity, size, color):
    return {"name": name, "type": "rectLight", "position": position, "target": [0, 0, 0.02], "intensity": intensity, "width": size,
            "height": size, "color": color}


SKY = {"name": "sky", "type": "domeLight", "intensity": 0.03, "color": [0.6, 0.75, 1.0], "visibleToCamera": False}
LIGHTS = {
    "side": [rect("key", [-0.75, 0.35, 0.35], 5.5, 0.7, [1.0, 0.93, 0.84]), rect("rim", [0.6, 0.35, -0.55], 8, 0.5, [0.75, 0.87, 1.0]), SKY],
    "behind": [rect("left", [-0.55, 0.30, -0.65], 21, 0.5, [1.0, 0.86, 0.70]), rect("right", [0.7, 0.15, -0.45], 14, 0.5, [0.7, 0.85, 1.0]),
               rect("fill", [-0.2, 0.5, 1.0], 0.9, 0.5, [1.0, 0.95, 0.9]), SKY]}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--cell", type=float, default=3.2)
    parser.add_argument("--drops", type=int, default=120)
    given = parser.parse_args()
    build(given.folder, given.cell, given.drops)
