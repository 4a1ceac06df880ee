#!/usr/bin/env python3
"""Makes lights.glb (a ball, a box and a vase before a backdrop), lamp.ies and screen.png, for lights.json, which has a light of each
kind that is not in the other scenes: disk, cylinder, rect with an image, IES profile, colour temperature, spot shaping.

Metres, y up. Run: python3 testenv/scenes/lights/make_lights.py [output.glb]
"""
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from gltf_writer import Document, png  # noqa: E402
from shapes import backdrop, box, cube_sphere, lathe, placed  # noqa: E402


def candela(vertical, horizontal):
    """A wall washer: two lobes at 25 and 55 degrees from straight down, the outer one only to the front and back."""
    lobe = math.exp(-((vertical - 25) / 9) ** 2)
    outer = math.exp(-((vertical - 55) / 6) ** 2) * math.cos(math.radians(horizontal)) ** 2
    return 1200 * lobe + 900 * outer


def ies():
    verticals, horizontals = range(0, 91, 3), range(0, 91, 15)
    lines = ["IESNA:LM-63-2002", "[TEST] none: computed", "[MANUFAC] Alabaster", "[LUMINAIRE] wall washer with two lobes", "TILT=NONE",
             f"1 -1 1.0 {len(verticals)} {len(horizontals)} 1 2 0.1 0.1 0.0", "1.0 1.0 20.0",
             " ".join(str(v) for v in verticals), " ".join(str(h) for h in horizontals)]
    lines += [" ".join(f"{candela(v, h):.1f}" for v in verticals) for h in horizontals]
    return "\r\n".join(lines) + "\r\n"


def screen(x, y):
    """Warm at the left, blue at the right, a dark cross and a bright corner at the upper left: it shows what is up and left."""
    if abs(x - 31.5) < 3 or abs(y - 15.5) < 2:
        return (0.02, 0.02, 0.02)
    if x < 12 and y < 8:
        return (1.0, 1.0, 1.0)
    return (0.75, 0.30, 0.08) if x < 32 else (0.08, 0.25, 0.75)


def build(path):
    path = pathlib.Path(path)
    (path.parent / "lamp.ies").write_bytes(ies().encode())
    (path.parent / "screen.png").write_bytes(png(64, 32, screen))
    doc = Document("make_lights.py")
    chalk = doc.add_material("chalk", {"baseColor": [0.7, 0.7, 0.7], "roughness": 0.9})
    glaze = doc.add_material("glaze", {"baseColor": [0.6, 0.58, 0.55], "roughness": 0.15})
    doc.add_node("backdrop", doc.add_mesh("backdrop", backdrop(), chalk))
    doc.add_node("ball", doc.add_mesh("ball", cube_sphere(4, lambda d: tuple(0.14 * c for c in d)), glaze),
                 placed(at=(0.0, 0.14, 0.1)))
    doc.add_node("box", doc.add_mesh("box", box(0.22, 0.3, 0.22, 0.01), chalk), placed(0.5, at=(-0.42, 0.0, -0.1)))
    vase = lathe([(0.07, 0.0), (0.09, 0.04), (0.06, 0.16), (0.035, 0.24), (0.05, 0.32)])
    doc.add_node("vase", doc.add_mesh("vase", vase, glaze), placed(at=(0.42, 0.0, -0.05)))
    doc.write_glb(path)


if __name__ == "__main__":
    build(sys.argv[1] if len(sys.argv) > 1 else HERE / "lights.glb")
