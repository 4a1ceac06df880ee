#!/usr/bin/env python3
"""Writes render descriptions of bodies that are not in the repository, for peers.py: a wax dragon, a marble bunny, a jade
armadillo, a cow of skin.

  asset_scenes.py OUT [--assets FOLDER]

FOLDER holds sss/dragon_wax.glb and so on, and subdiv/spot_control_sss.glb (default: $ALABASTER_TEST_ASSETS). Bodies that it
lacks are left out, with a message. Each is lit by a key from the side, a rim from behind, a fill and a dim sky, scaled to its
size.
"""
import argparse
import itertools
import json
import math
import os
import pathlib
import shutil
import sys

from neutral_scene import Glb, placed_meshes, to_world

MATERIALS = {
    "dragon_wax": {"baseColor": [0.9, 0.5, 0.2], "roughness": 0.3, "scatterDistance": [0.6, 0.3, 0.15]},
    "bunny_marble": {"baseColor": [0.83, 0.79, 0.75], "roughness": 0.35, "scatterDistance": [0.104, 0.078, 0.0603]},
    "armadillo_jade": {"baseColor": [0.35, 0.62, 0.32], "roughness": 0.25, "scatterDistance": [0.03, 0.05, 0.02]},
    "spot_control_sss": {"baseColor": [0.85, 0.62, 0.52], "roughness": 0.45, "scatterDistance": [0.06, 0.025, 0.015]},
}
CAGES = {"spot_control_sss": {"refineLevel": 3}}  # refined, and not in the folder sss
LIGHTS = {  # direction from the middle, size and power by the radius of the body
    "key": ((1.0, 0.8, 0.3), 1.0, 22.0), "rim": ((-0.6, 0.5, -1.0), 1.0, 16.0), "fill": ((-1.0, 0.4, 0.8), 1.6, 2.0)}


def bounds(glb):
    """Middle and radius of all meshes."""
    unit = [[float(i == j) for j in range(4)] for i in range(4)]
    points = []
    for node in glb.json["scenes"][0]["nodes"]:
        for mesh, matrix in placed_meshes(glb, node, unit):
            for primitive in glb.json["meshes"][mesh]["primitives"]:
                box = glb.json["accessors"][primitive["attributes"]["POSITION"]]
                corners = list(itertools.product(*zip(box["min"], box["max"])))
                points += to_world(matrix, corners, corners)[0]
    low, high = list(map(min, zip(*points))), list(map(max, zip(*points)))
    return [(a + b) / 2 for a, b in zip(low, high)], math.dist(low, high) / 2


def describe(name, middle, radius):
    def place(direction, distance):
        return [m + d * distance * radius / math.hypot(*direction) for m, d in zip(middle, direction)]
    lights = [{"name": light, "type": "rectLight", "width": size * radius, "height": size * radius, "intensity": power,
               "position": place(direction, 2.5), "target": middle} for light, (direction, size, power) in LIGHTS.items()]
    return {
        "gltf": [{"file": name + ".glb", **CAGES.get(name, {})}],
        "materials": [{"match": "*", "replace": MATERIALS[name]}],
        "lights": lights + [{"name": "sky", "type": "domeLight", "intensity": 0.15}],
        "camera": {"lookAt": {"eye": place((0.35, 0.25, 1.0), 3.6), "target": middle}, "focalLength": 50,
                   "horizontalAperture": 36, "verticalAperture": 24},
        "settings": {"samples": 64, "resolution": [480, 320]},
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--assets", default=os.environ.get("ALABASTER_TEST_ASSETS"))
    arguments = parser.parse_args()
    if not arguments.assets:
        parser.error("--assets or $ALABASTER_TEST_ASSETS must name the folder of test assets")
    arguments.out.mkdir(parents=True, exist_ok=True)
    for name in MATERIALS:
        file = pathlib.Path(arguments.assets) / ("subdiv" if name in CAGES else "sss") / (name + ".glb")
        if not file.exists():
            print(f"{file}: there is no such file, so {name}.json is left out", file=sys.stderr)
            continue
        shutil.copy(file, arguments.out)
        (arguments.out / (name + ".json")).write_text(json.dumps(describe(name, *bounds(Glb(file))), indent=1) + "\n")
        print(arguments.out / (name + ".json"))


if __name__ == "__main__":
    main()
