"""Renders a glTF file with Cycles under a constant dome. Runs inside Blender (blender -b -P), for contact_sheet.py.

The argument is a JSON file: model, size, samples, threads, dome (radiance) and output, the path of the picture and, with the
suffix .json, of the camera as a render description has it. The camera frames the model as Alabaster frames one
(delegate/description/placement.h), with a lens of its own, so that both programs can use it.
"""
import json
import math
import pathlib
import sys

import addon_utils
import bpy
import mathutils
import numpy

numpy.bool = bool  # Debian 12's numpy no longer has this name, which its Blender's importer uses

FOCAL_LENGTH, FILM_HEIGHT, MARGIN = 50.0, 24.0, 0.86
AZIMUTH, ELEVATION = math.radians(35), math.radians(18)


def world_points():
    """In glTF's axes (y up); Blender's importer has turned y into z."""
    graph = bpy.context.evaluated_depsgraph_get()
    points = []
    for instance in graph.object_instances:
        if instance.object.type == "MESH" and instance.show_self:
            points += [instance.matrix_world @ v.co for v in instance.object.data.vertices]
    return [mathutils.Vector((p.x, p.z, -p.y)) for p in points] or [mathutils.Vector((0, 0, 0))]


def frame(points, aspect):
    """(axes x, y, z of the camera, eye), as frame_points."""
    z = mathutils.Vector((math.sin(AZIMUTH) * math.cos(ELEVATION), math.sin(ELEVATION), math.cos(AZIMUTH) * math.cos(ELEVATION)))
    x = mathutils.Vector((0, 1, 0)).cross(z).normalized()
    y = z.cross(x)
    half = FILM_HEIGHT / FOCAL_LENGTH / 2 * MARGIN
    position, needed = [], []
    depths = [p.dot(z) for p in points]
    for axis, t in ((x, half * aspect), (y, half)):
        along = [p.dot(axis) for p in points]
        plus, minus = max(a + t * d for a, d in zip(along, depths)), max(-a + t * d for a, d in zip(along, depths))
        position.append((plus - minus) / 2)
        needed.append((plus + minus) / (2 * t))
    return (x, y, z), x * position[0] + y * position[1] + z * (max(needed) or 1)


def place_camera(job, points):
    aspect = job["size"][0] / job["size"][1]
    (x, y, z), eye = frame(points, aspect)
    data = bpy.data.cameras.new("contact sheet")
    data.sensor_fit, data.sensor_height, data.lens = "VERTICAL", FILM_HEIGHT, FOCAL_LENGTH
    far = max((p - eye).length for p in points)
    data.clip_start, data.clip_end = far * 1e-4, far * 10
    item = bpy.data.objects.new("contact sheet", data)
    to_blender = mathutils.Matrix(((1, 0, 0), (0, 0, -1), (0, 1, 0)))
    columns = [to_blender @ v for v in (x, y, z, eye)]
    item.matrix_world = mathutils.Matrix([[c[i] for c in columns] for i in range(3)] + [[0, 0, 0, 1]])
    bpy.context.scene.collection.objects.link(item)
    bpy.context.scene.camera = item
    camera = {"lookAt": {"eye": list(eye), "target": list(eye - z * far)}, "focalLength": FOCAL_LENGTH,
              "horizontalAperture": FILM_HEIGHT * aspect, "verticalAperture": FILM_HEIGHT}
    pathlib.Path(job["output"]).with_suffix(".json").write_text(json.dumps(camera))


def make_dome(radiance):
    world = bpy.context.scene.world = bpy.data.worlds.new("dome")
    world.use_nodes = True
    background = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (1, 1, 1, 1), radiance


def main():
    job = json.loads(pathlib.Path(sys.argv[sys.argv.index("--") + 1]).read_text())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("io_scene_gltf2")
    bpy.ops.import_scene.gltf(filepath=job["model"])
    place_camera(job, world_points())
    make_dome(job["dome"])
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = job["size"]
    scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(pathlib.Path(job["output"]).with_suffix(".exr"))
    cycles = scene.cycles
    cycles.device, cycles.use_denoising, cycles.use_adaptive_sampling, cycles.samples = "CPU", False, False, job["samples"]
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 8
    bpy.ops.render.render(write_still=True)


main()
