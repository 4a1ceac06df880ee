"""Passes of a view layer as AOVs."""
import numpy

from . import settings


def wanted(view_layer):
    """(AOV, name of the pass, channels, type) of each pass but Combined."""
    found = []
    if view_layer.use_pass_z:
        found.append(("cameraDepth", "Depth", "Z", "VALUE"))
    if view_layer.use_pass_normal:
        found.append(("normal", "Normal", "XYZ", "VECTOR"))
    if view_layer.use_pass_emit:
        found.append(("emission", "Emit", "RGB", "COLOR"))
    if view_layer.use_pass_vector:
        found.append(("motion", "Vector", "XYZW", "VECTOR"))
    return found + [(aov, label, channels, kind) for aov, (label, channels, kind) in settings.PASSES.items()
                    if getattr(view_layer.alabaster, aov)]


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
