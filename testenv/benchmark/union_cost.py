#!/usr/bin/env python3
"""Seconds of a sample where N overlapping balls scatter as one body (subsurfaceSet), and where each is a body of its own.

  union_cost.py [N ...]      needs the Python module in PYTHONPATH; N: 1000 4000 16000 32000

64 x 64 pixels, one thread. The radius falls with N^(-1/3), so the balls cover the same pixels. CPU seconds are the difference of
9 samples and 1, over 8, the least of three.
"""
import pathlib
import random
import sys

import hdalabaster
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "matrix"))
from features import box, look_at  # noqa: E402


def scene_of(count, united):
    numbers, radius = random.Random(1), 1.12 / count ** (1 / 3)
    points, quads = box()
    points = np.float32(points)
    scene = hdalabaster.Scene()
    scene.set_material("/wax", baseColor=(0.9, 0.6, 0.4), scatterDistance=(radius / 2,) * 3, roughness=0.4)
    scene.set_light("/sky", "domeLight")
    for i in range(count):
        place = np.eye(4)
        place[3, :3] = [numbers.uniform(-0.8, 0.8) for _ in range(3)]
        given = {"primvars": {"subsurfaceSet": hdalabaster.Primvar("balls", "constant")}} if united else {}
        scene.set_mesh(f"/ball{i}", points * radius, quads, material="/wax", scheme="catmullClark", refine_level=1, transform=place, **given)
    return scene


def seconds(scene):
    camera = {"transform": look_at((0, 0, 1), 5.0), "focalLength": 0.05, "horizontalAperture": 0.036, "verticalAperture": 0.036}
    renderer, least = hdalabaster.Renderer(scene, threads=1), []
    for turn in range(3):
        spent = []
        for samples in (1, 9):
            renderer.set(samples=samples, seed=2 * turn + samples % 9)  # another seed: all samples are new
            renderer.render(width=64, height=64, camera=camera)
            spent.append(renderer.stats()["cpuSeconds"])
        least.append((spent[1] - spent[0]) / 8)
    return min(least)


def main():
    print("| members | each a body | one set | ratio |\n|--|--|--|--|")
    for count in [int(n) for n in sys.argv[1:]] or [1000, 4000, 16000, 32000]:
        each, united = (seconds(scene_of(count, one)) for one in (False, True))
        print(f"| {count} | {each:.3f} | {united:.3f} | {united / each:.2f} |", flush=True)


main()
