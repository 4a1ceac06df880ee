"""Preferences of the add-on: where the Python module and the denoiser are."""
import bpy

from . import denoiser, library


def _changed(preferences, _context):
    library.set_folder(bpy.path.abspath(preferences.module_folder))
    denoiser.set_folder(bpy.path.abspath(preferences.denoiser_folder))


class AlabasterPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    module_folder: bpy.props.StringProperty(
        name="Module Folder", subtype="DIR_PATH", update=_changed,
        description="The folder that holds the Python module hdalabaster; empty: the one that the add-on was installed with")
    denoiser_folder: bpy.props.StringProperty(
        name="Denoiser Folder", subtype="DIR_PATH", update=_changed,
        description="The folder that holds Open Image Denoise 2; empty: the renderer looks beside itself, in the system and in Blender (from 4.0 on)")

    def draw(self, _context):
        self.layout.prop(self, "module_folder")
        self.layout.prop(self, "denoiser_folder")
        try:
            self.layout.label(text=f"hdalabaster {library.load().__version__}", icon="CHECKMARK")
        except ImportError as error:
            self.layout.label(text=str(error), icon="ERROR")


def register():
    bpy.utils.register_class(AlabasterPreferences)
    held = bpy.context.preferences.addons.get(__package__)
    if held and held.preferences:
        _changed(held.preferences, None)


def unregister():
    bpy.utils.unregister_class(AlabasterPreferences)
