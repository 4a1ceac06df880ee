"""Lights of UsdLux. Values that a file leaves out are the schema's, such as intensity 50000 of a DistantLight."""
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from .values import V, asset_value, color_space_of, matrix, to_rec709, token, value_of

TYPES = {"RectLight": "rectLight", "DiskLight": "diskLight", "CylinderLight": "cylinderLight", "SphereLight": "sphereLight",
         "DistantLight": "distantLight", "DomeLight": "domeLight", "DomeLight_1": "domeLight"}
UNREAD = {"PortalLight": "portals of domes are not read", "GeometryLight": "lights by geometry are not read",
          "PluginLight": "lights of plug-ins are not read"}
COMMON = ("intensity", "exposure", "color", "enableColorTemperature", "colorTemperature")
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
    elif prim.HasAPI(UsdLux.MeshLightAPI):
        notes.tell("meshes are no lights: give the material an emission", prim.GetPath())


def light_fields(prim, world, visible, time, up, links, notes):
    kind = TYPES[prim.GetTypeName()]
    fields = {}
    names = COMMON + OWN[kind]
    if prim.HasAPI(UsdLux.ShapingAPI) and kind not in ("distantLight", "domeLight"):
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
        pole = prim.GetAttribute("poleAxis").Get() if prim.GetTypeName() == "DomeLight_1" else "Y"
        if pole == "Z" or (pole == "scene" and up == "Z"):
            world = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), 90)) * world
        shape = prim.GetAttribute("inputs:texture:format").Get(time)
        if shape and shape not in ("automatic", "latlong") and "texture:file" in fields:
            notes.tell("images of domes are read as latitude and longitude alone (texture:format)", prim.GetPath())
        if UsdLux.DomeLight(prim) and UsdLux.DomeLight(prim).GetPortalsRel().GetTargets():
            notes.tell("portals of domes are not read", prim.GetPath())
    fields["transform"] = matrix(world)
    if not visible:
        fields["visible"] = V("bool", False)
    fields.update(links)
    _tell(prim, time, notes)
    return kind, fields


def _tell(prim, time, notes):
    for name in ("diffuse", "specular"):
        attribute = prim.GetAttribute("inputs:" + name)
        if attribute and attribute.Get(time) not in (None, 1.0):
            notes.tell("a light's multipliers diffuse and specular are not read", prim.GetPath())
    if any(prim.GetAttribute("inputs:shadow:" + n).HasAuthoredValue() for n in ("enable", "color", "distance", "falloff") if
           prim.GetAttribute("inputs:shadow:" + n)):
        notes.tell("a light's shadows have no settings (inputs:shadow)", prim.GetPath())
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
