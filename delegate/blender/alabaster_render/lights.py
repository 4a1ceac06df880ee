"""Blender's lights as UsdLux's, with the brightness that Cycles gives them (README.md has the table)."""
import math

import bpy
import mathutils

from . import names
from .sockets import Reader, Source

MODERN = bpy.app.version >= (4, 0, 0)


def radiance_of_sphere(light, radius):
    """Radiance of a point light with a radius: the power over 4 pi^2 r^2."""
    return light.energy / (math.pi if not _normalized(light) else 4 * math.pi ** 2 * radius ** 2)


def radiance_of_area(light, area):
    """Radiance of an area light of spread pi. Blender 3 takes 4 for the pi of a surface that radiates evenly."""
    return light.energy / ((math.pi if MODERN else 4) * (area if _normalized(light) else 1.0))


def _normalized(light):
    """False where the power does not depend on the size (from Blender 4.5 on)."""
    return getattr(light, "normalize", True)


def smooth(inner, outer):
    """Our cone: a smoothstep of the angle."""
    return lambda angle: (lambda t: t * t * (3 - 2 * t))(min(max((outer - angle) / max(outer - inner, 1e-6), 0.0), 1.0))


def flux(falloff, outer, power=0, steps=256):
    """Through a cone of directions, over 2 pi; weighted by that power of the cosine."""
    angles = [(i + 0.5) / steps * outer for i in range(steps)]
    return sum(falloff(a) * math.cos(a) ** power * math.sin(a) for a in angles) * outer / steps


def _spot(light):
    """Cycles falls by a smoothstep of the cosine, from the cone's to where `spot_blend` ends; ours by one of the angle, from the
    same cone inwards, as far as gives the same flux. In Blender 3 the cosine itself multiplies that."""
    outer = 0.5 * light.spot_size
    wanted = (1 - math.cos(outer)) * (1 - 0.5 * light.spot_blend)
    low, high = 0.0, outer
    for _ in range(30):
        inner = 0.5 * (low + high)
        low, high = (inner, high) if flux(smooth(inner, outer), outer) < wanted else (low, inner)
    shaping = {"shaping:cone:angle": math.degrees(outer), "shaping:cone:softness": 1 - low / outer}
    return shaping if MODERN else {**shaping, "shaping:focus": 1.0}


def _spread(light):
    """(factor of the radiance, shaping) of an area light that is gathered about its axis. Cycles falls evenly with the tangent of
    the angle, ours by a smoothstep over the same cone, with the same flux."""
    half = 0.5 * light.spread
    if half >= 0.5 * math.pi - 1e-3:
        return 1.0, {}
    half = max(half, 1e-3)
    peak = 1 / (1 - half / math.tan(half))
    theirs = flux(lambda a: peak * (1 - math.tan(a) / math.tan(half)), half, 1)
    factor = theirs / flux(smooth(0.0, half), half, 1)
    return factor, {"shaping:cone:angle": math.degrees(half), "shaping:cone:softness": 1.0}


def _point(light, matrix):
    radius = light.shadow_soft_size
    shape = {"radius": radius, "intensity": radiance_of_sphere(light, radius)} if radius > 0 else {
        "treatAsPoint": True, "intensity": light.energy / (4 * math.pi)}
    if light.type == "SPOT":
        shape.update(_spot(light))
    return "sphereLight", matrix.normalized(), shape


def _sun(light, matrix):
    return "distantLight", matrix.normalized(), {
        "intensity": light.energy, "angle": math.degrees(light.angle), "normalize": _normalized(light)}


def _area(light, matrix):
    across = light.size
    up = light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
    round_shape = light.shape in {"DISK", "ELLIPSE"}
    # Sizes go into the matrix: an ellipse is a disk that is scaled unevenly.
    sized = matrix @ mathutils.Matrix.Diagonal((across, up, 1.0, 1.0))
    x, y = sized.col[0].to_3d(), sized.col[1].to_3d()
    area = x.cross(y).length * (0.25 * math.pi if round_shape else 1.0)
    if area <= 0:
        return None
    shape = {"radius": 0.5} if round_shape else {"width": 1.0, "height": 1.0}
    factor, shaping = _spread(light)
    return ("diskLight" if round_shape else "rectLight"), sized, {
        **shape, **shaping, "intensity": factor * radiance_of_area(light, area)}


MAKERS = {"POINT": _point, "SPOT": _point, "SUN": _sun, "AREA": _area}


def motion(light, poses):
    """Transforms at times of a light whose size is that of the frame; None where it gives none. poses: [(time, rows)] of its object."""
    placed = [(time, MAKERS[light.type](light, mathutils.Matrix(rows).transposed())) for time, rows in poses or ()]
    return [(time, names.matrix(made[1])) for time, made in placed] if placed and all(made for _, made in placed) else None


def _emission_node(light, note):
    """(colour, strength) of an Emission node, which multiply the light. Textures count by their mean."""
    if not light.use_nodes or not light.node_tree:
        return (1.0, 1.0, 1.0), 1.0
    reader = Reader(None, note)
    output = light.node_tree.get_output_node("CYCLES") or light.node_tree.get_output_node("ALL")
    source = reader.source(output.inputs["Surface"]) if output else None
    if not isinstance(source, Source):
        return (0.0, 0.0, 0.0), 1.0
    if source.node.type != "EMISSION":
        note(f"node '{source.node.name}' is not translated; an Emission node is expected")
        return (1.0, 1.0, 1.0), 1.0
    strength = reader.mean(reader.input(source, "Strength"), "strength")
    return reader.mean(reader.input(source, "Color"), "colour"), sum(strength) / 3


def _cycles(light, name, otherwise):
    """A setting of Cycles, which may not be there."""
    return getattr(getattr(light, "cycles", None), name, otherwise)


def translate(light, matrix, camera_sees, note):
    """(type, transform, parameters) of a light, or None where it gives none. note(text) hears of what is approximated."""
    if light.type == "AREA" and _cycles(light, "is_portal", False):
        return None  # the world shines through it by itself
    made = MAKERS[light.type](light, matrix)
    if not made:
        return None
    kind, placed, parameters = made
    tint, strength = _emission_node(light, lambda text: note(f"light '{light.name}': {text}"))
    if not (_cycles(light, "cast_shadow", True) and getattr(light, "use_shadow", True)):
        note(f"light '{light.name}': it casts shadows, because lights without them are not translated")
    exposure = getattr(light, "exposure", 0.0)
    temperature = getattr(light, "use_temperature", False)
    if temperature:
        tint = [a * b for a, b in zip(tint, light.temperature_color)]
    parameters["intensity"] *= strength * 2 ** exposure
    parameters["color"] = [max(0.0, a * b) for a, b in zip(light.color, tint)]
    parameters["visibleToCamera"] = bool(camera_sees)
    return kind, names.matrix(placed), parameters
