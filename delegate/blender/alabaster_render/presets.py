"""Presets of quality as schemas/quality_presets.json has them.

Without `bpy`: Blender 4.2 keeps the functions of properties, and the module bpy crashes at exit where one of them still leads to it.
"""
from . import schema

PRESETS = schema.document("quality_presets")["presets"]
NAMES = sorted({name for preset in PRESETS for name in preset["settings"]})
DEFAULTS = {name: p.default for name, p in schema.parameters("render_settings").items() if name in NAMES}


def values(preset):
    """All settings that any preset has. Those that this one does not name are at their defaults."""
    return {**DEFAULTS, **preset["settings"]}


def _is_set(group, preset):
    return all(held == value or (isinstance(value, float) and abs(held - value) <= 1e-6)
               for held, value in ((getattr(group, name), value) for name, value in values(preset).items()))


def held(group):
    """The number of the preset whose settings a scene has, from 1; 0: of none."""
    return next((number for number, preset in enumerate(PRESETS, 1) if _is_set(group, preset)), 0)


def apply(group, number):
    for name, value in values(PRESETS[number - 1]).items() if number else ():
        setattr(group, name, value)
