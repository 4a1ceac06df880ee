#!/usr/bin/env python3
"""Makes the still life: a carved alabaster bowl with grapes, a goblet of wine, peaches and a pewter spoon on a lacquered table
(quad cages, FB_ngon_encoding), with its images: heights for displacement and bump, and window.hdr, the only light.

Everything is modelled here, in metres, y up. Run: python3 testenv/scenes/still_life/make_still_life.py [PATH.glb]
"""
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from gltf_writer import Document, Mesh, png  # noqa: E402
from images import heights_png, write_hdr  # noqa: E402
from shapes import cube_sphere, lathe, noise, placed, unit  # noqa: E402

SUN = unit((-0.82, 0.50, -0.20))  # low, from the left, a little behind
SUN_WIDTH = math.radians(5.0)     # through haze: its edge fades over this


def smooth(a, b, x):
    t = min(1.0, max(0.0, (x - a) / (b - a)))
    return t * t * (3 - 2 * t)


def mix(a, b, t):
    return tuple(x + (y - x) * t for x, y in zip(a, b))


def octaves(x, y, salt, count=4):
    total, weight = 0.0, 0.5
    for k in range(count):
        total += weight * noise(x * 2 ** k, y * 2 ** k, salt + 17 * k)
        weight /= 2
    return total


# Light -----------------------------------------------------------------------------------------------------------------------
SKY_WIDTH, SKY_HEIGHT = 256, 128


def radiance(row, column):
    """A room in the evening: a dim warm ceiling, cool light from the right, and a hazy sun in a tall window."""
    theta, phi = math.pi * (row + 0.5) / SKY_HEIGHT, 2 * math.pi * ((column + 0.5) / SKY_WIDTH - 0.5)
    # The picture's centre looks along +z, its left half to +x.
    d = (-math.sin(theta) * math.sin(phi), math.cos(theta), math.sin(theta) * math.cos(phi))
    base = mix((0.020, 0.017, 0.015), (0.05, 0.045, 0.04), smooth(-0.2, 0.9, d[1]))
    ceiling = smooth(0.60, 1.0, sum(a * b for a, b in zip(d, unit((0.25, 0.9, 0.35)))))
    base = tuple(b + 0.10 * ceiling * c for b, c in zip(base, (1.0, 0.93, 0.84)))
    cool = smooth(0.55, 0.95, sum(a * b for a, b in zip(d, unit((0.85, 0.35, 0.45)))))
    base = tuple(b + 0.55 * cool * c for b, c in zip(base, (0.55, 0.75, 1.0)))
    angle = math.acos(max(-1.0, min(1.0, sum(a * b for a, b in zip(d, SUN)))))
    glow = 2.6 * math.exp(-(angle / 0.28) ** 2)
    sun = 520.0 * (1 - smooth(0.45 * SUN_WIDTH, SUN_WIDTH, angle))
    return tuple(b + glow * g + sun * s for b, g, s in zip(base, (1.0, 0.72, 0.42), (1.0, 0.80, 0.55)))


# The bowl --------------------------------------------------------------------------------------------------------------------
LOBES = 18
BOWL = [(0.030, 0.0), (0.0385, 0.0012), (0.0405, 0.004), (0.0385, 0.0072), (0.0300, 0.0090), (0.0245, 0.0120), (0.0240, 0.0160),
        (0.0290, 0.0200), (0.0420, 0.0250), (0.0560, 0.0330), (0.0670, 0.0440), (0.0740, 0.0570), (0.0775, 0.0700),
        (0.0790, 0.0800), (0.0815, 0.0870), (0.0850, 0.0915), (0.0852, 0.0940), (0.0830, 0.0948), (0.0790, 0.0920),
        (0.0755, 0.0850), (0.0738, 0.0780), (0.0718, 0.0680), (0.0680, 0.0560), (0.0610, 0.0450), (0.0500, 0.0360),
        (0.0360, 0.0300), (0.0180, 0.0275)]
OUTER = 14 / (len(BOWL) - 1)  # v of the rim


def bowl():
    mesh = lathe(BOWL, 36)
    mesh.uvs = [[(LOBES * u, v) for u, v in quad] for quad in mesh.uvs]
    return mesh


def carving(u, v):
    """One lobe of the gadroons around the bowl's body, and a bead of the string below its rim."""
    x = 2 * u - 1
    low, high = 7.2 / 26, 11.8 / 26
    t = (v - low) / (high - low)
    tongue = 0.0
    if 0 < t < 1:
        # A tongue: round at the top, narrow at the foot.
        half = 0.94 * math.sqrt(max(0.0, 1 - max(0.0, (t - 0.62) / 0.38) ** 2)) * (0.72 + 0.28 * smooth(0, 0.5, t))
        if half > 0:
            inside = max(0.0, 1 - (x / half) ** 2)
            tongue = math.sqrt(inside) * smooth(0, 0.16, t)
    middle = 12.7 / 26
    bead = 1 - (((v - middle) * 26 / 0.34) ** 2 + (abs(2 * abs(x) - 1) / 0.86) ** 2)
    bead = 0.55 * math.sqrt(bead) if bead > 0 else 0.0
    groove = -0.30 * math.exp(-((abs(v - middle) * 26 - 0.52) / 0.10) ** 2)
    return min(1.0, max(0.0, 0.30 + 0.62 * max(tongue, bead) + groove * 0.6))


# Fruit -----------------------------------------------------------------------------------------------------------------------
def turned(profile, sides, radius_of=None):
    return lathe(profile, sides, radius_of)


def peach():
    """Flattened, with a suture on the side that looks along +x and a hollow for the stalk."""
    profile = []
    for k in range(13):
        a = math.pi * (0.06 + 0.90 * k / 12)
        r, y = 0.0355 * math.sin(a) ** 0.92, -0.0325 * math.cos(a)
        profile.append((r, y - (0.0095 * math.exp(-(r / 0.010) ** 2) if y > 0 else 0.0)))
    return turned(profile, 24, lambda a, k, r: r * (1 - 0.075 * math.exp(-(math.remainder(a, 2 * math.pi) / 0.17) ** 2)))


def peach_color(x, y):
    u, v = (x + 0.5) / 256, 1 - (y + 0.5) / 128
    n = octaves(8 * u, 6 * v, 3)
    facing = 0.5 + 0.5 * math.cos(2 * math.pi * (u - 0.36))
    blush = smooth(0.34, 0.80, facing * 0.75 + 0.45 * (n - 0.4) + 0.25 * v)
    base = mix((0.90, 0.52, 0.16), (0.72, 0.075, 0.055), blush)
    freckle = smooth(0.70, 0.82, noise(110 * u, 74 * v, 91)) * (0.3 + 0.7 * blush)
    base = mix(base, (0.95, 0.62, 0.28), 0.30 * freckle)
    base = mix(base, (0.72, 0.60, 0.20), 0.7 * smooth(0.90, 1.0, v))  # green-gold about the stalk
    return tuple(c ** (1 / 2.2) for c in base)


def skin(u, v):
    """Low dents and fine pores."""
    wrap = [octaves(7 * (u - k), 5 * v, 21, 3) for k in (0, 1)]
    dents = wrap[0] * (1 - u) + wrap[1] * u
    return 0.25 + 0.55 * dents + 0.20 * noise(90 * u, 60 * v, 5)


def grape():
    return cube_sphere(3, lambda d: (0.0108 * d[0], 0.0124 * d[1] - 0.0006 * d[1] ** 3, 0.0108 * d[2]))


def stalk(points, radius):
    """A square tube along points, closed at both ends."""
    mesh, rings = Mesh(), []
    for i, p in enumerate(points):
        q, r = points[max(i - 1, 0)], points[min(i + 1, len(points) - 1)]
        along = unit(tuple(b - a for a, b in zip(q, r)))
        side = unit((along[1] * 0.3 - along[2], along[2] * 0.1 - along[0] * 0.3, along[0] - along[1] * 0.1))
        other = (along[1] * side[2] - along[2] * side[1], along[2] * side[0] - along[0] * side[2],
                 along[0] * side[1] - along[1] * side[0])
        size = radius * (1.0 - 0.45 * i / (len(points) - 1)) * (1.5 if i == len(points) - 1 else 1.0)
        rings.append([tuple(c + size * (math.cos(a) * s + math.sin(a) * o) for c, s, o in zip(p, side, other))
                      for a in (math.pi / 4 + k * math.pi / 2 for k in range(4))])
    mesh.add_grid(rings, lambda i, j: (j / 4, i / len(rings)), closed_u=True)
    last = 4 * (len(rings) - 1)
    mesh.quads += [[3, 2, 1, 0], [last, last + 1, last + 2, last + 3]]
    mesh.uvs += [[(0.0, 0.0)] * 4] * 2
    return mesh


def leaf():
    """A thin leaf, bent along and across its rib."""
    mesh, rows = Mesh(), []
    for i in range(9):
        t = i / 8
        half = 0.0175 * math.sin(math.pi * (0.04 + 0.94 * t)) ** 0.85 * (1 - 0.35 * t)
        row = []
        for j in range(5):
            s = (j - 2) / 2
            wave = 0.0022 * math.sin(9 * t + 2 * s) * abs(s)
            row.append((0.085 * t, 0.012 * math.sin(2.4 * t) + 0.010 * abs(s) * half / 0.0175 - 0.016 * t * t + wave, -s * half))
        rows.append(row)
    mesh.add_grid(rows, lambda i, j: (i / 8, j / 4))
    return mesh


# Glass, spoon, table -----------------------------------------------------------------------------------------------------------
GLASS_OUT = [(0.020, 0.0), (0.0335, 0.0006), (0.0345, 0.0016), (0.0330, 0.0028), (0.0160, 0.0052), (0.0060, 0.0095),
             (0.0042, 0.0180), (0.0040, 0.0400), (0.0046, 0.0600), (0.0075, 0.0700), (0.0180, 0.0790), (0.0290, 0.0920),
             (0.0355, 0.1100), (0.0372, 0.1280), (0.0355, 0.1480), (0.0318, 0.1700), (0.0300, 0.1800)]
GLASS_IN = [(0.0302, 0.1812), (0.0293, 0.1812), (0.0288, 0.1800), (0.0306, 0.1700), (0.0342, 0.1480), (0.0359, 0.1280),
            (0.0342, 0.1100), (0.0277, 0.0925), (0.0165, 0.0806), (0.0060, 0.0752)]
# The wine goes a little into the glass, whose priority is higher: between them lies one boundary.
WINE = [(0.0058, 0.0748), (0.0169, 0.0802), (0.0282, 0.0922), (0.0347, 0.1100), (0.0360, 0.1200), (0.03640, 0.1262),
        (0.03630, 0.1278), (0.0356, 0.1277), (0.0348, 0.1272), (0.0300, 0.1270), (0.0120, 0.1270)]


def spoon():
    """Sections along x: the bowl at x < 0, then a handle that widens to its end."""
    mesh, rings = Mesh(), []
    stations = [-0.056, -0.054, -0.048, -0.038, -0.026, -0.014, -0.006, 0.0, 0.008, 0.022, 0.045, 0.070, 0.095, 0.108, 0.116, 0.119,
                0.120]
    for x in stations:
        t = (x + 0.029) / 0.029
        in_bowl = max(0.0, 1 - t * t)
        half = max(0.0215 * in_bowl ** 0.5 * (1 - 0.12 * t), 0.0023 + 0.0048 * smooth(0.03, 0.112, x) if x > -0.006 else 0.0016)
        if x > 0.112:
            half *= math.sqrt(max(0.12, 1 - ((x - 0.112) / 0.0082) ** 2))
        lift = 0.0090 * smooth(-0.012, 0.03, x) + 0.010 * math.sin(math.pi * smooth(0.0, 0.12, x)) - 0.0075 * smooth(0.05, 0.12, x)
        depth, thick = 0.0080 * in_bowl, 0.0011 + 0.0007 * smooth(0.0, 0.02, x)
        ring = []
        for j in range(6):
            s = 1 - j / 2.5
            ring.append((x, 0.0105 + lift - depth * (1 - s * s) + thick, -half * s))
        for j in range(6):
            s = -1 + j / 2.5
            ring.append((x, 0.0105 + lift - depth * (1 - s * s) - thick * (0.4 + 0.6 * (1 - s * s)), -half * s))
        rings.append(ring)
    mesh.add_grid(rings, lambda i, j: (2.6 * rings[i][j % 12][0] / 0.17 + 1, rings[i][j % 12][2] / 0.065 + (0.5 if j < 6 else 1.5)),
                  closed_u=True)
    last = 12 * (len(rings) - 1)
    for k in range(5):
        a, b, c, d = k, k + 1, 10 - k, 11 - k
        if b < c:
            mesh.quads += [[d, c, b, a], [last + a, last + b, last + c, last + d]]
            mesh.uvs += [[(0.0, 0.5)] * 4] * 2
    return mesh


def hammered(x, y):
    """Normals of shallow dimples about points of a shaken grid."""
    size, cells = 128, 12

    def height(px, py):
        best = 9.0
        gx, gy = px * cells / size, py * cells / size
        for i in range(math.floor(gx) - 1, math.floor(gx) + 2):
            for j in range(math.floor(gy) - 1, math.floor(gy) + 2):
                a, b = i % cells, j % cells
                cx = i + 0.5 + 0.35 * (2 * noise(a, b, 7) - 1)
                cy = j + 0.5 + 0.35 * (2 * noise(a, b, 8) - 1)
                best = min(best, (gx - cx) ** 2 + (gy - cy) ** 2)
        return best

    slope = 0.11 * size / cells
    dx, dy = (height(x + 1, y) - height(x - 1, y)) / 2, (height(x, y + 1) - height(x, y - 1)) / 2
    n = unit((-slope * dx, slope * dy, 1.0))
    return tuple(0.5 + 0.5 * c for c in n)


TABLE = (1.30, 0.74)  # width, depth
TABLE_Z = -0.06


def table():
    """A slab with a rounded edge; its texture is laid on from above."""
    mesh, rows = Mesh(), []
    outline = [(0.37, -0.050), (0.37, -0.034), (0.369, -0.008), (0.366, -0.002), (0.360, 0.0), (0.20, 0.0), (0.0, 0.0), (-0.20, 0.0),
               (-0.37, 0.0)]
    for z, y in outline:
        rows.append([(x * TABLE[0] / 2, y, z + TABLE_Z) for x in (-1.0, -0.5, 0.0, 0.5, 1.0)])
    mesh.add_grid(rows)
    mesh.uvs = [[(mesh.points[i][0] / TABLE[0] + 0.5, (TABLE_Z + 0.37 - mesh.points[i][2] - mesh.points[i][1]) / 0.80) for i in quad]
                for quad in mesh.quads]
    return mesh


WOOD = (320, 192)


def grain(u, v):
    """0..1 across the rings of sawn planks that lie along u."""
    plank = math.floor(7 * v)
    across = 7 * v - plank
    shift = noise(plank, 0, 400) * 40
    wave = 0.30 * noise(3.0 * u + shift, 1.5 * across + shift, 401) + 0.10 * noise(11 * u, 5 * across + shift, 402)
    rings = 0.5 + 0.5 * math.sin(2 * math.pi * (9.0 * (across - 0.5) ** 2 + 9.0 * wave + shift))
    fibre = noise(30 * u + shift, 170 * v, 403)
    seam = min(across, 1 - across) / 7 / 0.0022
    return rings, fibre, min(1.0, seam), noise(plank, 3, 404)


def wood_color(x, y):
    rings, fibre, seam, tone = grain((x + 0.5) / WOOD[0], 1 - (y + 0.5) / WOOD[1])
    base = mix((0.085, 0.030, 0.012), (0.235, 0.095, 0.036), 0.55 * rings + 0.45 * fibre)
    base = tuple(c * (0.72 + 0.5 * tone) * (0.25 + 0.75 * seam) for c in base)
    return tuple(c ** (1 / 2.2) for c in base)


def wood_height(u, v):
    rings, fibre, seam, _ = grain(u, v)
    return 0.25 * rings + 0.35 * fibre + 0.4 * seam


def wall():
    """Turned to the sun, which grazes it."""
    mesh = Mesh()
    mesh.add_grid([[(0.47 * x, y, -0.50 + 0.20 * x) for x in (-1.8, -0.6, 0.6, 1.8)] for y in (-0.2, 0.2, 0.6, 0.9)], lambda i, j: (1.4 * j, 1.1 * i))
    return mesh


def plaster(u, v):
    """Repeats in u and v."""
    def tile(f):
        return sum(f(u - i, v - j) * (u if i else 1 - u) * (v if j else 1 - v) for i in (0, 1) for j in (0, 1))
    return tile(lambda a, b: 0.7 * octaves(4 * a, 4 * b, 60, 5) + 0.3 * noise(9 * a, 13 * b, 61))


# Arrangement -------------------------------------------------------------------------------------------------------------------
BOWL_AT = (-0.050, 0.0, -0.015)


def heap():
    """Grapes in and about the bowl: (x, y, z) relative to it, lying against each other in rings."""
    spots = []
    for radius, height, count, turn in ((0.057, 0.077, 14, 0.1), (0.034, 0.080, 8, 0.4), (0.011, 0.083, 3, 0.2), (0.046, 0.0965, 11, 0.3),
                                        (0.023, 0.0995, 6, 0.0), (0.0, 0.102, 1, 0.0), (0.033, 0.1155, 7, 0.5), (0.0115, 0.119, 3, 0.9)):
        for k in range(count):
            a = 2 * math.pi * (k + turn) / count
            shake = [0.0016 * (2 * noise(len(spots), i, 77) - 1) for i in range(3)]
            spots.append((radius * math.cos(a) + shake[0], height + shake[1], radius * math.sin(a) + shake[2]))
    # A few hang over the rim in front.
    spots += [(0.070, 0.101, 0.050), (0.086, 0.0905, 0.056), (0.079, 0.082, 0.071), (0.092, 0.072, 0.069), (0.0825, 0.062, 0.076)]
    return spots


def add_fruit(document):
    grape_skin = document.add_material("grape", {
        "baseColor": [0.40, 0.50, 0.065], "roughness": 0.32, "scatterDistance": [0.0062, 0.0068, 0.0020], "coat": 0.35,
        "coatRoughness": 0.18})
    dark_skin = document.add_material("dark_grape", {
        "baseColor": [0.17, 0.013, 0.035], "roughness": 0.36, "scatterDistance": [0.0042, 0.0008, 0.0011], "coat": 0.30,
        "coatRoughness": 0.22})
    wood = document.add_material("stalk", {"baseColor": [0.23, 0.16, 0.06], "roughness": 0.7})
    bodies = [document.add_mesh("grape", grape(), grape_skin), document.add_mesh("dark_grape", grape(), dark_skin)]
    for n, p in enumerate(heap()):
        at = tuple(a + b for a, b in zip(BOWL_AT, p))
        dark = noise(7.3 * p[0] * 30, 5.1 * p[2] * 30, 15) > 0.52
        document.add_node("grape %d" % n, bodies[dark], placed(1.7 * n, 0.9 * math.sin(2.3 * n), 0.93 + 0.12 * noise(n, 1, 9), at))
    loose = [(-0.150, 0.0107, 0.088), (-0.128, 0.0105, 0.105), (-0.006, 0.0107, 0.118)]
    for n, at in enumerate(loose):
        document.add_node("loose grape %d" % n, bodies[n == 1], placed(0.8 * n, 1.45, 0.98, at))
    top = (BOWL_AT[0] - 0.004, 0.126, BOWL_AT[2])
    stem = stalk([top, (top[0] + 0.006, 0.140, top[2] + 0.003), (top[0] + 0.020, 0.149, top[2] + 0.002),
                  (top[0] + 0.036, 0.151, top[2] - 0.004)], 0.0019)
    document.add_node("stalk", document.add_mesh("stalk", stem, wood))
    peach_skin = document.add_material("peach", {
        "baseColor": [1.0, 1.0, 1.0], "roughness": 0.55, "specular": 0.5, "scatterDistance": [0.0060, 0.0026, 0.0012], "sheen": 0.55,
        "sheenColor": [1.0, 0.80, 0.66], "sheenRoughness": 0.45}, document.add_texture("peach", png(256, 128, peach_color)))
    body = document.add_mesh("peach", peach(), peach_skin)
    document.add_node("peach", body, placed(-1.15, 0.30, 1.0, (0.066, 0.0330, 0.082)))
    document.add_node("second peach", body, placed(1.9, -0.16, 0.94, (0.126, 0.0308, 0.038)))
    green = document.add_material("leaf", {
        "baseColor": [0.10, 0.20, 0.035], "roughness": 0.38, "thin": True, "diffTrans": 0.8, "diffTransColor": [0.30, 0.42, 0.04]})
    document.add_node("leaf", document.add_mesh("leaf", leaf(), green), placed(2.5, 0.0, 1.0, (0.050, 0.0035, 0.128)))


def build(path):
    folder = path.parent
    write_hdr(folder / "window.hdr", SKY_WIDTH, SKY_HEIGHT, radiance)
    for name, size, value in (("carving", (128, 512), carving), ("skin", (256, 128), skin), ("plaster", (160, 160), plaster),
                              ("grain", WOOD, wood_height)):
        (folder / (name + ".png")).write_bytes(heights_png(*size, value))
    document = Document("Alabaster make_still_life.py")
    alabaster = document.add_material("alabaster", {
        "baseColor": [0.93, 0.885, 0.82], "roughness": 0.30, "scatterDistance": [0.0085, 0.0062, 0.0044]})
    document.add_node("bowl", document.add_mesh("bowl", bowl(), alabaster), placed(0.1, 0.0, 1.0, BOWL_AT))
    add_fruit(document)
    glass = document.add_material("glass", {"baseColor": [1.0, 1.0, 1.0], "roughness": 0.0, "specTrans": 1.0, "ior": 1.5, "priority": 2})
    wine = document.add_material("wine", {
        "baseColor": [1.0, 1.0, 1.0], "roughness": 0.0, "specTrans": 1.0, "ior": 1.345, "priority": 1,
        "attenuationColor": [0.62, 0.030, 0.050], "attenuationDistance": 0.030})
    at = placed(0.0, 0.0, 1.0, (0.098, 0.0004, -0.072))
    document.add_node("glass", document.add_mesh("glass", lathe(GLASS_OUT + GLASS_IN, 24), glass), at)
    document.add_node("wine", document.add_mesh("wine", lathe(WINE, 24), wine), at)
    pewter = document.add_material("pewter", {"baseColor": [0.60, 0.585, 0.555], "metallic": 1.0, "roughness": 0.24},
                                   normal=document.add_texture("hammered", png(128, 128, hammered)))
    document.add_node("spoon", document.add_mesh("spoon", spoon(), pewter), placed(0.42, 0.0, 1.0, (-0.048, -0.0012, 0.158)))
    lacquer = document.add_material("lacquer", {
        "baseColor": [1.0, 1.0, 1.0], "roughness": 0.45, "coat": 1.0, "coatRoughness": 0.09},
        document.add_texture("wood", png(*WOOD, wood_color)))
    document.add_node("table", document.add_mesh("table", table(), lacquer))
    plastered = document.add_material("wall", {"baseColor": [0.21, 0.185, 0.135], "roughness": 0.85, "specular": 0.4})
    document.add_node("wall", document.add_mesh("wall", wall(), plastered))
    document.write_glb(path)


if __name__ == "__main__":
    build(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "still_life.glb")
