"""Stages of OpenUSD that the user's own Python has opened, with its resolver."""
from __future__ import annotations

import tempfile
import warnings
from typing import TYPE_CHECKING, Any, Optional, Sequence

from ._hdalabaster import Scene

if TYPE_CHECKING:
    from pxr import Usd


def load_stage(stage: Usd.Stage, scene: Optional[Scene] = None, *, time: Optional[float] = None, settings: str = "",
               purposes: Sequence[str] = (), refine_level: int = 2) -> Scene:
    """Adds what an open Usd.Stage has at a time code to a scene, or to a new one, as the program reads it: usd.md of the manual. Without
    a time it is the stage's start. Each kind of thing that is not read is one Python warning."""
    from .alabaster_usd import notes, scene as reading, values
    scene = Scene() if scene is None else scene
    sink, told = values.Archive(), notes.Notes()
    asked: dict[str, Any] = {"refine": refine_level, "settings": settings, "purposes": list(purposes)}
    beside = reading.Reader(stage, sink, told, time, asked).run()
    for kind, count, first in told.warnings():
        warnings.warn(f"{first}: {kind} ({count} times)", stacklevel=2)
    for fault in told.faults:
        warnings.warn(f"{fault['prim']}: {fault['text']}", stacklevel=2)
    with tempfile.NamedTemporaryFile(suffix=".alab") as file:
        sink.write(file.fileno(), beside)
        scene.load(file.name, allow_outside=True)
    return scene
