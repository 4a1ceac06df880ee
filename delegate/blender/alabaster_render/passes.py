"""Passes of a view layer as AOVs."""
import functools

import bpy
import numpy

from . import cryptomatte, roles, settings


# Those that Blender has switches for: AOV, name of the pass, channels, type.
BLENDERS = {
    "use_pass_z": ("cameraDepth", "Depth", "Z", "VALUE"), "use_pass_position": ("position", "Position", "XYZ", "VECTOR"),
    "use_pass_normal": ("normal", "Normal", "XYZ", "VECTOR"), "use_pass_vector": ("motion", "Vector", "XYZW", "VECTOR"),
    "use_pass_uv": ("uv", "UV", "UVA", "VECTOR"), "use_pass_object_index": (f"primvars:{roles.INDEX}", "IndexOB", "X", "VALUE"),
    "use_pass_material_index": ("materialId", "IndexMA", "X", "VALUE"), "use_pass_emit": ("emission", "Emit", "RGB", "COLOR"),
    "use_pass_ambient_occlusion": ("ambientOcclusion", "AO", "RGB", "COLOR")}
CRYPTO_CHANNELS = "rgba" if bpy.app.version >= (4, 2) else "RGBA"  # as Cycles has them


def wanted(view_layer):
    """(AOV, name of the pass, channels, type) of each pass but Combined."""
    return [one for switch, one in BLENDERS.items() if getattr(view_layer, switch)] + [
        (*one, CRYPTO_CHANNELS, "COLOR") for one in cryptomatte.wanted(view_layer)] + [
        (aov, *one) for aov, one in settings.PASSES.items() if getattr(view_layer.alabaster, aov)] + [
        ("lightGroup:" + name, "Combined_" + name, "RGB", "COLOR") for name in roles.light_groups(view_layer)[:roles.MOST_GROUPS]]


FAR = 1e10  # where the camera sees nothing, as Cycles has it


def converted(pixels, aov, names):
    """The rows of an AOV as Blender's pass has them. names: of materials, by what they are in the scene."""
    if aov == "cameraDepth":
        return numpy.where((pixels > 0) & numpy.isfinite(pixels), pixels, numpy.float32(FAR))
    if aov == "motion":  # the frame before less this one, and this one less the next: ours takes the motion for even
        return numpy.concatenate([-pixels, -pixels], axis=1)
    if aov == "ambientOcclusion":
        return numpy.repeat(pixels, 3, axis=1)
    if aov == "uv":
        return numpy.concatenate([pixels, pixels.any(axis=1, keepdims=True)], axis=1)
    if aov == "materialId":
        table = [*names.indices(), 0.0]  # the last is the background's, -1
        return numpy.array(table, numpy.float32)[pixels.astype(numpy.int64)]
    if aov.startswith("cryptoMaterial"):
        return names.rename(pixels)
    return pixels


def fill(render_pass, pixels, aov, names=None):
    """Gives a pass the pixels of an AOV, whose rows begin at the bottom, as Blender's do."""
    height, width = pixels.shape[:2]
    channels = render_pass.channels
    pixels = converted(pixels.reshape(height * width, -1), aov, names).astype(numpy.float32, copy=False)
    if pixels.shape[1] != channels:
        wide = numpy.zeros((height * width, channels), numpy.float32)
        shared = min(channels, pixels.shape[1])
        wide[:, :shared] = pixels[:, :shared]
        pixels = wide
    pixels = numpy.ascontiguousarray(pixels)
    try:
        render_pass.rect.foreach_set(pixels)
    except TypeError:  # Blender 5 counts numbers, Blender 3 pixels
        render_pass.rect.foreach_set(pixels.reshape(-1))


class Names:
    """Those of Blender, for what a renderer shows. materials: (name, pass index), by their paths."""

    def __init__(self, renderer, materials):
        self.renderer, self.materials = renderer, materials

    @functools.cached_property
    def known(self):
        return self.renderer.command("names")

    def of(self, path):
        return self.materials.get(path, (path, 0))

    def indices(self):
        """The pass indices of materials, by AOV materialId."""
        paths = self.known["materialId"]
        return [self.of(paths[number])[1] for number in sorted(paths, key=int)]

    def rename(self, pixels):
        return cryptomatte.rename(pixels, self.known["cryptoMaterial"], {path: name for path, (name, _) in self.materials.items()})

    def stamp(self, result, view_layer):
        if not cryptomatte.wanted(view_layer):
            return
        cryptomatte.stamp(result, view_layer, {
            "Object": self.known["cryptoObject"], "Asset": self.known["cryptoAsset"],
            "Material": [self.of(path)[0] for path in self.known["cryptoMaterial"]]})
