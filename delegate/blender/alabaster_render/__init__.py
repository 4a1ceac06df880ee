"""Alabaster as a render engine of Blender. README.md beside this folder says what becomes of a scene."""
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


def register():
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()
