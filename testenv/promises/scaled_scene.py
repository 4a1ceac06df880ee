#!/usr/bin/env python3
"""Renders a waxen pebble under a lamp and a sky at 2^k times its size to k.exr, for each k.

  scaled_scene.py [--unscaled-lamp] K...      needs the module hdalabaster
"""
import sys

import hdalabaster


def matrix(z, y, unit):
    return [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, y * unit, z * unit, 1]]


def render(k, lamp):
    unit = 2.0 ** k
    scene = hdalabaster.Scene()
    scene.set_mesh("/pebble", points=[(x * unit, y * unit, z * unit) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], material="/wax",
                   indices=[[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]], scheme="catmullClark",
                   refine_level=2)
    scene.set_material("/wax", baseColor=(0.9, 0.6, 0.3), scatterDistance=tuple(d * unit for d in (0.3, 0.1, 0.05)))
    scene.set_light("/sky", "domeLight", intensity=0.3)
    scene.set_light("/lamp", "sphereLight", matrix(2, 2, unit), intensity=20, radius=0.25 * (unit if lamp else 1))
    scene.set_camera("/camera", matrix(6, 0, unit), focalLength=0.05, horizontalAperture=0.036, verticalAperture=0.024)
    scene.set_render_settings("/settings", camera="/camera", width=24, height=16)
    hdalabaster.Renderer(scene, samples=8).record(f"{k}.exr")


words = sys.argv[1:]
for word in words:
    if not word.startswith("--"):
        render(int(word), "--unscaled-lamp" not in words)
