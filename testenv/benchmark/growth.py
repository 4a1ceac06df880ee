#!/usr/bin/env python3
"""Measures how cost and memory grow with the size of a scene and of its picture.

  growth.py PROGRAM [--most-triangles N] [--only triangles|instances|lights|pixels|threads ...]
  growth.py PROGRAM --noise     the noise of many lights, as relative mean squared error x CPU seconds of the render phase

Scenes are made in a temporary folder. Triangles: one translucent sphere, subdivided. Instances: translucent spheres in a cubic
lattice of fixed size. Lights: rect lights in a square of fixed size and power, above a diffuse sphere. Pixels: the diffuse
sphere. Threads: 1, 2, 4 and so on, up to those of the machine, for the translucent sphere and for hard_light, evenly sampled
and adaptively. CPU seconds are of all threads; those of the render phase are divided by the camera samples. A run may have 8
GiB; one that needs more is a row that says so.

--noise: disk lights of one power together, at random places above a floor with spheres. They face down, or anywhere. The
error is the variance over eight seeds, as noise_gain.py has it.
"""
import argparse
import array
import json
import math
import os
import pathlib
import random
import resource
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from compare_programs import SCENES, environment  # noqa: E402

MOST_BYTES = 8 << 30


def icosphere(levels):
    """Points and triangles of a sphere of radius 1: 20 * 4^levels."""
    g = (1 + math.sqrt(5)) / 2
    points = [(x, y * g, 0) for x in (-1, 1) for y in (-1, 1)]
    points += [(0, x, y * g) for x in (-1, 1) for y in (-1, 1)] + [(y * g, 0, x) for x in (-1, 1) for y in (-1, 1)]
    near = [[j for j in range(12) if i != j and math.dist(points[i], points[j]) < 2.1] for i in range(12)]
    triangles = []
    for i in range(12):
        for j in near[i]:
            for k in near[j]:
                if i < j and i < k and k in near[i]:
                    a, b, c = points[i], points[j], points[k]
                    u, v = [b[n] - a[n] for n in range(3)], [c[n] - a[n] for n in range(3)]
                    out = a[0] * (u[1] * v[2] - u[2] * v[1]) + a[1] * (u[2] * v[0] - u[0] * v[2]) + a[2] * (u[0] * v[1] - u[1] * v[0])
                    if out > 0:
                        triangles.append((i, j, k))
    for _ in range(levels):
        middles, finer = {}, []

        def middle(i, j):
            key = (min(i, j), max(i, j))
            if key not in middles:
                middles[key] = len(points)
                points.append(tuple((points[i][n] + points[j][n]) / 2 for n in range(3)))
            return middles[key]
        for i, j, k in triangles:
            a, b, c = middle(i, j), middle(j, k), middle(k, i)
            finer += [(i, a, c), (a, j, b), (c, b, k), (a, b, c)]
        triangles = finer
    return [tuple(x / math.hypot(*p) for x in p) for p in points], triangles


def write_sphere(folder, radius=1.0, places=([0, 0, 0],)):
    """A glTF file of a sphere of 320 triangles, with one instance at each place."""
    points, triangles = icosphere(2)
    arrays = [array.array("f", [radius * x for p in points for x in p]), array.array("I", [i for t in triangles for i in t]),
              array.array("f", [x for place in places for x in place])]
    data = b"".join(a.tobytes() for a in arrays)
    views, accessors, offset = [], [], 0
    for a, kind in zip(arrays, ("VEC3", "SCALAR", "VEC3")):
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": 4 * len(a)})
        accessors.append({"bufferView": len(views) - 1, "componentType": 5126 if a.typecode == "f" else 5125,
                          "count": len(a) // (3 if kind == "VEC3" else 1), "type": kind})
        offset += 4 * len(a)
    accessors[0].update({"min": [min(arrays[0][n::3]) for n in range(3)], "max": [max(arrays[0][n::3]) for n in range(3)]})
    instancing = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}}
    gltf = {"asset": {"version": "2.0"}, "extensionsUsed": list(instancing), "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "extensions": instancing}], "materials": [{"name": "body"}],
            "meshes": [{"name": "ball", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
            "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(data), "uri": "ball.bin"}]}
    (folder / "ball.bin").write_bytes(data)
    (folder / "ball.gltf").write_text(json.dumps(gltf))


CAMERA = {"lookAt": {"eye": [0, 0.6, 3.6], "target": [0, 0, 0]}}
KEY = {"name": "key", "type": "rectLight", "position": [-3, 4, 3], "target": [0, 0, 0], "width": 2, "height": 2, "intensity": 8}
SKY = {"name": "sky", "type": "domeLight", "intensity": 0.5}
DIFFUSE = {"match": "body", "set": {"baseColor": [0.7, 0.7, 0.7], "roughness": 1}}


def translucent(distance):
    return {"match": "body", "set": {"baseColor": [0.8, 0.7, 0.6], "scatterDistance": [distance] * 3}}


def scene(material, lights, meshes=()):
    return {"gltf": [{"file": "ball.gltf"}], "materials": [material], "meshes": list(meshes), "lights": lights, "camera": CAMERA}


def smooth(level):
    return {"match": "*", "scheme": "catmullClark", "refineLevel": level}


def triangles_scene(folder, level):
    write_sphere(folder)
    return scene(translucent(0.1), [KEY, SKY], [smooth(level)])


def instances_scene(folder, side):
    step = 2 / side
    write_sphere(folder, 0.4 * step, [[(i + 0.5) * step - 1 for i in (x, y, z)]
                                      for x in range(side) for y in range(side) for z in range(side)])
    return scene(translucent(0.04 * step), [KEY, SKY])


def lights_scene(folder, side):
    write_sphere(folder)
    size = 4 / side
    lights = [{"name": f"l{x}_{z}", "type": "rectLight", "position": [(x + 0.5) * size - 2, 3, (z + 0.5) * size - 2],
               "target": [(x + 0.5) * size - 2, 0, (z + 0.5) * size - 2], "width": 0.8 * size, "height": 0.8 * size, "intensity": 3}
              for x in range(side) for z in range(side)]
    return scene(DIFFUSE, lights, [smooth(3)])


def pixels_scene(folder, _):
    write_sphere(folder)
    return scene(DIFFUSE, [SKY], [smooth(3)])


def threads_scene(folder, _):
    write_sphere(folder)
    return scene(translucent(0.1), [KEY, SKY], [smooth(4)])


def bundled_scene(name):
    """Makes nothing: the file of a bundled scene."""
    return lambda folder, _: SCENES / name / f"{name}.json"


def noise_scene(folder, count, anywhere):
    """Lights above a floor of 16 x 16 with 25 spheres."""
    write_sphere(folder, 0.5, [[3 * x, 0.5, 3 * z] for x in range(-2, 3) for z in range(-2, 3)])
    rng, lights = random.Random(7), []
    for i in range(count):
        place = [rng.uniform(-8, 8), rng.uniform(1.2, 4), rng.uniform(-8, 8)]
        towards = [rng.gauss(0, 1) for _ in range(3)] if anywhere else [0, -1, 0]
        lights.append({"name": f"l{i}", "type": "diskLight", "position": place, "target": [p + t for p, t in zip(place, towards)],
                       "radius": 0.05, "normalize": True, "intensity": 1500 / count})
    description = scene(DIFFUSE, lights, [smooth(1)])
    description["gltf"].append({"file": "ball.gltf", "transform": {"scale": [16, 0.001, 16]}})
    return description | {"camera": {"lookAt": {"eye": [0, 6, 13], "target": [0, 0, 0]}}}


def noise_rows(program, seeds=8):
    """Relative mean squared error at 16 samples, CPU seconds of a picture, and their product."""
    from noise_gain import Side, read_exr
    print("| lights | facing | relative MSE | CPU s | product |\n|--|--|--|--|--|")
    for anywhere in (False, True):
        for count in (10, 100, 1000, 10000):
            side = Side()
            with tempfile.TemporaryDirectory() as name:
                folder = pathlib.Path(name)
                for seed in range(1, seeds + 1):
                    flags = ["--size", "96x64", "--spp", "16", "--threads", "1", "--set", f"seed={seed}"]
                    stats = measure(program, folder, noise_scene, (count, anywhere), flags)
                    side.pictures.append(read_exr(folder / "picture.exr"))
                    side.seconds += stats["phases"]["render"]["cpu"] / seeds
            errors = side.pixel_errors()
            error = sum(errors) / len(errors)
            print(f"| {count} | {'anywhere' if anywhere else 'down'} | {error:.4f} | {side.seconds:.2f} | {error * side.seconds:.4f} |",
                  flush=True)


# One row each: the quantity, its number, the scene and its argument, flags.
USUAL = ["--size", "160x120", "--spp", "8", "--threads", "1"]
ROWS = [("triangles", 320 * 6 * 4 ** (level - 1), triangles_scene, level, USUAL) for level in (2, 3, 5, 6, 7, 8)]
ROWS += [("instances", side ** 3, instances_scene, side, USUAL) for side in (1, 5, 10, 22, 46, 100)]
ROWS += [("lights", side * side, lights_scene, side, USUAL) for side in (1, 2, 3, 10, 32, 100)]
ROWS += [("pixels", w * h, pixels_scene, 0, ["--size", f"{w}x{h}", "--spp", "2", "--threads", "1"])
         for w, h in ((368, 276), (1152, 864), (2304, 1728), (4608, 3456))]
for name, make, flags in (("threads", threads_scene, ["--spp", "64"]),
                          ("threads, hard_light", bundled_scene("hard_light"), ["--spp", "16"]),
                          ("threads, adaptive", bundled_scene("hard_light"), ["--spp", "16", "--set", "adaptive=true"])):
    ROWS += [(name, n, make, 0, ["--size", "480x320", "--threads", str(n), *flags])
             for n in (1, 2, 4, 8, 16, 32, 64) if n <= len(os.sched_getaffinity(0))]


def measure(program, folder, make, argument, flags):
    """The statistics of one render, or None if it needs too much memory."""
    arguments = argument if isinstance(argument, tuple) else (argument,)
    file = make(folder, *arguments)
    if not isinstance(file, pathlib.Path):
        (folder / "scene.json").write_text(json.dumps(file))
        file = folder / "scene.json"
    command = [program, "render", str(file), "-o", str(folder / "picture.exr"), "--quiet", "--stats",
               str(folder / "stats.json"), *flags]
    done = subprocess.run(command, env=environment(program), capture_output=True, text=True,
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES)))
    if done.returncode != 0:
        print(f"{' '.join(command)}\nended with {done.returncode}: {done.stderr}", file=sys.stderr)
        return None
    return json.loads((folder / "stats.json").read_text())


def row(kind, number, stats):
    if not stats:
        return f"| {kind} | {number:.3g} | not within 8 GiB | | | | |"
    phases, samples = stats["phases"], stats["samples"]["total"]
    render = phases["render"]
    build = stats["delegate"][0]["phase.sync.cpu"]
    return (f"| {kind} | {number:.3g} | {1e6 * render['cpu'] / samples:.2f} | {1e6 * render['wall'] / samples:.2f} | "
            f"{phases['load']['cpu']:.2f} | {build:.2f} | {stats['peakMemory'] / 2 ** 20:.0f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--most-triangles", type=float, default=1e9)
    parser.add_argument("--noise", action="store_true")
    a = parser.parse_args()
    if a.noise:
        return noise_rows(a.program)
    print("| what grows | number | CPU us/sample | wall us/sample | load, CPU s | build, CPU s | peak MiB |")
    print("|--|--|--|--|--|--|--|")
    for kind, number, make, argument, flags in ROWS:
        if (a.only and kind.split(',')[0] not in a.only) or (kind == "triangles" and number > a.most_triangles):
            continue
        with tempfile.TemporaryDirectory() as folder:
            print(row(kind, number, measure(a.program, pathlib.Path(folder), make, argument, flags)), flush=True)


if __name__ == "__main__":
    main()
