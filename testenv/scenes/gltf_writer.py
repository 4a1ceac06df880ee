"""Writes quad meshes as binary glTF with FB_ngon_encoding, for the scene scripts. Standard library only."""
import json
import struct
import zlib


class Mesh:
    """Quads over shared points, with one uv per face corner (v up)."""

    def __init__(self):
        self.points = []   # (x, y, z)
        self.quads = []    # 4 point indices, counter-clockwise seen from outside
        self.uvs = []      # 4 (u, v) per quad

    def add_grid(self, rows, uv_of=None, closed_u=False, flip=False):
        """Adds rows with equal numbers of points and joins consecutive rows by quads. Returns the index of the first point."""
        first, n = len(self.points), len(rows[0])
        for row in rows:
            self.points.extend(row)
        for i in range(len(rows) - 1):
            for j in range(n if closed_u else n - 1):
                k = (j + 1) % n
                a, b, c, d = (first + i * n + j, first + i * n + k, first + (i + 1) * n + k, first + (i + 1) * n + j)
                corners = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)]
                quad = [a, b, c, d]
                uv = [uv_of(ci, cj) if uv_of else (0.0, 0.0) for ci, cj in corners]
                if flip:
                    quad.reverse()
                    uv.reverse()
                self.quads.append(quad)
                self.uvs.append(uv)
        return first


def png(width, height, pixel):
    """Bytes of an 8-bit RGB PNG; pixel(x, y) gives 3 floats in 0..1, row 0 at the top."""
    rows = bytearray()
    for y in range(height):
        rows.append(0)
        for x in range(width):
            rows.extend(min(255, max(0, round(c * 255))) for c in pixel(x, y))

    def chunk(tag, data):
        return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(rows), 9)) +
            chunk(b"IEND", b""))


class Document:
    """A glTF document under construction."""

    def __init__(self, generator):
        self.json = {"asset": {"version": "2.0", "generator": generator}, "extensionsUsed": [], "scene": 0,
                     "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "materials": [], "accessors": [],
                     "bufferViews": [], "buffers": []}
        self.binary = bytearray()

    def use(self, extension):
        if extension not in self.json["extensionsUsed"]:
            self.json["extensionsUsed"].append(extension)

    def _view(self, data, target=None):
        while len(self.binary) % 4:
            self.binary.append(0)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        if target:
            view["target"] = target
        self.binary.extend(data)
        self.json["bufferViews"].append(view)
        return len(self.json["bufferViews"]) - 1

    def _accessor(self, view, component, kind, count, bounds=None):
        accessor = {"bufferView": view, "componentType": component, "type": kind, "count": count}
        if bounds:
            accessor["min"], accessor["max"] = bounds
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def add_texture(self, name, png_bytes):
        view = self._view(png_bytes)
        self.json.setdefault("images", []).append({"name": name, "mimeType": "image/png", "bufferView": view})
        self.json.setdefault("samplers", [{"wrapS": 33071, "wrapT": 33071}])
        self.json.setdefault("textures", []).append({"source": len(self.json["images"]) - 1, "sampler": 0})
        return len(self.json["textures"]) - 1

    def add_material(self, name, disney, texture=None, normal=None):
        """`texture` of baseColor and `normal` map: of add_texture."""
        self.use("ALAB_materials_disney")
        base = {"metallicFactor": 0.0, "roughnessFactor": disney.get("roughness", 0.5)}
        color = disney.get("baseColor", [0.8, 0.8, 0.8])
        base["baseColorFactor"] = list(color) + [1.0]
        if texture is not None:
            base["baseColorTexture"] = {"index": texture}
        self.json["materials"].append({"name": name, "pbrMetallicRoughness": base,
                                       "extensions": {"ALAB_materials_disney": disney}})
        if normal is not None:
            self.json["materials"][-1]["normalTexture"] = {"index": normal}
        return len(self.json["materials"]) - 1

    def add_mesh(self, name, mesh, material):
        """Corners with equal (point, uv) share a vertex. No polygon starts at the same vertex as its predecessor."""
        self.use("FB_ngon_encoding")
        vertices, index_of, indices, previous = [], {}, [], None
        for quad, uv in zip(mesh.quads, mesh.uvs):
            corners = []
            for point, st in zip(quad, uv):
                key = (point, st)
                if key not in index_of:
                    index_of[key] = len(vertices)
                    vertices.append((mesh.points[point], (st[0], 1.0 - st[1])))
                corners.append(index_of[key])
            if corners[0] == previous:
                corners = corners[1:] + corners[:1]
            previous = corners[0]
            indices += [corners[0], corners[1], corners[2], corners[0], corners[2], corners[3]]
        positions = b"".join(struct.pack("<3f", *p) for p, _ in vertices)
        uvs = b"".join(struct.pack("<2f", *t) for _, t in vertices)
        packed = [struct.unpack("<3f", positions[12 * i:12 * i + 12]) for i in range(len(vertices))]
        bounds = ([min(p[c] for p in packed) for c in range(3)], [max(p[c] for p in packed) for c in range(3)])
        wide = len(vertices) > 65535
        primitive = {
            "attributes": {
                "POSITION": self._accessor(self._view(positions, 34962), 5126, "VEC3", len(vertices), bounds),
                "TEXCOORD_0": self._accessor(self._view(uvs, 34962), 5126, "VEC2", len(vertices))},
            "indices": self._accessor(
                self._view(struct.pack("<%d%s" % (len(indices), "I" if wide else "H"), *indices), 34963),
                5125 if wide else 5123, "SCALAR", len(indices)),
            "material": material, "extensions": {"FB_ngon_encoding": {}}}
        self.json["meshes"].append({"name": name, "primitives": [primitive]})
        return len(self.json["meshes"]) - 1

    def add_node(self, name, mesh, matrix=None):
        """`matrix`: 16 numbers in glTF's column-major order."""
        node = {"name": name, "mesh": mesh}
        if matrix:
            node["matrix"] = matrix
        self.json["nodes"].append(node)
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)

    def write_glb(self, path):
        while len(self.binary) % 4:
            self.binary.append(0)
        self.json["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        total = 12 + 8 + len(text) + 8 + len(self.binary)
        with open(path, "wb") as out:
            out.write(struct.pack("<4sII", b"glTF", 2, total))
            out.write(struct.pack("<I4s", len(text), b"JSON") + text)
            out.write(struct.pack("<I4s", len(self.binary), b"BIN\0") + bytes(self.binary))
