#!/usr/bin/env python3
"""Measures what the filtering of textures (setting textureFilter) gains, how far it is off, and what textureMemory costs.

  texture_filter.py PROGRAM [--size WxH] [--spp N] [--seeds N] [--texels N] [--copies N] [--filter W ...] [--memory MIB ...]

The scene is made here: a wide floor, a mirror and a white ball, and a wall, under a dome: without caustics, whose noise is another matter. Floor and wall
show bricks with grain in every texel, in images of N x N texels, so that a pixel covers from one to many of them. `copies` images of
other bricks lie on parts of the floor. Every width of the filter is rendered with several seeds. `noise` is the relative root mean
squared error of a picture over its seeds; `bias` is the relative root mean squared difference of the mean over seeds from an
unfiltered reference, without the noise of both; `level` is the mean of the whole picture over the reference's. `gain` is the
unfiltered noise squared times CPU seconds, over the filtered. `equal` tells what counts: the unfiltered picture has the error of the
filtered one, noise and bias, after so many times its samples. The reference has 8 times the samples of all seeds.
"""
import argparse
import json
import math
import pathlib
import random
import struct
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "statistical" / "calibration"), str(HERE.parent / "scenes")]
from compare_programs import environment  # noqa: E402
from gltf_writer import Document, Mesh  # noqa: E402
from pictures import Picture, Reference, read_exr  # noqa: E402

BRICK, COURSE, JOINT = 64, 32, 4  # texels


def bricks(file, texels, seed):
    """A TGA, because it needs no compression: bricks, and grain in each texel."""
    source = random.Random(seed)

    def grain(level, spread):
        return bytes(min(255, max(0, level + (i - 128) * spread // 128)) for i in range(256))

    joint = grain(40, 24)
    tables = [grain(source.randrange(70, 180), 60) for _ in range(64)]
    with open(file, "wb") as out:
        out.write(struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, texels, texels, 24, 0x20))
        choice = []
        for y in range(texels):
            if y % COURSE == 0:
                choice = [source.choice(tables) for _ in range(texels // BRICK + 2)]
            row, at = source.randbytes(3 * texels), 0
            if y % COURSE < JOINT:
                out.write(row.translate(joint))
                continue
            shift, parts, brick = BRICK // 2 * (y // COURSE % 2), [], 0
            while at < texels:
                end = min(texels, (brick + 1) * BRICK - shift)
                parts.append(row[3 * at:3 * min(end, at + JOINT)].translate(joint))
                parts.append(row[3 * min(end, at + JOINT):3 * end].translate(choice[brick]))
                at, brick = end, brick + 1
            out.write(b"".join(parts))


def rectangle(corners, tiles):
    mesh = Mesh()
    mesh.points = list(corners)
    mesh.quads, mesh.uvs = [[0, 1, 2, 3]], [[(0.0, 0.0), (tiles, 0.0), (tiles, tiles), (0.0, tiles)]]
    return mesh


def ball(radius, at):
    mesh, n = Mesh(), 48
    rows = [[tuple(c + radius * d for c, d in zip(at, (
        math.sin(math.pi * i / n) * math.cos(2 * math.pi * j / n), math.cos(math.pi * i / n),
        -math.sin(math.pi * i / n) * math.sin(2 * math.pi * j / n)))) for j in range(n)] for i in range(1, n)]
    mesh.add_grid(rows, closed_u=True, flip=True)
    return mesh


def write_scene(folder, texels, copies):
    document, materials = Document("texture_filter.py"), []
    for i in range(copies):
        bricks(folder / f"bricks{i}.tga", texels, i)
        name = f"bricks{i}"
        materials.append({"match": name, "set": {"baseColor": {"file": f"bricks{i}.tga"}, "roughness": 0.6}})
        material = document.add_material(name, {})
        left, right = (-12 + 24 * (i + k) / copies for k in (0, 1))
        floor = [(left, 0, 6), (right, 0, 6), (right, 0, -30), (left, 0, -30)]
        document.add_node(f"floor{i}", document.add_mesh(f"floor{i}", rectangle(floor, 4.0), material))
        wall = [(left, 0, -30), (right, 0, -30), (right, 9, -30), (left, 9, -30)]
        document.add_node(f"wall{i}", document.add_mesh(f"wall{i}", rectangle(wall, 2.0), material))
    mirror = document.add_material("mirror", {"metallic": 1.0, "roughness": 0.05})
    document.add_node("ball", document.add_mesh("ball", ball(1.0, (1.6, 1.0, 0)), mirror))
    white = document.add_material("white", {})
    document.add_node("matt", document.add_mesh("matt", ball(1.0, (-1.6, 1.0, 0)), white))
    document.write_glb(folder / "room.glb")
    (folder / "room.json").write_text(json.dumps({
        "gltf": [{"file": "room.glb"}], "materials": materials,
        "lights": [{"name": "sky", "type": "domeLight", "color": [0.8, 0.9, 1.0]}],
        "camera": {"lookAt": {"eye": [0, 2.2, 8], "target": [0, 1, 0]}, "focalLength": 28}}))


def render(arguments, folder, seed, spp, flags):
    """The picture and the statistics."""
    output, stats = folder / "picture.exr", folder / "stats.json"
    command = [arguments.program, "render", str(folder / "room.json"), "-o", str(output), "--quiet", "--stats", str(stats),
               "--size", arguments.size, "--spp", str(spp), "--seed", str(seed), "--threads", str(arguments.threads), *flags]
    done = subprocess.run(command, env=environment(arguments.program), capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\nended with {done.returncode}: {done.stderr}")
    return read_exr(output), json.loads(stats.read_text())


def mean_picture(parts):
    planes = [[sum(values) / len(parts) for values in zip(*(part.planes[c] for part in parts))] for c in range(3)]
    return Picture(parts[0].width, parts[0].height, planes)


def level(picture):
    return sum(sum(plane) for plane in picture.planes)


def measure_filters(arguments, folder):
    print(f"{arguments.texels} x {arguments.texels} texels, {arguments.copies} images, {arguments.size}, {arguments.spp} samples, "
          f"{arguments.seeds} seeds\n")
    spp = 8 * arguments.spp
    reference = Reference([render(arguments, folder, 1000 + seed, spp, [])[0] for seed in range(arguments.seeds)])
    print("| textureFilter | noise | bias | level | CPU s | peak MiB | gain | equal |\n|--|--|--|--|--|--|--|--|")
    plain = None
    for width in [0.0, *arguments.filter]:
        runs = [render(arguments, folder, seed, arguments.spp, ["--set", f"textureFilter={width}"])
                for seed in range(1, arguments.seeds + 1)]
        pictures = [picture for picture, _ in runs]
        seconds = sum(stats["delegate"][0]["phase.render.cpu"] for _, stats in runs)
        mine = Reference(pictures)
        noise2 = arguments.seeds * sum(sum(v / s for v, s in zip(variance, reference.scales)) for variance in mine.variance) / (
            3 * len(reference.scales))
        bias2 = reference.squared_error(mean_picture(pictures)) - noise2 / arguments.seeds
        plain = plain or (noise2, seconds)
        print(f"| {width:g} | {math.sqrt(noise2):.4f} | {math.copysign(math.sqrt(abs(bias2)), bias2):.4f} | "
              f"{level(mean_picture(pictures)) / level(reference):.4f} | {seconds:.2f} | {runs[0][1]['peakMemory'] / 2**20:.0f} | "
              f"{plain[0] * plain[1] / (noise2 * seconds):.2f} | {plain[0] / (noise2 + max(bias2, 0)):.2f} |", flush=True)


def measure_memory(arguments, folder):
    print("\n| textureMemory | textureFilter | CPU s | wall s | peak MiB | bytes |\n|--|--|--|--|--|--|")
    first = {}
    for width in [0.0, *arguments.filter[-1:]]:
        for memory in arguments.memory:
            picture, stats = render(arguments, folder, 1, arguments.spp,
                                    ["--set", f"textureFilter={width}", "--texture-memory", str(memory)])
            same = first.setdefault(width, picture.planes) == picture.planes
            frame = stats["delegate"][0]
            print(f"| {memory} | {width:g} | {frame['phase.render.cpu']:.2f} | {frame['phase.render.wall']:.2f} | "
                  f"{stats['peakMemory'] / 2**20:.0f} | {'same' if same else 'OTHER'} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--size", default="240x160")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--texels", type=int, default=4096)
    parser.add_argument("--copies", type=int, default=2)
    parser.add_argument("--filter", type=float, nargs="*", default=[0.5, 1.0])
    parser.add_argument("--memory", type=int, nargs="*", default=[4096, 64, 16, 1])
    arguments = parser.parse_args()
    if arguments.seeds < 2:
        parser.error("--seeds must be 2 or more: noise is the difference between seeds")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_scene(folder, arguments.texels, arguments.copies)
        if arguments.filter:
            measure_filters(arguments, folder)
        if arguments.memory:
            measure_memory(arguments, folder)


if __name__ == "__main__":
    main()
