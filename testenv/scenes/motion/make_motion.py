#!/usr/bin/env python3
"""Makes motion.glb: a wax ball in flight, a jelly that shakes, a windmill that turns, and small lamps far behind them.

One animation moves all three: a translation with a rotation, a morph target, a rotation. Metres, y up.
Run: python3 testenv/scenes/motion/make_motion.py [output.glb]
"""
import math
import pathlib
import struct
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from gltf_writer import Document, Mesh  # noqa: E402
from shapes import backdrop, box, cube_sphere, placed  # noqa: E402

SECONDS = 1.0


def floats(doc, values, kind):
    """An accessor of rows of floats."""
    rows = [v if isinstance(v, (list, tuple)) else (v,) for v in values]
    packed = b"".join(struct.pack("<%df" % len(r), *r) for r in rows)
    read = [struct.unpack_from("<%df" % len(rows[0]), packed, 4 * len(rows[0]) * i) for i in range(len(rows))]
    bounds = ([min(r[c] for r in read) for c in range(len(rows[0]))], [max(r[c] for r in read) for c in range(len(rows[0]))])
    return doc._accessor(doc._view(packed), 5126, kind, len(rows), bounds)


def animate(doc, node, path, keys, kind):
    """Keys (time, value), linear in between."""
    animation = doc.json.setdefault("animations", [{"name": "all", "channels": [], "samplers": []}])[0]
    animation["samplers"].append({"input": floats(doc, [t for t, _ in keys], "SCALAR"),
                                  "output": floats(doc, [v for _, v in keys], kind)})
    animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": {"node": node, "path": path}})


def add_morph(doc, mesh, offset_of):
    """A morph target that moves each point by offset_of(point)."""
    primitive = doc.json["meshes"][mesh]["primitives"][0]
    accessor = doc.json["accessors"][primitive["attributes"]["POSITION"]]
    start = doc.json["bufferViews"][accessor["bufferView"]]["byteOffset"]
    points = [struct.unpack_from("<3f", doc.binary, start + 12 * i) for i in range(accessor["count"])]
    primitive["targets"] = [{"POSITION": floats(doc, [offset_of(p) for p in points], "VEC3")}]
    doc.json["meshes"][mesh]["weights"] = [0.0]


def moving_node(doc, name, mesh, at):
    doc.add_node(name, mesh)
    doc.json["nodes"][-1]["translation"] = list(at)
    return len(doc.json["nodes"]) - 1


def about_z(degrees):
    a = math.radians(degrees) / 2
    return (0.0, 0.0, math.sin(a), math.cos(a))


def windmill():
    """Four arms about the z axis."""
    mesh, arm = Mesh(), box(0.035, 0.13, 0.012, 0.004)
    for k in range(4):
        c, s, first = math.cos(k * math.pi / 2), math.sin(k * math.pi / 2), len(mesh.points)
        mesh.points += [(c * x - s * (y + 0.02), s * x + c * (y + 0.02), z) for x, y, z in arm.points]
        mesh.quads += [[first + i for i in quad] for quad in arm.quads]
        mesh.uvs += arm.uvs
    return mesh


def build(path):
    doc = Document("make_motion.py")
    chalk = doc.add_material("chalk", {"baseColor": [0.6, 0.6, 0.6], "roughness": 0.8})
    wax = doc.add_material("wax", {"baseColor": [0.95, 0.75, 0.45], "roughness": 0.35,
                                   "scatterDistance": [0.016, 0.008, 0.003]})
    jelly = doc.add_material("jelly", {"baseColor": [0.95, 0.25, 0.2], "roughness": 0.12,
                                       "scatterDistance": [0.03, 0.004, 0.003]})
    paint = doc.add_material("paint", {"baseColor": [0.1, 0.3, 0.6], "roughness": 0.25})
    lamp = doc.add_material("lamp", {"baseColor": [0.0, 0.0, 0.0], "emission": [60.0, 45.0, 25.0]})
    doc.add_node("backdrop", doc.add_mesh("backdrop", backdrop(), chalk))

    dimpled = cube_sphere(6, lambda d: tuple(0.07 * (1 - 0.12 * max(0.0, d[0]) ** 4) * c for c in d))
    ball = moving_node(doc, "ball", doc.add_mesh("ball", dimpled, wax), (-0.4, 0.25, 0.0))
    flight = [(t * SECONDS / 8, (-0.62 + 0.088 * t, 0.12 + 0.40 * (t / 8) * (1 - t / 8) * 4 * 0.4, 0.06)) for t in range(9)]
    animate(doc, ball, "translation", flight, "VEC3")
    animate(doc, ball, "rotation", [(t * SECONDS / 8, about_z(-50 * t)) for t in range(9)], "VEC4")

    block = doc.add_mesh("jelly", cube_sphere(4, lambda d: (0.09 * d[0], 0.1 + 0.09 * d[1], 0.09 * d[2])), jelly)
    add_morph(doc, block, lambda p: (0.9 * (p[1] - 0.01), 0.0, 0.0))
    shaken = moving_node(doc, "jelly", block, (0.1, 0.0, 0.1))
    animate(doc, shaken, "weights", [(t * SECONDS / 8, (-1) ** t * 0.45) for t in range(9)], "SCALAR")

    mill = moving_node(doc, "windmill", doc.add_mesh("windmill", windmill(), paint), (0.42, 0.24, -0.05))
    animate(doc, mill, "rotation", [(t * SECONDS / 8, about_z(130 * t)) for t in range(9)], "VEC4")
    doc.add_node("post", doc.add_mesh("post", box(0.02, 0.24, 0.02, 0.003), paint), placed(at=(0.42, 0.0, -0.08)))

    bulb = doc.add_mesh("lamp", cube_sphere(2, lambda d: tuple(0.004 * c for c in d)), lamp)
    for i in range(5):
        doc.add_node("lamp%d" % i, bulb, placed(at=(-0.5 + 0.22 * i, 0.5 + 0.06 * (i % 2), -0.55)))
    doc.write_glb(path)


if __name__ == "__main__":
    build(sys.argv[1] if len(sys.argv) > 1 else HERE / "motion.glb")
