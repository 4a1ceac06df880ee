#!/usr/bin/env python3
"""Measures what scenes cost to load, and animations from one frame to the next.

  load_time.py PROGRAM [PROGRAM ...] [--only nodes|quads|frames ...] [--quads N] [--frames N]

Scenes are made in a temporary folder: `nodes`, 10,000 nodes with a mesh each, of which one moves; `quads`, one node that moves, and a
grid of N quads (4 million) that stands still; `frames`, 200 nodes with a mesh of 5,000 quads each, of which one has moving morph
weights. Each is rendered in 8 x 6 pixels at one sample: one frame, and the whole sequence (81 frames; nine of `quads`), without and
with an open shutter. A row tells the CPU seconds of the first frame's load, by --stats, and the CPU seconds of the program for each
frame after the first: a pose, what it changes in the delegate, a picture. Programs take turns; a number is the least of three.
"""
import argparse
import array
import json
import os
import pathlib
import resource
import struct
import subprocess
import tempfile


class Glb:
    """A glTF document with one buffer."""

    def __init__(self):
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "accessors": [],
                     "bufferViews": [], "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}]}
        self.data = bytearray()

    def add(self, code, values, kind):
        values, width = array.array(code, values), {"SCALAR": 1, "VEC3": 3}[kind]
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(values) * 4})
        self.data += values.tobytes()
        accessor = {"bufferView": len(self.json["bufferViews"]) - 1, "componentType": {"f": 5126, "I": 5125}[code],
                    "count": len(values) // width, "type": kind}
        if kind == "VEC3":
            accessor.update(min=[min(values[i::3]) for i in range(3)], max=[max(values[i::3]) for i in range(3)])
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def node(self, **node):
        self.json["nodes"].append(node)
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)

    def mesh(self, primitive):
        self.json["meshes"].append({"primitives": [primitive]})
        return len(self.json["meshes"]) - 1

    def animate(self, node, path, times, values):
        sampler = {"input": self.add("f", times, "SCALAR"), "output": self.add("f", values, "SCALAR" if path == "weights" else "VEC3")}
        self.json["animations"] = [{"samplers": [sampler], "channels": [{"sampler": 0, "target": {"node": node, "path": path}}]}]

    def write(self, file):
        self.json["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(self.data), 0x004E4942) + self.data
        file.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)


def grid(quads, size):
    """Points and triangles of a square grid of about so many quads, two triangles each."""
    n = max(round(quads**0.5), 1)
    points, indices = array.array("f"), array.array("I")
    for y in range(n + 1):
        for x in range(n + 1):
            points.extend((size * x / n, size * y / n, 0))
    for y in range(n):
        for a in range(y * (n + 1), y * (n + 1) + n):
            indices.extend((a, a + 1, a + n + 2, a, a + n + 2, a + n + 1))
    return points, indices


def add_grid(glb, quads, size):
    points, indices = grid(quads, size)
    return {"attributes": {"POSITION": glb.add("f", points, "VEC3")}, "indices": glb.add("I", indices, "SCALAR")}, len(points) // 3


def make(name, quads, file):
    glb = Glb()
    glb.node(camera=0, translation=[5, 5, 20])
    if name == "quads":
        glb.node(mesh=glb.mesh(add_grid(glb, 1, 1)[0]))
        glb.node(mesh=glb.mesh(add_grid(glb, quads, 10)[0]))
        glb.animate(1, "translation", [0, 4], [0, 0, 1, 8, 8, 1])
    elif name == "nodes":
        primitive, _ = add_grid(glb, 1, 0.08)
        for i in range(10000):
            glb.node(mesh=glb.mesh(primitive), translation=[0.1 * (i % 100), 0.1 * (i // 100), 0])
        glb.animate(1, "translation", [0, 4], [0, 0, 1, 8, 8, 1])
    else:
        primitive, points = add_grid(glb, 5000, 0.7)
        for i in range(200):
            glb.node(mesh=glb.mesh(dict(primitive)), translation=[0.7 * (i % 15), 0.7 * (i // 15), 0])
        target = glb.add("f", [0, 0, 1] * points, "VEC3")
        glb.json["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": target}]
        glb.animate(1, "weights", [0, 4], [0, 3])
    glb.write(file)


def cpu_seconds(command, folder):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(program, scene, frames, shutter, folder):
    """CPU seconds of the first load, and of each further frame."""
    def run(last):
        command = [program, "render", scene, "--quiet", "--size", "8x6", "--spp", "1", "--threads", "1", "--frames", f"0:{last}",
                   "--shutter", shutter, "-o", "f.####.exr", "--stats", "stats.json"]
        return cpu_seconds(command, folder), json.loads((folder / "stats.json").read_text())["phases"]["load"]["cpu"]
    one, load = run(0)
    return load, (run(frames - 1)[0] - one) / (frames - 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", nargs="+")
    parser.add_argument("--only", action="append", choices=("nodes", "quads", "frames"))
    parser.add_argument("--quads", type=int, default=4000000)
    parser.add_argument("--frames", type=int, default=81)
    a = parser.parse_args()
    print("| scene | shutter | program | load, CPU s | each further frame, CPU s |\n| --- | --- | --- | --- | --- |")
    for name in a.only or ("nodes", "quads", "frames"):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            make(name, a.quads, folder / "scene.glb")
            for shutter in ("0:0", "0:0.5"):
                best = {}
                for _ in range(3):
                    for program in a.programs:
                        found = measure(os.path.abspath(program), "scene.glb", 9 if name == "quads" else a.frames, shutter, folder)
                        best[program] = tuple(map(min, best.get(program, found), found))
                for program in a.programs:
                    load, frame = best[program]
                    print(f"| {name} | {shutter} | {program} | {load:.3f} | {frame:.4f} |", flush=True)


if __name__ == "__main__":
    main()
