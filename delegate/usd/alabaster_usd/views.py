"""Cameras and render settings."""
import math
import os

from pxr import Gf, Usd, UsdGeom, UsdRender

from .values import V, array, matrix, path, token, value_of

POLICIES = {"expandAperture": "fit", "cropAperture": "crop", "adjustApertureWidth": "matchVertically",
            "adjustApertureHeight": "matchHorizontally", "adjustPixelAspectRatio": "dontConform"}
# The apertures and the focal length are tenths of a unit.
LENS = {"focalLength": .1, "horizontalAperture": .1, "verticalAperture": .1, "horizontalApertureOffset": .1,
        "verticalApertureOffset": .1, "fStop": 1, "focusDistance": 1}


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


def exposure_of(camera, time):
    """In stops; by exposure alone before OpenUSD 25.5."""
    if hasattr(camera, "ComputeLinearExposureScale"):
        scale = camera.ComputeLinearExposureScale(time)
        return math.log2(scale) if scale > 0 else 0
    return camera.GetExposureAttr().Get(time) or 0


def choose_settings(stage, named, notes):
    """The RenderSettings prim: named, else by the stage, else the only one there is."""
    if named:
        prim = stage.GetPrimAtPath(named)
        return prim if prim and prim.IsA(UsdRender.Settings) else None
    found = UsdRender.Settings.GetStageRenderSettings(stage)
    if found:
        return found.GetPrim()
    every = [p for p in stage.Traverse() if p.IsA(UsdRender.Settings)]
    if len(every) == 1:
        return every[0]
    if every:
        notes.tell("the stage does not say which of its RenderSettings count (renderSettingsPrimPath): none is read", every[0].GetPath())
    return None


def default_settings(camera, camera_prim, time):
    """Of a stage without any: 1280 pixels wide, and as high as the camera's film asks."""
    fields = {"windowPolicy": token("fit")}
    if camera:
        fields["camera"] = path(camera)
        wide, high = (camera_prim.GetAttribute(n).Get(time) for n in ("horizontalAperture", "verticalAperture"))
        if wide and high and wide > 0 and high > 0:
            fields["width"], fields["height"] = V("int", 1280), V("int", max(1, min(16384, round(1280 * high / wide))))
    return fields


def settings_fields(prim, time, notes, known, may_write, aovs):
    """The fields of the settings. `known` are names of cameras of the scene; may_write(file) tells of a product's. `aovs`: those that there are; empty: not known."""
    fields = _base(prim, "", notes, known)
    settings = UsdRender.Settings(prim)
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
    number = 0
    for target in settings.GetProductsRel().GetForwardedTargets():
        product = prim.GetStage().GetPrimAtPath(target)
        if product:
            number += _add_product(product, "products:%d:" % number, fields, notes, known, may_write, aovs)
        else:
            notes.fault("the product %s does not exist" % target, prim=prim.GetPath())
    return fields


def _base(prim, prefix, notes, known):
    base = UsdRender.SettingsBase(prim)
    fields = {}
    size = base.GetResolutionAttr().Get()
    if prefix == "" or base.GetResolutionAttr().HasAuthoredValue():
        fields[prefix + "width"], fields[prefix + "height"] = V("int", size[0]), V("int", size[1])
    targets = base.GetCameraRel().GetForwardedTargets()
    if targets:
        if str(targets[0]) in known:
            fields[prefix + "camera"] = path(targets[0])
        else:
            notes.tell("a camera is named that is none", prim.GetPath())
    for name in ("disableMotionBlur", "disableDepthOfField"):
        attribute = prim.GetAttribute(name)
        if prefix and attribute and attribute.Get():
            fields[prefix + name] = V("bool", True)
    if prefix:
        for name in ("pixelAspectRatio", "aspectRatioConformPolicy", "dataWindowNDC"):
            if prim.GetAttribute(name).HasAuthoredValue():
                notes.tell("a product has the window, conform policy and pixel aspect of its settings; its own are not read", prim.GetPath())
                break
        return fields
    fields["pixelAspectRatio"] = V("float", base.GetPixelAspectRatioAttr().Get())
    fields["windowPolicy"] = token(POLICIES.get(base.GetAspectRatioConformPolicyAttr().Get(), "fit"))
    left, low, right, high = base.GetDataWindowNDCAttr().Get()
    if (left, low, right, high) != (0, 0, 1, 1):  # from the lower left; pixels count from the upper left
        crop = [math.ceil(left * size[0]), size[1] - math.ceil(high * size[1]), math.ceil(right * size[0]), size[1] - math.ceil(low * size[1])]
        fields["crop"] = array("int", crop)
    return fields


def _add_product(prim, prefix, fields, notes, known, may_write, aovs):
    """True if it is written."""
    product = UsdRender.Product(prim)
    kind = product.GetProductTypeAttr().Get()
    if kind and kind != "raster":
        notes.tell("products of other types than raster are not written", prim.GetPath())
        return False
    folder = os.path.dirname(prim.GetStage().GetRootLayer().realPath)
    file = os.path.join(folder, product.GetProductNameAttr().Get() or prim.GetName() + ".exr")
    if not may_write(file):
        notes.tell("products outside of the stage's folder are not written: give -o, or --allow-outside", prim.GetPath())
        return False
    fields.update(_base(prim, prefix, notes, known))
    fields[prefix + "file"] = V("string", file)
    for target in product.GetOrderedVarsRel().GetForwardedTargets():
        var = UsdRender.Var(prim.GetStage().GetPrimAtPath(target))
        if not var:
            continue
        source = var.GetSourceNameAttr().Get() or var.GetPrim().GetName()
        if var.GetSourceTypeAttr().Get() == "primvar":
            source = "primvars:" + source
        if var.GetSourceTypeAttr().Get() == "lpe":
            notes.tell("light path expressions are not read", var.GetPrim().GetPath())
            continue
        layer = {"Ci": "color", "RGBA": "color", "RGB": "color", "beauty": "color", "a": "alpha", "A": "alpha"}.get(source, source)
        if aovs and layer not in aovs and not layer.startswith("primvars:"):
            notes.tell("layers that the renderer does not have are not written, such as %s" % source, var.GetPrim().GetPath())
            continue
        fields[prefix + "vars:" + layer] = token(layer)
        given = str(var.GetDataTypeAttr().Get())
        fields[prefix + "vars:" + layer + ":dataType"] = token("int" if given.startswith("int") else "half" if "half" in given or given.endswith("h") else "float")
    return True
