#!/usr/bin/env python3
"""Each dirty bit, and edits of a scene that mark it: a render that follows the edit must show the picture of a scene that had it from
the start, and not the picture before. Needs the Python module.

  dirty_bits_table.py [BIT ...]

A bit of delegate/api/scene_types.h without a row fails. An edit changes one field, so that a bit is marked for it alone.
"""
import pathlib
import re
import sys
import tempfile
from typing import Callable, NamedTuple

import hdalabaster
from small_scene import CAMERA, HEIGHT, KEY, WIDTH, at, set_ball, small_scene
from shapes import cube_sphere

HEADER = pathlib.Path(__file__).resolve().parents[2] / "delegate/api/scene_types.h"
BALL = cube_sphere(2, lambda d: d)
PLACE = at(0, 0.8, 1.5, 0.7)
LEFT, RIGHT = (-1.0, 0.8, 1.5), (1.0, 0.8, 1.5)


class Row(NamedTuple):
    """`edit(scene)` is done to a scene that `begin(scene)` has completed; `aovs` must follow. `frame`: other arguments of the update."""
    name: str
    edit: Callable
    begin: Callable = lambda scene: None
    aovs: tuple = ("color",)
    frame: dict = {}


def scaled(scale):
    return [tuple(scale * c for c in p) for p in BALL.points]


def each(value):
    return [value] * len(BALL.points)


def mesh(**options):
    """A ball in front of the camera, with these options of set_mesh."""
    return lambda scene: set_ball(scene, "/probe", **{"place": PLACE, "material": "/metal", **options})


def faces(count):
    return lambda scene: scene.set_mesh("/probe", BALL.points, BALL.quads[:count], transform=PLACE, material="/metal")


def painted(scene):
    scene.set_material("/paint", nodes={"surface": {"baseColor": ("color", "rgb")}, "color": {"type": "AlabasterPrimvar"}})
    mesh(material="/paint", primvars={"displayColor": each((0.9, 0.1, 0.1))})(scene)


def instanced(*places, indices=None, **options):
    def fill(scene):
        scene.set_instancer("/many", {"/probe": indices or list(range(len(places)))}, translations=list(places), **options)
        mesh(instancer="/many", place=None)(scene)
    return fill


def within_another(parent):
    def fill(scene):
        scene.set_instancer("/outer", {"/many": [0, 1]}, translations=[(0, 0, 0), (0, 0.6, 0)])
        instanced(LEFT, RIGHT, **parent)(scene)
    return fill


def with_shutter(begin):
    def fill(scene):
        begin(scene)
        for name, value in (("shutterOpen", -0.5), ("shutterClose", 0.5)):
            scene.set_parameter("/camera", name, value)
    return fill


def linked(scene):
    mesh(categories=["some"])(scene)
    scene.set_parameter("/key", "lightLink", "some")


def overlapping(scene):
    """Two balls of wax, one of them in a set."""
    mesh(material="/wax", place=at(-1.2, 0.5, 0.4, 0.5))(scene)
    scene.set_primvar("/wax_ball", "subsurfaceSet", hdalabaster.Primvar("set", "constant"))


def lens(**parameters):
    return lambda scene: scene.set_camera("/camera", CAMERA, focalLength=0.05, horizontalAperture=0.036, verticalAperture=0.024, **parameters)


def changed(name, before, after, aovs=("color",)):
    return Row(name, mesh(**after), mesh(**before), aovs)


def parameter(path, name, value, begin=mesh()):
    return Row(f"{name} of {path}", lambda scene: scene.set_parameter(path, name, value), begin)


def primvar(name, values, begin):
    return Row(name, lambda scene: scene.set_primvar("/probe", name, values), begin)


MOVING = [(-0.5, at(-0.5, 0.8, 1.5)), (0.5, at(0.5, 0.8, 1.5))]
SHARP = {"corner_indices": list(range(20)), "corner_weights": [9.0] * 20}
TABLE = {  # rows, or why there is none
    "kPrimId": "the renderer numbers prims",
    "kPoints": [primvar("points", scaled(1.5), mesh()),
                primvar("points", hdalabaster.Primvar(scaled(1), motion=[(-0.5, scaled(0.5)), (0.5, scaled(1.5))]), with_shutter(mesh()))],
    "kPrimvar": [primvar("displayColor", each((0.1, 0.1, 0.9)), painted),
                 primvar("holdout", hdalabaster.Primvar(True, "constant"), mesh()),
                 primvar("visibleToCamera", hdalabaster.Primvar(False, "constant"), mesh()),
                 primvar("subsurfaceSet", hdalabaster.Primvar("set", "constant"), overlapping),
                 Row("values of instances", lambda scene: scene.set_instance_values("/many", 1, translations=[(0, 0, 0.5)]), instanced(LEFT, RIGHT)),
                 Row("translations", instanced(LEFT, (0, 0, 0.5)), instanced(LEFT, RIGHT))],
    "kMaterialId": [Row("material", lambda scene: scene.bind_material("/probe", "/wax"), mesh())],
    "kTopology": [Row("faces", faces(12), faces(24)), changed("scheme", {"scheme": "bilinear"}, {"scheme": "catmullClark"}),
                  changed("orientation", {"double_sided": False}, {"double_sided": False, "left_handed": True}),
                  changed("holes", {}, {"holes": [0, 1, 2, 3, 4, 5, 8, 9]}),
                  changed("invisible faces", {}, {"invisible_faces": list(range(12))}),
                  changed("subsets", {}, {"subsets": {"/wax": list(range(12))}})],
    "kTransform": [Row("mesh", lambda scene: scene.set_transform("/probe", at(0.8, 0.8, 1.5)), mesh()),
                   Row("motion of a mesh", mesh(motion=MOVING), with_shutter(mesh())),
                   Row("light", lambda scene: scene.set_transform("/key", at(0, 3, 3)), mesh()),
                   Row("camera", lambda scene: scene.set_transform("/camera", at(0.3, 1, 6)), mesh()),
                   Row("motion of a camera", lens(shutterOpen=-0.5, shutterClose=0.5, motion=[(-0.5, at(-0.3, 1, 6)), (0.5, at(0.3, 1, 6))]),
                       lens(shutterOpen=-0.5, shutterClose=0.5)),
                   Row("instancer", lambda scene: scene.set_transform("/many", at(0.4, 0.3, 0)), instanced(LEFT, RIGHT))],
    "kVisibility": [Row("mesh", lambda scene: scene.set_visible("/probe", False), mesh()),
                    Row("mesh that was hidden", lambda scene: scene.set_visible("/probe", True), mesh(visible=False)),
                    Row("light", lambda scene: scene.set_visible("/key", False), mesh())],
    "kNormals": [primvar("normals", each((0.0, 0.6, 0.8)), mesh(scheme="none", refine_level=0, primvars={"normals": each((0.0, 0.0, 1.0))}))],
    "kDoubleSided": [changed("one side", {"left_handed": True}, {"left_handed": True, "double_sided": False})],
    "kDisplayStyle": [changed("refineLevel", {"refine_level": 0}, {"refine_level": 2})],
    "kSubdivTags": [changed("corners", {}, {"subdiv_tags": SHARP})],
    "kInstancer": [Row("instancer of a mesh", instanced(LEFT, RIGHT), mesh(place=None)), Row("none", mesh(place=None), instanced(LEFT, RIGHT)),
                   Row("parent", within_another({"parent": "/outer"}), within_another({}))],
    "kInstanceIndex": [Row("indices", instanced(LEFT, RIGHT, indices=[1]), instanced(LEFT, RIGHT))],
    "kRenderTag": [changed("guide", {}, {"render_tag": "guide"})],
    "kParams": [parameter("/key", "intensity", 5.0), parameter("/key", "color", (0.2, 0.5, 1.0)), parameter("/camera", "focalLength", 0.03),
                Row("lens", lens(fStop=0.5, focusDistance=3.0), lens()),
                Row("lens that moves", lens(**{"focalLength:samples": [(0, 0.05), (1, 0.09)]}, shutterClose=1.0), lens()), parameter("/metal", "surface.roughness", 0.9),
                parameter("/settings", "seed", 5)],
    "kResource": [Row("material", lambda scene: scene.set_material("/metal", baseColor=(0.1, 0.7, 0.2)), mesh()),
                  Row("image of a light", lambda scene: scene.set_parameter("/sky", "texture:file", str(pathlib.Path(FOLDER) / "checks.png")))],
    "kDescription": [Row("size of the buffers", lambda scene: None, frame={"width": WIDTH // 2, "height": HEIGHT // 2})],
    "kCategories": [Row("light link", mesh(categories=["other"]), linked)],
    "kCullStyle": [changed("faces to the front", {"cull_style": "back"}, {"cull_style": "front"}, ("color", "normal"))],
}


def complete(row):
    scene = small_scene(FOLDER)
    scene.set_render_settings("/settings", camera="/camera", width=WIDTH, height=HEIGHT, samples=2)
    row.begin(scene)
    return scene


def pixels(render, aovs):
    if not render.wait():
        raise RuntimeError(f"the render ended as {render.state}")
    return [bytes(memoryview(render.pixels(aov))) for aov in aovs]


def fault_of(row):
    frame = {"aovs": list(row.aovs), "settings": "/settings"}
    scene = complete(row)
    render = hdalabaster.Renderer(scene).start(**frame)
    before = pixels(render, row.aovs)
    row.edit(scene)
    render.update(**row.frame)
    after = pixels(render, row.aovs)
    other = complete(row)
    row.edit(other)
    whole = pixels(hdalabaster.Renderer(other).start(**{**frame, **row.frame}), row.aovs)
    if whole == before:
        return "the edit changes nothing"
    if after == before:
        return "a render that runs does not follow the edit"
    return "" if after == whole else "after the edit the picture is not the one of a scene that had it from the start"


def main():
    known = set(re.findall(r"DirtyBits (k\w+) = 1u <<", HEADER.read_text()))
    found = [f"{bit}: there is no row for this bit" for bit in sorted(known - TABLE.keys())]
    found += [f"{bit}: there is no such bit" for bit in sorted(TABLE.keys() - known)]
    count = 0
    for bit, rows in TABLE.items():
        if isinstance(rows, str) or (sys.argv[1:] and bit not in sys.argv[1:]):
            continue
        for row in rows:
            count += 1
            if fault := fault_of(row):
                found.append(f"{bit}, {row.name}: {fault}")
    print("\n".join(found) if found else f"{count} edits of {len(known)} dirty bits are followed")
    return 1 if found else 0


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as FOLDER:
        sys.exit(main())
