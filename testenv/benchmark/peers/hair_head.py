"""A head with 2,000 brow and lash curves over scattering skin, with ours and with Cycles 5.0.1: hair_head.py PROGRAM.

The head is a formula. Ours reads a stage of it, Cycles the same numbers. Prints CPU seconds, with the scene's preparation,
and how far the pictures' blocks are apart; both pictures stay in the work folder.
"""
import argparse
import json
import math
import os
import pathlib
import random
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import formulas  # noqa: E402

LOOKS = {"skin": {"baseColor": [0.85, 0.62, 0.5], "roughness": 0.45, "ior": 1.4, "metallic": 0.0, "scatterDistance": [0.6, 0.25, 0.12]},
         "hair": {"baseColor": [0.06, 0.035, 0.02], "roughness": 0.4, "ior": 1.5, "metallic": 0.0}}  # centimetres
CAMERA = {"focalLength": 50, "verticalAperture": 24, "lookAt": {"eye": [3, 3.5, 38], "target": [0, 2, 8]}}
LIGHTS = [{"name": "key", "type": "rectLight", "intensity": 12, "width": 16, "height": 16, "position": [22, 22, 34], "target": [0, 1, 8]},
          {"name": "sky", "type": "domeLight", "intensity": 0.35, "visibleToCamera": True}]
BUMPS = [((0, -0.12, 1), 2.3, 0.14), ((0, 0.1, 1), 0.9, 0.13), ((0, -0.62, 0.9), 0.8, 0.3),  # nose, its bridge, chin
         ((0.36, 0.12, 0.95), -0.9, 0.17), ((-0.36, 0.12, 0.95), -0.9, 0.17),              # eyes
         ((0.36, 0.34, 0.9), 0.35, 0.14), ((-0.36, 0.34, 0.9), 0.35, 0.14)]                # brows
ROWS, COLUMNS = 160, 320


def surface(azimuth, elevation):
    """0, 0 is the middle of the face, towards +z; y is up."""
    d = [math.cos(elevation) * math.sin(azimuth), math.sin(elevation), math.cos(elevation) * math.cos(azimuth)]
    radius = 1 / math.sqrt((d[0] / 7.6) ** 2 + (d[1] / 11) ** 2 + (d[2] / 9.4) ** 2)
    for center, height, width in BUMPS:
        apart = sum((a - b) ** 2 for a, b in zip(d, formulas.normalized(center)))
        radius += height * math.exp(-apart / (2 * width * width))
    return [c * radius for c in d]


def frame(azimuth, elevation):
    """The normal, and the directions of growing azimuth and elevation."""
    e = 1e-4
    along = [[b - a for a, b in zip(surface(azimuth - x, elevation - y), surface(azimuth + x, elevation + y))] for x, y in ((e, 0), (0, e))]
    return formulas.normalized(formulas.cross(*along)), *map(formulas.normalized, along)


def head():
    at = lambda row, column: (2 * math.pi * column / COLUMNS - math.pi, math.pi * (row / ROWS - 0.5))
    places = [(0, 1e-3 - math.pi / 2)] + [at(r, c) for r in range(1, ROWS) for c in range(COLUMNS)] + [(0, math.pi / 2 - 1e-3)]
    ring = lambda r, c: 1 + (r - 1) * COLUMNS + c % COLUMNS
    faces = [(ring(r, c), ring(r, c + 1), ring(r + 1, c + 1), ring(r + 1, c)) for r in range(1, ROWS - 1) for c in range(COLUMNS)]
    faces += [(0, ring(1, c + 1), ring(1, c)) for c in range(COLUMNS)]
    faces += [(len(places) - 1, ring(ROWS - 1, c), ring(ROWS - 1, c + 1)) for c in range(COLUMNS)]
    return {"points": [surface(*p) for p in places], "normals": [frame(*p)[0] for p in places], "faces": faces}


def hair():
    """1400 hairs of brows and 600 of lashes, of five points and as many radii; Catmull-Rom."""
    dice, curves, radii = random.Random(1), [], []

    def grow(azimuth, elevation, length, radius, weights, bend):
        root, axes = surface(azimuth, elevation), frame(azimuth, elevation)
        for step in range(5):
            t = step / 4
            w = [weights[0] * (t if bend else t * (1 - 0.6 * t)), weights[1] * t, weights[2] * t * (t if bend else 1)]
            curves.append([p + length * sum(k * axis[i] for k, axis in zip(w, axes)) for i, p in enumerate(root)])
            radii.append(radius * (1 - t))

    for side in (-1, 1):
        for _ in range(700):
            along = dice.random()
            grow(side * (0.14 + 0.44 * along), 0.32 + 0.09 * math.sin(math.pi * (0.2 + 0.7 * along)) + dice.gauss(0, 0.016),
                 dice.uniform(0.7, 1.2), 0.012, (0.5, side * (0.3 + 0.6 * along), 0.8 - 0.9 * along + dice.gauss(0, 0.15)), False)
        for i in range(300):
            turn, upper = dice.uniform(0.1, 0.9) * math.pi, i < 200
            grow(side * (0.36 - 0.15 * math.cos(turn)), 0.13 + (0.05 if upper else -0.06) * math.sin(turn),
                 dice.uniform(0.7, 1.0) * (1 if upper else 0.55), 0.01, (0.9, -0.3 * side * math.cos(turn), 0.7 if upper else -0.5), True)
    return {"points": curves, "radii": radii}


def write_stage(file, body, strands):
    text = lambda rows: ", ".join("(%s)" % ", ".join("%.7g" % c for c in row) for row in rows)
    plain = lambda row: ", ".join("%.7g" % c for c in row)

    def placed(position, target):
        return "matrix4d xformOp:transform = (%s)\n uniform token[] xformOpOrder = [\"xformOp:transform\"]" % text(
            [[*row, 0] for row in formulas.look_at(position, target)] + [[*position, 1]])
    looks = "".join("""def Material "%s" {
 token outputs:surface.connect = </World/%s/s.outputs:out>
 def Shader "s" { uniform token info:id = "AlabasterDisney"
%s token outputs:out
 }
}
""" % (name, name, "".join(" %s inputs:%s = %s\n" % (("color3f", k, text([v])) if isinstance(v, list) else ("float", k, v)) for k, v in look.items()))
        for name, look in LOOKS.items())
    key, sky, look = *LIGHTS, CAMERA["lookAt"]
    bound = '( prepend apiSchemas = ["MaterialBindingAPI"] ) { rel material:binding = </World/%s>'
    file.write_text("""#usda 1.0
( defaultPrim = "World"
 upAxis = "Y" )
def Xform "World" {
%s def Mesh "head" %s
 uniform token subdivisionScheme = "none"
 int[] faceVertexCounts = [%s]
 int[] faceVertexIndices = [%s]
 point3f[] points = [%s]
 normal3f[] normals = [%s] ( interpolation = "vertex" )
 }
 def BasisCurves "curves" %s
 uniform token type = "cubic"
 uniform token basis = "catmullRom"
 uniform token wrap = "pinned"
 int[] curveVertexCounts = [%s]
 point3f[] points = [%s]
 float[] widths = [%s] ( interpolation = "vertex" )
 }
 def RectLight "key" { float inputs:intensity = %g
 float inputs:width = %g
 float inputs:height = %g
 %s
 }
 def DomeLight "sky" { float inputs:intensity = %g
 }
 def Camera "cam" { float focalLength = %g
 float horizontalAperture = %g
 float verticalAperture = %g
 %s
 }
}
""" % (looks, bound % "skin", plain(len(f) for f in body["faces"]), ", ".join(str(i) for f in body["faces"] for i in f), text(body["points"]),
       text(body["normals"]), bound % "hair", ", ".join(["5"] * (len(strands["points"]) // 5)), text(strands["points"]),
       plain(2 * r for r in strands["radii"]), key["intensity"], key["width"], key["height"], placed(key["position"], key["target"]),
       sky["intensity"], CAMERA["focalLength"], CAMERA["verticalAperture"], CAMERA["verticalAperture"], placed(look["eye"], look["target"])))


def in_cycles(job):
    import bpy
    import cycles_scene

    bpy.ops.wm.read_factory_settings(use_empty=True)
    looks = {name: cycles_scene.make_material(name, look) for name, look in LOOKS.items()}
    body, strands = job["body"], job["strands"]
    mesh = bpy.data.meshes.new("head")
    mesh.from_pydata(body["points"], [], body["faces"])
    mesh.normals_split_custom_set_from_vertices(body["normals"])
    curves = bpy.data.hair_curves.new("hair")
    curves.add_curves([5] * (len(strands["points"]) // 5))
    curves.attributes["position"].data.foreach_set("vector", [c for p in strands["points"] for c in p])
    (curves.attributes.get("radius") or curves.attributes.new("radius", "FLOAT", "POINT")).data.foreach_set("value", strands["radii"])
    bpy.context.scene.cycles_curves.shape = "THICK"
    for data, look in ((mesh, "skin"), (curves, "hair")):
        data.materials.append(looks[look])
        bpy.context.scene.collection.objects.link(bpy.data.objects.new(data.name, data))
    for light in LIGHTS:
        cycles_scene.make_light(light)
    cycles_scene.make_camera(CAMERA)
    cycles_scene.make_settings({**job, "adaptive": 0, "blurGlossy": 0.0}, {"maxDepth": 8})
    print("\nPEER " + json.dumps({"cpuSeconds": [cycles_scene.render(task) for task in job["renders"]]}), flush=True)


def main():
    if len(sys.argv) == 2 and sys.argv[1].endswith(".job.json"):
        return in_cycles(json.loads(pathlib.Path(sys.argv[1]).read_text()))
    import peers

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("--size", type=int, default=480)
    parser.add_argument("--samples", type=int, default=32)
    parser.add_argument("--work", type=pathlib.Path, default=peers.ROOT / "build" / "peers")
    options = parser.parse_args()
    work = options.work.resolve()
    work.mkdir(parents=True, exist_ok=True)
    body, strands = head(), hair()
    write_stage(work / "head.usda", body, strands)
    files = [work / "head_ours.exr", work / "head_cycles.exr"]
    subprocess.run([options.program, "render", work / "head.usda", "--size", f"{options.size}x{options.size}", "--spp", str(options.samples),
                    "--threads", "1", "--set", "filter=box", "--quiet", "-o", files[0]], check=True)
    usage = os.times()
    print(f"ours: {usage.children_user + usage.children_system:.1f} CPU s")
    cycles = peers.from_pypi("Cycles 5.0.1", "hair_head.py", peers.PACKAGES[0], work)
    seconds = cycles.render({"width": options.size, "height": options.size, "threads": 1, "body": body, "strands": strands,
                             "renders": [{"samples": options.samples, "seed": 0, "output": str(files[1])}]})
    print(f"Cycles: {seconds[0]:.1f} CPU s")
    pictures = [peers.read_exr(f) for f in files]
    for name, picture in zip(("ours", "Cycles"), pictures):
        print(name, "mean", *("%.4f" % (sum(plane) / len(plane)) for plane in picture.planes))
    blocks = [peers.block_means(p, peers.BLOCK).planes for p in pictures]
    square = sum((a - b) ** 2 for x, y in zip(*blocks) for a, b in zip(x, y))
    print("blocks of 8 pixels: RMS difference over RMS of Cycles %.4f" % math.sqrt(square / sum(b * b for y in blocks[1] for b in y)))
    return None


if __name__ == "__main__":
    main()
