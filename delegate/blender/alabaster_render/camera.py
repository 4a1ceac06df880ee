"""Blender's cameras, and the viewport's, as parameters of schemas/camera.json. Scene units are metres."""
import mathutils

from . import names

MILLIMETRE = 1e-3


def _lens(data, depsgraph, focus_from):
    """Depth of field. focus_from: the camera's matrix, from which the distance to the object in focus counts."""
    if not data.dof.use_dof or data.type == "ORTHO":
        return {}
    distance = data.dof.focus_distance
    if data.dof.focus_object:
        target = data.dof.focus_object.evaluated_get(depsgraph).matrix_world.translation
        distance = -(focus_from.normalized().inverted() @ target).z
    return {"fStop": data.dof.aperture_fstop, "focusDistance": max(distance, 0.0), "apertureBlades": data.dof.aperture_blades,
            "apertureRotation": _degrees(data.dof.aperture_rotation)}


def _degrees(radians):
    return radians * 57.29577951308232


def placement(camera):
    """The camera's matrix without its scale, which neither lens nor film takes part in."""
    return camera.matrix_world.normalized()


def lens(camera, depsgraph):
    """Parameters that may change while the shutter is open."""
    focus = {name: value for name, value in _lens(camera.data, depsgraph, camera.matrix_world).items() if name in ("fStop", "focusDistance")}
    return focus if camera.data.type == "ORTHO" else {"focalLength": camera.data.lens * MILLIMETRE, **focus}


def final(camera, depsgraph, width, height, aspect):
    """Parameters of a camera object for a picture of width x height pixels, whose shape is `aspect` (x : y)."""
    data = camera.data
    fit = data.sensor_fit if data.sensor_fit != "AUTO" else "HORIZONTAL" if width * aspect >= height else "VERTICAL"
    shape = width * aspect / height
    if data.type == "ORTHO":
        film = data.ortho_scale
        focal = 1.0
    else:
        film = (data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width) * MILLIMETRE
        focal = data.lens * MILLIMETRE
    across, up = (film, film / shape) if fit == "HORIZONTAL" else (film * shape, film)
    parameters = {
        "projection": "orthographic" if data.type == "ORTHO" else "perspective",
        "focalLength": focal, "horizontalAperture": across, "verticalAperture": up,
        "horizontalApertureOffset": data.shift_x * film, "verticalApertureOffset": data.shift_y * film,
        "clippingRange": (data.clip_start, data.clip_end)}
    parameters.update(_lens(data, depsgraph, camera.matrix_world))
    return parameters


def viewport(context, depsgraph):
    """A camera for the region that is drawn: transform and parameters, from the matrices that Blender draws with."""
    region, space = context.region_data, context.space_data
    window = region.window_matrix
    looks_through = region.view_perspective == "CAMERA" and space.camera is not None
    data = space.camera.evaluated_get(depsgraph).data if looks_through and space.camera.type == "CAMERA" else None
    orthographic = not region.is_perspective
    focal = 1.0 if orthographic else (data.lens if data else space.lens) * MILLIMETRE
    across, up = 2 * focal / window[0][0], 2 * focal / window[1][1]
    # The middle of the picture lies off the axis by the third column of a perspective matrix, by the fourth of a parallel one.
    x, y = (-window[0][3], -window[1][3]) if orthographic else (window[0][2], window[1][2])
    parameters = {
        "projection": "orthographic" if orthographic else "perspective",
        "focalLength": focal, "horizontalAperture": across, "verticalAperture": up,
        "horizontalApertureOffset": 0.5 * across * x, "verticalApertureOffset": 0.5 * up * y}
    to_world = region.view_matrix.inverted()
    if orthographic and not data:
        to_world = to_world @ mathutils.Matrix.Translation((0, 0, 0.5 * space.clip_end))  # what lies behind the eye is seen, too
    else:
        parameters["clippingRange"] = (data.clip_start, data.clip_end) if data else (space.clip_start, space.clip_end)
    if data:
        parameters.update(_lens(data, depsgraph, to_world))
    return {"transform": names.matrix(to_world), **parameters}


