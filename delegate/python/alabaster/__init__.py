"""Alabaster: path-traced subsurface scattering. See help(alabaster.Scene) and help(alabaster.Renderer)."""
from ._alabaster import _check_interpreter

_check_interpreter()

from ._alabaster import (ArgumentError, Cancelled, Display, Error, NotFoundError, OutputError, Pixels, Primvar, Render, Renderer,
                         RenderError, Scene, SceneError, __version__, versions)

__all__ = ["ArgumentError", "Cancelled", "Display", "Error", "NotFoundError", "OutputError", "Pixels", "Primvar", "Render", "Renderer",
           "RenderError", "Scene", "SceneError", "versions"]
