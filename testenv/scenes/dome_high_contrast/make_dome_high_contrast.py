#!/usr/bin/env python3
"""Makes dome_high_contrast.glb, a jade gourd and a marble egg as quad cages (FB_ngon_encoding) for subdivision, and sky.hdr,
the only light: an evening sky with a sun of two texels, 40 000 times as bright as the sky behind it.

Everything is modelled here, in metres, y up. Run: python3 testenv/scenes/dome_high_contrast/make_dome_high_contrast.py [PATH.glb]
"""
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from gltf_writer import Document, Mesh  # noqa: E402
from images import write_hdr  # noqa: E402
from shapes import cube_sphere, lathe, placed  # noqa: E402

WIDTH, HEIGHT = 256, 128
SUN_ROW, SUN_COLUMNS = 46, (28, 29)  # 25 degrees high, behind the bodies, right
SUN_RATIO = 4.0e4


def sky(row, column):
    """Radiance of a texel. The top row is the zenith; the picture's centre looks along +z, its edges along -z."""
    up = math.cos(math.pi * (row + 0.5) / HEIGHT)
    turn = 2 * math.pi * (column - SUN_COLUMNS[0]) / WIDTH
    near = 0.5 + 0.5 * math.cos(turn)
    if up < 0:  # sand that continues the floor; it darkens away from the horizon
        fade = math.exp(6.0 * up)
        return tuple(c * (0.35 + 0.65 * fade) for c in (0.30, 0.22, 0.16))
    zenith, horizon, glow = (0.06, 0.13, 0.30), (0.30, 0.27, 0.26), (0.75, 0.36, 0.10)
    low = math.exp(-5.0 * up)
    return tuple(z * (1 - low) + h * low + g * near ** 6 * math.exp(-3.5 * up) for z, h, g in zip(zenith, horizon, glow))


def radiance(row, column):
    base = sky(row, column)
    if row == SUN_ROW and column in SUN_COLUMNS:
        level = SUN_RATIO * sum(base) / 3
        return (1.25 * level, 1.0 * level, 0.75 * level)
    return base


def gourd():
    """Two ribbed bulbs with a stalk."""
    profile = [(0.018, 0.0), (0.034, 0.002), (0.048, 0.014), (0.053, 0.032), (0.046, 0.052), (0.030, 0.068), (0.0225, 0.078),
               (0.025, 0.089), (0.033, 0.101), (0.035, 0.113), (0.027, 0.126), (0.013, 0.133), (0.0065, 0.139), (0.0045, 0.149),
               (0.0050, 0.156), (0.003, 0.158)]
    ribs = [0.0, 0.5, 1, 1, 1, 0.7, 0.4, 0.5, 0.7, 0.7, 0.6, 0.4, 0, 0, 0, 0]
    mesh = lathe(profile, 40, lambda a, k, r: r * (1 - 0.075 * ribs[k] * (1 - abs(math.sin(5 * a)))))
    # The stalk bends.
    mesh.points = [(x + 0.012 * max(0.0, (y - 0.130) / 0.028) ** 2, y, z) for x, y, z in mesh.points]
    return mesh


def egg():
    def point(d):
        taper = 1 - 0.13 * d[0]
        return (0.040 * d[0], 0.030 * d[1] * taper, 0.030 * d[2] * taper)
    return cube_sphere(4, point)


def sand():
    """A floor to the horizon, with ripples where the bodies stand."""
    def height(x, z):
        near = math.exp(-(x * x + z * z) / 0.35)
        return near * 0.0022 * (math.sin(62 * (0.45 * x + 0.9 * z) + 1.6 * math.sin(7 * x)) - 1)

    fine = [-0.6 + 1.2 * i / 72 for i in range(73)]
    cuts = [-40.0, -12.0, -4.0, -1.6, -0.9] + fine + [0.9, 1.6, 4.0, 12.0, 40.0]
    mesh = Mesh()
    mesh.add_grid([[(x, height(x, z), z) for x in cuts] for z in reversed(cuts)])
    return mesh


def build(path):
    write_hdr(path.parent / "sky.hdr", WIDTH, HEIGHT, radiance)
    document = Document("Alabaster make_dome_high_contrast.py")
    jade = document.add_material("jade", {
        "baseColor": [0.42, 0.78, 0.50], "roughness": 0.16, "scatterDistance": [0.0050, 0.0095, 0.0055]})
    marble = document.add_material("marble", {
        "baseColor": [0.93, 0.89, 0.84], "roughness": 0.25, "scatterDistance": [0.0065, 0.0048, 0.0036]})
    ground = document.add_material("sand", {"baseColor": [0.36, 0.29, 0.23], "roughness": 0.9, "specular": 0.3})
    document.add_node("gourd", document.add_mesh("gourd", gourd(), jade), placed(0.4, at=(-0.028, -0.001, 0.0)))
    document.add_node("egg", document.add_mesh("egg", egg(), marble), placed(0.6, 0.0, 1.0, (0.066, 0.0272, 0.034)))
    document.add_node("sand", document.add_mesh("sand", sand(), ground))
    document.write_glb(path)


if __name__ == "__main__":
    build(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "dome_high_contrast.glb")
