#!/usr/bin/env python3
"""Measures what the models of a folder cost to load: CPU seconds of reading and of building the scene, and peak memory.

  asset_load.py PROGRAM [PROGRAM ...] --assets FOLDER [--md FILE] [--shared]

Every .gltf and .glb below FOLDER/valid, FOLDER/sss and FOLDER/subdiv is rendered in 8 x 6 pixels at one sample without a studio. A number
is the least of two runs. Two programs take turns and give two columns each: before and after. --shared measures a made file instead, of
1000 meshes that share the accessors of one ball of 10,000 triangles, each mesh with a material of its own.
"""
import argparse
import json
import math
import os
import pathlib
import struct
import tempfile


def measure(program, model, folder):
    """(CPU seconds of the whole run, peak bytes)"""
    pid = os.fork()
    if pid == 0:
        with open(os.devnull, "w") as null:
            os.dup2(null.fileno(), 1)
            os.dup2(null.fileno(), 2)
        os.execv(program, [program, "render", str(model), "-o", f"{folder}/p.exr", "--size", "8x6", "--spp", "1", "--studio", "off"])
    _, status, usage = os.wait4(pid, 0)
    return None if status else (usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024)


def write_shared(folder, meshes=1000, rings=50, segments=100):
    """shared.gltf with its buffer."""
    points, triangles = [], []
    for ring in range(rings + 1):
        for segment in range(segments + 1):
            up, around = math.pi * ring / rings, 2 * math.pi * segment / segments
            points.append((math.sin(up) * math.cos(around), math.cos(up), math.sin(up) * math.sin(around)))
    for ring in range(rings):
        for a in range(ring * (segments + 1), ring * (segments + 1) + segments):
            triangles += [(a, a + 1, a + segments + 1), (a + 1, a + segments + 2, a + segments + 1)]
    positions = b"".join(struct.pack("<3f", *p) for p in points)
    indices = b"".join(struct.pack("<3H", *t) for t in triangles)
    (folder / "shared.bin").write_bytes(positions + indices)
    primitive = {"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1}
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(meshes + 1))}],
        "nodes": [*({"mesh": m, "translation": [3 * (m % 32), 3 * (m // 32), 0]} for m in range(meshes)),
                  {"camera": 0, "translation": [48, 48, 150]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": .1}}],  # else framing looks at all points
        "meshes": [{"primitives": [{**primitive, "material": m}]} for m in range(meshes)],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [m / meshes, .5, .5, 1]}} for m in range(meshes)],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3", "min": [-1] * 3, "max": [1] * 3},
                      {"bufferView": 1, "componentType": 5123, "count": 3 * len(triangles), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(positions)}, {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)}],
        "buffers": [{"uri": "shared.bin", "byteLength": len(positions) + len(indices)}]}
    (folder / "shared.gltf").write_text(json.dumps(document))
    return folder / "shared.gltf"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", nargs="+")
    parser.add_argument("--assets", type=pathlib.Path)
    parser.add_argument("--md", type=pathlib.Path)
    parser.add_argument("--shared", action="store_true")
    options = parser.parse_args()
    if bool(options.assets) == options.shared:
        parser.error("give --assets FOLDER or --shared")
    models = [] if options.shared else sorted(f for part in ("valid", "sss", "subdiv") for f in (options.assets / part).rglob("*.gl*") if f.suffix in (".gltf", ".glb"))
    head = "| file |" + "".join(f" CPU s {k} | MB {k} |" for k in range(1, len(options.programs) + 1)).replace(" 1 |", " |" if len(options.programs) == 1 else " 1 |")
    rows, totals = [head, "| --- |" + " --- | --- |" * len(options.programs)], [[0, 0] for _ in options.programs]
    with tempfile.TemporaryDirectory() as folder:
        if options.shared:
            models = [write_shared(pathlib.Path(folder))]
        for model in models:
            best = [None] * len(options.programs)
            for _ in range(2):
                for k, program in enumerate(options.programs):
                    got = measure(program, model, folder)
                    if got:
                        best[k] = got if best[k] is None else tuple(map(min, best[k], got))
            cells = ""
            for k, one in enumerate(best):
                cells += f" {one[0]:.2f} | {one[1] / 1e6:.0f} |" if one else " refused | - |"
                if all(best):  # a file that one program refuses is in no sum
                    totals[k] = [totals[k][0] + one[0], max(totals[k][1], one[1])]
            rows.append(f"| {model.name if options.shared else model.relative_to(options.assets)} |{cells}")
            print(rows[-1], flush=True)
    rows.append("| sum, largest |" + "".join(f" {t:.2f} | {m / 1e6:.0f} |" for t, m in totals))
    if len(totals) > 1:
        rows.append("| ratio to the first |" + "".join(f" {t / totals[0][0]:.2f} | {m / totals[0][1]:.2f} |" for t, m in totals))
    print("\n".join(rows[-2:]))
    if options.md:
        options.md.write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
