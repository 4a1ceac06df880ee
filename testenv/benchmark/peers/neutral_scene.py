"""Turns a render description into its neutral form: triangles in world space with normals, one mesh per material, materials
of constants, lights and a camera. All renderers read the same two files, scene.json (a render description itself) and
scene.glb, so that they draw the same geometry.

Meshes with FB_ngon_encoding are refined by Catmull-Clark to the description's level, without the projection to the limit
surface. Textures of materials become their mean. `specular` is folded into `ior`, so that f0 stays. Standard library only.
"""
import array
import fnmatch
import json
import pathlib
import struct
import zlib

import formulas

FLOAT, UINT32 = 5126, 5125
INDEX_CODES = {5121: "B", 5123: "H", 5125: "I"}
MATERIAL_KEYS = ("baseColor", "metallic", "roughness", "sheen", "sheenTint", "clearcoat", "clearcoatGloss",
                 "scatterDistance", "emission", "specTrans", "attenuationColor", "attenuationDistance", "priority")
UNSUPPORTED = {"anisotropic": 0, "specularTint": 0, "scatterAnisotropy": 0, "thin": False}
LIGHT_KEYS = {"name", "type", "intensity", "exposure", "color", "width", "height", "radius", "position", "target", "up",
              "texture:file", "visibleToCamera"}


class Unsupported(Exception):
    """The scene needs something that has no counterpart in the other renderers; the text says what."""


class Glb:
    def __init__(self, path):
        data = pathlib.Path(path).read_bytes()
        length = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20:20 + length])
        self.binary = data[28 + length:]

    def view(self, index):
        view = self.json["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return view, self.binary[start:start + view["byteLength"]]

    def accessor(self, index):
        """A list of numbers, or of tuples for vectors."""
        accessor = self.json["accessors"][index]
        view, data = self.view(accessor["bufferView"])
        n = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        code = "f" if accessor["componentType"] == FLOAT else INDEX_CODES[accessor["componentType"]]
        layout = struct.Struct("<%d%s" % (n, code))
        stride, start = view.get("byteStride", layout.size), accessor.get("byteOffset", 0)
        values = [layout.unpack_from(data, start + i * stride) for i in range(accessor["count"])]
        return [v[0] for v in values] if n == 1 else values


def polygons_of(indices):
    """FB_ngon_encoding: consecutive triangles that start at the same vertex are one polygon."""
    polygons = []
    for i in range(0, len(indices), 3):
        a, b, c = indices[i:i + 3]
        if polygons and polygons[-1][0] == a and polygons[-1][-1] == b:
            polygons[-1].append(c)
        else:
            polygons.append([a, b, c])
    return polygons


def weld(points, polygons):
    """One vertex per place, as our reader of FB_ngon_encoding makes."""
    index_of, kept, welded = {}, [], []
    for p in points:
        if p not in index_of:
            index_of[p] = len(kept)
            kept.append(p)
        welded.append(index_of[p])
    faces = []
    for polygon in polygons:
        face = [welded[v] for v in polygon]
        face = [v for i, v in enumerate(face) if v != face[i - 1]]
        if len(set(face)) >= 3:
            faces.append(face)
    return kept, faces


def mean(points):
    n = 1.0 / len(points)
    return (n * sum(p[0] for p in points), n * sum(p[1] for p in points), n * sum(p[2] for p in points))


def moved_point(p, face_points, edges):
    """Catmull and Clark 1978; boundary points by the boundary's own rule, a point of one face stays."""
    boundary = [m for m, count in edges if count == 1]
    if len(face_points) == 1:
        return p
    if boundary:
        b = mean(boundary)
        return tuple(0.5 * (x + y) for x, y in zip(p, b))
    n = len(edges)
    f, e = mean(face_points), mean([m for m, _ in edges])
    return tuple((x + 2 * y + (n - 3) * z) / n for x, y, z in zip(f, e, p))


def catmull_clark(points, faces):
    """One level: as many points as vertices, faces and edges; quads."""
    face_points = [mean([points[v] for v in face]) for face in faces]
    faces_of_edge, faces_of_point = {}, [[] for _ in points]
    for i, face in enumerate(faces):
        for k, v in enumerate(face):
            faces_of_edge.setdefault((min(v, face[k - 1]), max(v, face[k - 1])), []).append(i)
            faces_of_point[v].append(face_points[i])
    edges_of_point = [[] for _ in points]
    edge_points, edge_index = [], {}
    for (a, b), sides in faces_of_edge.items():
        middle = mean([points[a], points[b]])
        edge_index[a, b] = edge_index[b, a] = len(points) + len(faces) + len(edge_points)
        inner = len(sides) == 2
        edge_points.append(mean([points[a], points[b], face_points[sides[0]], face_points[sides[1]]]) if inner else middle)
        for v in (a, b):
            edges_of_point[v].append((middle, len(sides)))
    moved = [moved_point(p, f, e) if f else p for p, f, e in zip(points, faces_of_point, edges_of_point)]
    quads = []
    for i, face in enumerate(faces):
        for k, v in enumerate(face):
            following = face[(k + 1) % len(face)]
            quads.append([v, edge_index[v, following], len(points) + i, edge_index[face[k - 1], v]])
    return moved + face_points + edge_points, quads


def area_normals(points, triangles):
    sums = [[0.0, 0.0, 0.0] for _ in points]
    for a, b, c in triangles:
        n = formulas.cross([y - x for x, y in zip(points[a], points[b])], [y - x for x, y in zip(points[a], points[c])])
        for v in (a, b, c):
            s = sums[v]
            s[0] += n[0]
            s[1] += n[1]
            s[2] += n[2]
    return [formulas.normalized(s) for s in sums]


def fan(faces):
    return [(face[0], face[k], face[k + 1]) for face in faces for k in range(1, len(face) - 1)]


def primitive_triangles(glb, primitive, level):
    points = glb.accessor(primitive["attributes"]["POSITION"])
    indices = glb.accessor(primitive["indices"])
    if "FB_ngon_encoding" in primitive.get("extensions", {}):
        points, faces = weld(points, polygons_of(indices))
        for _ in range(level):
            points, faces = catmull_clark(points, faces)
        triangles = fan(faces)
        return points, area_normals(points, triangles), triangles
    triangles = list(zip(indices[0::3], indices[1::3], indices[2::3]))
    if "NORMAL" in primitive["attributes"]:
        return points, glb.accessor(primitive["attributes"]["NORMAL"]), triangles
    flat = [points[v] for triangle in triangles for v in triangle]  # glTF: without normals, flat
    triangles = [(i, i + 1, i + 2) for i in range(0, len(flat), 3)]
    return flat, area_normals(flat, triangles), triangles


def product(a, b):
    """Column vectors, rows of rows: a b."""
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def node_matrix(node):
    if "matrix" in node:
        return [[node["matrix"][4 * j + i] for j in range(4)] for i in range(4)]
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    s, t = node.get("scale", (1, 1, 1)), node.get("translation", (0, 0, 0))
    r = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return [[r[i][j] * s[j] for j in range(3)] + [t[i]] for i in range(3)] + [[0, 0, 0, 1]]


def placed_meshes(glb, index, parent):
    node = glb.json["nodes"][index]
    matrix = product(parent, node_matrix(node))
    if "mesh" in node:
        yield node["mesh"], matrix
    for child in node.get("children", []):
        yield from placed_meshes(glb, child, matrix)


def to_world(matrix, points, normals):
    m = [row[:3] for row in matrix[:3]]
    cofactors = [formulas.cross(m[1], m[2]), formulas.cross(m[2], m[0]), formulas.cross(m[0], m[1])]
    if sum(a * b for a, b in zip(m[0], cofactors[0])) <= 0:
        raise Unsupported("a mesh that is mirrored")
    moved = [tuple(sum(m[i][k] * p[k] for k in range(3)) + matrix[i][3] for i in range(3)) for p in points]
    return moved, [formulas.normalized([sum(c[k] * n[k] for k in range(3)) for c in cofactors]) for n in normals]


def mean_of_png(data):
    """Linear mean of an 8-bit RGB PNG with unfiltered rows, as testenv/scenes/gltf_writer.py makes."""
    width, height, depth, kind = struct.unpack_from(">IIBB", data, 16)
    if (depth, kind) != (8, 2):
        raise Unsupported("a texture other than 8-bit RGB")
    at, packed = 8, b""
    while at < len(data):
        length, tag = struct.unpack_from(">I4s", data, at)
        if tag == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += 12 + length
    rows, counts = zlib.decompress(packed), [[0] * 256 for _ in range(3)]
    for y in range(height):
        start = y * (3 * width + 1)
        if rows[start] != 0:
            raise Unsupported("a PNG with filtered rows")
        for c in range(3):
            for value in rows[start + 1 + c:start + 3 * width + 1:3]:
                counts[c][value] += 1
    linear = [v / 255 / 12.92 if v <= 10 else ((v / 255 + 0.055) / 1.055) ** 2.4 for v in range(256)]
    return [sum(n * v for n, v in zip(channel, linear)) / (width * height) for channel in counts]


def disney_of(glb, material):
    extensions = material.get("extensions", {})
    if "ALAB_materials_disney" not in extensions:
        return None
    disney = dict(extensions["ALAB_materials_disney"])
    pbr = material.get("pbrMetallicRoughness", {})
    disney.setdefault("baseColor", pbr.get("baseColorFactor", [0.8, 0.8, 0.8])[:3])
    disney.setdefault("metallic", pbr.get("metallicFactor", 0.0))
    disney.setdefault("roughness", pbr.get("roughnessFactor", 0.5))
    if "baseColorTexture" in pbr:
        source = glb.json["textures"][pbr["baseColorTexture"]["index"]]["source"]
        texture = mean_of_png(glb.view(glb.json["images"][source]["bufferView"])[1])
        disney["baseColor"] = [a * b for a, b in zip(disney["baseColor"], texture)]
    return disney


def neutral_material(name, disney):
    """The parameters that all renderers share, with `specular` folded into `ior`."""
    for key, default in UNSUPPORTED.items():
        if disney.get(key, default) != default:
            raise Unsupported(f"{key} of material {name}")
    if any(isinstance(disney.get(key), dict) for key in ("baseColor", "scatterDistance")):
        raise Unsupported(f"a texture in the description's material {name}")
    clear = disney.get("specTrans", 0)
    if clear not in (0, 1) or (clear == 1 and disney.get("baseColor") != [1, 1, 1] and "scatterDistance" not in disney):
        raise Unsupported(f"partly clear or tinted glass of material {name}")
    f0 = formulas.f0_from_ior(disney.get("ior", 1.5)) * disney.get("specular", 1.0)
    shared = {key: disney[key] for key in MATERIAL_KEYS if key in disney}
    return {"baseColor": [0.8, 0.8, 0.8], "metallic": 0.0, "roughness": 0.5, **shared, "ior": formulas.ior_from_f0(f0)}


def scene_of(description, folder):
    """({name: material or None}, [(material name, points, normals, triangles)])"""
    materials, meshes = {}, []
    if "meshes" in description:
        raise Unsupported("changes to meshes")
    for model in description["gltf"]:
        if not model["file"].endswith(".glb") or "transform" in model:
            raise Unsupported("models other than .glb in their own place")
        glb = Glb(folder / model["file"])
        names = [m.get("name", f"material{i}") for i, m in enumerate(glb.json["materials"])]
        for name, material in zip(names, glb.json["materials"]):
            materials[name] = disney_of(glb, material)
        identity = [[float(i == j) for j in range(4)] for i in range(4)]
        for root in glb.json["scenes"][glb.json.get("scene", 0)]["nodes"]:
            for mesh, matrix in placed_meshes(glb, root, identity):
                for primitive in glb.json["meshes"][mesh]["primitives"]:
                    points, normals, triangles = primitive_triangles(glb, primitive, model.get("refineLevel", 2))
                    points, normals = to_world(matrix, points, normals)
                    meshes.append((names[primitive["material"]], points, normals, triangles))
    for change in description.get("materials", []):
        matched = fnmatch.filter(materials, change.get("match", ""))
        if not matched:
            raise Unsupported(f"a change of material {change.get('match', change.get('name'))}, of which no model has the name")
        for name in matched:
            materials[name] = change.get("replace") or {**(materials[name] or {}), **change["set"]}
    return materials, meshes


def write_glb(path, materials, meshes):
    document = {"asset": {"version": "2.0"}, "extensionsUsed": ["ALAB_materials_disney"], "scene": 0,
                "scenes": [{"nodes": list(range(len(meshes)))}], "nodes": [], "meshes": [], "accessors": [], "bufferViews": []}
    names, binary = list(materials), bytearray()
    document["materials"] = [{"name": n, "extensions": {"ALAB_materials_disney": materials[n]}} for n in names]

    def accessor(code, values, component, kind, size):
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": 4 * len(values)})
        binary.extend(array.array(code, values).tobytes())
        document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1, "componentType": component,
                                      "type": kind, "count": len(values) // size})
        return len(document["accessors"]) - 1

    for i, (material, points, normals, triangles) in enumerate(meshes):
        position = accessor("f", [c for p in points for c in p], FLOAT, "VEC3", 3)
        bounds = document["accessors"][position]
        stored = array.array("f", [c for p in points for c in p])
        bounds["min"], bounds["max"] = [min(stored[c::3]) for c in range(3)], [max(stored[c::3]) for c in range(3)]
        normal = accessor("f", [c for n in normals for c in n], FLOAT, "VEC3", 3)
        indices = accessor("I", [v for t in triangles for v in t], UINT32, "SCALAR", 1)
        document["nodes"].append({"name": f"mesh{i}", "mesh": i})
        document["meshes"].append({"primitives": [{"attributes": {"POSITION": position, "NORMAL": normal}, "indices": indices,
                                                   "material": names.index(material)}]})
    document["buffers"] = [{"byteLength": len(binary)}]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as out:
        out.write(struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(binary), len(text), b"JSON") + text)
        out.write(struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def checked_light(light, folder):
    if "match" in light or not set(light) <= LIGHT_KEYS or light["type"] not in ("rectLight", "sphereLight", "domeLight"):
        raise Unsupported(f"light {light.get('name', light.get('match'))}")
    light = dict(light)
    if light.get("texture:file"):
        light["texture:file"] = str((folder / light["texture:file"]).resolve())
    light["intensity"] = light.get("intensity", 1) * 2 ** light.pop("exposure", 0)
    return light


def write_neutral(description_path, folder):
    """Writes scene.json and scene.glb to `folder`; raises Unsupported."""
    source = pathlib.Path(description_path)
    description = json.loads(source.read_text())
    materials, meshes = scene_of(description, source.parent)
    used = {name for name, *_ in meshes}
    for name in used:
        if materials[name] is None:
            raise Unsupported(f"material {name} without ALAB_materials_disney: replace it in the description")
    if "lookAt" not in description.get("camera", {}):
        raise Unsupported("a camera without lookAt")
    write_scene(folder, {
        "gltf": [{"file": "scene.glb", "refineLevel": 0}],
        "lights": [checked_light(light, source.parent) for light in description["lights"]],
        "camera": description["camera"],
        "settings": {"filter": "box", "maxDepth": description.get("settings", {}).get("maxDepth", 8)}},
        {name: neutral_material(name, materials[name]) for name in materials if name in used}, meshes)


def write_scene(folder, description, materials, meshes):
    folder.mkdir(parents=True, exist_ok=True)
    write_glb(folder / "scene.glb", materials, meshes)
    (folder / "scene.json").write_text(json.dumps(description, indent=1))


def write_slab(folder):
    """A white sky above a box so large in mean free paths (90 from its middle to every wall) that it is a half-space of A = .8."""
    points, normals, triangles = [], [], []
    for axis in range(3):
        for sign in (1, -1):
            corners = [(1, -1), (1, 1), (-1, 1), (-1, -1)][::sign]
            for s, t in corners:
                p = [0.0, 0.0, 0.0]
                p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = sign, s, t
                points.append((p[0], p[1] - 1, p[2]))
                normals.append([float(sign) if k == axis else 0.0 for k in range(3)])
            first = len(points) - 4
            triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    medium = {"baseColor": [0.8] * 3, "metallic": 0.0, "roughness": 0.5, "ior": 1.0, "scatterDistance": [0.01] * 3}
    write_scene(folder, {
        "gltf": [{"file": "scene.glb", "refineLevel": 0}],
        "lights": [{"name": "sky", "type": "domeLight", "intensity": 1, "color": [1, 1, 1]}],
        "camera": {"lookAt": {"eye": [0, 1, 0], "target": [0, 0, 0], "up": [0, 0, -1]}, "focalLength": 180,
                   "horizontalAperture": 36, "verticalAperture": 36},
        "settings": {"filter": "box", "maxDepth": 8}}, {"slab": medium}, [("slab", points, normals, triangles)])
