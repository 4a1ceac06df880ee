#!/usr/bin/env python3
"""Makes sample.glb: a lotus blossom with alabaster pebbles, as quad cages (FB_ngon_encoding) for subdivision.

Everything is modelled here, in metres, y up. Run: python3 testenv/scenes/sample/make_sample.py [output.glb]
"""
import math
import pathlib
import random
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from gltf_writer import Document, Mesh, png  # noqa: E402
from shapes import fan_cap, placed, unit  # noqa: E402

random.seed(2016)


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def scale(a, s):
    return tuple(x * s for x in a)


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def petal(length, width, lean, curl, cup):
    """A closed thin shell: an inner and an outer sheet that meet in the rim. The petal grows from the origin along +y and
    leans towards +x. `lean` is the angle from the vertical at the base, `curl` the turn from there to the tip, and `cup` the
    angle by which the sides fold towards the axis (radians)."""
    rows, columns = 9, 7
    spine, angle, p = [], lean, (0.0, 0.0, 0.0)
    for i in range(rows):
        s = i / (rows - 1)
        direction = (math.sin(angle), math.cos(angle), 0.0)
        spine.append((p, direction, s))
        angle = lean + curl * s * s
        p = add(p, scale(direction, length / (rows - 1)))

    def sheet(side):
        out = []
        for position, direction, s in spine:
            outward = (direction[1], -direction[0], 0.0)  # away from the flower's axis
            # Obovate: narrow claw, widest beyond the middle, a pointed tip.
            half = width * (0.16 + 0.84 * math.sin(math.pi * min(1.0, 0.06 + 0.94 * s) ** 1.25) ** 0.8) * (1 - s ** 7)
            half = max(half, 0.045 * width)
            row = []
            for j in range(columns):
                t = 2 * j / (columns - 1) - 1
                fold = cup * t * (0.55 + 0.45 * s)
                ripple = 0.035 * width * math.sin(5.0 * s + 2.3) * t * t * s
                across = math.sin(fold) / max(cup, 1e-6) if cup > 1e-6 else t
                inward = (1 - math.cos(fold)) / max(cup, 1e-6) if cup > 1e-6 else 0
                thickness = length * (0.016 * (1 - s) ** 1.5 + 0.0055) * (1 - 0.75 * t * t)
                q = add(position, (0, 0, half * across))
                q = add(q, scale(outward, -half * inward + ripple + side * 0.5 * thickness))
                row.append(q)
            out.append(row)
        return out

    mesh = Mesh()
    inner, outer = sheet(-1), sheet(+1)
    # One ring of points per row: inner sheet forth, outer sheet back. Rings joined along the petal; ends are capped.
    rings = [a + b[::-1] for a, b in zip(inner, outer)]
    n = len(rings[0])

    def uv_of(i, j):
        j %= n
        across = j if j < columns else n - 1 - j
        return (across / (columns - 1), i / (rows - 1))

    first = mesh.add_grid(rings, uv_of, closed_u=True, flip=False)
    for ring, v in ((0, 0.0), (rows - 1, 1.0)):
        base = first + ring * n
        for j in range(columns - 1):
            quad = [base + j, base + j + 1, base + n - 2 - j, base + n - 1 - j]
            uv = [(j / (columns - 1), v), ((j + 1) / (columns - 1), v)] * 2
            uv = [uv[0], uv[1], uv[1], uv[0]]
            if ring == 0:
                quad.reverse()
                uv.reverse()
            mesh.quads.append(quad)
            mesh.uvs.append(uv)
    return mesh


def pod():
    """The seed pod: an inverted cone with a flat, dimpled top."""
    profile = [(0.006, 0.0), (0.012, 0.006), (0.018, 0.018), (0.0215, 0.027), (0.0205, 0.0305), (0.014, 0.0295), (0.005, 0.029)]
    mesh, sides = Mesh(), 16
    rings = []
    for k, (r, y) in enumerate(profile):
        ring = []
        for j in range(sides):
            a = 2 * math.pi * j / sides
            lift = 0.0016 * (1 if (j % 2 == 0) else -1) if k == 5 else 0.0
            ring.append((r * math.cos(a), y + lift, -r * math.sin(a)))
        rings.append(ring)
    first = mesh.add_grid(rings, closed_u=True)
    fan_cap(mesh, first, sides, (0, -0.001, 0), bottom=True, uv=(0.0, 0.0))
    fan_cap(mesh, first + (len(profile) - 1) * sides, sides, (0, 0.0286, 0), bottom=False, uv=(0.0, 0.0))
    return mesh


def stamen():
    """A filament with a thick anther, bent outwards."""
    sides, rings = 6, []
    profile = [(0.0, 0.0007), (0.3, 0.0005), (0.62, 0.0005), (0.70, 0.0012), (0.80, 0.0015), (0.92, 0.0013), (1.0, 0.0005)]
    for s, r in profile:
        x, y = 0.020 * s * s, 0.030 * s
        rings.append([(x + r * math.cos(2 * math.pi * j / sides), y, -r * math.sin(2 * math.pi * j / sides))
                      for j in range(sides)])
    mesh = Mesh()
    first = mesh.add_grid(rings, lambda i, j: (0.5, profile[i][0]), closed_u=True)
    fan_cap(mesh, first, sides, (0, -0.0003, 0), bottom=True, uv=(0.0, 0.0))
    fan_cap(mesh, first + (len(profile) - 1) * sides, sides, (0.0205, 0.0304, 0), bottom=False, uv=(0.0, 0.0))
    return mesh


def pebble(rx, ry, rz, seed):
    """A deformed rounded cube: a river stone."""
    noise = random.Random(seed)
    bumps = [(unit((noise.uniform(-1, 1), noise.uniform(-1, 1), noise.uniform(-1, 1))), noise.uniform(-0.10, 0.16))
             for _ in range(5)]
    mesh, n, index = Mesh(), 3, {}

    def vertex(p):
        key = tuple(round(c, 6) for c in p)
        if key not in index:
            d = unit(p)
            r = 1 + sum(h * max(0.0, sum(a * b for a, b in zip(d, axis))) ** 2 for axis, h in bumps)
            index[key] = len(mesh.points)
            mesh.points.append((d[0] * r * rx, d[1] * r * ry, d[2] * r * rz))
        return index[key]

    for axis in range(3):
        for side in (-1, 1):
            for i in range(n):
                for j in range(n):
                    corners = []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        p = [0.0, 0.0, 0.0]
                        p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = side, 2 * a / n - 1, 2 * b / n - 1
                        corners.append(vertex(p))
                    mesh.quads.append(corners if side > 0 else corners[::-1])
                    mesh.uvs.append([(0.0, 0.0)] * 4)
    return mesh


def ground():
    """A floor that sweeps up into a backdrop behind the subject."""
    mesh = Mesh()
    profile = [(1.6, 0.0), (0.6, 0.0), (-0.2, 0.0), (-0.75, 0.0), (-1.15, 0.12), (-1.35, 0.55), (-1.4, 1.6)]  # z, y
    mesh.add_grid([[(x, y, z) for x in (-2.2, -0.8, 0.8, 2.2)] for z, y in profile])
    return mesh


def petal_colour(x, y, size=192):
    """White at the claw, rose at the tip, with veins that run along the petal."""
    s, t = 1 - y / (size - 1), 2 * x / (size - 1) - 1
    veins = 0.5 + 0.5 * math.cos(34 * t * (1 - 0.35 * s * s) + 0.6 * math.sin(9 * s))
    veins = veins ** 6 * (0.25 + 0.75 * s) * 0.10
    tip = min(1.0, max(0.0, (s - 0.25) / 0.75)) ** 1.6
    edge = 0.22 * abs(t) ** 5
    rose = min(1.0, 0.95 * tip + edge * s + veins)
    white, pink, yellow = (0.985, 0.955, 0.915), (0.94, 0.50, 0.60), (0.93, 0.92, 0.62)
    claw = max(0.0, 1 - s / 0.22) ** 1.5 * 0.7
    return tuple((w * (1 - rose) + p * rose) * (1 - claw) + g * claw for w, p, g in zip(white, pink, yellow))


def build(path):
    doc = Document("Alabaster make_sample.py")
    rose = doc.add_texture("petal", png(192, 192, petal_colour))
    petal_material = doc.add_material("petal", {
        "baseColor": [1.0, 1.0, 1.0], "roughness": 0.42, "specular": 0.7, "sheen": 0.2,
        "scatterDistance": [0.00042, 0.00024, 0.00023]}, texture=rose)
    pod_material = doc.add_material("pod", {
        "baseColor": [0.62, 0.66, 0.20], "roughness": 0.4, "scatterDistance": [0.0016, 0.0018, 0.0006]})
    stamen_material = doc.add_material("stamen", {
        "baseColor": [0.95, 0.72, 0.22], "roughness": 0.5, "scatterDistance": [0.0006, 0.0004, 0.0002]})
    stone = doc.add_material("alabaster", {
        "baseColor": [0.93, 0.90, 0.84], "roughness": 0.22, "clearcoat": 0.3, "clearcoatGloss": 0.85,
        "scatterDistance": [0.0050, 0.0044, 0.0036]})
    slate = doc.add_material("ground", {"baseColor": [0.115, 0.105, 0.10], "roughness": 0.42, "specular": 0.8})

    # Whorls from the outside in: count, length, half width, lean, curl, cup, radius of the ring, height.
    whorls = [(8, 0.118, 0.036, 1.22, -0.55, 0.95, 0.016, 0.010), (8, 0.112, 0.036, 0.86, -0.35, 1.05, 0.014, 0.015),
              (7, 0.100, 0.033, 0.52, -0.15, 1.15, 0.012, 0.020)]
    for w, (count, length, half, lean, curl, cup, radius, height) in enumerate(whorls):
        meshes = [doc.add_mesh("petal_%d_%d" % (w, k), petal(length * random.uniform(0.95, 1.05), half, lean +
                  random.uniform(-0.06, 0.06), curl + random.uniform(-0.10, 0.10), cup), petal_material) for k in range(2)]
        for k in range(count):
            a = 2 * math.pi * (k + 0.5 * (w % 2)) / count + random.uniform(-0.07, 0.07)
            at = (radius * math.cos(a), height + random.uniform(-0.001, 0.001), -radius * math.sin(a))
            doc.add_node("petal_%d_%d" % (w, k), meshes[k % 2], placed(a, random.uniform(-0.05, 0.05),
                                                                       random.uniform(0.95, 1.04), at))
    doc.add_node("pod", doc.add_mesh("pod", pod(), pod_material), placed(0, at=(0, 0.016, 0)))
    filament = doc.add_mesh("stamen", stamen(), stamen_material)
    for k in range(64):
        a = k * 2.399963 + random.uniform(-0.1, 0.1)
        at = (0.0115 * math.cos(a), 0.017, -0.0115 * math.sin(a))
        doc.add_node("stamen_%d" % k, filament, placed(a, random.uniform(-0.12, 0.25), random.uniform(0.8, 1.12), at))

    for k, (rx, ry, rz, x, z, turn) in enumerate([(0.031, 0.020, 0.026, 0.150, 0.040, 0.5), (0.021, 0.0150, 0.018, 0.096, 0.112, -0.4),
                                                  (0.026, 0.018, 0.022, -0.132, 0.070, 0.9)]):
        mesh = doc.add_mesh("pebble_%d" % k, pebble(rx, ry, rz, 7 + k), stone)
        doc.add_node("pebble_%d" % k, mesh, placed(turn, at=(x, ry * 0.93, z)))
    doc.add_node("ground", doc.add_mesh("ground", ground(), slate))
    doc.write_glb(path)


if __name__ == "__main__":
    build(sys.argv[1] if len(sys.argv) > 1 else HERE / "sample.glb")
