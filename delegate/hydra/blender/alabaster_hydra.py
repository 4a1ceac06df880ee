"""Alabaster as a Hydra engine of Blender 4.2 and later, by Blender's own Hydra export. An add-on of one file.

Blender finds the plug-in by the variable PXR_PLUGINPATH_NAME, which must be set before it starts:
    PXR_PLUGINPATH_NAME=PREFIX/lib/alabaster/hydra blender
Settings are custom properties of the scene, named as in schemas/render_settings.json: scene["alabaster"] = {"samples": 128}.
"""
import atexit
import os
import pathlib

import bpy

bl_info = {"name": "Alabaster (Hydra)", "category": "Render", "blender": (4, 2, 0), "version": (0, 1, 0),
           "description": "Renders with Alabaster through Blender's Hydra"}


class AlabasterHydraEngine(bpy.types.HydraRenderEngine):
    bl_idname = "ALABASTER_HYDRA"
    bl_label = "Alabaster (Hydra)"
    bl_use_preview = True
    bl_use_gpu_context = False
    bl_use_materialx = True  # Standard Surface has subsurface scattering, UsdPreviewSurface has none
    bl_delegate_id = "HdAlabasterRendererPlugin"

    def get_render_settings(self, engine_type):
        scene = bpy.context.scene
        settings = {f"alabaster:{name}": value for name, value in scene.get("alabaster", {}).items()}
        settings["aovToken:Combined"] = "color"
        # Blender changes its lights for Hydra, in another way for each export; the plug-in takes that back.
        settings["alabaster:host"] = "blender" if scene.hydra.export_method == "HYDRA" else "blender_usd"
        return settings

    def update_render_passes(self, scene, render_layer):
        self.register_pass(scene, render_layer, "Combined", 4, "RGBA", "COLOR")


def plugin_folders():
    """Folders of PXR_PLUGINPATH_NAME that hold the plug-in."""
    named = os.environ.get("PXR_PLUGINPATH_NAME", "").split(os.pathsep)
    return [folder for folder in named if folder and (pathlib.Path(folder) / "hdAlabasterPlugin.so").is_file()]


def register():
    if not plugin_folders():  # Blender ends with a segmentation fault where it finds no plug-in of an engine's name
        raise RuntimeError("PXR_PLUGINPATH_NAME names no folder with hdAlabasterPlugin.so. Set it to PREFIX/lib/alabaster/hydra before "
                           "Blender starts (delegate/hydra/README.md)")
    bpy.utils.register_class(AlabasterHydraEngine)
    for panel in panels():
        panel.COMPAT_ENGINES.add(AlabasterHydraEngine.bl_idname)
    if not bpy.app.binary_path:  # the module bpy
        atexit.register(unregister)  # that of Blender 4.2 crashes at exit where it still has an engine, that of 4.5 hangs


def unregister():
    """Once: Blender also disables add-ons at its exit."""
    atexit.unregister(unregister)
    if not AlabasterHydraEngine.is_registered:
        return
    for panel in panels():
        panel.COMPAT_ENGINES.discard(AlabasterHydraEngine.bl_idname)
    bpy.utils.unregister_class(AlabasterHydraEngine)


def panels():
    """Blender's panels of lights, cameras, materials and worlds, which EEVEE and Cycles share."""
    return [panel for panel in bpy.types.Panel.__subclasses__() if "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ())]
