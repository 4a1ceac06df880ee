"""Cameras and render settings."""
import math
import os

from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender

from . import lights
from .notes import Fault
from .values import Samples, V, array, matrix, path, token, value_of

POLICIES = {"expandAperture": "fit", "cropAperture": "crop", "adjustApertureWidth": "matchVertically",
            "adjustApertureHeight": "matchHorizontally", "adjustPixelAspectRatio": "dontConform"}
# The apertures and the focal length are tenths of a unit.
LENS = {"focalLength": .1, "horizontalAperture": .1, "verticalAperture": .1, "horizontalApertureOffset": .1,
        "verticalApertureOffset": .1, "fStop": 1, "focusDistance": 1}
MOVING = ("focalLength", "fStop", "focusDistance")


def camera_fields(prim, world, time):
    camera = UsdGeom.Camera(prim)
    fields = {"transform": matrix(world)}
    for name, unit in LENS.items():
        value = prim.GetAttribute(name).Get(time)
        if value is not None:
            fields[name] = V("float", value * unit)
    if camera.GetProjectionAttr().Get(time) == "orthographic":
        fields["projection"] = token("orthographic")
    near_far = camera.GetClippingRangeAttr().Get(time)
    if near_far is not None:
        fields["clippingRange"] = V("float2", [max(c, 0.0) for c in near_far])
    planes = camera.GetClippingPlanesAttr().Get(time)
    if planes:
        fields["clipPlanes"] = V("float4[]", planes)
    exposure = exposure_of(camera, time)
    if exposure:
        fields["exposure"] = V("float", exposure)
    opens, closes = camera.GetShutterOpenAttr().Get(time), camera.GetShutterCloseAttr().Get(time)
    if opens or closes:
        fields["shutterOpen"], fields["shutterClose"] = V("double", opens), V("double", closes)
    return fields


def lens_samples(prim, time, shutter, notes):
    """Fields of what changes within the shutter: samples of its own, with those around it. Splines are sampled evenly."""
    now, fields = time.GetValue(), {}
    ends = now + shutter[0], now + shutter[-1]
    for name, unit in LENS.items():
        attribute = prim.GetAttribute(name)
        if not attribute.ValueMightBeTimeVarying() or prim.GetStage().GetInterpolationType() == Usd.InterpolationTypeHeld:
            continue
        if name not in MOVING:
            if attribute.Get(ends[0]) != attribute.Get(ends[1]):
                notes.tell("a film that changes within the shutter stands still", prim.GetPath())
            continue
        times = {*attribute.GetTimeSamplesInInterval(Gf.Interval(*ends)), *(t for end in ends for t in attribute.GetBracketingTimeSamples(end))}
        times = sorted(times) or [ends[0] + (ends[1] - ends[0]) * i / 8 for i in range(9)]
        values = [attribute.Get(t) for t in times]
        if any(v != values[0] for v in values) and None not in values:
            fields[name + ":samples"] = V("samples", Samples([t - now for t in times], [V("float", v * unit) for v in values]))
    return fields


def exposure_of(camera, time):
    """In stops; by exposure alone before OpenUSD 25.5."""
    if hasattr(camera, "ComputeLinearExposureScale"):
        scale = camera.ComputeLinearExposureScale(time)
        return math.log2(scale) if scale > 0 else 0
    return camera.GetExposureAttr().Get(time) or 0


def choose_settings(stage, named, notes, only_named=False):
    """The RenderSettings prim: named, else by the stage, else the only one there is."""
    if named:
        return _prim(stage, named, UsdRender.Settings, "RenderSettings")
    found = UsdRender.Settings.GetStageRenderSettings(stage)
    if found or only_named:
        return found.GetPrim() if found else None
    every = [p for p in stage.Traverse() if p.IsA(UsdRender.Settings)]
    if len(every) == 1:
        return every[0]
    if every:
        notes.tell("the stage does not say which of its RenderSettings count (renderSettingsPrimPath): none is read", every[0].GetPath())
    return None


def _prim(stage, named, schema, kind):
    prim = stage.GetPrimAtPath(named) if Sdf.Path.IsValidPathString(named) else None
    if prim and prim.IsA(schema):
        return prim
    every = [str(p.GetPath()) for p in stage.Traverse() if p.IsA(schema)]
    raise Fault("it is no prim of type %s; of these the stage has %s" % (kind, ", ".join(every[:20]) or "none"), prim=named)


class Pass:
    """A RenderPass: the settings that it names, and what of the scene it prunes, shows and holds out."""

    def __init__(self, stage, named, notes):
        prim = _prim(stage, named, UsdRender.Pass, "RenderPass")
        sources = UsdRender.Pass(prim).GetRenderSourceRel().GetForwardedTargets()
        self.settings = str(sources[0]) if sources else None
        if len(sources) > 1:
            notes.tell("a pass has several sources: the first counts", named)
        if UsdRender.Pass(prim).GetInputPassesRel().GetForwardedTargets():
            notes.tell("the passes that a pass takes (inputPasses) are not rendered before it", named)
        self.queries = {}
        for name in ("renderVisibility", "cameraVisibility", "prune", "matte"):
            collection = Usd.CollectionAPI(prim, name) if prim.HasAPI(Usd.CollectionAPI, name) else None
            if collection and lights.is_by_expression(collection):
                notes.tell("collections of passes by path expressions are not read", named)
            elif collection and (lights.is_authored(collection) or collection.GetIncludeRootAttr().HasAuthoredValue()):
                self.queries[name] = collection.ComputeMembershipQuery()

    def prunes(self, path):
        return "prune" in self.queries and lights.holds(self.queries["prune"], path)

    def shows(self, path):
        return "renderVisibility" not in self.queries or lights.holds(self.queries["renderVisibility"], path)

    def is_seen(self, path):
        return "cameraVisibility" not in self.queries or lights.holds(self.queries["cameraVisibility"], path)

    def options(self, path):
        """Fields of a mesh."""
        fields = {} if self.is_seen(path) else {"visibleToCamera": V("bool", False)}
        if "matte" in self.queries and lights.holds(self.queries["matte"], path):
            fields["holdout"] = V("bool", True)
        return fields


def default_settings(camera, camera_prim, time, width):
    """Of a stage without any: as high as the camera's film asks."""
    fields = {"windowPolicy": token("fit")}
    if camera:
        fields["camera"] = path(camera)
        wide, high = (camera_prim.GetAttribute(n).Get(time) for n in ("horizontalAperture", "verticalAperture"))
        if wide and high and wide > 0 and high > 0:
            fields["width"], fields["height"] = V("int", width), V("int", max(1, min(16384, round(width * high / wide))))
    return fields


def recorded_size(camera_prim, time, width):
    """Of usdrecord: its height is cut off, and a stage without a camera has the film of its default one."""
    film = (camera_prim.GetAttribute(n).Get(time) for n in ("horizontalAperture", "verticalAperture")) if camera_prim else (20.955, 15.2908)
    wide, high = film
    aspect = wide / high if wide and high and wide > 0 and high > 0 else 1
    return {"width": V("int", width), "height": V("int", max(1, min(16384, int(width / aspect)))), "windowPolicy": token("fit"),
            "pixelAspectRatio": V("float", 1.0)}


WINDOW = ("pixelAspectRatio", "aspectRatioConformPolicy", "dataWindowNDC")


def settings_fields(prim, time, notes, known, may_write, aovs):
    """(the fields, those of further settings): a product with a window, conform policy or pixel aspect of its own has settings of its own.
    `known` are names of cameras of the scene; may_write(file) tells of a product's. `aovs`: those that there are; empty: not known."""
    settings = UsdRender.Settings(prim)
    size = settings.GetResolutionAttr().Get()
    fields = {"width": V("int", size[0]), "height": V("int", size[1]), **_camera(settings, notes, known), **_window(prim, prim, size, notes)}
    purposes = settings.GetIncludedPurposesAttr().Get()
    if purposes:
        fields["includedPurposes"] = V("token[]", [str(p) for p in purposes])
    space = prim.GetAttribute("renderingColorSpace")
    if space and space.Get() and space.Get() not in ("lin_rec709", "lin_rec709_scene"):
        notes.tell("the rendering colour space is that of the OpenColorIO config (--ocio); renderingColorSpace is not read", prim.GetPath())
    for attribute in prim.GetAuthoredAttributes():
        name = attribute.GetName()
        if name.startswith("alabaster:") and attribute.Get(time) is not None:
            value = value_of(attribute.Get(time), str(attribute.GetTypeName()))
            if value is not None:
                fields[name[len("alabaster:"):]] = value
    further, number = [], 0
    for target in settings.GetProductsRel().GetForwardedTargets():
        product = prim.GetStage().GetPrimAtPath(target)
        if not product:
            notes.fault("the product %s does not exist" % target, prim=prim.GetPath())
            continue
        made = _product(product, prim, notes, known, may_write, aovs)
        if made is None:
            continue
        if any(product.GetAttribute(name).HasAuthoredValue() for name in WINDOW):
            own = {n: made.pop(n) for n in ("camera", "width", "height") if n in made}
            size = [own.get(n, fields[n]).data for n in ("width", "height")]
            further.append({**own, **_window(product, prim, size, notes), **{"products:0:" + n: v for n, v in made.items()}})
        else:
            fields.update(("products:%d:%s" % (number, n), v) for n, v in made.items())
            number += 1
    common = {n: v for n, v in fields.items() if not n.startswith("products:") and n != "crop"}
    further = [{**common, **one} for one in further]
    return (fields, further) if number or not further else (further[0], further[1:])


def all_disabled(settings, name):
    """Of settings whose products do not turn it on again."""
    products = [settings.GetStage().GetPrimAtPath(t) for t in UsdRender.Settings(settings).GetProductsRel().GetForwardedTargets()]
    return is_disabled(settings, name) and not any(p and p.GetAttribute(name).Get() is False and p.GetAttribute(name).HasAuthoredValue() for p in products)


def is_disabled(settings, name):
    """disableMotionBlur and disableDepthOfField, of settings or a product; instantaneousShutter is the older name of the first."""
    names = (name, "instantaneousShutter") if name == "disableMotionBlur" else (name,)
    return any(settings.GetAttribute(n) and settings.GetAttribute(n).Get() for n in names)


def _camera(base, notes, known):
    targets = base.GetCameraRel().GetForwardedTargets()
    if targets and str(targets[0]) not in known:
        notes.tell("a camera is named that is none", base.GetPrim().GetPath())
    return {"camera": path(targets[0])} if targets and str(targets[0]) in known else {}


def _window(prim, settings, size, notes):
    """How the frame is filled; what a product leaves out is the settings'."""
    get = lambda name: (prim if prim.GetAttribute(name).HasAuthoredValue() else settings).GetAttribute(name).Get()
    policy = get("aspectRatioConformPolicy")
    if policy not in POLICIES:
        notes.tell("a conform policy is not known: %s" % policy, prim.GetPath())
    fields = {"pixelAspectRatio": V("float", get("pixelAspectRatio")), "windowPolicy": token(POLICIES.get(policy, "fit"))}
    left, low, right, high = get("dataWindowNDC")
    if not all(map(math.isfinite, (left, low, right, high))) or left >= right or low >= high:
        notes.tell("a data window that holds nothing is not read", prim.GetPath())
        return fields
    if (left, low, right, high) != (0, 0, 1, 1):  # from the lower left; pixels count from the upper left
        crop = [math.ceil(left * size[0]), size[1] - math.ceil(high * size[1]), math.ceil(right * size[0]), size[1] - math.ceil(low * size[1])]
        fields["crop"] = array("int", crop)
    return fields


def _product(prim, settings, notes, known, may_write, aovs):
    """The fields of a product; None: it is not written."""
    product = UsdRender.Product(prim)
    kind = product.GetProductTypeAttr().Get()
    if kind and kind != "raster":
        notes.tell("products of other types than raster are not written", prim.GetPath())
        return None
    folder = os.path.dirname(prim.GetStage().GetRootLayer().realPath)
    file = os.path.join(folder, product.GetProductNameAttr().Get() or prim.GetName() + ".exr")
    if not may_write(file):
        notes.tell("products outside of the stage's folder are not written: give -o, or --allow-outside", prim.GetPath())
        return None
    fields = {"file": V("string", file), **_camera(product, notes, known)}
    if product.GetResolutionAttr().HasAuthoredValue():
        size = product.GetResolutionAttr().Get()
        fields["width"], fields["height"] = V("int", size[0]), V("int", size[1])
    for name in ("disableMotionBlur", "disableDepthOfField"):
        if is_disabled(prim if prim.GetAttribute(name).HasAuthoredValue() else settings, name) or is_disabled(prim, name):
            fields[name] = V("bool", True)
    for target in product.GetOrderedVarsRel().GetForwardedTargets():
        var = UsdRender.Var(prim.GetStage().GetPrimAtPath(target))
        if not var:
            notes.tell("variables of a product are named that do not exist", prim.GetPath())
            continue
        source = var.GetSourceNameAttr().Get() or var.GetPrim().GetName()
        if var.GetSourceTypeAttr().Get() == "primvar":
            source = "primvars:" + source
        if var.GetSourceTypeAttr().Get() == "lpe":
            source = "lpe:" + source.removeprefix("lpe:")
        layer = {"Ci": "color", "RGBA": "color", "RGB": "color", "beauty": "color", "a": "alpha", "A": "alpha"}.get(source, source)
        if aovs and layer not in aovs and not layer.startswith(("primvars:", "lightGroup:", "lpe:")):
            notes.tell("layers that the renderer does not have are not written, such as %s" % source, var.GetPrim().GetPath())
            continue
        # Houdini's name of the layer. The beauty stays RGBA.
        chosen = var.GetPrim().GetAttribute("driver:parameters:aov:name").Get() if layer != "color" else None
        name = chosen or (var.GetPrim().GetName() if layer.startswith("lpe:") else layer)
        fields["vars:" + name] = token(layer)
        given = str(var.GetDataTypeAttr().Get())
        fields["vars:" + name + ":dataType"] = token("int" if given.startswith("int") else "half" if "half" in given or given.endswith("h") else "float")
    return fields
