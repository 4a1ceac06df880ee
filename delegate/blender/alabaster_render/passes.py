"""Passes of a view layer as AOVs."""
import numpy

from . import roles, settings


# Those that Blender has switches for: AOV, name of the pass, channels, type.
BLENDERS = {"use_pass_z": ("cameraDepth", "Depth", "Z", "VALUE"), "use_pass_normal": ("normal", "Normal", "XYZ", "VECTOR"),
            "use_pass_vector": ("motion", "Vector", "XYZW", "VECTOR"), "use_pass_emit": ("emission", "Emit", "RGB", "COLOR")}


def wanted(view_layer):
    """(AOV, name of the pass, channels, type) of each pass but Combined."""
    return [one for switch, one in BLENDERS.items() if getattr(view_layer, switch)] + [
        (aov, *one) for aov, one in settings.PASSES.items() if getattr(view_layer.alabaster, aov)] + [
        ("lightGroup:" + name, "Combined_" + name, "RGB", "COLOR") for name in roles.light_groups(view_layer)[:roles.MOST_GROUPS]]


FAR = 1e10  # where the camera sees nothing, as Cycles has it


def fill(render_pass, pixels, aov):
    """Gives a pass the pixels of an AOV, whose rows begin at the bottom, as Blender's do."""
    height, width = pixels.shape[:2]
    channels = render_pass.channels
    pixels = pixels.reshape(height * width, -1).astype(numpy.float32, copy=False)
    if aov == "cameraDepth":
        pixels = numpy.where((pixels > 0) & numpy.isfinite(pixels), pixels, numpy.float32(FAR))
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
