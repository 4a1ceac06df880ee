"""Blender's hair and point clouds as fields of the kinds basisCurves and points."""
import numpy

from . import meshes

KINDS = {"CURVES", "POINTCLOUD"}
RADIUS = {"CURVES": 0.005, "POINTCLOUD": 0.01}  # where the attribute is missing, as in Cycles
CATMULL_ROM, POLY = 0, 1  # of attribute curve_type


def extract(ob, note, wanted):
    """Fields of an evaluated object of these KINDS; None: it has no points. Point clouds have the colours that materials read."""
    attributes = ob.data.attributes
    points = meshes.array(attributes["position"].data, "vector", numpy.float32, 3) if "position" in attributes else ()
    if not len(points):
        return None
    radius = attributes.get("radius")
    radii = meshes.array(radius.data, "value", numpy.float32) if radius else numpy.full(len(points), RADIUS[ob.type], numpy.float32)
    made = {"kind": "points", "points": points, "widths": meshes.frozen(radii * 2)}
    if ob.type == "POINTCLOUD":
        return {**made, "primvars": meshes.colors(ob.data, wanted)}
    offsets = numpy.empty(len(ob.data.curves) + 1, numpy.int32)
    ob.data.curve_offset_data.foreach_get("value", offsets)
    kinds, closed = (numpy.unique(meshes.array(attributes[name].data, "value", kind)) if name in attributes else numpy.zeros(1)
                     for name, kind in (("curve_type", numpy.int32), ("cyclic", bool)))
    if len(kinds) > 1 or len(closed) > 1 or kinds[0] not in (CATMULL_ROM, POLY):
        note(f"object '{ob.name}': its curves of other types than Catmull-Rom, and some closed ones among others, go through their points")
    wraps = "periodic" if len(closed) == 1 and closed[0] else "pinned"
    return strands(made, numpy.diff(offsets), "linear" if len(kinds) == 1 and kinds[0] == POLY else "cubic", wraps)


def strands(made, counts, kind="cubic", wrap="pinned"):
    return {**made, "kind": "basisCurves", "curve_vertex_counts": meshes.frozen(counts), "type": kind, "basis": "catmullRom", "wrap": wrap}


def systems(ob, viewport):
    """The particle systems of an evaluated object that are drawn as strands."""
    for modifier in ob.modifiers:
        if modifier.type == "PARTICLE_SYSTEM" and (modifier.show_viewport if viewport else modifier.show_render):
            settings = modifier.particle_system.settings
            if settings.type == "HAIR" and settings.render_type == "PATH":
                yield modifier.particle_system


def of_system(ob, system, viewport):
    """Fields of the strands of a particle system, whose children take the place of their parents; None: there are none."""
    settings = system.settings
    parents, children = len(system.particles), len(system.child_particles)
    first = parents if settings.child_type != "NONE" and children else 0
    steps = (1 << (settings.display_step if viewport else settings.render_step)) + 1
    if settings.kink == "SPIRAL":
        steps += settings.kink_extra_steps
    count = parents + children - first
    if count == 0:
        return None
    world = numpy.array([system.co_hair(object=ob, particle_no=first + i, step=s) for i in range(count) for s in range(steps)])
    to_object = numpy.array(ob.matrix_world.inverted_safe())
    points = (world @ to_object[:3, :3].T + to_object[:3, 3]).astype(numpy.float32)
    along = numpy.linspace(0, 1, steps)
    thins = (1 - along) ** (1 + settings.shape if settings.shape < 0 else 1 / max(1 - settings.shape, 1e-6))
    radii = settings.radius_scale * (settings.tip_radius + (settings.root_radius - settings.tip_radius) * thins)
    if settings.use_close_tip:
        radii[-1] = 0
    widths = numpy.tile(radii.astype(numpy.float32), count)
    return strands({"points": meshes.frozen(points), "widths": meshes.frozen(widths)}, numpy.full(count, steps, numpy.int32))
