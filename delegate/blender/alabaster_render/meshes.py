"""Blender's meshes, curves, texts and metaballs as arguments of hdalabaster.Scene.set_mesh."""
from typing import NamedTuple

import bpy
import numpy

from . import images

TOPOLOGY = ("counts", "indices", "curve_vertex_counts")
KINDS = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
CORNER_NORMALS = bpy.app.version >= (4, 1, 0)  # meshes know their normals; before, they had to be computed
LAST_BITS = 1e-5  # of the components of a normal: no two normals of a vertex are as close
INFINITELY_SHARP = 10.0  # of OpenSubdiv

BOUNDARIES = {"ALL": "edgeOnly", "PRESERVE_CORNERS": "edgeAndCorner"}
UV_SMOOTHING = {"NONE": "all", "PRESERVE_CORNERS": "cornersOnly", "PRESERVE_CORNERS_AND_JUNCTIONS": "cornersPlus1",
                "PRESERVE_CORNERS_JUNCTIONS_AND_CONCAVE": "cornersPlus2", "PRESERVE_BOUNDARIES": "boundaries",
                "SMOOTH_ALL": "none"}


class Primvar(NamedTuple):
    """Arguments of hdalabaster.Primvar, which can be compared."""
    values: numpy.ndarray
    interpolation: str
    role: str = ""
    motion: list = None  # [(time, values)]


def same(a, b):
    """True for two meshes of the same numbers."""
    if isinstance(a, numpy.ndarray):
        return isinstance(b, numpy.ndarray) and numpy.array_equal(a, b)
    if isinstance(a, dict):
        return isinstance(b, dict) and a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, tuple):
        return isinstance(b, tuple) and all(same(x, y) for x, y in zip(a, b))
    return a == b


def shape(mesh):
    """The arguments of set_mesh that a deformation changes, and those that it must not."""
    return mesh and {**{name: mesh[name] for name in ("points", *TOPOLOGY) if name in mesh}, "normals": mesh.get("primvars", {}).get("normals")}


def same_topology(a, b):
    return b is not None and all(numpy.array_equal(a.get(name), b.get(name)) for name in TOPOLOGY) \
        and len(a["points"]) == len(b["points"])


def array(collection, attribute, dtype, width=1):
    """An attribute of each element; read-only, so that the renderer reads it where it lies."""
    values = numpy.empty(len(collection) * width, dtype)
    collection.foreach_get(attribute, values)
    return frozen(values.reshape(-1, width) if width > 1 else values)


def frozen(values):
    values.flags.writeable = False
    return values


def subdivision(ob, viewport):
    """The subdivision modifiers at the end of the stack, last first, that refine instead of being applied."""
    shown = "show_viewport" if viewport else "show_render"
    found = []
    for modifier in reversed(ob.modifiers):
        if not getattr(modifier, shown):
            continue
        if modifier.type != "SUBSURF" or (found and modifier.subdivision_type != found[0].subdivision_type):
            break
        found.append(modifier)
    return found


def level(modifier, scene, viewport):
    levels = modifier.levels if viewport else modifier.render_levels
    render = scene.render
    if render.use_simplify:
        levels = min(levels, render.simplify_subdivision if viewport else render.simplify_subdivision_render)
    return levels


class Cage:
    """While it lives, an evaluated object is without the subdivision at the end of its stack."""

    def __init__(self, ob, modifiers, viewport):
        self.ob, self.modifiers, self.shown = ob, modifiers, "show_viewport" if viewport else "show_render"

    def __enter__(self):
        for modifier in self.modifiers:
            setattr(modifier, self.shown, False)
        return self.ob

    def __exit__(self, *_):
        for modifier in self.modifiers:
            setattr(modifier, self.shown, True)


def extract(ob, depsgraph, is_real, viewport, wanted):
    """Arguments of set_mesh, without material, transform and instancer; None: there are no faces. is_real: the object's own
    data, and not what geometry nodes put in its place."""
    scene = depsgraph.scene_eval
    modifiers = subdivision(ob, viewport) if is_real and ob.type == "MESH" and ob.mode == "OBJECT" else []
    levels = sum(level(modifier, scene, viewport) for modifier in modifiers)
    if not is_real and ob.type == "MESH":
        return arguments(ob.data, wanted)
    if levels > 0:
        with Cage(ob, modifiers, viewport):
            mesh = ob.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
            cage = arguments(mesh, wanted, modifiers[0], min(levels, 8)) if mesh and is_smooth(mesh) else None
            ob.to_mesh_clear()
        if cage:
            return cage
    mesh = ob.to_mesh()
    made = arguments(mesh, wanted) if mesh else None
    ob.to_mesh_clear()
    return made


def is_smooth(mesh):
    """False if a face is flat: refinement would round its facets off."""
    return bool(array(mesh.polygons, "use_smooth", bool).all())


def arguments(mesh, wanted, modifier=None, levels=0):
    if len(mesh.polygons) == 0:
        return None
    counts = array(mesh.polygons, "loop_total", numpy.int32)
    primvars = {**texture_coordinates(mesh, wanted), **colors(mesh, wanted)}
    made = {"points": array(mesh.vertices, "co", numpy.float32, 3), "counts": counts,
            "indices": array(mesh.loops, "vertex_index", numpy.int32), "primvars": primvars,
            "material_index": array(mesh.polygons, "material_index", numpy.int32)}
    if modifier:
        made.update(scheme="catmullClark" if modifier.subdivision_type == "CATMULL_CLARK" else "bilinear", refine_level=levels,
                    subdiv_tags=tags(mesh, modifier))
    else:
        primvars.update(normals(mesh))
    return made


def tags(mesh, modifier):
    made = {"interpolate_boundary": BOUNDARIES[modifier.boundary_smooth],
            "face_varying_linear_interpolation": UV_SMOOTHING[modifier.uv_smooth]}
    if not modifier.use_creases:
        return made
    edges, vertices = creases(mesh)
    sharp = numpy.flatnonzero(edges > 0)
    if len(sharp):
        ends = array(mesh.edges, "vertices", numpy.int32, 2)[sharp]
        made.update(crease_indices=frozen(ends.reshape(-1).copy()), crease_lengths=numpy.full(len(sharp), 2, numpy.int32),
                    crease_weights=sharpness(edges[sharp]))
    sharp = numpy.flatnonzero(vertices > 0)
    if len(sharp):
        made.update(corner_indices=frozen(sharp.astype(numpy.int32)), corner_weights=sharpness(vertices[sharp]))
    return made


def creases(mesh):
    """Creases of edges and of vertices, 0 to 1."""
    named = [mesh.attributes.get(name) for name in ("crease_edge", "crease_vert")]
    if bpy.app.version >= (4, 0, 0):
        return [array(one.data, "value", numpy.float32) if one else numpy.zeros(0, numpy.float32) for one in named]
    corners = mesh.vertex_creases
    return (array(mesh.edges, "crease", numpy.float32),
            array(corners[0].data, "value", numpy.float32) if len(corners) else numpy.zeros(0, numpy.float32))


def sharpness(crease):
    """Blender's own rule (BKE_subdiv_crease_to_sharpness_f)."""
    return frozen((crease * crease * INFINITELY_SHARP).astype(numpy.float32))


def texture_coordinates(mesh, wanted):
    """st, of the map that is active for rendering, and those that materials name."""
    made = {}
    for layer in mesh.uv_layers:
        names = ["st"] * layer.active_render + [images.uv_primvar(layer.name)] * (layer.name in wanted.maps)
        if names:
            values = array(layer.data, "uv", numpy.float32, 2)
            made.update({name: Primvar(values, "faceVarying", role="textureCoordinate") for name in names})
    return made


def colors(mesh, wanted):
    """displayColor, of the colour attribute that materials name, or of the active one."""
    if not wanted.colors or not len(mesh.color_attributes):
        return {}
    named = [a for a in mesh.color_attributes if a.name in wanted.colors]
    index = max(getattr(mesh.color_attributes, "render_color_index", 0), 0)  # point clouds have none
    attribute = named[0] if named else mesh.color_attributes[index]
    values = array(attribute.data, "color", numpy.float32, 4)
    spread = "vertex" if attribute.domain == "POINT" else "faceVarying"
    return {"displayColor": Primvar(frozen(values[:, :3].copy()), spread, role="color")}


def normals(mesh):
    """Nothing for a mesh of flat faces, whose normals the renderer knows."""
    if CORNER_NORMALS:
        domain = mesh.normals_domain
        if domain == "FACE":
            return {}
        if domain == "POINT":
            return {"normals": Primvar(array(mesh.vertex_normals, "vector", numpy.float32, 3), "vertex")}
        return {"normals": Primvar(array(mesh.corner_normals, "vector", numpy.float32, 3), "faceVarying")}
    smooth = array(mesh.polygons, "use_smooth", bool)
    split = mesh.use_auto_smooth or mesh.has_custom_normals
    if not smooth.any() and not split:
        return {}
    of_vertices = vertex_normals(mesh)
    if smooth.all() and not split:
        return {"normals": Primvar(frozen(of_vertices), "vertex")}
    mesh.calc_normals_split()
    made = array(mesh.loops, "normal", numpy.float32, 3).copy()
    mesh.free_normals_split()
    of_corners = of_vertices[array(mesh.loops, "vertex_index", numpy.int32)]
    taken = (abs(made - of_corners) < LAST_BITS).all(axis=1)  # these corners have the normals of their vertices
    made[taken] = of_corners[taken]
    return {"normals": Primvar(frozen(made), "faceVarying")}


def vertex_normals(mesh):
    """The normals of faces, weighted by their angles at the vertex. Blender before 4.1 sums them in no fixed order, so that the
    last bits differ from frame to frame; here the order is that of the corners."""
    points = array(mesh.vertices, "co", numpy.float32, 3).astype(numpy.float64)
    vertices = array(mesh.loops, "vertex_index", numpy.int32)
    first, count = (array(mesh.polygons, name, numpy.int32) for name in ("loop_start", "loop_total"))
    following, preceding = numpy.arange(1, len(vertices) + 1), numpy.arange(-1, len(vertices) - 1)
    following[first + count - 1], preceding[first] = first, first + count - 1
    corner = points[vertices]
    ahead, back = corner[following] - corner, corner[preceding] - corner
    lengths = numpy.sqrt((ahead * ahead).sum(axis=1) * (back * back).sum(axis=1))
    cosines = numpy.divide((ahead * back).sum(axis=1), lengths, out=numpy.ones(len(lengths)), where=lengths > 0)
    angles = numpy.arccos(numpy.clip(cosines, -1, 1))
    faces = numpy.repeat(array(mesh.polygons, "normal", numpy.float32, 3), count, axis=0)
    sums = numpy.stack([numpy.bincount(vertices, angles * faces[:, axis], len(points)) for axis in range(3)], axis=1)
    lengths = numpy.sqrt((sums * sums).sum(axis=1, keepdims=True))
    held = array(mesh.vertex_normals, "vector", numpy.float32, 3)  # where a vertex has no normal of its own
    return numpy.where(lengths > 1e-12, sums / numpy.maximum(lengths, 1e-12), held).astype(numpy.float32)
