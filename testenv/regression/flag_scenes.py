"""Scenes for flags_table.py: a glTF file with cameras, scenes, animations and variants, and descriptions of it."""
import json
import pathlib
import sys

from feature_scenes import WAX, ball, floats  # noqa: F401, sets the path of what follows

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scenes"))
from gltf_writer import Document, Mesh, png  # noqa: E402
from shapes import box, placed  # noqa: E402

# Two displays with two views each, and a look.
COLORS = """ocio_profile_version: 2
roles: {scene_linear: linear, default: linear}
file_rules: [!<Rule> {name: Default, colorspace: linear}]
displays:
  first:
    - !<View> {name: plain, colorspace: linear}
    - !<View> {name: dim, colorspace: half}
  second:
    - !<View> {name: plain, colorspace: quarter}
    - !<View> {name: dim, colorspace: eighth}
looks:
  - !<Look> {name: warm, process_space: linear, transform: !<CDLTransform> {slope: [1, 0.5, 0.2]}}
colorspaces:
  - !<ColorSpace> {name: linear}
  - !<ColorSpace> {name: half, from_scene_reference: !<CDLTransform> {slope: [0.5, 0.5, 0.5]}}
  - !<ColorSpace> {name: quarter, from_scene_reference: !<CDLTransform> {slope: [0.25, 0.25, 0.25]}}
  - !<ColorSpace> {name: eighth, from_scene_reference: !<CDLTransform> {slope: [0.125, 0.125, 0.125]}}
"""


def add_animation(doc, name, node, to):
    keys, values = floats(doc, [0.0, 1.0], "SCALAR"), floats(doc, [(0.0, 0.5, 0.0), to], "VEC3")
    doc.json.setdefault("animations", []).append(
        {"name": name, "samplers": [{"input": keys, "output": values}], "channels": [{"sampler": 0, "target": {"node": node, "path": "translation"}}]})


def add_camera(doc, name, at):
    doc.json.setdefault("cameras", []).append({"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.01, "aspectRatio": 1.5}})
    doc.json["nodes"].append({"name": name, "camera": len(doc.json["cameras"]) - 1, "translation": at})
    return len(doc.json["nodes"]) - 1


def model(file):
    """A ball of wax, red or blue by variant, on a floor, which scene 1 lacks, and a box that is fine when refined."""
    doc = Document("flag_scenes.py")
    red, blue = (doc.add_material(name, {**WAX, "baseColor": color}) for name, color in (("red", [0.9, 0.2, 0.2]), ("blue", [0.2, 0.2, 0.9])))
    floor = Mesh()
    floor.add_grid([[(x, 0.0, z) for x in (-2.0, 2.0)] for z in (1.5, -2.0)])
    chalk = doc.add_material("chalk", {"baseColor": [0.6, 0.6, 0.6]})
    shape = doc.add_mesh("ball", ball(0.5), red)
    doc.add_node("ball", shape)
    doc.add_node("floor", doc.add_mesh("floor", floor, chalk))
    doc.add_node("box", doc.add_mesh("box", box(0.4, 0.4, 0.4, 0.05), chalk), placed(at=(-1.0, 0.0, 0.3)))
    doc.json["nodes"][0]["translation"] = [0.0, 0.5, 0.0]
    for extension in ("KHR_materials_variants",):
        doc.use(extension)
    doc.json["extensions"] = {"KHR_materials_variants": {"variants": [{"name": "warm"}, {"name": "cold"}]}}
    doc.json["meshes"][shape]["primitives"][0]["extensions"]["KHR_materials_variants"] = {
        "mappings": [{"material": red, "variants": [0]}, {"material": blue, "variants": [1]}]}
    add_animation(doc, "aside", 0, (1.0, 0.5, 0.0))
    add_animation(doc, "up", 0, (0.0, 1.2, 0.0))
    cameras = [add_camera(doc, "front", [0.0, 0.6, 4.0]), add_camera(doc, "near", [0.0, 0.8, 2.5])]
    doc.json["scenes"] = [{"name": "all", "nodes": [0, 1, 2, *cameras]}, {"name": "bare", "nodes": [0, *cameras]}]
    doc.write_glb(file)


def write_flag_scenes(folder):
    """Writes model.glb, and descriptions: inner/outside.json names a file outside of its folder, gap.json an image that is missing, bad_view.json
    a view that is none, broken.json an image that is none, heavy.json a mesh that takes long to build; colors.ocio."""
    folder = pathlib.Path(folder)
    model(folder / "model.glb")
    (folder / "colors.ocio").write_text(COLORS)
    (folder / "inner").mkdir()
    (folder / "broken.png").write_bytes(png(8, 8, lambda x, y: (0.5, 0.5, 0.5))[:60])
    files = {"inner/outside.json": {"gltf": [{"file": "../model.glb"}]},
             "gap.json": {"gltf": [{"file": "model.glb"}], "materials": [{"match": "chalk", "bump": {"file": "missing.png"}}]},
             "broken.json": {"gltf": [{"file": "model.glb"}], "materials": [{"match": "chalk", "bump": {"file": "broken.png"}}]},
             "bad_view.json": {"gltf": [{"file": "model.glb"}], "products": [{"file": "a.png", "view": "no such view"}]},
             "heavy.json": {"gltf": [{"file": "model.glb"}], "meshes": [{"match": "ball", "scheme": "catmullClark", "refineLevel": 8}]},
             "open.json": {"gltf": [{"file": "model.glb"}], "materials": [{"match": "chalk", "set": {"scatterDistance": [0.5, 0.5, 0.5]}}]}}
    for name, description in files.items():
        (folder / name).write_text(json.dumps(description))
