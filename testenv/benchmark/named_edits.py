#!/usr/bin/env python3
"""Measures whether the time of scenes with many names is in proportion to their number.

  named_edits.py PROGRAM [--only KIND ...] [--counts N ...]

Scenes are made in a temporary folder, with N of each kind: edits of materials by name, edits of meshes by name that give a material, lights
that are added by name and then changed by name, lights that are linked to a mesh each by name, models of one file, an archive of one mesh
with N subsets, edits of these subsets by name, and products. Numbers are CPU seconds of `alabaster check`, and for `info` those of
`alabaster info` for the edits of materials. A scene that takes more than a minute ends its row.
"""
import argparse
import json
import os
import pathlib
import resource
import struct
import subprocess
import tempfile

LIMIT = 60


def triangles(n, folder):
    """N meshes of a triangle, each with a material and a node of its own."""
    points = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    (folder / "points.bin").write_bytes(points)
    document = {"asset": {"version": "2.0"}, "scenes": [{"nodes": list(range(n))}],
                "nodes": [{"mesh": i, "name": f"o{i}", "translation": [i % 100, i // 100, 0]} for i in range(n)],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": i}]} for i in range(n)],
                "materials": [{"name": f"m{i}", "pbrMetallicRoughness": {"roughnessFactor": i / n}} for i in range(n)],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
                "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "points.bin"}]}
    (folder / "model.gltf").write_text(json.dumps(document))
    return {"models": [{"file": "model.gltf"}]}


def strip(n, folder):
    """A mesh of N primitives that share their edges, which becomes one mesh with N subsets; two materials."""
    points, accessors = bytearray(), []
    for i in range(n):
        accessors.append({"bufferView": 0, "byteOffset": len(points), "componentType": 5126, "count": 3, "type": "VEC3",
                          "min": [i, 0, 0], "max": [i + 1, 1, 0]})
        a, b, c = (i, i % 2, 0), (i + 1, (i + 1) % 2, 0), (i, 1 - i % 2, 0)
        points += struct.pack("<9f", *a, *b, *c)
    (folder / "strip.bin").write_bytes(points)
    document = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "strip"}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": i}, "material": i % 2} for i in range(n)]}],
                "materials": [{"name": "a"}, {"name": "b"}], "accessors": accessors,
                "bufferViews": [{"buffer": 0, "byteLength": len(points)}], "buffers": [{"byteLength": len(points), "uri": "strip.bin"}]}
    (folder / "model.gltf").write_text(json.dumps(document))
    return {"models": [{"file": "model.gltf"}]}


def light(i, **more):
    return {"name": f"l{i}", "type": "sphereLight", "position": [i % 100, i // 100, 2], "intensity": 1, **more}


def make(kind, n, folder):
    if kind in ("archive", "subsets"):
        scene = strip(n, folder)
        if kind == "subsets":
            scene["meshes"] = [{"match": f"/gltf/model/nodes/0_strip/{i}", "material": "b"} for i in range(n)]
    elif kind == "models":
        triangles(1, folder)
        scene = {"models": [{"file": "model.gltf"}] * n}
    else:
        scene = triangles(1 if kind in ("lights", "products") else n, folder)
    if kind in ("materials", "info"):
        scene["materials"] = [{"match": f"m{i}", "set": {"roughness": 0.5}} for i in range(n)]
    if kind == "meshes":
        scene["meshes"] = [{"match": f"o{i}", "material": f"m{n - 1 - i}"} for i in range(n)]
    if kind == "lights":
        scene["lights"] = [light(i) for i in range(n)] + [{"match": f"l{i}", "intensity": 2} for i in range(n)]
    if kind == "links":
        scene["lights"] = [light(i, lightLink=[f"o{i}"]) for i in range(n)]
    if kind == "products":
        scene["products"] = [{"file": f"p{i}.exr"} for i in range(n)]
    (folder / "scene.json").write_text(json.dumps(scene))
    if kind != "archive":
        return "scene.json"
    return "scene.alab"


def measure(program, kind, n, folder):
    """CPU seconds, or None after the limit."""
    scene = make(kind, n, folder)
    limit = {"timeout": 2 * LIMIT, "cwd": folder, "check": True, "stdout": subprocess.DEVNULL}
    try:
        if kind == "archive":
            subprocess.run([program, "convert", "scene.json", "-o", scene], **limit)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([program, "info", scene] if kind == "info" else [program, "check", scene, "--quiet"], **limit)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    except (subprocess.TimeoutExpired, subprocess.CalledProcessError) as fault:
        return None if isinstance(fault, subprocess.TimeoutExpired) else float("nan")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    kinds = ("materials", "meshes", "lights", "links", "models", "archive", "subsets", "products", "info")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--only", nargs="+", default=kinds, choices=kinds)
    parser.add_argument("--counts", nargs="+", type=int, default=(1000, 4000, 16000, 64000))
    a = parser.parse_args()
    print("| kind |" + "".join(f" {n} |" for n in a.counts) + "\n| --- |" + " --- |" * len(a.counts))
    for kind in a.only:
        row, seconds = [], 0
        for n in a.counts:
            with tempfile.TemporaryDirectory() as folder:
                seconds = None if seconds is None else measure(os.path.abspath(a.program), kind, n, pathlib.Path(folder))
            row.append("-" if seconds is None else f"{seconds:.2f}")
            seconds = None if seconds is None or seconds > LIMIT else seconds
        print(f"| {kind} | " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    main()
