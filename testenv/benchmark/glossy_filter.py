#!/usr/bin/env python3
"""Measures how far setting glossyFilter is off on glass, metal and coat, and what it gains.

  glossy_filter.py PROGRAM [--size WxH] [--spp N] [--seeds N] [--filter W ...]

The scene is made here: a clear and a rough ball of glass, a ring of rough gold and a coated ball on plaster, under a lamp and a
dim dome, so that much of the light comes by way of gloss. Every width of the filter is rendered with several seeds, and compared with an
unfiltered reference of 8 times the samples and other seeds, object by object: `level` is the light of the object over the reference's less 1, with its standard error;
`bias` is the relative root mean squared difference of the mean pictures (core/convergence/frame_error.h), the noise of both
subtracted, `below` its 95 % end where it may be 0. `gain` is the unfiltered noise squared times CPU seconds of the whole frame, over the
filtered.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "statistical" / "calibration"), str(HERE.parent / "scenes")]
from compare_programs import environment, require  # noqa: E402
from gltf_writer import Document, Mesh  # noqa: E402
from pictures import Reference, read_exr  # noqa: E402
from texture_filter import ball, rectangle  # noqa: E402

OBJECTS = {
    "clear_glass": {"baseColor": [1, 1, 1], "roughness": 0, "specTrans": 1, "ior": 1.5},
    "rough_glass": {"baseColor": [0.9, 1, 0.95], "roughness": 0.15, "specTrans": 1, "ior": 1.4},
    "gold": {"baseColor": [1, 0.75, 0.35], "metallic": 1, "roughness": 0.12},
    "coat": {"baseColor": [0.5, 0.05, 0.04], "roughness": 0.5, "coat": 1, "coatRoughness": 0.03},
    "plaster": {"baseColor": [0.7, 0.68, 0.62], "roughness": 0.9, "specular": 0.2},
}


def ring(radius, thickness, at):
    mesh, n, k = Mesh(), 64, 24
    rows = [[(at[0] + (radius + thickness * math.cos(2 * math.pi * j / k)) * math.cos(2 * math.pi * i / n),
              at[1] + thickness * math.sin(2 * math.pi * j / k),
              at[2] + (radius + thickness * math.cos(2 * math.pi * j / k)) * math.sin(2 * math.pi * i / n)) for j in range(k)]
            for i in range(n + 1)]
    mesh.add_grid(rows, closed_u=True)
    return mesh


def write_scene(folder):
    document = Document("glossy_filter.py")
    shapes = {"clear_glass": ball(0.6, (-1.4, 0.6, 0)), "rough_glass": ball(0.6, (0, 0.6, 0.2)), "coat": ball(0.6, (1.4, 0.6, 0)),
              "gold": ring(0.5, 0.1, (0.3, 0.1, 1.5)), "plaster": rectangle([(-5, 0, 4), (5, 0, 4), (5, 0, -5), (-5, 0, -5)], 1.0)}
    for name, mesh in shapes.items():
        document.add_node(name, document.add_mesh(name, mesh, document.add_material(name, {})))
    document.write_glb(folder / "table.glb")
    (folder / "table.json").write_text(json.dumps({
        "gltf": [{"file": "table.glb"}],
        "materials": [{"match": name, "replace": values} for name, values in OBJECTS.items()],
        "lights": [{"name": "sky", "type": "domeLight", "intensity": 0.3},
                   {"name": "lamp", "type": "sphereLight", "radius": 0.4, "intensity": 100, "position": [2, 4, -2]}],
        "camera": {"lookAt": {"eye": [0, 2.2, 5], "target": [0, 0.4, 0.3]}, "focalLength": 40}}))


def render(arguments, folder, seed, spp, flags):
    """The picture and CPU seconds."""
    output, stats = folder / "picture.exr", folder / "stats.json"
    command = [arguments.program, "render", str(folder / "table.json"), "-o", str(output), "--quiet", "--stats", str(stats),
               "--size", arguments.size, "--spp", str(spp), "--seed", str(seed), "--threads", str(arguments.threads), *flags]
    done = subprocess.run(command, env=environment(arguments.program), capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\nended with {done.returncode}: {done.stderr}")
    return read_exr(output), json.loads(stats.read_text())["delegate"][0]["phase.render.cpu"]


def mask(arguments, folder, name):
    """The pixels that show nothing but the object: it glows, and no light is followed."""
    glow = ["--set", f"materials/{name}.emission=[1000,1000,1000]", "--set", "maxDepth=0"]
    picture, _ = render(arguments, folder, 1, 16, glow)
    return [i for i, value in enumerate(picture.planes[0]) if value > 990]


def compare(reference, mine, pixels):
    """Level and its standard error, bias^2 and its standard error, over the pixels."""
    levels = [sum(r.planes[c][i] for c in range(3) for i in pixels) for r in (mine, reference)]
    variance = sum(r.variance[c][i] for r in (mine, reference) for c in range(3) for i in pixels)
    squares = [sum((mine.planes[c][i] - reference.planes[c][i]) ** 2 - mine.variance[c][i] - reference.variance[c][i] for c in range(3)) / 3 /
               reference.scales[i] for i in pixels]
    mean = sum(squares) / len(squares)
    scatter = sum((s - mean) ** 2 for s in squares) / len(squares) / (len(squares) - 1)
    return levels[0] / levels[1] - 1, math.sqrt(variance) / levels[1], mean, math.sqrt(scatter)


def noise(reference, pictures):
    total = sum(sum(v / s for v, s in zip(plane, reference.scales)) for plane in pictures.variance)
    return total / 3 / len(reference.scales)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--size", default="96x64")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--filter", type=float, nargs="+", default=[0.5, 1.0])
    arguments = parser.parse_args()
    if arguments.seeds < 2:
        parser.error("--seeds must be 2 or more: noise is the difference between seeds")
    require(arguments.program)
    print(f"{arguments.size}, {arguments.spp} samples, {arguments.seeds} seeds\n\n| object | glossyFilter | level | bias | gain, whole frame |\n|--|--|--|--|--|")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_scene(folder)
        masks = {one: mask(arguments, folder, one) for one in OBJECTS}
        reference = Reference([render(arguments, folder, 1000 + seed, 8 * arguments.spp, [])[0] for seed in range(arguments.seeds)])
        work = None
        for width in [0.0, *arguments.filter]:
            runs = [render(arguments, folder, 1 + seed, arguments.spp, ["--set", f"glossyFilter={width}"]) for seed in range(arguments.seeds)]
            mine = Reference([picture for picture, _ in runs])
            cost = noise(reference, mine) * sum(seconds for _, seconds in runs)
            work = work or cost
            for one, pixels in masks.items():
                level, error, squared, deviation = compare(reference, mine, pixels)
                low, high = squared - 2 * deviation, squared + 2 * deviation
                bias = f"{100 * math.sqrt(squared):.1f} %" if low > 0 else f"below {100 * math.sqrt(max(0.0, high)):.1f} %"
                print(f"| {one} | {width:g} | {100 * level:+.1f} ± {100 * error:.1f} % | {bias} | {work / cost:.2f} |", flush=True)


if __name__ == "__main__":
    main()
