"""Reports about glTF files: materials, attributes, nodes, animation and names."""
import base64
import json
import math
import struct

import numpy as np
from made_images import flat, png, to_linear
from made_models import CORNERS, CUBE, CUBE_SIDES, Model
from public_reports import report

COLOR = [1, .5, .25]


def seen(case, model, name="model.glb", **more):
    return case.render(model.write(case.folder / name), **more)


def vertex_colors(case, colors, what, right, color=(1, 1, 1, 1), **material):
    model = Model()
    model.square(model.unlit(color, **material), {"COLOR_0": colors})
    case.near(what, seen(case, model).middle, right)


@report("three.js 21466, meshoptimizer 909", "alpha of vertex colours counts for BLEND and MASK, and not for OPAQUE")
def vertex_alpha(case):
    vertex_colors(case, [(*COLOR, .25)] * 4, "BLEND", [c / 4 for c in COLOR] + [.25], alphaMode="BLEND")
    vertex_colors(case, [(*COLOR, .25)] * 4, "OPAQUE", COLOR + [1])
    vertex_colors(case, [(*COLOR, .48)] * 4, "MASK, below", [0] * 4, alphaMode="MASK")
    vertex_colors(case, [(*COLOR, .52)] * 4, "MASK, above", COLOR + [1], alphaMode="MASK")


@report("assimp 3473", "vertex colours of three components have alpha 1")
def vertex_rgb(case):
    vertex_colors(case, [COLOR] * 4, "BLEND", COLOR + [1], alphaMode="BLEND")
    model = Model()
    stored = model.accessor([(255, 128, 64)] * 4, "u1", normalized=True)
    model.square(model.unlit(alphaMode="BLEND"), {"COLOR_0": stored})
    case.near("of bytes", seen(case, model).middle, [1, 128 / 255, 64 / 255, 1])


@report("glTF-Blender-IO 355", "alpha is the product of factor, texture and vertex colour")
def alpha_product(case):
    model = Model()
    texture = model.image(png(flat(255, 255, 255, 128)))
    model.square(model.unlit((*COLOR, .5), texture, alphaMode="BLEND"), {"COLOR_0": [(1, 1, 1, .5)] * 4})
    alpha = .5 * .5 * 128 / 255
    case.near("BLEND", seen(case, model).middle, [c * alpha for c in COLOR] + [alpha])


@report("three.js 24838, UnityGLTF 900", "accessors without a buffer view are zeros, and sparse ones change some of them")
def absent_views(case):
    model = Model()
    primitive = model.primitive(attributes={"NORMAL": [(0, 0, 1)] * 4}, material=model.unlit((*COLOR, 1)))
    zeros = model.add("accessors", {"componentType": 5126, "count": 4, "type": "VEC3", "min": [0] * 3, "max": [0] * 3})
    indices, values = model.view(np.uint16([1, 2]).tobytes()), model.view(np.float32([(-1, 0, 0)] * 2).tobytes())
    moved = model.add("accessors", {"componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, 0], "max": [0] * 3, "sparse": {
        "count": 2, "indices": {"bufferView": indices, "componentType": 5123}, "values": {"bufferView": values}}})
    primitive["targets"] = [{"POSITION": zeros}, {"POSITION": moved}]
    mesh = model.mesh(primitive, weights=[1, 1])
    model.node(mesh=mesh)
    picture = seen(case, model)  # the right half of the square moves to its middle
    case.near("left half", picture.layers["R"][:, :4], np.ones((4 * 8,)).reshape(8, 4))
    case.near("right half", picture.layers["A"][:, 4:], np.zeros((8, 4)))


@report("three.js 15142, glTF-Blender-IO 290", "weights of a node replace those of its mesh, for this node alone")
def node_weights(case):
    model = Model()
    primitive = model.primitive([(x / 4, y / 4, z) for x, y, z in CORNERS], attributes={}, material=model.unlit((*COLOR, 1)),
                                targets=[{"POSITION": model.accessor([(0, .5, 0)] * 4)}])
    mesh = model.mesh(primitive, weights=[1])
    model.node(mesh=mesh, translation=[-.5, 0, 0], weights=[-1])
    model.node(mesh=mesh, translation=[.5, 0, 0])
    alpha = seen(case, model).layers["A"]
    case.near("of the node: down", [alpha[5, 2], alpha[2, 2]], [1, 0])
    case.near("of the mesh: up", [alpha[5, 5], alpha[2, 5]], [0, 1])


@report("godot 91593", "triangle strips: every second triangle is turned, so that none is culled")
def strips(case):
    model = Model()
    order = [CORNERS[i] for i in (0, 1, 3, 2)]
    model.node(mesh=model.mesh(model.primitive(order, None, mode=5, material=model.unlit((*COLOR, 1)))))
    case.near("front", seen(case, model).mean, COLOR + [1])
    model.json["nodes"][-1]["rotation"] = [0, 1, 0, 0]
    case.near("back, culled", seen(case, model).mean, [0] * 4)
    model.json["nodes"][-1] = {"mesh": 0, "scale": [-1, 1, 1]}
    case.near("mirrored: front again", seen(case, model).mean, COLOR + [1])


def grid_texture():
    """4 x 4 texels of distinct colours, and their linear values, row 0 at the top."""
    texels = np.array([[(60 * x + 20, 60 * y + 20, 128) for x in range(4)] for y in range(4)])
    return png(texels), np.vectorize(to_linear)(texels)


@report("three.js 16297, glTF-Sample-Assets 138", "texCoord of KHR_texture_transform replaces that of the texture")
def transform_set(case):
    data, linear = grid_texture()
    model = Model()
    model.use("KHR_texture_transform")
    texture = {"index": model.image(data), "texCoord": 0, "extensions": {"KHR_texture_transform": {"texCoord": 1}}}
    other = [(.625, .125)] * 4  # the texel (2, 0)
    model.square(model.unlit(texture=texture), {"TEXCOORD_1": other})
    case.near("the second set", seen(case, model).middle[:3], linear[0, 2])


@report("three.js 34032", "KHR_texture_transform: offset after rotation after scale")
def transform_order(case):
    data, linear = grid_texture()
    model = Model()
    model.use("KHR_texture_transform")
    angle, scale, offset = .5, (2, .5), (.15, .3)
    texture = {"index": model.image(data), "extensions": {"KHR_texture_transform": {"offset": offset, "rotation": angle, "scale": scale}}}
    model.square(model.unlit(texture=texture))
    picture = seen(case, model, size=(16, 16), samples=16)
    rgb, right, sure = picture.rgb(), np.zeros((16, 16, 3)), np.zeros((16, 16), bool)
    for y in range(16):
        for x in range(16):
            found = set()
            for dx in (0, .5, 1):
                for dy in (0, .5, 1):
                    u, v = (x + dx) / 16 * scale[0], (y + dy) / 16 * scale[1]
                    s = math.cos(angle) * u + math.sin(angle) * v + offset[0]
                    t = -math.sin(angle) * u + math.cos(angle) * v + offset[1]
                    found.add((math.floor(t * 4) % 4, math.floor(s * 4) % 4))
            sure[y, x] = len(found) == 1
            right[y, x] = linear[next(iter(found))]
    case.true("some pixels lie within one texel", sure.sum() > 40, sure.sum())
    case.near("their colours", rgb[sure], right[sure], 4e-3)


@report("three.js 12867, filament 131", "a clear coat without a normal map of its own reflects as over a flat base")
def coat_normal(case):
    lights = [{"name": "sky", "type": "domeLight"}]
    for roughness in (0, .2):
        for degrees in (0, 30, 60):
            turn, reflected = [0, math.sin(math.radians(degrees / 2)), 0, math.cos(math.radians(degrees / 2))], []
            for color in (None, (190, 128, 238), (66, 128, 238), (230, 128, 204)):  # leans by 30 degrees, to either side, and by 53
                model = Model()
                model.use("KHR_materials_clearcoat", "KHR_materials_specular")
                material = {"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0}, "extensions": {
                    "KHR_materials_specular": {"specularFactor": 0},
                    "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": roughness}}}
                if color:
                    material["normalTexture"] = {"index": model.image(png(flat(*color)))}
                model.square(model.add("materials", material), rotation=turn)
                reflected.append(seen(case, model, lights=lights, samples=512).middle[0])
            if degrees == 0:
                case.near("reflects .04 of the sky", reflected[0], .04, 1e-3)
            case.near(f"at {degrees} degrees with roughness {roughness}", reflected[1:], reflected[:1] * 3, 8e-4)


@report("three.js 14618, three.js 21850", "lights keep their intensity below scaled nodes, and a mirrored one its direction")
def scaled_lights(case):
    means = []
    for scale in ([1, 1, 1], [10, 10, 10], [.01, .01, .01], [1, -1, 1]):
        model = Model()
        model.use("KHR_lights_punctual")
        model.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 5}, {"type": "directional", "intensity": 2}]}}
        white = model.add("materials", {"pbrMetallicRoughness": {"metallicFactor": 0}})
        model.square(white)
        point = model.node(False, translation=[0, 0, 2 / scale[2]], extensions={"KHR_lights_punctual": {"light": 0}})
        sun = model.node(False, extensions={"KHR_lights_punctual": {"light": 1}})
        model.node(scale=scale, children=[point, sun])
        means.append(seen(case, model, samples=16).middle[0])
    case.near("all agree", means[1:], means[:1] * 3, 5e-3)
    case.true("light falls on the square", means[0] > .5, means[0])


@report("playcanvas 8305, filament 4607", "a spot light without angles has a cone of 45 degrees")
def spot_angles(case):
    model = Model()
    model.use("KHR_lights_punctual")
    model.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 100, "spot": {}}]}}
    white = model.add("materials", {"pbrMetallicRoughness": {"metallicFactor": 0}})
    model.square(white)
    model.node(translation=[0, 0, .5], extensions={"KHR_lights_punctual": {"light": 0}})
    row = seen(case, model, size=(80, 80), samples=16).layers["R"][40]
    inside = .5 * math.tan(math.radians(44)), .5 * math.tan(math.radians(46))
    case.true("light at 44 degrees", row[int(40 + 40 * inside[0])] > 0, row[int(40 + 40 * inside[0])])
    case.near("none beyond 46", row[int(41 + 40 * inside[1]):], np.zeros(80 - int(41 + 40 * inside[1])))


def joint_quad(model, weights, joints, dtype="f4"):
    stored = model.accessor(weights, dtype, **({"normalized": True} if dtype != "f4" else {}))
    return model.primitive([(x / 2, y / 2, z) for x, y, z in CORNERS], attributes={
        "JOINTS_0": model.accessor(joints, "u1"), "WEIGHTS_0": stored}, material=model.unlit((*COLOR, 1)))


@report("glTF-Sample-Assets 263, glTF-Blender-IO 368", "transforms of a skinned mesh's node and its parents take no part")
def skin_of_a_moved_node(case):
    model = Model()
    joint = model.node(translation=[.5, .5, 0])
    mesh = model.mesh(joint_quad(model, [(1, 0, 0, 0)] * 4, [(0, 0, 0, 0)] * 4))
    child = model.node(False, mesh=mesh, skin=model.add("skins", {"joints": [joint]}), translation=[0, -3, 0])
    model.node(translation=[-7, 0, 0], children=[child], scale=[2, 2, 2])
    alpha = seen(case, model).layers["A"]
    right = np.zeros((8, 8))
    right[:4, 4:] = 1
    case.near("the quarter that the joint chooses", alpha, right)


@report("three.js 15319, glTF-Validator 132", "weights of bytes whose sum is not 1")
def skin_weights(case):
    for name, dtype, weights in (("bytes of sum 254", "u1", (127, 127, 0, 0)), ("floats of sum 2", "f4", (1, 1, 0, 0))):
        model = Model()
        joints = [model.node(translation=[.5, 0, 0]), model.node(translation=[.5, 1, 0])]
        model.node(mesh=model.mesh(joint_quad(model, [weights] * 4, [(0, 1, 0, 0)] * 4, dtype)), skin=model.add("skins", {"joints": joints}))
        right = np.zeros((8, 8))
        right[:4, 4:] = 1
        case.near(name, seen(case, model).layers["A"], right)


@report("filament 6358, playcanvas 9193", "a mesh without normals has those of its triangles, though they share vertices")
def flat_normals(case):
    model = Model()
    angle = math.radians(30)
    model.node(mesh=model.mesh(model.primitive([np.multiply(p, .6) for p in CUBE], CUBE_SIDES)), rotation=[0, math.sin(angle / 2), 0, math.cos(angle / 2)])
    picture = seen(case, model, aovs=["normal"], lights=[{"name": "sky", "type": "domeLight"}])
    normals = np.stack([picture.layers["N." + c] for c in "XYZ"], axis=-1)[4]
    case.near("of the front", normals[5], [math.sin(angle), 0, math.cos(angle)], 3e-3)
    case.near("of the left side", normals[1], [-math.cos(angle), 0, math.sin(angle)], 3e-3)


@report("glTF 1345", "a .gltf that begins with a byte order mark: read, or refused by name")
def byte_order_mark(case):
    model = Model()
    model.square(model.unlit((*COLOR, 1)))
    try:
        picture = case.render(model.write(case.folder / "model.gltf", prefix=b"\xef\xbb\xbf"))
        case.near("read", picture.middle, COLOR + [1])
    except RuntimeError as refusal:
        case.true("refused by name", "byte order" in str(refusal), refusal)


@report("glTF-Blender-IO 1836, three-gltf-viewer 146, fastgltf 28", "names of files with spaces, percent signs and #, escaped or as they are")
def file_names(case):
    for stored, uri in (("a b.bin", "a%20b.bin"), ("c d.bin", "c d.bin"), ("e 10%.bin", "e 10%.bin"), ("f 10%.bin", "f%2010%25.bin"),
                        ("g#1.bin", "g%231.bin"), ("ü ♻.bin", "ü ♻.bin"), ("h+1.bin", "h+1.bin")):
        model = Model()
        model.square(model.unlit((*COLOR, 1)))
        file = model.write(case.folder / "model.gltf", buffer_uri=uri)
        (case.folder / stored).write_bytes(model.binary)
        try:
            case.near(f"{stored} as {uri}", case.render(file).middle, COLOR + [1])
        except RuntimeError as refusal:
            case.true(f"{stored} as {uri}: {str(refusal)[:200]}", False)


@report("three.js 22339, assimp 2689", "rotations by CUBICSPLINE are normalized after interpolation")
def cubic_rotation(case):
    model = Model()
    node = model.square(model.unlit((*COLOR, 1)), scale=[.5, .5, 1])
    s = math.sqrt(.5)
    keys = [(0,) * 4, (0, 0, 0, 1), (0,) * 4, (0,) * 4, (0, 0, s, s), (0,) * 4]
    animate(model, node, "rotation", [0, 1], keys, "CUBICSPLINE")
    alpha = seen(case, model, options=["--time", "0.5"], size=(40, 40), samples=16).layers["A"]
    case.near("a square of 1 x 1, at 45 degrees", [alpha.mean() * 4, alpha[20, :].sum() / 20], [1, math.sqrt(2) - .05], 2e-2)


def animate(model, node, path, times, values, interpolation="LINEAR"):
    sampler = {"input": model.accessor(times), "output": model.accessor(values), "interpolation": interpolation}
    model.add("animations", {"samplers": [sampler], "channels": [{"sampler": 0, "target": {"node": node, "path": path}}]})


@report("fastgltf 108, glTF 2073", "LINEAR rotations take the shorter way")
def shorter_way(case):
    for sign in (1, -1):
        model = Model()
        node = model.node(mesh=model.mesh(model.primitive([(x / 8 + .6, y / 8, z) for x, y, z in CORNERS], material=model.unlit((*COLOR, 1)))))
        animate(model, node, "rotation", [0, 1], [(0, 0, 0, 1), (0, 0, sign * math.sqrt(.5), sign * math.sqrt(.5))])
        alpha = seen(case, model, options=["--time", "0.5"], size=(16, 16), samples=16).layers["A"]
        y, x = np.array([(y, x) for y in range(16) for x in range(16) if alpha[y, x] > .5]).mean(axis=0)
        case.near(f"at 45 degrees, sign {sign}", [(x - 7.5) / 8, (7.5 - y) / 8], [.6 * math.sqrt(.5)] * 2, 5e-2)


@report("godot 93596", "CUBICSPLINE is a Hermite spline whose tangents count per second")
def hermite(case):
    model = Model()
    node = model.node(mesh=model.mesh(model.primitive([(x / 8, y / 8, z) for x, y, z in CORNERS], material=model.unlit((*COLOR, 1)))))
    keys = [(0, 0, 0), (-.5, 0, 0), (0, .75, 0), (0, -.75, 0), (.5, 0, 0), (0, 0, 0)]
    animate(model, node, "translation", [0, 2], keys, "CUBICSPLINE")
    alpha = seen(case, model, options=["--time", "1"], size=(16, 16), samples=16).layers["A"]
    y, x = np.array([(y, x) for y in range(16) for x in range(16) if alpha[y, x] > .5]).mean(axis=0)
    case.near("half of the way, 2 (.75 + .75) / 8 up", [(x - 7.5) / 8, (7.5 - y) / 8], [0, .375], 5e-2)


@report("glTFast 50, glTF 1327, glTF 1597", "before the first key and after the last an animation holds; one key is a constant")
def held_keys(case):
    for times, values, time, right in (([1, 2], [(-.5, 0, 0), (.5, 0, 0)], 0, -.5), ([1, 2], [(-.5, 0, 0), (.5, 0, 0)], 9, .5), ([1], [(.5, 0, 0)], 0, .5)):
        for interpolation in ("LINEAR", "STEP"):
            model = Model()
            node = model.node(mesh=model.mesh(model.primitive([(x / 2, y, z) for x, y, z in CORNERS], material=model.unlit((*COLOR, 1)))))
            animate(model, node, "translation", times, values, interpolation)
            alpha = seen(case, model, options=["--time", str(time)]).layers["A"]
            case.near(f"{interpolation} {times} at {time}", [alpha[:, :4].mean(), alpha[:, 4:].mean()], [float(right < 0), float(right > 0)])


@report("three.js 24800, glTF 1663, glTF 1822", "xmag is half of the width; scale of a camera's node does not count")
def orthographic(case):
    for scale in (1, 5):
        model = Model(camera=False)
        model.json["cameras"] = [{"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 2, "znear": .1, "zfar": 100}}]
        model.node(camera=0, translation=[0, 0, 5], scale=[scale] * 3)
        model.square(model.unlit((*COLOR, 1)))
        case.near(f"the square is half as wide as the picture, scale {scale}", seen(case, model).layers["A"].mean(), .25)


@report("Babylon.js 8149, Cesium 10771", "EXT_mesh_gpu_instancing: the mesh alone is not shown; rotations of signed bytes")
def instances(case):
    for dtype, value in (("i1", 127), ("i2", 32767), ("f4", 1)):
        model = Model()
        model.use("EXT_mesh_gpu_instancing")
        mesh = model.mesh(model.primitive([(x / 4 + .5, y / 4 + .5, z) for x, y, z in CORNERS], material=model.unlit((*COLOR, 1))))
        turns = model.accessor([(0, 0, value, 0), (0, 0, round(value * math.sqrt(.5), 9), round(value * math.sqrt(.5), 9))], dtype,
                               **({} if dtype == "f4" else {"normalized": True}))
        model.node(mesh=mesh, extensions={"EXT_mesh_gpu_instancing": {"attributes": {"ROTATION": turns}}})
        alpha = seen(case, model).layers["A"]
        quarters = [alpha[1:3, 5:7].mean(), alpha[5:7, 1:3].mean(), alpha[1:3, 1:3].mean(), alpha[5:7, 5:7].mean()]
        case.near(f"turned by 180 and 90 degrees, {dtype}", quarters, [0, 1, 1, 0], 2e-2)


@report("DiligentFX 267, glTF-Sample-Models 149", "the fourth number of TANGENT turns the bitangent; a mirrored node mirrors the mapped normal")
def handedness(case):
    for sign, mirrored in ((1, False), (-1, False), (1, True)):
        model = Model()
        material = model.add("materials", {"normalTexture": {"index": model.image(png(flat(170, 150, 240)))}, "pbrMetallicRoughness": {"metallicFactor": 0}})
        scale = {"scale": [-1, 1, 1]} if mirrored else {}
        model.square(material, {"TANGENT": [(1, 0, 0, sign)] * 4}, **scale)
        n = 2 * np.array([170, 150, 240]) / 255 - 1
        n = n / np.linalg.norm(n) * (-1 if mirrored else 1, sign, 1)
        picture = seen(case, model, aovs=["normal"], lights=[{"name": "sky", "type": "domeLight"}])
        case.near(f"sign {sign}, mirrored {mirrored}", picture.layer("N.X", "N.Y", "N.Z"), n, 6e-3)


@report("GLSL-PathTracer 35", "millimetres and kilometres: the picture does not change with the unit")
def units(case):
    means = []
    for unit in (1, 1e-4, 1e5):
        model = Model(camera=False)
        model.json["cameras"] = [{"type": "orthographic", "orthographic": {"xmag": unit, "ymag": unit, "znear": unit, "zfar": 1e3 * unit}}]
        model.node(camera=0, translation=[0, 0, 5 * unit])
        white = model.add("materials", {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": .5}})
        model.node(mesh=model.mesh(model.primitive([np.multiply(p, unit / 2) for p in CUBE], CUBE_SIDES, material=white)),
                   rotation=[.2, .3, .1, math.sqrt(1 - .14)])
        means.append(seen(case, model, samples=64, lights=[{"name": "sky", "type": "domeLight"}]).mean)
    case.near("1e-4 and 1e5 of a unit", means[1:], [means[0]] * 2, 3e-3)


@report("tinygltf 79, glTF-Blender-IO 635, gltflib 1", "a data URI within a .glb; one without base64; a chunk without bytes")
def unusual_buffers(case):
    model = Model()
    model.square(model.unlit((*COLOR, 1)))
    data = bytes(model.binary) + bytes(-len(model.binary) % 4)
    text = json.dumps({**model.json, "buffers": [{"byteLength": len(data), "uri": "data:;base64," + base64.b64encode(data).decode()}]}).encode()
    text += b" " * (-len(text) % 4)
    for name, tail in (("alone", b""), ("with an empty chunk", struct.pack("<I4s", 0, b"BIN\0"))):
        file = case.folder / "model.glb"
        file.write_bytes(struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(tail)) + struct.pack("<I4s", len(text), b"JSON") + text + tail)
        case.near(name, case.render(file).middle, COLOR + [1])
    escaped = "data:application/octet-stream," + "".join(f"%{b:02X}" for b in data)
    try:
        case.near("without base64", case.render(model.write(case.folder / "plain.gltf", buffer_uri=escaped)).middle, COLOR + [1])
    except RuntimeError as refusal:
        case.true("without base64: refused by name", "base64" in str(refusal), refusal)


@report("godot 114033, glTF 940", "an emissiveTexture without emissiveFactor is black: zero is the factor's default")
def emissive_default(case):
    model = Model()
    material = {"emissiveTexture": {"index": model.image(png(flat(255, 255, 255)))}, "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}}
    model.square(model.add("materials", material))
    case.near("black", seen(case, model).middle, [0, 0, 0, 1])


@report("glTF 2284", "the back of a two-sided surface with a normal map: the mapped normal is reversed")
def back_of_two_sides(case):
    model = Model()
    material = model.add("materials", {"normalTexture": {"index": model.image(png(flat(170, 150, 240)))}, "doubleSided": True,
                                       "pbrMetallicRoughness": {"metallicFactor": 0}})
    model.square(material, {"TANGENT": [(1, 0, 0, 1)] * 4}, rotation=[0, 1, 0, 0])
    n = 2 * np.array([170, 150, 240]) / 255 - 1
    n = n / np.linalg.norm(n) * (1, -1, 1)  # turned about y: u runs to the left; reversed: -n
    picture = seen(case, model, aovs=["normal"], lights=[{"name": "sky", "type": "domeLight"}])
    case.near("of the back", picture.layer("N.X", "N.Y", "N.Z"), n, 6e-3)


@report("three.js 29034, gltf-rs 364, three.js 24620", "glass of exporters in JavaScript: attenuationDistance null (infinity) or 0 (off)")
def attenuation_null(case):
    means = []
    for volume in ({}, {"attenuationDistance": None}, {"attenuationDistance": 0}):
        model = Model()
        model.use("KHR_materials_transmission", "KHR_materials_volume")
        glass = model.add("materials", {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0}, "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": {"thicknessFactor": 1, "attenuationColor": [.2, .5, .9], **volume}}})
        model.node(mesh=model.mesh(model.primitive([np.multiply(p, .7) for p in CUBE], CUBE_SIDES, material=glass)))
        means.append(seen(case, model, lights=[{"name": "sky", "type": "domeLight"}], samples=16).mean[:3])
    case.near("null as absent", means[1], means[0], 1e-4)
    case.near("0 as absent", means[2], means[0], 1e-4)
