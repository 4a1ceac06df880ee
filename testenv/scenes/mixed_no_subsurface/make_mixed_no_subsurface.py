#!/usr/bin/env python3
"""Makes mixed_no_subsurface.glb: chess pieces of brass, black lacquer and white plastic on an inlaid board, velvet behind.

Everything is modelled here, in metres, y up. Run: python3 testenv/scenes/mixed_no_subsurface/make_mixed_no_subsurface.py [output.glb]
"""
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from gltf_writer import Document, Mesh, png  # noqa: E402
from shapes import box, cube_sphere, lathe, noise, placed  # noqa: E402

SQUARE = 0.05  # side of a square of the board
HALF_BOARD = 3 * SQUARE

# The foot that all pieces share; (radius, height) for a foot of radius 1.
FOOT = [(0.90, 0.0), (0.98, 0.004), (1.0, 0.03), (1.0, 0.20), (0.97, 0.26), (0.86, 0.30), (0.84, 0.34), (0.88, 0.40),
        (0.84, 0.50), (0.62, 0.62), (0.50, 0.80)]


def piece(radius, neck, collar, head, sides=16, radius_of=None):
    """A foot, a stem that narrows to `neck` at height `collar`, and a head given from the collar upwards."""
    profile = [(r * radius, y * radius) for r, y in FOOT]
    r0, y0 = profile[-1]
    for t in (0.3, 0.6, 0.85):
        profile.append((neck + (r0 - neck) * (1 - t) ** 2.2, y0 + (collar - y0) * t))
    profile += [(neck * 1.02, collar - 0.0030), (neck * 1.62, collar - 0.0022), (neck * 1.70, collar - 0.0006),
                (neck * 1.62, collar + 0.0010), (neck * 1.04, collar + 0.0018)]
    profile += [(r, collar + y) for r, y in head]
    return lathe(profile, sides, radius_of)


def ball(radius, start):
    """The outline of a sphere that stands on a neck, from `start` (radians from its lowest point) to the top."""
    lift = radius * math.cos(start)
    return [(radius * math.sin(a), lift - radius * math.cos(a)) for a in
            (start + (math.pi - 0.12 - start) * k / 7 for k in range(8))]


def pawn():
    return piece(0.0155, 0.0058, 0.030, [(r, y + 0.002) for r, y in ball(0.0100, 0.65)])


def bishop():
    head = [(0.0068, 0.003), (0.0098, 0.008), (0.0106, 0.013), (0.0094, 0.019), (0.0066, 0.0245), (0.0034, 0.0285),
            (0.0024, 0.0295), (0.0024, 0.0302), (0.0036, 0.0318), (0.0036, 0.0340), (0.0020, 0.0358)]
    return piece(0.0180, 0.0064, 0.044, head)


def rook():
    """The wall goes up outside, down inside; every other part of its rim is lower."""
    head = [(0.0088, 0.003), (0.0094, 0.008), (0.0122, 0.010), (0.0126, 0.0108), (0.0126, 0.0180), (0.0124, 0.0192),
            (0.0092, 0.0192), (0.0088, 0.0182), (0.0088, 0.0125), (0.0080, 0.0118), (0.0030, 0.0118)]
    return piece(0.0185, 0.0082, 0.030, head)


def queen():
    """A coronet of eight points."""
    head = [(0.0078, 0.003), (0.0092, 0.010), (0.0118, 0.020), (0.0142, 0.0262), (0.0138, 0.0272), (0.0116, 0.0250),
            (0.0094, 0.0262), (0.0050, 0.0300), (0.0028, 0.0312), (0.0030, 0.0328), (0.0044, 0.0352), (0.0040, 0.0378),
            (0.0018, 0.0392)]
    crown = len(FOOT) + 3 + 5 + 3

    def radius_of(angle, k, r):
        return r * (1 + 0.10 * math.cos(8 * angle)) if crown - 1 <= k <= crown + 1 else r
    return piece(0.0205, 0.0070, 0.058, head, 32, radius_of)


def king_cross():
    """Two crossed bars that stand on the king."""
    return [box(0.0040, 0.0125, 0.0034, 0.0007), box(0.0105, 0.0038, 0.0030, 0.0007)]


def king():
    head = [(0.0080, 0.003), (0.0094, 0.011), (0.0122, 0.022), (0.0132, 0.0270), (0.0128, 0.0285), (0.0102, 0.0300),
            (0.0062, 0.0330), (0.0034, 0.0352), (0.0030, 0.0362), (0.0020, 0.0368)]
    return piece(0.0210, 0.0072, 0.064, head)


def velvet(width=1.1, columns=56):
    """A cloth that hangs in folds behind the board and runs out under it."""
    mesh, rows = Mesh(), []
    profile = [(0.50, 0.0), (0.30, 0.0), (0.10, 0.0), (-0.06, 0.0), (-0.155, 0.001), (-0.20, 0.006), (-0.235, 0.03),
               (-0.255, 0.08), (-0.265, 0.15), (-0.27, 0.24), (-0.275, 0.36), (-0.28, 0.50)]  # z, y
    for k, (z, y) in enumerate(profile):
        hang = min(1.0, max(0.0, (-z - 0.13) / 0.10))
        row = []
        for j in range(columns + 1):
            x = width * (j / columns - 0.5)
            fold = math.sin(34 * x + 1.3 * math.sin(9 * x) + 0.5 * y) + 0.45 * math.sin(71 * x + 2.0 + 2.4 * y)
            ripple = 0.0022 * hang * (1 - hang) * 4 * math.sin(47 * x + 1.0)
            row.append((x, y + abs(ripple) * 3 + 0.004 * hang * (1 - min(1.0, y / 0.1)) * (1 + fold), z + 0.017 * hang * fold))
        rows.append(row)
    mesh.add_grid(rows, lambda i, j: (j / columns, i / (len(profile) - 1)))
    return mesh


def board_colour(px, py, size=384):
    """Six by six squares of maple and walnut with the grain along x or z in turn, a dark line inlaid between."""
    x, y = 6 * (px + 0.5) / size, 6 * (py + 0.5) / size
    i, j = int(x), int(y)
    dark = (i + j) % 2
    along, across = (x, y) if dark else (y, x)
    warp = 0.35 * noise(2.0 * along, 3.0 * across, (3 + i + 7 * j) * 2147483647)
    rings = 0.5 + 0.5 * math.sin(2 * math.pi * (5.0 * across + 2.2 * warp + 0.37 * (5 * i + 3 * j)))
    fibre = noise(5 * along, 60 * across, 11 * 2147483647)
    t = 0.55 * rings + 0.45 * fibre
    light_wood = ((0.86, 0.70, 0.50), (0.74, 0.55, 0.35))
    dark_wood = ((0.40, 0.23, 0.14), (0.26, 0.14, 0.085))
    a, b = dark_wood if dark else light_wood
    edge = min(x - i, 1 - x + i, y - j, 1 - y + j)
    line = 0.35 if edge < 0.018 else 1.0
    return tuple((p * (1 - t) + q * t) * line for p, q in zip(a, b))


def board_top():
    """The inlay: a sheet just above the box below it."""
    mesh = Mesh()
    steps = 6
    mesh.add_grid([[(HALF_BOARD * (2 * j / steps - 1), 0.0, HALF_BOARD * (1 - 2 * i / steps)) for j in range(steps + 1)]
                   for i in range(steps + 1)], lambda i, j: (j / steps, i / steps))
    return mesh


def build(path):
    doc = Document("Alabaster make_mixed_no_subsurface.py")
    brass = doc.add_material("brass", {"baseColor": [0.91, 0.74, 0.40], "metallic": 1.0, "roughness": 0.24})
    steel = doc.add_material("steel", {"baseColor": [0.80, 0.80, 0.81], "metallic": 1.0, "roughness": 0.10})
    lacquer = doc.add_material("lacquer", {"baseColor": [0.014, 0.012, 0.013], "roughness": 0.12, "clearcoat": 1.0,
                                           "clearcoatGloss": 0.97})
    enamel = doc.add_material("enamel", {"baseColor": [0.46, 0.025, 0.030], "roughness": 0.22, "clearcoat": 1.0,
                                         "clearcoatGloss": 0.95})
    plastic = doc.add_material("plastic", {"baseColor": [0.84, 0.81, 0.74], "roughness": 0.30})
    cloth = doc.add_material("velvet", {"baseColor": [0.035, 0.115, 0.120], "roughness": 0.95, "specular": 0.15,
                                        "sheen": 1.0, "sheenTint": 0.7})
    inlay = doc.add_material("inlay", {"baseColor": [1.0, 1.0, 1.0], "roughness": 0.28, "specular": 0.8},
                             texture=doc.add_texture("board", png(384, 384, board_colour)))
    frame = doc.add_material("frame", {"baseColor": [0.085, 0.040, 0.022], "roughness": 0.30})

    top = 0.0165
    doc.add_node("frame", doc.add_mesh("frame", box(2 * HALF_BOARD + 0.024, 0.016, 2 * HALF_BOARD + 0.024, 0.0014), frame))
    doc.add_node("inlay", doc.add_mesh("inlay", board_top(), inlay), placed(at=(0.0, 0.0163, 0.0)))
    doc.add_node("velvet", doc.add_mesh("velvet", velvet(), cloth), placed(at=(0.0, -0.0005, 0.0)))

    meshes = {}

    def stand(name, shape, material, column, row, turn=0.0):
        key = (shape.__name__, material)
        if key not in meshes:
            meshes[key] = doc.add_mesh(shape.__name__, shape(), material)
        at = ((column - 2.5) * SQUARE, top, (row - 2.5) * SQUARE)
        doc.add_node(name, meshes[key], placed(turn, at=at))
        return at

    x, y, z = stand("king", king, brass, 3.0, 1.98)
    upright, bar = (doc.add_mesh("cross", part, brass) for part in king_cross())
    doc.add_node("cross", upright, placed(0.25, at=(x, y + 0.1000, z)))
    doc.add_node("cross_bar", bar, placed(0.25, at=(x, y + 0.1050, z)))
    stand("queen", queen, lacquer, 2.02, 1.0)
    stand("bishop", bishop, plastic, 0.98, 2.03)
    stand("rook", rook, steel, 4.03, 1.98)
    stand("pawn_plastic", pawn, plastic, 2.03, 3.0)
    stand("pawn_lacquer", pawn, lacquer, 5.0, 3.02)
    stand("pawn_brass", pawn, brass, 0.0, 0.98)
    stand("bishop_red", bishop, enamel, 4.98, 1.0)
    fallen = placed(-0.75, 1.395, at=(-0.088, top + 0.0153, 0.075))
    doc.add_node("pawn_red", doc.add_mesh("pawn", pawn(), enamel), fallen)
    doc.add_node("marble_ball", doc.add_mesh("ball", cube_sphere(4, lambda d: tuple(0.014 * c for c in d)), steel),
                 placed(at=(0.014, top + 0.0139, 0.108)))
    doc.write_glb(path)


if __name__ == "__main__":
    build(sys.argv[1] if len(sys.argv) > 1 else HERE / "mixed_no_subsurface.glb")
