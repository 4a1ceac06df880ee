#!/usr/bin/env python3
"""Measures how runs end that ask for more than --memory-limit, and the most memory that they had resident.

  memory_limit.py PROGRAM [--only NAME ...] [--limits MIB ...] [--faults FOLDER]

Scenes are made in a temporary folder, each for one use of memory; those of FOLDER are rendered besides. Peak: the process's
maximum resident set. It may exceed the limit by SLACK: the program and its libraries, of which OpenImageIO's alone are 100 MiB,
the stacks of threads, and what malloc keeps. Exits with 1 if a run exceeds that, or ends in another way than with a picture or
an error that names the limit.
"""
import argparse
import json
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import zlib

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from compare_programs import environment  # noqa: E402
from growth import CAMERA, KEY, SKY, smooth, translucent, write_sphere  # noqa: E402

SLACK = 192  # MiB


def write_png(path, width, height):
    """A black image of bytes."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    packer, packed, row = zlib.compressobj(9), [], bytes(1 + 3 * width)
    for _ in range(height):
        packed.append(packer.compress(row))
    packed.append(packer.flush())
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
                     chunk(b"IDAT", b"".join(packed)) + chunk(b"IEND", b""))


def description(folder, copies=1, material=None, lights=(KEY,), meshes=()):
    write_sphere(folder)
    models = [{"file": "ball.gltf", "transform": {"translate": [2.5 * i, 0, 0]}} for i in range(copies)]
    return {"gltf": models, "materials": [material] if material else [], "meshes": list(meshes), "lights": list(lights), "camera": CAMERA}


def textured(file):
    return {"match": "body", "set": {"baseColor": {"file": file}}}


def image(folder, width, height):
    write_png(folder / "image.png", width, height)
    return description(folder, material=textured("image.png"))


def dome(folder):
    write_png(folder / "sky.png", 8192, 4096)
    return description(folder, lights=[{**SKY, "texture:file": "sky.png"}])


def zeros(folder):
    """One accessor without data for 100 primitives."""
    primitive = {"attributes": {"POSITION": 0}}
    gltf = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "accessors": [{"componentType": 5126, "type": "VEC3", "count": 1300000}], "meshes": [{"primitives": [primitive] * 100}]}
    (folder / "zeros.gltf").write_text(json.dumps(gltf))
    return "zeros.gltf"


def extras(folder):
    (folder / "extras.gltf").write_text('{"asset":{"version":"2.0"},"extras":[' + ",".join(['{"":0}'] * 4500000) + "]}")
    return "extras.gltf"


def values(folder):
    (folder / "values.json").write_text('{"gltf":[' + ",".join(['{"":0}'] * 4000000) + "]}")
    return "values.json"


FINE = (smooth(8),)  # of the sphere: 5.2e6 triangles and an interior
SMALL = ["--size", "64x48", "--spp", "1"]
SCENES = {
    "a sphere": (lambda f: description(f, material=translucent(0.1), meshes=(smooth(3),)), SMALL),
    "a JSON of 9e6 values in extras": (extras, SMALL),
    "a description of 8e6 values": (values, SMALL),
    "100 primitives over one accessor of zeros": (zeros, SMALL),
    "a sphere of 3.1e7 triangles": (lambda f: description(f, material=translucent(0.1), meshes=FINE), SMALL),
    "six spheres of 4.9e5 triangles that scatter": (lambda f: description(f, 6, translucent(0.1), meshes=(smooth(5),)), SMALL),
    "60 spheres of 1.2e5 triangles": (lambda f: description(f, 60, meshes=(smooth(4),)), SMALL),
    "an image of 16384 x 16384": (lambda f: image(f, 16384, 16384), SMALL),
    "an image of 1000000 x 16": (lambda f: image(f, 1000000, 16), SMALL),
    "a dome of 8192 x 4096": (dome, SMALL),
    "a frame of 4096 x 4096": (lambda f: description(f), ["--size", "4096x4096", "--spp", "1"]),
}


def run(program, scene, limit, flags, folder):
    """Exit code, errors, peak in MiB."""
    command = [program, "render", str(scene), "-o", str(folder / "picture.exr"), "--quiet", "--memory-limit", str(limit), *flags]
    with open(folder / "errors.txt", "w+") as errors:
        process = subprocess.Popen(command, env=environment(program), stdout=errors, stderr=errors, cwd=folder)
        _, status, usage = os.wait4(process.pid, 0)
        errors.seek(0)
        return os.waitstatus_to_exitcode(status), errors.read(), usage.ru_maxrss / 1024


def row(name, limit, result):
    """The row, and whether it is as it should be."""
    code, errors, peak = result
    asked = re.search(r"needs (\d+) MiB more", errors)
    reason = next((line for line in errors.splitlines() if line.startswith("error:")), "")
    said = re.search(r"(a mesh of \d+ triangles|a hierarchy of triangles|an? (?:image|frame|scene) of [^n]*?(?=needs)|[^:/]*(?= needs))", reason)
    text = said.group(1).strip() if said and asked else re.sub(r"/\S*/", "", reason[7:])[:90]
    outcome = "done" if code == 0 else f"exit {code}: {text}"
    print(f"| {name} | {limit} | {asked.group(1) if asked else ''} | {outcome} | {peak:.0f} | {peak - limit:+.0f} |", flush=True)
    return peak <= limit + SLACK and code in (0, 3, 4) and (code == 0) == (not reason)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--limits", nargs="*", type=int, default=[256, 512, 1024])
    parser.add_argument("--faults", type=pathlib.Path)
    a = parser.parse_args()
    print(f"Slack: {SLACK} MiB\n\n| scene | limit, MiB | more asked, MiB | outcome | peak, MiB | over the limit |\n|--|--|--|--|--|--|")
    good = True
    for name, (make, flags) in SCENES.items():
        if a.only and not any(part in name for part in a.only):
            continue
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            scene = make(folder)
            if isinstance(scene, dict):
                (folder / "scene.json").write_text(json.dumps(scene))
                scene = "scene.json"
            for limit in a.limits:
                good &= row(name, limit, run(a.program, scene, limit, flags, folder))
    for scene in sorted(a.faults.glob("F03*.*f")) + sorted(a.faults.glob("F03*.json")) if a.faults else []:
        with tempfile.TemporaryDirectory() as temporary:
            good &= row(scene.name, 512, run(a.program, scene.resolve(), 512, SMALL, pathlib.Path(temporary)))
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
