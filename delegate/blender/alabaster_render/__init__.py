"""Alabaster as a render engine of Blender. README.md beside this folder says what becomes of a scene."""
import atexit

import bpy

from . import engine, panels, preferences, settings

bl_info = {
    "name": "Alabaster",
    "author": "Alabaster",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render Properties > Render Engine",
    "description": "Path-traced subsurface scattering",
    "category": "Render",
}
MODULES = [preferences, settings, engine, panels]


_registered = False


def register():
    global _registered
    for module in MODULES:
        module.register()
    _registered = True
    if not bpy.app.binary_path:  # the module bpy
        atexit.register(unregister)  # that of Blender 4.2 crashes at exit where it still has an engine


def unregister():
    """Once: Blender also disables add-ons at its exit."""
    global _registered
    if not _registered:
        return
    engine.frames.close()  # raises where it cannot: then nothing has changed
    _registered = False
    atexit.unregister(unregister)
    for module in reversed(MODULES):
        module.unregister()
