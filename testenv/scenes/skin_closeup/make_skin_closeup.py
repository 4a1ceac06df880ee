#!/usr/bin/env python3
"""Makes skin_closeup.glb: an ear, life-sized, with its rim, folds, lobe and the side of the head.

Everything is modelled here, in metres, y up; x towards the face, z away from the head.
Run: python3 testenv/scenes/skin_closeup/make_skin_closeup.py [output.glb]
"""
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from gltf_writer import Document, png  # noqa: E402
from implicit import SurfaceNet, cone_chain, curve, ellipsoid, smooth_max, smooth_min  # noqa: E402
from shapes import backdrop, lattice, noise, placed  # noqa: E402

MM = 0.001
CELL = 1.75
SALT = 974711
LOW, HIGH = (-42.0, -47.0, -15.0), (58.0, 50.0, 24.0)  # of the net, mm

# Joints (x, y, z, radius) in mm. The rim starts in the bowl, climbs to the front, goes over the top and down the back.
HELIX = curve([(-1, 1, 5.5, 1.8), (7, 5, 7.5, 2.1), (12, 13, 8.0, 2.4), (11, 23, 9.5, 2.5), (4, 31, 11.5, 2.6),
               (-7, 33, 13.5, 2.7), (-17, 28, 15.5, 2.6), (-22, 18, 16.5, 2.4), (-22.5, 6, 16.5, 2.1), (-19.5, -6, 15.0, 1.9),
               (-14, -17, 12.5, 2.0), (-8, -24, 10.5, 2.2)])
ANTIHELIX = curve([(-2.5, -13, 9.5, 2.0), (-8.5, -9, 11.5, 2.3), (-12, -1, 12.8, 2.5), (-12, 9, 13.2, 2.6), (-9, 17, 12.0, 2.5),
                   (-5, 24, 10.5, 1.9)])
ROOT = curve([(-3, 1.5, 4.0, 1.6), (2, 2.5, 5.0, 2.0), (7, 5, 7.0, 2.3), (11, 11, 8.0, 2.5)])  # of the rim, across the bowl
CRUS = curve([(-11, 10, 12.8, 2.2), (-4, 14.5, 10.0, 2.0), (3, 16, 7.5, 1.6)])


def auricle(p):
    """The ear's own sheet: a shallow dish that leans away from the head, about 3 mm thick, wide at the top."""
    x, y, z = p
    slope = 4.6 - 0.40 * x + 0.02 * y + 0.0018 * (x * x + y * y)  # the sheet's height above the head
    sheet = abs(z - slope) * 0.90 - 1.5
    outline = smooth_min(ellipsoid((x, y, 0.0), (-5.0, 8.0, 0.0), (17.5, 24.5, 60.0)),
                         ellipsoid((x, y, 0.0), (-1.0, -14.0, 0.0), (13.0, 15.0, 60.0)), 10.0)
    return smooth_max(sheet, outline, 2.5)


def ear(p):
    d = auricle(p)
    d = smooth_min(d, cone_chain(p, HELIX), 1.8)
    d = smooth_min(d, cone_chain(p, ANTIHELIX), 2.6)
    d = smooth_min(d, cone_chain(p, CRUS), 2.6)
    d = smooth_min(d, ellipsoid(p, (0.5, -26.0, 7.6), (8.6, 8.8, 3.6)), 5.0)     # lobe
    d = smooth_min(d, ellipsoid(p, (-1.0, -15.5, 8.5), (4.6, 3.2, 3.4)), 3.5)    # antitragus
    return d


def skin(q):
    p = tuple(c / MM for c in q)
    x, y, z = p
    head = ellipsoid(p, (14.0, 6.0, -71.0), (88.0, 108.0, 74.0))
    jaw = ellipsoid(p, (34.0, -44.0, -28.0), (34.0, 38.0, 30.0))
    d = smooth_min(head, jaw, 16.0)
    bowl = ellipsoid(p, (0.5, -3.5, 9.5), (9.8, 11.5, 9.5))
    if z > -4.0 and x < 30.0:
        near = ear(p)
        behind = ellipsoid(p, (-19.0, 4.0, 1.0), (12.0, 25.0, 5.0))  # the groove between ear and head
        d = smooth_max(smooth_min(d, near, 6.0), -behind, 3.0)
        d = smooth_max(d, -bowl, 3.0)
        d = smooth_min(d, cone_chain(p, ROOT), 4.0)
        canal = cone_chain(p, [(4.0, -5.0, 4.0, 3.0), (7.0, -5.0, -4.0, 2.4)])
        d = smooth_max(d, -canal, 3.0)
        d = smooth_min(d, ellipsoid(p, (10.0, -6.0, 7.2), (3.8, 6.0, 3.6)), 4.5)  # tragus
    edge = max(-38.0 - x, x - 54.0, -43.0 - y, y - 46.0, -12.0 - z)       # cut out of the head, far outside the picture
    d = smooth_max(d, edge, 3.0)
    grain = math.sin(1.9 * x + 0.7 * y) * math.sin(1.7 * y - 0.5 * z) * math.sin(1.3 * z + 0.9 * x)
    return (d + 0.035 * grain) * MM


def freckle(x, y):
    """Small round spots, 0..1, at most one per cell of 4 mm."""
    best = 0.0
    for i in range(math.floor(x / 4) - 1, math.floor(x / 4) + 2):
        for j in range(math.floor(y / 4) - 1, math.floor(y / 4) + 2):
            if lattice(i, j, 5 * SALT) > 0.62:
                cx, cy = 4 * (i + lattice(i, j, 6 * SALT)), 4 * (j + lattice(i, j, 7 * SALT))
                r = 0.35 + 0.55 * lattice(i, j, 8 * SALT) ** 2
                best = max(best, math.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (r * r)) * (0.3 + 0.7 * lattice(i, j, 9 * SALT)))
    return best


def colour(px, py, size=256):
    """The colour seen from the side, 120 mm across: redder on rim, lobe and folds, mottled, freckled towards the cheek."""
    x, y = 120 * ((px + 0.5) / size - 0.5), 120 * (0.5 - (py + 0.5) / size)
    rim = math.exp(-(cone_chain((x, y, 0.0), [(a, b, 0.0, 0.0) for a, b, _, _ in HELIX[12:]]) / 5.0) ** 2)
    lobe = math.exp(-((x - 0.5) ** 2 + (y + 27) ** 2) / 90)
    mottle = 0.5 * noise(x / 6, y / 6, SALT) + 0.3 * noise(x / 2.2, y / 2.2, 2 * SALT) + 0.2 * noise(x / 0.8, y / 0.8, 3 * SALT)
    red = min(1.0, 0.55 * rim + 0.5 * lobe + 0.55 * max(0.0, mottle - 0.35))
    spot = freckle(x, y) * min(1.0, max(0.0, (x - 4) / 14)) * 0.55
    pale, ruddy, brown = (0.880, 0.680, 0.575), (0.835, 0.475, 0.400), (0.55, 0.33, 0.24)
    c = [p * (1 - red) + r * red for p, r in zip(pale, ruddy)]
    return tuple(a * (1 - spot) + b * spot for a, b in zip(c, brown))


def build(path):
    doc = Document("Alabaster make_skin_closeup.py")
    # Diffuse mean free paths of skin (Jensen et al. 2001, skin1): 3.67, 1.37 and 0.68 mm.
    material = doc.add_material("skin", {
        "baseColor": [1.0, 1.0, 1.0], "roughness": 0.46, "specular": 0.55, "ior": 1.4,
        "scatterDistance": [0.00367, 0.00137, 0.00068]}, texture=doc.add_texture("skin", png(256, 256, colour)))
    net = SurfaceNet(skin, [c * MM for c in LOW], [c * MM for c in HIGH], CELL * MM)
    mesh = net.mesh(lambda p: (p[0] / 0.120 + 0.5, p[1] / 0.120 + 0.5))
    doc.add_node("ear", doc.add_mesh("ear", mesh, material))
    wall = doc.add_material("wall", {"baseColor": [0.055, 0.075, 0.085], "roughness": 0.8})
    doc.add_node("wall", doc.add_mesh("wall", backdrop(), wall), placed(at=(-0.4, -0.5, 0.0)))
    doc.write_glb(path)


if __name__ == "__main__":
    build(sys.argv[1] if len(sys.argv) > 1 else HERE / "skin_closeup.glb")
