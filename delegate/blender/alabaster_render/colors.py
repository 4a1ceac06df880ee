"""Colour spaces of images, by the OpenColorIO configuration that Blender uses.

The renderer reads that configuration itself where its OpenColorIO can. Where it cannot (Blender 5 writes profile version 2.4 and
later), names that mean the same everywhere stay, and images in other spaces are converted here by Blender's PyOpenColorIO.
"""
import functools
import importlib
import os
import pathlib
import sys

import bpy
import numpy

from . import library

SCENE_LINEAR = "scene_linear"  # a role of every configuration
EVERYWHERE = {"sRGB": "sRGB", "Linear": "linear", "Linear Rec.709": "linear", "Linear BT.709": "linear", SCENE_LINEAR: "linear"}


def blenders_file():
    named = os.environ.get("OCIO", "")
    return named if os.path.isfile(named) else str(pathlib.Path(bpy.utils.system_resource("DATAFILES")) / "colormanagement/config.ocio")


@functools.lru_cache(maxsize=None)
def _is_readable(file):
    hdalabaster = library.load()
    try:
        hdalabaster.Display(file)
    except hdalabaster.Error:
        return False
    return True


def renderers_file():
    """For setting "ocio": Blender's configuration, or "built-in" where the renderer cannot read it."""
    file = blenders_file()
    return file if _is_readable(file) else "built-in"


def working_space():
    """Blender 5 files choose what scene-linear means."""
    return getattr(getattr(bpy.data, "colorspace", None), "working_space", "") or SCENE_LINEAR


def name_of(image):
    """The space of an image's file as the renderer knows it; "" where it does not."""
    if image.colorspace_settings.is_data:
        return "raw"
    name = image.colorspace_settings.name
    if _is_readable(blenders_file()):
        return name
    return EVERYWHERE.get(name, "") if working_space() in EVERYWHERE else ""


def linear():
    """The renderer's name of its own space."""
    return SCENE_LINEAR if _is_readable(blenders_file()) else "linear"


def _blenders_own(name):
    """A package that Blender 4.5 and later bring. The module bpy has it, but not in Python's path."""
    path = list(sys.path)
    sys.path += map(str, pathlib.Path(bpy.utils.system_resource("PYTHON")).glob("lib/python*/site-packages"))
    try:
        return importlib.import_module(name)
    finally:
        sys.path[:] = path


@functools.lru_cache(maxsize=None)
def _processor(file, space, working):
    return _blenders_own("PyOpenColorIO").Config.CreateFromFile(file).getProcessor(space, working).getDefaultCPUProcessor()


def to_linear(rgba, space):
    """Converts rows of RGBA in place. False where Blender has no PyOpenColorIO."""
    try:
        processor = _processor(blenders_file(), space, working_space())
    except ImportError:
        return False
    processor.applyRGBA(rgba)
    return True


def from_srgb(values):
    return numpy.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
