#!/usr/bin/env python3
"""Writes render descriptions of a ball of milk with 1, 10 and 10,000 stones in it, which have the same cross-section together, and
without any, for peers.py.

  contents_scenes.py OUT
"""
import json
import math
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scenes"))
from gltf_writer import Document  # noqa: E402
from shapes import cube_sphere  # noqa: E402

MILK = {"baseColor": [0.97, 0.95, 0.9], "specTrans": 1, "roughness": 0.0, "ior": 1.33, "scatterDistance": [0.25, 0.2, 0.15]}
STONE = {"baseColor": [0.5, 0.1, 0.05], "roughness": 0.5}
COUNTS = (0, 1, 10, 10000)
CROSS_SECTION = 0.35 ** 2  # by pi


def ball(n, radius, at=(0, 0, 0)):
    return cube_sphere(n, lambda d: tuple(radius * c + a for c, a in zip(d, at)))


def places(count, radius):
    """Even in the ball, from a fixed seed."""
    chance, found = random.Random(1), []
    while len(found) < count:
        at = [chance.uniform(-1, 1) for _ in range(3)]
        if math.hypot(*at) < 0.9 - radius:
            found.append(at)
    return found


def describe(name):
    return {
        "gltf": [{"file": name + ".glb", "refineLevel": 0}],
        "lights": [{"name": "sky", "type": "domeLight", "intensity": 0.6},
                   {"name": "window", "type": "rectLight", "intensity": 8, "width": 3, "height": 3, "position": [-3, 4, 3], "target": [0, 0, 0]}],
        "camera": {"lookAt": {"eye": [0, 0, 6], "target": [0, 0, 0]}, "focalLength": 60, "horizontalAperture": 24, "verticalAperture": 24},
        "settings": {"maxDepth": 64}}


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for count in COUNTS:
        document, name = Document("Alabaster contents_scenes.py"), f"milk_{count}"
        document.add_node("milk", document.add_mesh("milk", ball(12, 1.0), document.add_material("milk", MILK)))
        stone, radius = document.add_material("stone", STONE), math.sqrt(CROSS_SECTION / max(count, 1))
        for k, at in enumerate(places(count, radius)):
            document.add_node(f"stone{k}", document.add_mesh(f"stone{k}", ball(2, radius, at), stone))
        document.write_glb(folder / f"{name}.glb")
        (folder / f"{name}.json").write_text(json.dumps(describe(name), indent=1) + "\n")


if __name__ == "__main__":
    main()
