"""Lights of UsdLux. Values that a file leaves out are the schema's, such as intensity 50000 of a DistantLight."""
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from .values import V, asset_value, color_space_of, matrix, path, to_rec709, token, value_of

TYPES = {"RectLight": "rectLight", "DiskLight": "diskLight", "CylinderLight": "cylinderLight", "SphereLight": "sphereLight",
         "DistantLight": "distantLight", "DomeLight": "domeLight", "DomeLight_1": "domeLight"}
UNREAD = {"PortalLight": "portals of domes are not read", "GeometryLight": "lights by geometry are not read",
          "PluginLight": "lights of plug-ins are not read"}
COMMON = ("intensity", "exposure", "diffuse", "specular", "color", "enableColorTemperature", "colorTemperature")
OWN = {"rectLight": ("normalize", "width", "height", "texture:file"), "diskLight": ("normalize", "radius"),
       "cylinderLight": ("normalize", "radius", "length"), "sphereLight": ("normalize", "radius"), "distantLight": ("normalize", "angle"),
       "domeLight": ("texture:file",)}
SHAPING = ("shaping:cone:angle", "shaping:cone:softness", "shaping:focus", "shaping:focusTint", "shaping:ies:file",
           "shaping:ies:angleScale", "shaping:ies:normalize")


def is_light(prim):
    return prim.GetTypeName() in TYPES


def tell_unread(prim, notes):
    """Of a prim that is no light of TYPES."""
    if prim.GetTypeName() in UNREAD:
        notes.tell(UNREAD[prim.GetTypeName()], prim.GetPath())
    elif prim.GetTypeName().endswith("LightFilter") or prim.GetTypeName() == "LightFilter":
        notes.tell("filters of lights are not read", prim.GetPath())


def light_fields(prim, world, visible, time, up, links, notes):
    kind = TYPES[prim.GetTypeName()]
    fields = {}
    names = COMMON + OWN[kind] + ("shadow:enable",)  # authored values count without the applied schema, as in UsdImaging
    if kind not in ("distantLight", "domeLight"):
        names += SHAPING
    for name in names:
        attribute = prim.GetAttribute("inputs:" + name)
        value = attribute.Get(time) if attribute else None
        if isinstance(value, Sdf.AssetPath):
            if value.path:
                fields[name], _ = asset_value(value, attribute, time)
        elif value is not None:
            fields[name] = value_of(value, str(attribute.GetTypeName()))
            space = color_space_of(attribute) if name == "color" else ""
            fields[name] = (to_rec709(fields[name], space) if space else None) or fields[name]
    fields["color:colorSpace"] = token("lin_rec709")
    if prim.GetTypeName() == "SphereLight" and UsdLux.SphereLight(prim).GetTreatAsPointAttr().Get(time):
        fields["treatAsPoint"] = V("bool", True)
    if kind == "domeLight":
        fields["visibleToCamera"] = V("bool", True)
        shape = prim.GetAttribute("inputs:texture:format").Get(time)
        if shape and shape not in ("automatic", "latlong") and "texture:file" in fields:
            notes.tell("images of domes are read as latitude and longitude alone (texture:format)", prim.GetPath())
        if UsdLux.DomeLight(prim) and UsdLux.DomeLight(prim).GetPortalsRel().GetTargets():
            notes.tell("portals of domes are not read", prim.GetPath())
    fields.update(group_fields(prim, time))
    fields["transform"] = matrix(placed(prim, world, up))
    if not visible:
        fields["visible"] = V("bool", False)
    fields.update(links)
    _tell(prim, notes)
    return kind, fields


def placed(prim, world, up):
    """The transform, with the pole of a dome."""
    pole = prim.GetAttribute("poleAxis").Get() if prim.GetTypeName() == "DomeLight_1" else "Y"
    if pole == "Z" or (pole == "scene" and up == "Z"):
        return Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), 90)) * world
    return world


def group_fields(prim, time):
    """The light group, as RenderMan and Arnold have it."""
    for name in ("inputs:ri:light:lightGroup", "ri:light:lightGroup", "primvars:arnold:aov"):
        value = prim.GetAttribute(name).Get(time) if prim.GetAttribute(name) else None
        if value:
            return {"lightGroup": V("string", str(value))}
    return {}


def is_mesh_light(prim):
    return prim.HasAPI(UsdLux.MeshLightAPI)


def glow_fields(prim, areas, primvar, time, notes):
    """(the material of a mesh that is a light, its emission by instance or None): its front emits, and nothing else is seen of it.
    areas() are those of its instances in the world. Where their emission differs, the material reads it from `primvar`."""
    get = lambda name, otherwise: prim.GetAttribute("inputs:" + name).Get(time) if prim.GetAttribute("inputs:" + name) else otherwise
    if UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]:
        notes.tell("the materials of meshes that are lights are not drawn", prim.GetPath())
    if any(get(name, 1.0) != 1.0 for name in ("diffuse", "specular")) or get("shadow:enable", True) is False:
        notes.tell("the multipliers and shadows of meshes that are lights are not read", prim.GetPath())
    api = UsdLux.LightAPI(prim)
    if any(c and is_authored(c) for c in (api.GetLightLinkCollectionAPI(), api.GetShadowLinkCollectionAPI())):
        notes.tell("links of meshes that are lights are not read", prim.GetPath())
    strength = get("intensity", 1.0) * 2.0 ** get("exposure", 0.0)
    strengths = [strength / area if area > 0 else 0.0 for area in areas()] if get("normalize", False) else [strength]
    color = value_of(get("color", Gf.Vec3f(1)), "color3f")
    space = color_space_of(prim.GetAttribute("inputs:color")) if prim.GetAttribute("inputs:color") else ""
    color = (to_rec709(color, space) if space else None) or color
    tint = UsdLux.BlackbodyTemperatureAsRgb(get("colorTemperature", 6500.0)) if get("enableColorTemperature", False) else (1, 1, 1)
    _tell(prim, notes)
    emissions = [[max(0.0, c * t * s) for c, t in zip(color.data, tint)] for s in strengths]
    black = V("float3", [0.0, 0.0, 0.0])
    fields = {"surface.type": token("AlabasterDisney"), "surface.baseColor": black, "surface.specular": V("float", 0.0),
              "surface.sides": token("front"), "surface": path("surface.out")}
    if all(e == emissions[0] for e in emissions):
        return {**fields, "surface.emission:colorSpace": token("lin_rec709"), "surface.emission": V("float3", emissions[0])}, None
    reader = {"emission.type": token("AlabasterPrimvar"), "emission.varname": token(primvar), "surface.emission": path("emission.rgb")}
    return {**fields, **reader}, emissions


class Areas:
    """Of the faces of a mesh as polygons; of maps that stretch alike only once."""

    def __init__(self, mesh, time):
        self.mesh, self.time, self.known = mesh, time, {}

    def under(self, map):
        linear = map.ExtractRotationMatrix()
        stretch = linear * linear.GetTranspose()
        size = sum(stretch[i][i] for i in range(3)) or 1.0
        key = "%.6g" % size, *(round(stretch[i][j] / size, 5) for i in range(3) for j in range(i, 3))
        if key not in self.known:
            self.known[key] = _area(self.mesh, map, self.time)
        return self.known[key]


def _area(mesh, world, time):
    points = [world.Transform(Gf.Vec3d(p)) for p in mesh.GetPointsAttr().Get(time) or ()]
    indices, area, at = mesh.GetFaceVertexIndicesAttr().Get(time) or (), 0.0, 0
    for count in mesh.GetFaceVertexCountsAttr().Get(time) or ():
        face = [points[i] for i in indices[at:at + count]]
        at += count
        normal = Gf.Vec3d(0)
        for a, b in zip(face[1:], face[2:]):
            normal += Gf.Cross(a - face[0], b - face[0])
        area += normal.GetLength() / 2
    return area


def _tell(prim, notes):
    if any(prim.GetAttribute("inputs:shadow:" + n).HasAuthoredValue() for n in ("color", "distance", "falloff") if
           prim.GetAttribute("inputs:shadow:" + n)):
        notes.tell("the colour, distance and falloff of shadows are not read", prim.GetPath())
    filters = prim.GetRelationship("light:filters")
    if filters and filters.GetTargets():
        notes.tell("filters of lights are not read", prim.GetPath())


class Links:
    """Light and shadow links: a category for each collection that does not hold everything, of the objects that it holds."""

    def __init__(self):
        self.of = []  # (category, query)
        self.fields = {}  # light's path -> fields

    def add(self, prim, notes):
        fields = {}
        api = UsdLux.LightAPI(prim)
        for key, collection in (("lightLink", api.GetLightLinkCollectionAPI()), ("shadowLink", api.GetShadowLinkCollectionAPI())):
            if not collection or not is_authored(collection):
                continue
            if is_by_expression(collection):
                notes.tell("links by path expressions are not read: the light is linked to all", prim.GetPath())
                continue
            name = "%s %s" % (key, prim.GetPath())
            self.of.append((name, collection.ComputeMembershipQuery()))
            fields[key] = token(name)
        self.fields[str(prim.GetPath())] = fields

    def categories(self, path):
        return [name for name, query in self.of if holds(query, path)]


def is_authored(collection):
    includes, excludes = collection.GetIncludesRel().GetTargets(), collection.GetExcludesRel().GetTargets()
    return bool(includes or excludes or collection.GetIncludeRootAttr().Get() is False or is_by_expression(collection))


def is_by_expression(collection):
    attribute = collection.GetMembershipExpressionAttr() if hasattr(collection, "GetMembershipExpressionAttr") else None
    return bool(attribute and attribute.HasAuthoredValue())


def holds(query, path):
    held = query.IsPathIncluded(Sdf.Path(path))
    return held[0] if isinstance(held, tuple) else held
