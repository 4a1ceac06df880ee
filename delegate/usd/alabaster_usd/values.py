"""Values of fields with their types, and the scene archive that they are written to (delegate/archive/archive.h)."""
import json
import math
import os
from collections import namedtuple

from pxr import Gf, Sdf, Usd, Vt

V = namedtuple("V", "type data")  # `type` as in archives; of an array "float3[]", and the data is a buffer
Samples = namedtuple("Samples", "times values")
Asset = namedtuple("Asset", "authored file bytes fault", defaults=(None, ""))  # file "": none; bytes: of an image in a package

KINDS = {"bool": ("BOOL", 1, 1), "int": ("I32", 4, 1), "int64": ("I64", 8, 1), "uint": ("U32", 4, 1), "float": ("F32", 4, 1),
         "double": ("F64", 8, 1), "float2": ("F32", 4, 2), "float3": ("F32", 4, 3), "float4": ("F32", 4, 4), "int2": ("I32", 4, 2),
         "int3": ("I32", 4, 3), "double2": ("F64", 8, 2), "double3": ("F64", 8, 3), "double4": ("F64", 8, 4), "half": ("F16", 2, 1),
         "half2": ("F16", 2, 2), "half3": ("F16", 2, 3), "half4": ("F16", 2, 4), "matrix": ("F64", 8, 16), "quaternion": ("F32", 4, 4),
         "quaternion of halves": ("F16", 2, 4)}
ARRAYS = {"FloatArray": "float", "Vec2fArray": "float2", "Vec3fArray": "float3", "Vec4fArray": "float4", "DoubleArray": "double",
          "Vec2dArray": "double2", "Vec3dArray": "double3", "Vec4dArray": "double4", "HalfArray": "half", "Vec2hArray": "half2",
          "Vec3hArray": "half3", "Vec4hArray": "half4", "IntArray": "int", "Vec2iArray": "int2", "Vec3iArray": "int3",
          "Int64Array": "int64", "UIntArray": "uint", "BoolArray": "bool", "Matrix4dArray": "matrix"}
# float2 and not half2 of a single value: a scalar is written in decimals either way.
SCALARS = {Gf.Vec2f: "float2", Gf.Vec3f: "float3", Gf.Vec4f: "float4", Gf.Vec2d: "double2", Gf.Vec3d: "double3", Gf.Vec4d: "double4",
           Gf.Vec2h: "float2", Gf.Vec3h: "float3", Gf.Vec4h: "float4", Gf.Vec2i: "int2", Gf.Vec3i: "int3"}
PLAIN = {"half": "float", "double": "double", "int": "int", "int64": "int64", "uint": "uint"}


def matrix(m):
    return V("matrix", memoryview(m).cast("B").cast("d").tolist())


def token(text):
    return V("token", str(text))


def path(text):
    return V("path", str(text))


def array(kind, numbers):
    """An array of Python numbers, flat."""
    import array as arrays
    code = {"I32": "i", "F32": "f", "F64": "d"}[KINDS[kind][0]]
    return V(kind + "[]", arrays.array(code, numbers))


def value_of(given, type_name=""):
    """The value of an attribute; None: its type is no value of a scene. `type_name` tells one number's type."""
    kind = ARRAYS.get(type(given).__name__)
    if kind:
        return V(kind + "[]", given)
    if isinstance(given, bool):
        return V("bool", given)
    if isinstance(given, int):
        return V(PLAIN.get(type_name, "int") if abs(given) < 1 << 31 else "int64", given)
    if isinstance(given, float):
        return V(PLAIN.get(type_name, "float"), given)
    if isinstance(given, str):
        return V("token" if type_name == "token" else "string", given)
    if type(given) in SCALARS:
        return V(SCALARS[type(given)], [c for c in given])
    if isinstance(given, (Gf.Matrix4d, Gf.Matrix4f)):
        return matrix(given)
    if isinstance(given, (Vt.TokenArray, Vt.StringArray)):
        return V("token[]" if isinstance(given, Vt.TokenArray) else "string[]", list(given))
    return None


def color_space_of(attribute):
    """The name of an attribute's colour space: its own, or that of the nearest ColorSpaceAPI; "": none."""
    if attribute.HasColorSpace():
        return attribute.GetColorSpace()
    return str(Usd.ColorSpaceAPI.ComputeColorSpaceName(attribute, None)) if hasattr(Usd, "ColorSpaceAPI") else ""


def to_rec709(made, space):
    """A value of colours in linear Rec. 709, within which there are no negative ones; None: OpenUSD does not know the space."""
    if not hasattr(Gf, "ColorSpace") or not Gf.ColorSpace.IsValid(space) or made.type not in ("float3", "float3[]"):
        return None
    if space in ("lin_rec709_scene", "raw", "data", "unknown", "identity"):
        return made
    source, target = Gf.ColorSpace(space), Gf.ColorSpace("lin_rec709_scene")
    convert = lambda c: Gf.Vec3f(*(max(0.0, x) for x in target.Convert(source, Gf.Vec3f(*c)).GetRGB()))
    return V(made.type, Vt.Vec3fArray([convert(c) for c in made.data])) if made.type == "float3[]" else V(made.type, list(convert(made.data)))


class Archive:
    """A sink of edits that makes a scene archive: `set` a prim, `write` all of them."""

    def __init__(self):
        self.prims, self.tensors, self.known, self.facts = {}, [], {}, {}

    def set(self, path, kind, fields):
        self.prims[path] = (kind, fields)

    def edit(self, path, fields):
        self.prims[path][1].update(fields)

    def remove(self, path):
        self.prims.pop(path, None)

    def _tensor(self, kind, data):
        """The tensor over the memory of an array; one for all that hold the very same object."""
        known = self.known.get((id(data), kind))
        if known is None:
            dtype, size, parts = KINDS[kind] if kind else ("U8", 1, 1)
            view = memoryview(data)
            view = view if view.nbytes == 0 else view.cast("B")
            count = view.nbytes // (size * parts)
            shape = [count] + ([4, 4] if parts == 16 else [parts] if parts > 1 else [])
            known = str(len(self.tensors))
            self.tensors.append((known, dtype, size, shape, view))
            self.known[(id(data), kind)] = known
            self.facts.setdefault("held", []).append(data)  # so that no other object gets its id
        return known

    def _json(self, value):
        if value is None:
            return None
        kind, data = value
        if kind == "asset":
            written = {"authored": data.authored}
            if data.fault:
                written["fault"] = data.fault
            elif data.bytes is not None:
                written["bytes"] = self._tensor(None, data.bytes)
            elif data.file:
                written["file"] = data.file
            return {"asset": written}
        if kind == "samples":
            return {"samples": [[t, self._json(v)] for t, v in zip(data.times, data.values)]}
        if kind.endswith("[]") and kind[:-2] in KINDS:
            return {kind: self._tensor(kind[:-2], data)}
        numbers = data if isinstance(data, list) else [data]
        if kind in KINDS and not all(math.isfinite(n) for n in numbers):
            made = array("double" if kind in ("matrix", "double", "double2", "double3", "double4") else "float", numbers).data
            return {kind: self._tensor(kind, made)}
        return {kind: data}

    def write(self, fd, scene):
        """Writes the archive to a file descriptor. `scene` has what stands beside the prims."""
        prims = [{"path": p, "kind": kind, "fields": [[n, self._json(v)] for n, v in fields.items()]}
                 for p, (kind, fields) in sorted(self.prims.items())]
        text = json.dumps({"prims": prims, **scene}, separators=(",", ":"), ensure_ascii=False).encode("utf-8", "replace")
        self.tensors.append(("scene.json", "U8", 1, [len(text)], memoryview(text)))
        ordered = sorted(self.tensors, key=lambda t: -t[2])  # the largest elements first: each is aligned without gaps
        header, offset = {"__metadata__": {"format": "alabaster scene", "version": "2"}}, 0
        for name, dtype, _, shape, view in ordered:
            header[name] = {"dtype": dtype, "shape": shape, "data_offsets": [offset, offset + view.nbytes]}
            offset += view.nbytes
        head = json.dumps(header, separators=(",", ":")).encode()
        head += b" " * (-len(head) % 8)
        pieces = [len(head).to_bytes(8, "little") + head] + [t[4] for t in ordered if t[4].nbytes]
        for first in range(0, len(pieces), 1000):
            group = pieces[first:first + 1000]
            written = os.writev(fd, group)
            for piece in group:  # what a full pipe or a large array has left
                rest = memoryview(piece)[max(0, min(written, len(piece))):]
                written -= len(piece)
                while rest.nbytes:
                    rest = rest[os.write(fd, rest):]


def may_read(file):
    """Whether a file may be read; a program that limits it puts another function here."""
    return True


def is_path_in_package(text):
    return "[" in text and text.endswith("]")


def resolved_asset(asset, attribute, time):
    """(file, is_there): the absolute path of the file that an attribute's asset path names, beside the layer that gave it."""
    from pxr import Ar, UsdShade
    layer = layer_of(attribute, time)
    text = asset.path
    if not text:
        return "", True
    if UsdShade.UdimUtils.IsUdimIdentifier(text):
        found = UsdShade.UdimUtils.ResolveUdimPath(text, layer) if layer else ""
        if found:
            return str(found), True
    elif asset.resolvedPath:
        return asset.resolvedPath, True
    folder = os.path.dirname(layer.realPath) if layer else ""
    return os.path.normpath(os.path.join(folder or "/", text)), False


def layer_of(attribute, time):
    """The layer whose opinion is the attribute's value."""
    stack = attribute.GetPropertyStack(time)
    for spec in stack:
        if spec.HasInfo("default") or spec.layer.GetNumTimeSamplesForPath(spec.path):
            return spec.layer
    return stack[0].layer if stack else None


def file_of(layer):
    """A layer that was made of a file of MaterialX names it as its comment."""
    return layer.realPath or layer.comment


def asset_value(asset, attribute, time):
    """The value of an asset path; an image in a package is read, for there is no file of its name."""
    file, there = resolved_asset(asset, attribute, time)
    if there and is_path_in_package(file):
        held = _tiles(asset, attribute, time) if "<UDIM>" in file else _bytes(file)
        return V("asset", Asset(asset.path, file, held)), held is not None
    if file and not may_read(file):
        outside = file + " lies outside the folder of the stage: allow it with --allow FOLDER or --allow-outside"
        return V("asset", Asset(asset.path, "", fault=outside)), True
    absent = "" if there else "there is no file %s, which %s names; correct the path or put the file there" % (file, file_of(layer_of(attribute, time)))
    return V("asset", Asset(asset.path, file, fault=absent)), there


def _bytes(file):
    from pxr import Ar
    held = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(file))
    return bytes(held.GetBuffer()) if held else None


def _tiles(asset, attribute, time):
    """A set of images as one (core/texture/udim.h)."""
    from pxr import UsdShade
    tiles = sorted((int(number), str(file)) for file, number in UsdShade.UdimUtils.ResolveUdimTilePaths(asset.path, layer_of(attribute, time)))
    images = [(number, _bytes(file)) for number, file in tiles]
    return b"UDIM" + b"".join(n.to_bytes(4, "little") + len(b).to_bytes(8, "little") + b for n, b in images if b) if images else None
