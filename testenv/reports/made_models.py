"""glTF files of a few lines, for reports. Standard library and numpy only."""
import base64
import json
import struct

import numpy as np

KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
COMPONENTS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
CORNERS = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
UV = [(0, 1), (1, 1), (1, 0), (0, 0)]  # v grows downwards
QUAD = [0, 1, 2, 0, 2, 3]
CUBE = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
CUBE_SIDES = [0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5]


class Model:
    """A glTF document under construction. Its camera looks down -z at [-1, 1] x [-1, 1], without perspective."""

    def __init__(self, camera=True):
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "accessors": [],
                     "bufferViews": []}
        self.binary = bytearray()
        if camera:
            self.json["cameras"] = [{"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": .1, "zfar": 100}}]
            self.node(camera=0, translation=[0, 0, 5])

    def view(self, data):
        self.binary.extend(bytes(-len(self.binary) % 4))
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary.extend(data)
        return len(self.json["bufferViews"]) - 1

    def add(self, key, value):
        self.json.setdefault(key, []).append(value)
        return len(self.json[key]) - 1

    def accessor(self, values, dtype="f4", **more):
        array = np.asarray(values).astype("<" + dtype)
        array = array.reshape(len(array), -1)
        stored = array
        if array.itemsize * array.shape[1] % 4 and array.shape[1] > 1:  # vertices start at multiples of four bytes
            stored = np.zeros((len(array), array.shape[1] + 1 if dtype[1] == "1" else -(-array.shape[1] // 2) * 2), array.dtype)
            stored[:, :array.shape[1]] = array
        view = self.view(stored.tobytes())
        if stored is not array:
            self.json["bufferViews"][view]["byteStride"] = stored.shape[1] * stored.itemsize
        value = {"bufferView": view, "componentType": COMPONENTS[dtype], "count": len(array), "type": KINDS[array.shape[1]], **more}
        if dtype == "f4":
            value["min"], value["max"] = array.min(axis=0).tolist(), array.max(axis=0).tolist()
        return self.add("accessors", value)

    def primitive(self, points=CORNERS, indices=QUAD, attributes=None, **more):
        """`attributes`: {name: values or the index of an accessor}."""
        given = {"POSITION": points, **(attributes or {})}
        accessors = {name: v if isinstance(v, int) else self.accessor(v) for name, v in given.items()}
        value = {"attributes": accessors, **more}
        if indices is not None:
            value["indices"] = self.accessor(indices, "u2")
        return value

    def mesh(self, *primitives, **more):
        return self.add("meshes", {"primitives": list(primitives), **more})

    def node(self, root=True, **fields):
        index = self.add("nodes", fields)
        if root:
            self.json["scenes"][0]["nodes"].append(index)
        return index

    def square(self, material=None, attributes=None, **fields):
        """A node with the square that fills the picture."""
        more = {} if material is None else {"material": material}
        return self.node(mesh=self.mesh(self.primitive(attributes={"TEXCOORD_0": UV, "NORMAL": [(0, 0, 1)] * 4, **(attributes or {})}, **more)),
                         **fields)

    def image(self, data, mime="image/png", **sampler):
        source = self.add("images", {"bufferView": self.view(data), "mimeType": mime})
        return self.texture(source, **sampler)

    def texture(self, source, **sampler):
        return self.add("textures", {"source": source, "sampler": self.add("samplers", {"magFilter": 9728, **sampler})})

    def use(self, *extensions):
        used = self.json.setdefault("extensionsUsed", [])
        used += [e for e in extensions if e not in used]

    def unlit(self, color=(1, 1, 1, 1), texture=None, **more):
        """A material that shows its base colour exactly."""
        self.use("KHR_materials_unlit")
        base = {"baseColorFactor": list(color)}
        if texture is not None:
            base["baseColorTexture"] = texture if isinstance(texture, dict) else {"index": texture}
        return self.add("materials", {"pbrMetallicRoughness": base, "extensions": {"KHR_materials_unlit": {}}, **more})

    def document(self, buffer=None):
        return {**self.json, "buffers": [{"byteLength": len(self.binary), **(buffer or {})}]} if self.binary else self.json

    def write(self, file, buffer_uri=None, prefix=b""):
        """A .glb, or a .gltf whose buffer is a data URI or the file that `buffer_uri` names, which the caller writes."""
        self.binary.extend(bytes(-len(self.binary) % 4))
        if file.suffix == ".glb":
            text = json.dumps(self.document(), ensure_ascii=False).encode()
            text += b" " * (-len(text) % 4)
            file.write_bytes(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(self.binary)) + struct.pack("<I4s", len(text), b"JSON") +
                             text + struct.pack("<I4s", len(self.binary), b"BIN\0") + self.binary)
        else:
            uri = buffer_uri or "data:application/octet-stream;base64," + base64.b64encode(self.binary).decode()
            file.write_bytes(prefix + json.dumps(self.document({"uri": uri}), ensure_ascii=False).encode())
        return file
