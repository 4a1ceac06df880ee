"""Alabaster: path-traced subsurface scattering. See help(hdalabaster.Scene) and help(hdalabaster.Renderer)."""
from ._hdalabaster import _check_interpreter

_check_interpreter()

from ._hdalabaster import (ArgumentError, Cancelled, Display, Error, NotFoundError, OutputError, Pixels, Primvar, Render, Renderer,
                         RenderError, Scene, SceneError, __version__, versions)
from ._medium import medium
from ._scene import SceneMethods as _SceneMethods
from ._stage import load_stage

for _name, _method in vars(_SceneMethods).items():
    if not _name.startswith("_"):
        setattr(Scene, _name, _method)
del _name, _method

__all__ = ["ArgumentError", "Cancelled", "Display", "Error", "NotFoundError", "OutputError", "Pixels", "Primvar", "Render", "Renderer",
           "RenderError", "Scene", "SceneError", "load_stage", "medium", "versions"]
