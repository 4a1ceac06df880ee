#!/usr/bin/env python3
"""Renders the edge of a shadow on half-spaces of recipes.md, and compares the light inside the shadow with that of the published media.

  shadow_edge.py PROGRAM [--samples N] [--medium NAME ...] [--times X]     --times X multiplies the distances

Prints a table: the light at depths into the shadow, in per cent of that far from the edge, as rendered and as the dipole of
scatter_distances.py says. The last line is the largest difference, as a fraction.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(TOP / "testenv/scenes"), str(TOP / "testenv/statistical/calibration")]
from gltf_writer import Document, Mesh  # noqa: E402
from pictures import read_layers  # noqa: E402
from scatter_distances import channels, material_of, media  # noqa: E402
from shapes import box, placed  # noqa: E402

WIDTH, HEIGHT, MM, MIDDLE = 96, 4, 24.0, -4.875  # pixels; the picture's width and middle in mm, the light at negative x
DEPTHS = (0.5, 1, 2, 4)  # mm into the shadow, at the middle of a column each
PLATE = 4  # columns at the lit end


def write_scene(folder, material, samples):
    document = Document("Alabaster shadow_edge.py")
    ground = Mesh()
    ground.add_grid([[(x, 0, z) for x in (-0.2, 0, 0.2)] for z in (0.2, -0.2)])
    document.add_node("ground", document.add_mesh("ground", ground, document.add_material("ground", material)))
    black = document.add_material("black", {"baseColor": [0, 0, 0], "specular": 0})
    document.add_node("screen", document.add_mesh("screen", box(0.4, 0.002, 0.4, 0.0005), black), placed(at=(-0.2, 2e-5, 0)))
    document.write_glb(folder / "edge.glb")
    (folder / "edge.json").write_text(json.dumps({
        "models": [{"file": "edge.glb"}], "meshes": [{"match": "screen", "visibleToCamera": False}],
        "lights": [{"name": "sun", "type": "distantLight", "angle": 0.001, "intensity": 1e6, "position": [0, 1, 0], "target": [0, 0, 0]}],
        "camera": {"projection": "orthographic", "horizontalAperture": MM, "verticalAperture": MM * HEIGHT / WIDTH,
                   "lookAt": {"eye": [MIDDLE / 1000, 0.1, 0], "target": [MIDDLE / 1000, 0, 0], "up": [0, 0, -1]}},
        "settings": {"resolution": [WIDTH, HEIGHT], "samples": samples, "filter": "box"}}))


def rendered(program, material, samples):
    """The mean of each column for red, green and blue."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_scene(folder, material, samples)
        # The ground is a half-space on purpose, of which the program warns.
        subprocess.run([program, "render", str(folder / "edge.json"), "-o", str(folder / "edge.exr"), "--aov", "subsurface", "--quiet"],
                       check=True, stderr=subprocess.DEVNULL)
        layers = read_layers(folder / "edge.exr")
    return [[sum(layers[f"subsurface.{c}"][row * WIDTH + x] for row in range(HEIGHT)) / HEIGHT for x in range(WIDTH)] for c in "RGB"]


def behind_edge(dipole, depth, steps=2000):
    """Light at `depth` mm into the shadow, as a fraction: of each ring around the point the part that lies in the light."""
    if depth < 0:
        return 1 - behind_edge(dipole, -depth, steps)
    reach, light, last = 40 / dipole.transport, 0, (depth, dipole.within(depth))
    for step in range(1, steps + 1):
        radius = depth + reach * (step / steps) ** 3
        now = (radius, dipole.within(radius))
        light += (now[1] - last[1]) * math.acos(min(1, depth / ((radius + last[0]) / 2))) / math.pi
        last = now
    return light / dipole.reflectance()


def column_depth(column):
    return -(MIDDLE + MM * ((column + 0.5) / WIDTH - 0.5))


def at_depth(columns, depth, dipole):
    """A column relative to the light far from the edge."""
    plate = sum(columns[-PLATE:]) / PLATE / (sum(behind_edge(dipole, column_depth(c)) for c in range(WIDTH - PLATE, WIDTH)) / PLATE)
    return columns[min(range(WIDTH), key=lambda c: abs(column_depth(c) - depth))] / plate


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--samples", type=int, default=4096)
    parser.add_argument("--medium", nargs="+", default=["Skin, pale", "Marble", "Whole milk"])
    parser.add_argument("--times", type=float, default=1)
    options = parser.parse_args()
    print("| medium, channel | " + " | ".join(f"{depth:g} mm" for depth in DEPTHS) + " |\n| --- |" + " --- |" * len(DEPTHS))
    worst = 0
    for medium in media():
        if medium["name"] in options.medium:
            material = {**material_of(medium), "specular": 0}
            material["scatterDistance"] = [options.times * distance for distance in material["scatterDistance"]]
            for channel, columns, dipole in zip(("red", "green", "blue"), rendered(options.program, material, options.samples), channels(medium)):
                pairs = [(at_depth(columns, depth, dipole), behind_edge(dipole, depth)) for depth in DEPTHS]
                worst = max([worst, *(abs(ours - theirs) for ours, theirs in pairs)])
                print(f"| {medium['name']}, {channel} | " + " | ".join(f"{100 * ours:.1f}, {100 * theirs:.1f}" for ours, theirs in pairs) + " |")
    print(f"{worst:.4f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
