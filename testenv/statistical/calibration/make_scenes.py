#!/usr/bin/env python3
"""Writes scenes on which calibrations are tried, and which no setting was chosen by: one kind of difficulty each.

  python3 testenv/statistical/calibration/make_scenes.py FOLDER      writes FOLDER/NAME/NAME.json and NAME.glb for each
"""
import json
import math
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scenes"))
from gltf_writer import Document, Mesh  # noqa: E402
from shapes import backdrop, box, cube_sphere, lathe, placed, torus  # noqa: E402

WHITE = {"baseColor": [0.75, 0.75, 0.72], "roughness": 0.9, "specular": 0.1}
METAL = {"baseColor": [0.93, 0.86, 0.72], "metallic": 1.0, "roughness": 0.06}
GLASS = {"baseColor": [1.0, 1.0, 1.0], "specTrans": 1.0, "ior": 1.5, "roughness": 0.0}


def ball(n=8):
    return cube_sphere(n, lambda d: d)


def panel(width, height):
    """A rectangle around the origin that faces +z."""
    mesh = Mesh()
    mesh.add_grid([[(x * width / 2, y * height / 2, 0.0) for x in (-1, 1)] for y in (-1, 1)])
    return mesh


def lying(at=(0.0, 0.0, 0.0)):
    """Turns what faces +z to face up."""
    return [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, *at, 1.0]


class Scene:
    def __init__(self, name, eye, target, focal=40.0):
        self.name, self.doc, self.materials = name, Document("Alabaster make_scenes.py"), {}
        self.refined = {}
        self.text = {"gltf": [{"file": name + ".glb"}], "lights": [], "meshes": [],
                     "camera": {"lookAt": {"eye": eye, "target": target}, "focalLength": focal, "horizontalAperture": 36,
                                "verticalAperture": 24},
                     "settings": {"resolution": [240, 160], "studio": "off"}}

    def add(self, name, mesh, material, matrix=None, level=0):
        key = json.dumps(material)
        if key not in self.materials:
            self.materials[key] = self.doc.add_material(f"material{len(self.materials)}", material)
        self.doc.add_node(name, self.doc.add_mesh(name, mesh, self.materials[key]), matrix)
        if level:
            self.text["meshes"].append({"match": name, "scheme": "catmullClark", "refineLevel": level})

    def light(self, kind, **values):
        self.text["lights"].append({"name": f"light{len(self.text['lights'])}", "type": kind, **values})

    def write(self, folder):
        folder = folder / self.name
        folder.mkdir(parents=True, exist_ok=True)
        self.doc.write_glb(folder / (self.name + ".glb"))
        if not self.text["meshes"]:
            del self.text["meshes"]
        (folder / (self.name + ".json")).write_text(json.dumps(self.text, indent=1) + "\n")
        return folder / (self.name + ".json")


def room(scene, width=4.0, height=2.6, depth=5.0, left=WHITE, right=WHITE, opening=None):
    """Floor, ceiling, back wall and side walls, seen from the open front. `opening`: (y, z) ranges cut out of the right wall."""
    scene.add("floor", panel(width, depth), WHITE, lying((0.0, 0.0, 0.0)))
    scene.add("ceiling", panel(width, depth), WHITE,
              [1.0, 0, 0, 0, 0, 0, 1.0, 0, 0, -1.0, 0, 0, 0.0, height, 0.0, 1.0])
    scene.add("back", panel(width, height), WHITE, placed(at=(0.0, height / 2, -depth / 2)))
    scene.add("left", panel(depth, height), left, placed(turn=math.pi / 2, at=(-width / 2, height / 2, 0.0)))
    if not opening:
        scene.add("right", panel(depth, height), right, placed(turn=-math.pi / 2, at=(width / 2, height / 2, 0.0)))
        return
    (y0, y1), (z0, z1) = opening
    half = depth / 2
    for i, (a, b, c, d) in enumerate(((0.0, y0, -half, half), (y1, height, -half, half), (y0, y1, -half, z0), (y0, y1, z1, half))):
        scene.add(f"right{i}", panel(d - c, b - a), right,
                  placed(turn=-math.pi / 2, at=(width / 2, (a + b) / 2, (c + d) / 2)))


def interior():
    """A room that a window lights: most light has bounced."""
    s = Scene("interior", [0.0, 1.3, 4.4], [0.0, 1.1, -1.0], 32.0)
    room(s, left={"baseColor": [0.6, 0.12, 0.1], "roughness": 0.9}, opening=((0.9, 2.1), (-1.6, -0.4)))
    s.add("front", panel(4.0, 2.6), WHITE, placed(turn=math.pi, at=(0.0, 1.3, 2.5 + 2.0)))
    s.add("table", box(1.4, 0.7, 0.8, 0.02), {"baseColor": [0.4, 0.25, 0.12], "roughness": 0.4}, placed(turn=0.3, at=(-0.3, 0.0, -0.8)))
    s.add("vase", lathe([(0.1, 0.0), (0.18, 0.15), (0.12, 0.4), (0.15, 0.5)]), {"baseColor": [0.2, 0.4, 0.6], "roughness": 0.2},
          placed(at=(-0.3, 0.7, -0.8)), 2)
    s.light("rectLight", width=1.6, height=1.6, intensity=40.0, position=[3.2, 1.9, -1.0], target=[0.0, 1.0, -1.0])
    return s


def caustic():
    """Polished rings under one small bright lamp: rare paths carry much of the light."""
    s = Scene("caustic", [0.0, 2.2, 4.0], [0.0, 0.2, 0.0], 45.0)
    s.add("floor", panel(6.0, 6.0), WHITE, lying())
    s.add("ring", torus(0.8, 0.12, 32, 12), METAL, placed(at=(-0.3, 0.12, 0.0)), 2)
    s.add("cup", lathe([(0.35, 0.0), (0.36, 0.3), (0.36, 0.5), (0.33, 0.5), (0.32, 0.05), (0.05, 0.04)], 24), METAL,
          placed(at=(1.0, 0.0, 0.5)), 1)
    s.light("sphereLight", radius=0.02, intensity=40000.0, position=[1.6, 2.6, -0.8])
    s.light("domeLight", intensity=0.03)
    return s


def strands():
    """Hair-thin strands, thinner than a pixel, before a bright and a dark wall."""
    s, r = Scene("strands", [0.0, 0.6, 3.0], [0.0, 0.55, 0.0], 60.0), random.Random(5)
    mesh = Mesh()
    for _ in range(700):
        x, z, lean = r.uniform(-0.8, 0.8), r.uniform(-0.3, 0.3), r.uniform(-0.25, 0.25)
        rows = [[(x + lean * h * h + side * 0.0016, 1.2 * h, z + 0.2 * lean * h) for side in (-1, 1)] for h in
                (0, 0.25, 0.5, 0.75, 1)]
        mesh.add_grid(rows)
    s.add("strands", mesh, {"baseColor": [0.85, 0.6, 0.3], "roughness": 0.35, "specular": 0.8})
    s.add("bright", panel(1.0, 2.0), {"baseColor": [0.9, 0.9, 0.9], "roughness": 0.9}, placed(at=(-0.5, 0.6, -0.8)))
    s.add("dark", panel(1.0, 2.0), {"baseColor": [0.03, 0.03, 0.04], "roughness": 0.9}, placed(at=(0.5, 0.6, -0.8)))
    s.light("rectLight", width=0.5, height=0.5, intensity=30.0, position=[1.2, 2.0, 1.6], target=[0.0, 0.5, 0.0])
    s.light("domeLight", intensity=0.1)
    return s


def many_lights():
    """Two hundred small lamps of unequal power between pillars."""
    s, r = Scene("many_lights", [0.0, 2.0, 6.0], [0.0, 0.8, 0.0], 35.0), random.Random(9)
    s.add("floor", panel(12.0, 12.0), WHITE, lying())
    s.add("wall", panel(12.0, 5.0), WHITE, placed(at=(0.0, 2.5, -4.0)))
    for i in range(9):
        s.add(f"pillar{i}", box(0.35, 2.0, 0.35, 0.02), WHITE,
              placed(turn=0.4 * i, at=(-3.0 + 1.5 * (i % 5), 0.0, -2.5 + 2.2 * (i // 5))))
    for _ in range(200):
        power = 10 ** r.uniform(-1, 1)
        s.light("sphereLight", radius=0.03, intensity=60.0 * power, color=[r.uniform(0.3, 1), r.uniform(0.3, 1), r.uniform(0.3, 1)],
                position=[r.uniform(-4, 4), r.uniform(0.1, 3), r.uniform(-3.8, 2.5)])
    return s


def sun():
    """A low sun of half a degree on water-like gloss, metal and leaves that shade."""
    s, r = Scene("sun", [0.0, 1.4, 4.0], [0.0, 0.5, 0.0], 40.0), random.Random(3)
    s.add("floor", panel(8.0, 8.0), {"baseColor": [0.25, 0.3, 0.3], "roughness": 0.12, "specular": 0.7}, lying())
    s.add("wall", panel(8.0, 3.0), WHITE, placed(at=(0.0, 1.5, -2.0)))
    s.add("ball", ball(), METAL, placed(size=0.5, at=(-0.7, 0.5, 0.0)), 2)
    leaves = Mesh()
    for _ in range(160):
        c = [r.uniform(0.2, 1.8), r.uniform(0.6, 1.8), r.uniform(-1.2, 0.6)]
        u = [r.uniform(-1, 1) * 0.09 for _ in range(3)]
        v = [u[1] * 0.7, -u[0] * 0.7, 0.05]
        leaves.add_grid([[tuple(c[k] + a * u[k] + b * v[k] for k in range(3)) for a in (-1, 1)] for b in (-1, 1)])
    s.add("leaves", leaves, {"baseColor": [0.15, 0.4, 0.08], "roughness": 0.5})
    s.light("distantLight", angle=0.53, intensity=30000.0, target=[-0.5, -0.35, -0.6])
    s.light("domeLight", intensity=0.15, color=[0.5, 0.7, 1.0])
    return s


def glass():
    """Clear and rough glass that focuses a small lamp."""
    s = Scene("glass", [0.0, 1.5, 4.2], [0.0, 0.4, 0.0], 45.0)
    s.add("floor", panel(6.0, 6.0), WHITE, lying())
    s.add("wall", panel(6.0, 3.0), {"baseColor": [0.5, 0.55, 0.7], "roughness": 0.8}, placed(at=(0.0, 1.5, -1.8)))
    s.add("ball", ball(), GLASS, placed(size=0.45, at=(-0.6, 0.46, 0.2)), 3)
    s.add("block", box(0.5, 0.8, 0.5, 0.03), {**GLASS, "baseColor": [0.8, 1.0, 0.9], "roughness": 0.12},
          placed(turn=0.6, at=(0.6, 0.001, -0.2)), 2)
    s.light("sphereLight", radius=0.06, intensity=4000.0, position=[1.5, 3.0, -1.0])
    s.light("domeLight", intensity=0.06)
    return s


def slit():
    """A closed room that a slit lights from behind its wall."""
    s = Scene("slit", [0.0, 1.3, 2.3], [0.0, 1.2, -1.0], 28.0)
    room(s, opening=((0.4, 2.2), (-1.02, -0.98)))
    s.add("front", panel(4.0, 2.6), WHITE, placed(turn=math.pi, at=(0.0, 1.3, 2.5)))
    s.add("block", box(0.8, 1.1, 0.8, 0.02), WHITE, placed(turn=0.5, at=(-0.5, 0.0, -0.9)))
    s.light("sphereLight", radius=0.25, intensity=3000.0, position=[4.0, 1.6, -0.6])
    return s


def bodies():
    """Translucent bodies, one within a clear coat of another, in soft light."""
    s = Scene("bodies", [0.0, 1.1, 3.4], [0.0, 0.4, 0.0], 48.0)
    s.add("stage", backdrop(), WHITE, None, 2)
    for i, (color, reach) in enumerate((([0.95, 0.85, 0.7], [0.3, 0.2, 0.1]), ([0.8, 0.3, 0.25], [0.1, 0.04, 0.03]),
                                        ([0.5, 0.8, 0.6], [0.6, 0.9, 0.5]))):
        mesh = (ball(), lathe([(0.6, -0.9), (0.9, 0.0), (0.3, 0.8)]), torus(0.8, 0.3, 24, 12))[i]
        s.add(f"body{i}", mesh, {"baseColor": color, "scatterDistance": reach, "roughness": 0.3},
              placed(turn=0.5 * i, size=0.38, at=(-0.9 + 0.9 * i, 0.39, 0.1 * i)), 2)
    s.light("rectLight", width=1.0, height=1.0, intensity=20.0, position=[-1.5, 2.2, -0.6], target=[0.0, 0.3, 0.0])
    s.light("domeLight", intensity=0.12)
    return s


SCENES = (interior, caustic, strands, many_lights, sun, glass, slit, bodies)


def write_all(folder):
    """The render descriptions, in the order of SCENES."""
    return [make().write(pathlib.Path(folder)) for make in SCENES]


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    for file in write_all(sys.argv[1]):
        print(file)
