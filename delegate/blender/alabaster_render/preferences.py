"""Preferences of the add-on: where the Python module is."""
import bpy

from . import library


def _changed(preferences, _context):
    library.set_folder(bpy.path.abspath(preferences.module_folder))


class AlabasterPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    module_folder: bpy.props.StringProperty(
        name="Module Folder", subtype="DIR_PATH", update=_changed,
        description="The folder that holds the Python module alabaster; empty: the one that the add-on was installed with")

    def draw(self, _context):
        self.layout.prop(self, "module_folder")
        try:
            self.layout.label(text=f"alabaster {library.load().__version__}", icon="CHECKMARK")
        except ImportError as error:
            self.layout.label(text=str(error), icon="ERROR")


def register():
    bpy.utils.register_class(AlabasterPreferences)
    held = bpy.context.preferences.addons.get(__package__)
    if held and held.preferences:
        _changed(held.preferences, None)


def unregister():
    bpy.utils.unregister_class(AlabasterPreferences)
