"""Stages that the plug-in is tested with, each with an expectation.

A case is a function of a folder that it may write files to. It gives a dictionary: stage (its text); and one of
  equals    the text of another stage that shows the same; `within`: the mean difference that is allowed (default none)
  written   True: the program renders the same from the scene that the plug-in writes
  check     a function of the pictures (arrays of rows from the top down) that gives a fault, or nothing
besides options of record_stage, and frames, a list of {time, settings}; `equals` and `written` are about the last picture.
"""
from stage_text import *  # noqa: F403

CASES = {}


def case(function):
    CASES[function.__name__] = function
    return function


def lit_by(*lights):
    return HEAD + "".join([camera(), wax(), clay(), octahedron("body", bound("/wax")), floor(bound("/clay")), *lights])


def light(kind, *lines, turn=(0, 0, 0), x=0.5, y=1.5, z=1.5):
    return prim(kind, "light", *lines, moved(x, y, z, turn))


LIGHTS = {
    "sphere": light("SphereLight", "float inputs:radius = 0.3", "float inputs:intensity = 20"),
    "point": light("SphereLight", "float inputs:radius = 0.3", "bool treatAsPoint = 1", "float inputs:intensity = 30", "bool inputs:normalize = 1"),
    "disk": light("DiskLight", "float inputs:radius = 0.5", "float inputs:intensity = 20", turn=(-50, 0, 0)),
    "rect": light("RectLight", "float inputs:width = 2", "float inputs:height = 0.5", "float inputs:intensity = 20", "float inputs:exposure = 0.5", turn=(-50, 0, 0)),
    "cylinder": light("CylinderLight", "float inputs:length = 2", "float inputs:radius = 0.1", "float inputs:intensity = 20", "color3f inputs:color = (1, 0.6, 0.2)"),
    "spot": prim("SphereLight", "light", "float inputs:radius = 0.05", "float inputs:intensity = 3000", "float inputs:shaping:cone:angle = 25",
                 "float inputs:shaping:cone:softness = 0.3", "float inputs:shaping:focus = 2", moved(0, 2, 2, (-50, 0, 0)),
                 about='prepend apiSchemas = ["ShapingAPI"]'),
    "distant": light("DistantLight", "float inputs:intensity = 50", "float inputs:angle = 8", "bool inputs:enableColorTemperature = 1",
                     "float inputs:colorTemperature = 3000", turn=(-40, 20, 0)),
    "dome": light("DomeLight", "float inputs:intensity = 0.7", "color3f inputs:color = (0.3, 0.6, 1)"),
}


def a_light(kind):
    return lambda _: {"stage": lit_by(LIGHTS[kind]), "written": True}


for kind in LIGHTS:
    CASES["light_" + kind] = a_light(kind)


@case
def standard_surface(_):
    paint = standard("paint", "color3f inputs:base_color = (0.2, 0.5, 0.8)", "float inputs:specular_roughness = 0.3", "float inputs:subsurface = 0.5",
                     "color3f inputs:subsurface_color = (0.9, 0.3, 0.2)", "color3f inputs:subsurface_radius = (0.3, 0.2, 0.1)", "float inputs:coat = 0.5")
    return {"stage": HEAD + camera() + sun() + paint + octahedron("body", bound("/paint")), "written": True}
