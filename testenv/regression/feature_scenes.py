"""Small scenes, each with a feature that the bundled scenes lack. Standard library only.

  feature_scenes.py FOLDER      writes them to FOLDER/NAME/

SCENES lists them. A scene's function fills a Draft: meshes as glTF, and the rest as a render description.
"""
import json
import math
import pathlib
import random
import struct
import sys

SCRIPTS = pathlib.Path(__file__).resolve().parents[1] / "scenes"
sys.path.insert(0, str(SCRIPTS))
sys.path.insert(0, str(SCRIPTS / "motion"))
from gltf_writer import Document, Mesh, png  # noqa: E402
from images import write_hdr  # noqa: E402
from make_motion import about_z, add_morph, animate, floats, moving_node  # noqa: E402
from shapes import box, cube_sphere, placed  # noqa: E402

WAX = {"baseColor": [0.9, 0.6, 0.35], "roughness": 0.4, "scatterDistance": [0.3, 0.15, 0.08]}
GLASS = {"baseColor": [1.0, 1.0, 1.0], "roughness": 0.0, "specTrans": 1.0}
CLOUDY = {**WAX, "specTrans": 0.5}  # a clear boundary and lobes that scatter, at the same surface
MARBLE = {"baseColor": [0.85, 0.7, 0.5], "roughness": 0.3, "scatterDistance": [0.004, 0.003, 0.002]}
KEY = {"name": "key", "type": "rectLight", "width": 1.5, "height": 1.5, "intensity": 8, "position": [-2, 3, 2], "target": [0, 0.3, 0]}
SKY = {"name": "sky", "type": "domeLight", "intensity": 0.3}


class Draft:
    """A floor, a camera at eye height, and what a scene adds."""

    def __init__(self, name, folder):
        self.name, self.folder = name, folder
        self.doc = Document("feature_scenes.py")
        self.json = {"gltf": [{"file": name + ".glb", "refineLevel": 1}], "lights": [KEY, SKY],
                     "camera": {"lookAt": {"eye": [0, 1.0, 4.0], "target": [0, 0.45, 0]}, "focalLength": 50},
                     "settings": {"samples": 4, "resolution": [32, 24]}}
        floor = Mesh()
        floor.add_grid([[(x, 0.0, z) for x in (-2.0, 2.0)] for z in (1.5, -2.0)], uv_of=lambda i, j: (j, i))
        self.add("floor", floor, {"baseColor": [0.5, 0.5, 0.45], "roughness": 0.7})

    def add(self, name, mesh, disney, at=None, **textures):
        """The index of a new mesh, which a node shows at `at`, if given; the floor stays where it is."""
        material = self.doc.add_material(name, disney, **textures)
        index = self.doc.add_mesh(name, mesh, material)
        self.doc.add_node(name, index, placed(at=at) if at else None)
        return index

    def write(self):
        self.doc.write_glb(self.folder / (self.name + ".glb"))
        (self.folder / (self.name + ".json")).write_text(json.dumps(self.json, indent=1))


def ball(radius, n=2):
    return cube_sphere(n, lambda d: tuple(radius * c for c in d))


def block(width, height, depth):
    """A box on y = 0 of six faces: two blocks may have a face in common."""
    mesh = Mesh()
    mesh.points = [(x * width / 2, y * height, z * depth / 2) for x in (-1, 1) for y in (0, 1) for z in (-1, 1)]
    mesh.quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    mesh.uvs = [[(0, 0), (1, 0), (1, 1), (0, 1)] for _ in mesh.quads]
    return mesh


def nested(draft):
    """Water in glass: their boundaries overlap, so that one of them is hidden by priority. A cloudy core in a clear body."""
    draft.add("glass", ball(0.45), {**GLASS, "priority": 2}, (-0.6, 0.5, 0))
    draft.add("water", ball(0.42), {**GLASS, "ior": 1.33, "priority": 1, "attenuationColor": [0.4, 0.7, 0.9],
                                    "attenuationDistance": 0.3}, (-0.35, 0.5, 0))
    draft.add("shell", ball(0.45), {**GLASS, "roughness": 0.1}, (0.65, 0.5, 0))
    draft.add("core", ball(0.25), WAX, (0.65, 0.5, 0))


def dispersion(draft):
    draft.add("flint", box(0.9, 0.9, 0.9, 0.05), {**GLASS, "ior": 1.6, "dispersion": 1.0}, (0, 0.02, 0))
    draft.add("lamp", ball(0.08), {"baseColor": [0, 0, 0], "emission": [30, 28, 25]}, (0.7, 0.9, -0.8))


def links(draft):
    """A light for the left ball alone, and one whose shadow the right ball does not cast."""
    draft.add("left", ball(0.4), {"baseColor": [0.8, 0.3, 0.3]}, (-0.6, 0.45, 0))
    draft.add("right", ball(0.4), WAX, (0.6, 0.45, 0))
    draft.json["lights"] = [SKY, {**KEY, "lightLink": ["left"]},
                            {"name": "side", "type": "sphereLight", "radius": 0.2, "intensity": 40, "position": [2, 2, 1],
                             "shadowLink": ["left", "floor"]}]


def holdout(draft):
    draft.add("hole", ball(0.4), {"baseColor": [0.8, 0.8, 0.8]}, (-0.6, 0.45, 0))
    draft.add("ghost", ball(0.4), WAX, (0.6, 0.45, 0))
    draft.json["meshes"] = [{"match": "hole", "holdout": True}, {"match": "ghost", "visibleToCamera": False}]
    draft.json["lights"] = [KEY, {**SKY, "visibleToCamera": True}]


def add_skin(draft):
    """A post that two joints bend."""
    doc, mesh = draft.doc, draft.add("post", box(0.2, 0.8, 0.2, 0.03), {"baseColor": [0.3, 0.6, 0.3]})
    primitive = doc.json["meshes"][mesh]["primitives"][0]
    accessor = doc.json["accessors"][primitive["attributes"]["POSITION"]]
    start = doc.json["bufferViews"][accessor["bufferView"]]["byteOffset"]
    heights = [min(1.0, max(0.0, struct.unpack_from("<3f", doc.binary, start + 12 * i)[1] / 0.8)) for i in range(accessor["count"])]
    joints = doc._view(bytes(v for _ in heights for v in (0, 1, 0, 0)))
    primitive["attributes"]["JOINTS_0"] = doc._accessor(joints, 5121, "VEC4", len(heights))
    primitive["attributes"]["WEIGHTS_0"] = floats(doc, [(1 - h, h, 0.0, 0.0) for h in heights], "VEC4")
    first = len(doc.json["nodes"])
    doc.json["nodes"] += [{"name": "root", "children": [first + 1]}, {"name": "tip"}]
    doc.json["scenes"][0]["nodes"].append(first)
    doc.json["skins"] = [{"joints": [first, first + 1]}]
    doc.json["nodes"][first - 1]["skin"] = 0
    animate(doc, first + 1, "rotation", [(0.0, about_z(0)), (1.0, about_z(-60))], "VEC4")
    animate(doc, first, "translation", [(0.0, (1.0, 0, -0.2)), (1.0, (1.0, 0, 0.2))], "VEC3")


def motion(draft):
    """Nodes that move and turn, a morph, a skin, a mesh that the description moves, a model and a camera that move."""
    doc = draft.doc
    flyer = moving_node(doc, "flyer", doc.add_mesh("flyer", box(0.4, 0.3, 0.3, 0.05), doc.add_material("flyer", WAX)), (-1, 0.6, 0))
    animate(doc, flyer, "translation", [(0.0, (-1, 0.5, 0)), (0.5, (-0.8, 0.9, 0)), (1.0, (-0.4, 0.5, 0))], "VEC3")
    animate(doc, flyer, "rotation", [(0.0, about_z(0)), (1.0, about_z(120))], "VEC4")
    shape = draft.add("jelly", ball(0.25), {**WAX, "baseColor": [0.9, 0.3, 0.3]}, (0.1, 0.3, 0.3))
    add_morph(doc, shape, lambda p: (1.2 * p[1], 0.0, 0.0))
    animate(doc, len(doc.json["nodes"]) - 1, "weights", [(0.0, -0.5), (1.0, 0.5)], "SCALAR")
    add_skin(draft)
    draft.add("wheel", ball(0.15), {"baseColor": [0.2, 0.3, 0.8]})
    draft.json["meshes"] = [{"match": "wheel", "motion": [{"time": -0.5, "transform": {"translate": [-0.4, 0.2, 0.9]}},
                                                          {"time": 0.5, "transform": {"translate": [0.0, 0.2, 0.9]}}]}]
    draft.json["gltf"][0] |= {"time": 0.5, "motion": [{"time": -0.5, "transform": {"translate": [0, 0, 0]}},
                                                      {"time": 0.5, "transform": {"translate": [0, 0.05, 0]}}]}
    camera = draft.json["camera"]
    camera.pop("lookAt")
    camera["motion"] = [{"time": -0.5, "transform": {"translate": [-0.05, 0.5, 4]}}, {"time": 0.5, "transform": {"translate": [0.05, 0.5, 4]}}]
    camera |= {"shutterOpen": -0.5, "shutterClose": 0.5}


def instances(draft):
    mesh = draft.add("seed", ball(0.2), WAX)
    draft.doc.use("EXT_mesh_gpu_instancing")
    places = [(0.6 * (i % 4) - 0.9, 0.25 + 0.1 * (i % 3), -0.6 * (i // 4)) for i in range(12)]
    turns = [about_z(25 * i) for i in range(12)]
    sizes = [(1.0 + 0.05 * i, 1.0 - 0.03 * i, 1.0) for i in range(12)]
    doc = draft.doc
    doc.json["nodes"][mesh]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {
        "TRANSLATION": floats(doc, places, "VEC3"), "ROTATION": floats(doc, turns, "VEC4"), "SCALE": floats(doc, sizes, "VEC3")}}}
    for at in ((-1.2, 0.3, 0.8), (1.2, 0.3, 0.8)):  # and nodes that share the mesh
        doc.add_node("seed", mesh, placed(size=1.3, at=at))


def union(draft):
    for name, at in (("lower", (-0.2, 0.4, 0)), ("upper", (0.25, 0.65, 0.1))):
        draft.add(name, ball(0.42), WAX, at)
    draft.json["meshes"] = [{"match": "?p*", "subsurfaceSet": "one"}, {"match": "lower", "subsurfaceSet": "one"}]


def inside_body(draft):
    draft.add("body", ball(1.2), {**WAX, "scatterDistance": [0.8, 0.5, 0.3]}, (0, 1.3, 3.4))
    draft.add("thing", ball(0.4), {"baseColor": [0.3, 0.3, 0.8]}, (0, 0.45, 0))


def inside_glass(draft):
    draft.add("glass", ball(1.2), {**GLASS, "attenuationColor": [0.6, 0.8, 0.7], "attenuationDistance": 1.0}, (0, 1.3, 3.4))
    draft.add("thing", ball(0.4), WAX, (0, 0.45, 0))


def opacity(draft):
    """A half opaque body of wax, a thin leaf, and a pane."""
    draft.add("half", ball(0.4), {**WAX, "opacity": 0.5}, (-0.7, 0.45, 0))
    draft.add("leaf", box(0.6, 0.6, 0.02, 0.005), {"baseColor": [0.3, 0.6, 0.2], "thin": True, "diffTrans": 1.0,
                                                   "diffTransColor": [0.6, 0.8, 0.2], "flatness": 0.5}, (0.85, 0.02, 0.2))
    draft.add("pane", box(0.5, 0.9, 0.02, 0.005), {**GLASS, "thin": True}, (0.5, 0.0, 0.9))


def nine_lights(draft):
    (draft.folder / "screen.png").write_bytes(png(8, 4, lambda x, y: (x / 8, y / 4, 0.5)))
    (draft.folder / "lamp.ies").write_text(
        "IESNA:LM-63-2002\r\nTILT=NONE\r\n1 -1 1.0 4 1 1 2 0.1 0.1 0.0\r\n1 1 20\r\n0 30 60 90\r\n0\r\n1200 900 200 0\r\n")
    # The poles differ, and so do left and right.
    write_hdr(draft.folder / "sky.hdr", 16, 8, lambda y, x: (0.3 + 0.1 * (7 - y), 0.3, 0.1 + 0.05 * x))
    draft.add("ball", ball(0.4), WAX, (0.5, 0.45, 0))
    draft.add("gold", ball(0.3), {"baseColor": [0.9, 0.7, 0.3], "metallic": 1.0, "roughness": 0.3}, (-0.6, 0.35, 0.2))
    draft.add("ember", ball(0.1), {"baseColor": [0, 0, 0], "emission": [9, 4, 1]}, (-0.1, 0.12, 0.7))

    def light(name, kind, at, **more):
        return {"name": name, "type": kind, "position": at, "target": [0, 0.3, 0], **more}
    draft.json["lights"] = [
        light("rect", "rectLight", [-1.5, 2, 1], width=0.5, height=0.3, intensity=8),
        light("screen", "rectLight", [1.5, 1, -1], width=0.8, height=0.5, intensity=6, visibleToCamera=True, **{"texture:file": "screen.png"}),
        light("disk", "diskLight", [0, 3, 0.5], radius=0.1, intensity=300, **{"shaping:cone:angle": 20, "shaping:cone:softness": 0.4}),
        light("tube", "cylinderLight", [-1, 1, -1], radius=0.03, length=0.8, intensity=20, visibleToCamera=True, color=[0.5, 1, 0.7]),
        light("bulb", "sphereLight", [1.2, 0.6, 0.8], radius=0.08, intensity=30, visibleToCamera=True, normalize=False,
              enableColorTemperature=True, colorTemperature=2700),
        light("point", "sphereLight", [-1.2, 1.5, 1.5], treatAsPoint=True, intensity=2, exposure=0.5),
        light("profile", "sphereLight", [0.3, 2, -0.8], treatAsPoint=True, intensity=0.004, **{"shaping:ies:file": "lamp.ies"}),
        light("sun", "distantLight", [2, 3, 2], angle=3, intensity=40, **{"normalize": False}),
        {"name": "sky", "type": "domeLight", "intensity": 0.5, "texture:file": "sky.hdr", "visibleToCamera": True}]


def bare(draft):
    """Neither camera nor light: the glTF file is rendered as it is, in the studio."""
    draft.add("ball", ball(0.5), WAX, (0, 0.5, 0))


def layers(draft):
    """All lobes, and maps of colour, normals, heights."""
    write_hdr(draft.folder / "heights.hdr", 16, 16, lambda y, x: (0.5 + 0.5 * math.sin(0.75 * x) * math.sin(0.56 * y),) * 3)
    stripes = draft.doc.add_texture("stripes", png(8, 8, lambda x, y: (0.9, 0.2 + 0.08 * x, 0.1 * y)))
    tilts = draft.doc.add_texture("tilts", png(8, 8, lambda x, y: (0.5 + 0.2 * math.sin(x), 0.5 + 0.2 * math.cos(y), 1.0)))
    kinds = {"coated": {"coat": 1.0, "coatRoughness": 0.1, "roughness": 0.6}, "clear": {"clearcoat": 1.0, "clearcoatGloss": 0.7},
             "velvet": {"sheen": 1.0, "sheenTint": 0.4, "sheenRoughness": 0.3}, "film": {"iridescence": 1.0, "roughness": 0.2},
             "brushed": {"metallic": 1.0, "anisotropic": 0.8, "roughness": 0.3, "anisotropicRotation": 0.2},
             "tinted": {"specularTint": 1.0, "specular": 0.8, "scatterDistance": [0.1, 0.1, 0.1], "scatterAnisotropy": 0.5}}
    for i, (name, lobes) in enumerate(kinds.items()):
        maps = {"texture": stripes} if i % 2 == 0 else {"normal": tilts}
        draft.add(name, ball(0.22), {"baseColor": [0.7, 0.4, 0.3], **lobes}, (0.55 * (i % 3) - 0.55, 0.25 + 0.5 * (i // 3), -0.4 * (i // 3)), **maps)
    draft.json["materials"] = [{"match": "coated", "bump": {"file": "heights.hdr", "scale": 0.05}},
                               {"match": "velvet", "displacement": {"file": "heights.hdr", "scale": 0.08}}]
    draft.json["meshes"] = [{"match": "velvet", "scheme": "catmullClark", "refineLevel": 3}]


def lens(draft):
    """Depth of field, clipping, exposure, an odd film, and products of their own sizes, crops, colours and data."""
    draft.add("near", ball(0.3), WAX, (-0.5, 0.35, 1.2))
    draft.add("far", ball(0.3), {"baseColor": [0.3, 0.4, 0.8]}, (0.6, 0.35, -0.8))
    draft.json["camera"] |= {"fStop": 1.4, "focusDistance": 2.8, "apertureBlades": 5, "apertureRotation": 20, "exposure": 0.7,
                             "horizontalApertureOffset": 3, "clippingRange": [0.5, 5.2], "clipPlanes": [[1, 0.2, 0, 1.2]]}
    draft.json["settings"] |= {"windowPolicy": "fit", "pixelAspectRatio": 1.25}
    draft.json["products"] = [
        {"file": "whole.exr", "dataType": "float", "aovs": ["color", "depth", "error", "diffuse", "specular"]},
        {"file": "part.exr", "resolution": [40, 20], "crop": [10, 5, 30, 18], "aovs": ["color", "normal"]},
        {"file": "display.png", "dataType": "uint16", "view": "Un-tone-mapped", "exposure": -1},
        {"file": "scene.tif", "colorSpace": "ACEScg"}, {"file": "plain.jpg"}]


def parallel(draft):
    draft.add("ball", ball(0.5), WAX, (0.3, 0.5, 0))
    draft.json["camera"] |= {"projection": "orthographic", "horizontalAperture": 3000, "verticalAperture": 2250}


def cloudy(draft):
    """Alone, over half its width hidden by a glass of higher priority, and within water."""
    draft.add("alone", ball(0.32), {**CLOUDY, "specTrans": 0.2}, (-0.95, 0.35, 0.2))
    draft.add("over", ball(0.35), {**CLOUDY, "priority": 1}, (-0.15, 0.4, 0))
    draft.add("glass", ball(0.3), {**GLASS, "priority": 2}, (0.05, 0.5, 0.2))
    draft.add("water", ball(0.45), {**GLASS, "ior": 1.33}, (0.95, 0.5, 0))
    draft.add("core", ball(0.3), CLOUDY, (0.95, 0.5, 0))


def inside_cloudy(draft):
    draft.add("body", ball(1.2), {**CLOUDY, "scatterDistance": [4.0, 3.0, 2.0]}, (0, 1.3, 3.4))
    draft.add("thing", ball(0.4), MARBLE, (0, 0.45, 0))


def touching(draft):
    """Blocks that stand on the floor and on each other, with whole faces in common."""
    draft.add("wax", block(0.7, 0.3, 0.6), WAX, (-0.7, 0, 0))
    draft.add("lid", block(0.7, 0.3, 0.6), GLASS, (-0.7, 0.3, 0))
    draft.add("cloudy", block(0.4, 0.5, 0.6), CLOUDY, (0.2, 0, 0.1))
    draft.add("water", block(0.4, 0.5, 0.6), {**GLASS, "ior": 1.33, "attenuationColor": [0.5, 0.8, 0.9], "attenuationDistance": 0.3}, (0.6, 0, 0.1))
    draft.add("plaster", block(0.3, 0.5, 0.6), {"baseColor": [0.8, 0.3, 0.2]}, (0.95, 0, 0.1))
    draft.json["meshes"] = [{"match": name, "scheme": "none"} for name in ("wax", "lid", "cloudy", "water", "plaster")]


def past_hidden(draft):
    """Lights, one of them with a shadow link, and a mesh that glows, seen by way of boundaries that are not there: one of lower priority, and
    one between equal indices of refraction."""
    draft.add("glass", block(1.1, 0.7, 0.5), {**GLASS, "priority": 2}, (-0.55, 0.05, 0.4))
    draft.add("water", ball(0.4), {**GLASS, "ior": 1.33, "priority": 1, "emission": [0.0, 0.1, 0.2]}, (-0.5, 0.45, 0.1))
    draft.add("ember", ball(0.1), {"baseColor": [0, 0, 0], "emission": [4, 2, 1]}, (-0.25, 0.25, 0.1))
    draft.add("outer", ball(0.45), {**GLASS, "roughness": 0.1}, (0.7, 0.5, 0))
    draft.add("inner", ball(0.3), GLASS, (0.7, 0.5, 0))
    draft.add("stone", ball(0.2), {"baseColor": [0.4, 0.4, 0.7]}, (0.1, 0.2, -0.5))
    draft.json["meshes"] = [{"match": "glass", "scheme": "none"}]
    draft.json["lights"] = [SKY, {**KEY, "lightLink": ["floor", "stone", "water", "outer"]},
                            {"name": "lamp", "type": "sphereLight", "radius": 0.4, "intensity": 6, "position": [0.1, 0.9, -1.6],
                             "shadowLink": ["stone"]}]


def many_lights(draft):
    draft.add("wax", ball(0.4), WAX, (0.6, 0.45, 0))
    draft.add("plaster", ball(0.4), {"baseColor": [0.7, 0.7, 0.7]}, (-0.6, 0.45, 0))
    draws = random.Random(7)
    draft.json["lights"] = [
        {"name": f"light{i}", "type": "sphereLight", "radius": 0.02, "intensity": 10 ** draws.uniform(0.5, 2.5),
         "color": [draws.random() for _ in range(3)], "position": [draws.uniform(-2, 2), draws.uniform(0.9, 1.8), draws.uniform(-2, 1.4)]}
        for i in range(200)]


def grazing(draft):
    """Smooth normals on few faces, across whose front the light ends."""
    tilts = draft.doc.add_texture("tilts", png(8, 8, lambda x, y: (0.5 + 0.1 * math.sin(x), 0.5 + 0.1 * math.cos(y), 1.0)))
    kinds = {"plaster": {"baseColor": [0.8, 0.8, 0.8]}, "wax": WAX, "marble": MARBLE, "cloudy": CLOUDY}
    for i, (name, disney) in enumerate(kinds.items()):
        draft.add(name, ball(0.4, 1), disney, (0.72 * i - 1.08, 0.4, 0), **({"normal": tilts} if name == "marble" else {}))
    draft.json["lights"] = [{**SKY, "intensity": 0.05}, {**KEY, "width": 0.3, "height": 0.3, "intensity": 300, "position": [-0.5, 4, -0.8]}]


def thick(draft):
    """Bodies of some hundred mean free paths, one of them lit from behind alone."""
    draft.add("marble", ball(0.45, 4), MARBLE, (-0.6, 0.5, 0))
    draft.add("jade", ball(0.4, 4), {"baseColor": [0.3, 0.6, 0.4], "scatterDistance": [0.01, 0.02, 0.01]}, (0.6, 0.45, 0))
    draft.json["lights"] = [{**SKY, "intensity": 0.1}, {**KEY, "lightLink": ["marble", "floor"]},
                            {**KEY, "name": "back", "position": [1.0, 1.5, -3], "intensity": 20}]


def rough_glass(draft):
    """Rough glass that absorbs, that disperses, of thin walls; a solid that only diffuse light passes, with a drop of water on it."""
    draft.add("green", ball(0.3), {**GLASS, "roughness": 0.4, "attenuationColor": [0.2, 0.7, 0.3], "attenuationDistance": 0.2}, (-1.0, 0.35, 0))
    draft.add("flint", ball(0.3), {**GLASS, "roughness": 0.25, "ior": 1.6, "dispersion": 1.0}, (-0.3, 0.35, 0.2))
    draft.add("sheet", box(0.5, 0.7, 0.02, 0.005), {**GLASS, "roughness": 0.3, "thin": True}, (0.4, 0.02, 0.3))
    draft.add("frosted", ball(0.3), {"baseColor": [0.9, 0.6, 0.6], "diffTrans": 1.0, "diffTransColor": [0.5, 0.7, 0.9]}, (1.0, 0.35, 0))
    draft.add("drop", ball(0.2), {**GLASS, "ior": 1.33}, (0.85, 0.5, 0.2))
    draft.add("lamp", ball(0.08), {"baseColor": [0, 0, 0], "emission": [30, 28, 25]}, (0.4, 0.5, -0.8))


def coats(draft):
    """Layers over a normal map, above lobes and above a body, so that light leaves the body through them."""
    tilts = draft.doc.add_texture("tilts", png(8, 8, lambda x, y: (0.5 + 0.2 * math.sin(x), 0.5 + 0.2 * math.cos(y), 1.0)))
    coat = {"coat": 1.0, "coatRoughness": 0.1}
    kinds = {"paint": {"baseColor": [0.2, 0.4, 0.7], "roughness": 0.6, **coat}, "candy": {**WAX, **coat},
             "plush": {**WAX, "sheen": 1.0, "sheenRoughness": 0.5}, "film": {**CLOUDY, "coat": 1.0}}
    for i, (name, lobes) in enumerate(kinds.items()):
        draft.add(name, ball(0.3), lobes, (0.7 * i - 1.05, 0.35, 0), normal=tilts)


def mirror(draft):
    """A wall that shows wax, plaster and glass, for the features that a denoiser takes from what mirrors show."""
    draft.add("wall", block(2.6, 1.4, 0.1), {"baseColor": [0.95, 0.95, 0.95], "metallic": 1.0, "roughness": 0.0}, (0, 0, -0.9))
    for name, disney, x in (("wax", WAX, -0.8), ("plaster", {"baseColor": [0.2, 0.5, 0.3]}, 0.1), ("glass", GLASS, 0.8)):
        draft.add(name, ball(0.3), disney, (x, 0.35, 0.3))
    draft.json["meshes"] = [{"match": "wall", "scheme": "none"}]


SCENES = {f.__name__: f for f in (nested, dispersion, links, holdout, motion, instances, union, inside_body, inside_glass, opacity,
                                  nine_lights, bare, layers, lens, parallel, cloudy, inside_cloudy, touching, past_hidden, many_lights,
                                  grazing, thick, rough_glass, coats, mirror)}


def write_scenes(folder):
    """Writes every scene to a folder of its name. {name: file to render}."""
    files = {}
    for name, fill in SCENES.items():
        place = pathlib.Path(folder) / name
        place.mkdir(parents=True)
        draft = Draft(name, place)
        fill(draft)
        draft.write()
        files[name] = place / (name + (".glb" if name == "bare" else ".json"))
    return files


if __name__ == "__main__":
    for file in write_scenes(sys.argv[1]).values():
        print(file)
