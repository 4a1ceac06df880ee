"""Materials: networks as they were authored, as edits. What they mean is decided behind the contract."""
from pxr import Sdf, Usd, UsdShade

from .values import V, asset_value, color_space_of, path, to_rec709, token, value_of

# The contexts of a surface, those that are read best first.
CONTEXTS = ["alabaster", "mtlx", ""]
# Those that delegate/looks reads, and ours.
READ = ("AlabasterDisney", "UsdPreviewSurface", "ND_UsdPreviewSurface_surfaceshader", "ND_standard_surface_surfaceshader",
        "ND_standard_surface_surfaceshader_100", "ND_open_pbr_surface_surfaceshader", "ND_gltf_pbr_surfaceshader",
        "ND_disney_principled", "arnold:standard_surface", "arnold:openpbr_surface")
# MaterialX's nodes of the preview surface are those of USD under other names.
NATIVE = {"ND_UsdPreviewSurface_surfaceshader": "UsdPreviewSurface", "ND_UsdTransform2d": "UsdTransform2d",
          "ND_UsdPrimvarReader_vector2": "UsdPrimvarReader_float2"}


class Looks:
    def __init__(self, stage):
        self.stage, self.done = stage, {}
        self.nodes = {}  # a material's path -> the paths of what it is made of
        self.fallbacks = {}  # names of nodes whose image is missing -> what their file gives in its place

    def begin(self, sink, notes, time):
        self.sink, self.notes, self.time = sink, notes, time

    def renew(self, changed):
        """Writes again the materials that are made of something that has changed."""
        for where in list(self.done):
            if not changed.isdisjoint(self.nodes[where]):
                self.done[where] = self._write(UsdShade.Material(self.stage.GetPrimAtPath(where)), where)

    def bind(self, material):
        """The path of a bound material as a value, after its network has been written; None without one."""
        if not material:
            return None
        prim = material.GetPrim()
        where = str(prim.GetPath())
        if where not in self.done:
            self.done[where] = self._write(material, where)
        return path(where) if self.done[where] else None

    def _surface(self, material):
        """(shader, id) of the surface that is read best."""
        sources = list(self._sources(material, "surface", material.ComputeSurfaceSource))
        return next((s for s in sources if s[1] in READ), sources[0] if sources else (None, ""))

    def _sources(self, material, terminal, compute):
        """(shader, id) of a terminal's contexts, those that are read best first. One that has none would get that of all renderers."""
        of_vendors = {n.split(":")[1] for n in material.GetPrim().GetPropertyNames()
                      if n.startswith("outputs:") and n.endswith(":" + terminal) and n.count(":") == 2}
        for context in CONTEXTS + sorted(of_vendors - set(CONTEXTS)):
            output = material.GetOutput(context + ":" + terminal if context else terminal)
            shader = compute(context)[0] if output and output.HasConnectedSource() else None
            if shader:
                yield shader, self._id(shader)

    @staticmethod
    def _id(shader):
        name = shader.GetShaderId() or shader.GetPrim().GetAttribute("info:id").Get()
        return str(name) if name else shader.GetPrim().GetTypeName() or "no id"

    def _write(self, material, where):
        self.nodes[where] = {material.GetPath()}
        shader, kind = self._surface(material)
        if not shader:
            if material.GetVolumeOutput().HasConnectedSource():
                self.notes.tell("materials of volumes are not read: their objects are left out or have the default material", where)
            elif material.GetPrim().GetChildren():
                self.notes.tell("materials without a surface have the default material", where)
            return False
        fields, self.fallbacks = {}, {}
        self._node(where, shader, fields, set())
        fields["surface"] = path(self._name(where, shader.GetPrim()) + ".out")
        shapes = list(self._sources(material, "displacement", material.ComputeDisplacementSource))
        shape = next((s for s, kind in shapes if kind == "AlabasterDisplacement" or kind.startswith("ND_displacement_")), None)
        if shape:
            self._node(where, shape, fields, set())
            fields["displacement"] = path(self._name(where, shape.GetPrim()) + ".out")
        elif any(s.GetPath() != shader.GetPath() for s, _ in shapes):  # a surface that displaces has it as an input
            self.notes.tell("displacements of type %s are not read" % shapes[0][1], where)
        self.sink.set(where, "material", fields)
        return True

    @staticmethod
    def _name(where, prim):
        name = str(prim.GetPath())
        return name[len(where) + 1:] if name.startswith(where + "/") else name

    def _node(self, where, shader, fields, visiting):
        prim = shader.GetPrim()
        name = self._name(where, prim)
        if name + ".type" in fields or len(visiting) > 200:
            return
        kind = self._id(shader)
        self.nodes[where].add(prim.GetPath())
        fields[name + ".type"] = token(NATIVE.get(kind, kind))
        is_ours = kind.startswith("Alabaster")
        for given in shader.GetInputs():
            if given.GetBaseName() in ("texcoord", "st") and kind == "ND_UsdPrimvarReader_vector2":
                continue
            self._input(where, name, given, fields, visiting | {name}, is_ours, kind)

    def _input(self, where, name, given, fields, visiting, is_ours, kind):
        base = given.GetBaseName()
        key = name + "." + base
        produced = UsdShade.Utils.GetValueProducingAttributes(given)
        upstream = []
        for attribute in produced:
            if UsdShade.Utils.GetType(attribute.GetName()) == UsdShade.AttributeType.Output:
                source = UsdShade.Shader(attribute.GetPrim())
                self._node(where, source, fields, visiting)
                upstream.append(self._name(where, attribute.GetPrim()) + "." + attribute.GetName()[len("outputs:"):])
        if upstream and upstream[0].rsplit(".", 1)[0] in self.fallbacks:
            color, output = self.fallbacks[upstream[0].rsplit(".", 1)[0]], upstream[0].rsplit(".", 1)[1]
            fields[key] = V("float%d" % len(output), color[:len(output)]) if output in ("rgb", "rgba") else V("float", color["rgba".find(output)])
            return
        if upstream:
            fields[key] = V("path[]", upstream)
            return
        attribute = produced[0] if produced else None
        if attribute:
            self.nodes[where].add(attribute.GetPrim().GetPath())
        if attribute and attribute.GetCustomDataByKey("unit"):
            self.notes.tell("units of MaterialX are not read: lengths are those of the scene", "%s of %s" % (key, where))
        value = attribute.Get(self.time) if attribute else None
        if value is None:
            return
        is_color = str(attribute.GetTypeName()).startswith("color")
        space = color_space_of(attribute) if is_color else attribute.GetColorSpace() if attribute.HasColorSpace() else ""
        if not isinstance(value, Sdf.AssetPath):
            made = value_of(value, str(attribute.GetTypeName()))
            converted = to_rec709(made, space) if is_color and space and made is not None and not is_ours else None
            made, space = (converted, "") if converted else (made, space)
            if made is not None:
                fields[key] = made
        if space and not is_ours:
            fields[name + ".colorSpace:" + base] = token(space)
        if not isinstance(value, Sdf.AssetPath):
            return
        if not value.path:
            return
        fields[key], there = asset_value(value, attribute, self.time)
        fallback = given.GetPrim().GetAttribute("inputs:fallback").Get(self.time) if not there and NATIVE.get(kind, kind) == "UsdUVTexture" else None
        if fallback is not None and base == "file":
            self.notes.tell("images are missing, and their nodes' fallback is used", "%s of %s" % (fields.pop(key).data.file, where))
            self.fallbacks[name] = [float(c) for c in fallback]
            return
