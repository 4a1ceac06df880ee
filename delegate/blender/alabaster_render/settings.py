"""Settings of a scene, made from schemas/render_settings.json, and those of layers and collections."""
import re

import bpy

from . import colors, presets, schema

# Blender itself has these: the frame, threads, and the parts of a farm.
LEFT_TO_BLENDER = {"frame", "firstSample", "threads"}
SETTINGS = {name: p for name, p in schema.parameters("render_settings").items() if name not in LEFT_TO_BLENDER}
LARGEST_INT = 2 ** 31 - 1

# AOVs that become passes of their own, besides those that Blender has switches for: AOV, channels, type of the pass.
PASSES = {
    "diffuse": ("Diffuse", "RGB", "COLOR"),
    "directDiffuse": ("Direct Diffuse", "RGB", "COLOR"),
    "indirectDiffuse": ("Indirect Diffuse", "RGB", "COLOR"),
    "subsurface": ("Subsurface", "RGB", "COLOR"),
    "directSubsurface": ("Direct Subsurface", "RGB", "COLOR"),
    "indirectSubsurface": ("Indirect Subsurface", "RGB", "COLOR"),
    "subsurfaceUnscattered": ("Subsurface Unscattered", "RGB", "COLOR"),
    "subsurfaceSingle": ("Subsurface Single", "RGB", "COLOR"),
    "subsurfaceMultiple": ("Subsurface Multiple", "RGB", "COLOR"),
    "specular": ("Specular", "RGB", "COLOR"),
    "directSpecular": ("Direct Specular", "RGB", "COLOR"),
    "indirectSpecular": ("Indirect Specular", "RGB", "COLOR"),
    "transmission": ("Transmission", "RGB", "COLOR"),
    "albedo": ("Albedo", "RGB", "COLOR"),
    "shadow": ("Shadow", "RGB", "COLOR"),
    "denoised": ("Denoised", "RGBA", "COLOR"),
    "error": ("Error", "X", "VALUE"),
    "sampleCount": ("Sample Count", "X", "VALUE"),
    "nonfiniteSamples": ("Nonfinite Samples", "X", "VALUE"),
}


# Artists' words where the schema has a programmer's.
LABELS = {"targetError": "Noise Target", "adaptive": "Adaptive Sampling", "filter": "Pixel Filter",
          "textureMemory": "Texture Memory (MiB)", "memoryLimit": "Memory Limit (MiB)"}
UNITS = {"seconds": {"subtype": "TIME_ABSOLUTE", "unit": "TIME_ABSOLUTE"}, "pixels": {"subtype": "PIXEL"}}


def words(name):
    """chiang2016 as Chiang 2016"""
    spaced = re.sub(r"([A-Z]|[0-9]+)", r" \1", name)
    return spaced[:1].upper() + spaced[1:]


def property_of(p, **changes):
    """A property of Blender's for a parameter of a schema."""
    options = {"name": LABELS.get(p.name, words(p.name)), "description": p.description.rstrip("."), "default": p.default,
               **UNITS.get(p.unit, {}), **changes}
    if p.kind == "bool":
        return bpy.props.BoolProperty(**options)
    if p.kind == "enum":
        return bpy.props.EnumProperty(items=[(choice, words(choice), "") for choice in p.choices], **options)
    ends = {"min": p.minimum, "max": p.maximum}
    if p.kind == "int":
        options.update({key: min(int(end), LARGEST_INT) for key, end in ends.items() if end is not None})
        return bpy.props.IntProperty(**options)
    options.update({key: end for key, end in ends.items() if end is not None})
    return bpy.props.FloatProperty(precision=4, **options)


class AlabasterSceneSettings(bpy.types.PropertyGroup):
    __annotations__ = {
        "viewport_samples": property_of(SETTINGS["samples"], name="Viewport Samples", default=256),
        "quality": bpy.props.EnumProperty(
            name="Quality", get=presets.held, set=presets.apply,
            description="Presets of the settings below it, of which the others keep theirs",
            items=[("CUSTOM", "Custom", "Settings of your own", 0)] + [
                (one["name"], words(one["name"]), one["description"].rstrip("."), number) for number, one in enumerate(presets.PRESETS, 1)]),
        **{name: property_of(parameter) for name, parameter in SETTINGS.items()}}


class AlabasterLayerSettings(bpy.types.PropertyGroup):
    __annotations__ = {aov: bpy.props.BoolProperty(name=label, default=False, description=f"Pass of AOV {aov}")
                       for aov, (label, _, _) in PASSES.items()}


class AlabasterCollectionSettings(bpy.types.PropertyGroup):
    subsurface_set: bpy.props.BoolProperty(
        name="Subsurface Set", default=False,
        description="Meshes of this collection form one body: light passes below the surface between those that touch")


def delegate_settings(scene, viewport):
    """For hdalabaster.Renderer."""
    group = scene.alabaster
    values = {name: getattr(group, name) for name in SETTINGS}
    for name, value in values.items():
        if value == "":  # the file holds a choice of an earlier version
            raise ValueError(f"{name}: the file has a choice that has been removed; choose again, for example "
                             f"{SETTINGS[name].default}")
    if viewport:
        values.update(samples=group.viewport_samples, targetError=0.0, timeLimit=0.0, denoise=False)
    values["frame"] = max(scene.frame_current, 0)
    values["ocio"] = colors.renderers_file()
    values["threads"] = scene.render.threads if scene.render.threads_mode == "FIXED" else 0
    return values


GROUPS = {"Scene": AlabasterSceneSettings, "ViewLayer": AlabasterLayerSettings, "Collection": AlabasterCollectionSettings}


def register():
    for owner, group in GROUPS.items():
        bpy.utils.register_class(group)
        getattr(bpy.types, owner).alabaster = bpy.props.PointerProperty(type=group)


def unregister():
    for owner, group in GROUPS.items():
        del getattr(bpy.types, owner).alabaster
        bpy.utils.unregister_class(group)
