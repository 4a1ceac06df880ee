"""White furnaces in which bodies meet, rendered by Cycles, another path tracer. The matrix asks for 1 there.

  blender --background --factory-startup --python in_cycles.py -- FOLDER [--size 128] [--samples 256]
  blender --background --factory-startup --python in_cycles.py -- FOLDER --measure NAME.exr ...

Writes FOLDER/cut.exr, hole.exr and drop.exr (linear, sky of 1, white subsurface, no specular) and prints for each the mean, the least and
the largest mean of blocks of 8 x 8 pixels within the ball. FOLDER/NAME.glb and NAME.json are the same scenes for `alabaster render NAME.json --size 128x128 --spp 256`, whose
pictures in FOLDER --measure measures alike.
"""
import argparse
import json
import math
import pathlib
import sys

import bpy
import numpy as np

EYE, FOCAL, SENSOR = 5.0, 50.0, 36.0
# name: balls (centre, radius, kind), near plane, opacity
SCENES = {
    "cut": ([((0, 0, 0), 1.0, "wax_0.3"), ((0.7, 0.3, 0.2), 0.8, "wax_0.1")], 4.9, 1.0),
    "hole": ([((0, 0, 0), 1.0, "wax_0.2")], 0.1, 0.5),
    "drop": ([((0, 0, 0), 1.0, "wax_0.4"), ((0, 0, 0.9), 0.5, "glass")], 0.1, 1.0),
}


def principled(name, opacity):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    node = material.node_tree.nodes["Principled BSDF"]
    node.inputs["Base Color"].default_value = (1, 1, 1, 1)
    if name == "glass":
        node.inputs["Transmission"].default_value, node.inputs["Roughness"].default_value = 1.0, 0.0
        node.inputs["IOR"].default_value = 1.5
        return material
    distance = float(name.split("_")[1])
    node.inputs["Specular"].default_value, node.inputs["Subsurface"].default_value = 0.0, 1.0
    node.inputs["Subsurface Color"].default_value = (1, 1, 1, 1)
    node.inputs["Subsurface Radius"].default_value = (distance,) * 3
    node.subsurface_method = "RANDOM_WALK_FIXED_RADIUS"
    node.inputs["Alpha"].default_value = opacity
    return material


def build(balls, near, opacity):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    for i, (centre, radius, kind) in enumerate(balls):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=6, radius=radius, location=centre)
        ball = bpy.context.object
        bpy.ops.object.shade_smooth()
        ball.name = f"ball{i}"
        ball.data.materials.append(principled(kind, opacity))
    world = scene.world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    camera = bpy.data.cameras.new("eye")
    camera.lens, camera.sensor_width, camera.clip_start = FOCAL, SENSOR, near
    scene.camera = bpy.data.objects.new("eye", camera)
    scene.camera.location = (0, 0, EYE)
    scene.collection.objects.link(scene.camera)
    return scene


def settings(scene, size, samples, file):
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", samples, False, False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 256
    cycles.transparent_max_bounces = 256
    cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.film_transparent = True
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(file)


def blocks_of_ball(file):
    image = bpy.data.images.load(str(file))
    image.colorspace_settings.name = "Raw"
    size = image.size[0]
    pixels = np.array(image.pixels[:], dtype=float).reshape(size, size, 4)
    half = FOCAL / SENSOR * size / math.sqrt(EYE ** 2 - 1)  # of the ball of radius 1, in pixels
    means = []
    for y in range(0, size - 7, 8):
        for x in range(0, size - 7, 8):
            far = max(math.hypot(a - size / 2, b - size / 2) for a in (x, x + 8) for b in (y, y + 8))
            if far < 0.95 * half:
                means.append(pixels[y:y + 8, x:x + 8].mean(axis=(0, 1)))
    return np.array(means)


def measure(file):
    means = blocks_of_ball(file)
    grey = means[:, :3].mean(axis=1)
    print(f"{file.stem}: alpha {means[:, 3].mean():.4f}, colour {grey.mean():.4f}, blocks {grey.min():.4f} to {grey.max():.4f}")


def description(scene, balls, near, opacity):
    materials = []
    for _, _, kind in balls:
        look = {"baseColor": [1, 1, 1], "specTrans": 1, "roughness": 0, "ior": 1.5} if kind == "glass" else {
            "baseColor": [1, 1, 1], "specular": 0, "scatterDistance": [float(kind.split("_")[1])] * 3, "opacity": opacity}
        materials.append({"match": kind, "replace": look})
    return {"materials": materials, "lights": [{"name": "sky", "type": "domeLight", "intensity": 1}],
            "camera": {"lookAt": {"eye": [0, 0, EYE], "target": [0, 0, 0]}, "focalLength": FOCAL, "horizontalAperture": SENSOR,
                       "verticalAperture": SENSOR, "clippingRange": [near, 100]},
            "settings": {"studio": "off", "maxDepth": 256}, "models": [{"file": f"{scene}.glb"}],
            **({"meshes": [{"match": "*", "subsurfaceSet": "x"}]} if scene == "cut" else {})}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--measure", nargs="+", default=[])
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    for name in options.measure:
        measure(options.folder / name)
    if options.measure:
        return
    options.folder.mkdir(parents=True, exist_ok=True)
    for name, (balls, near, opacity) in SCENES.items():
        scene = build(balls, near, opacity)
        file = options.folder / f"{name}.exr"
        settings(scene, options.size, options.samples, file)
        bpy.ops.export_scene.gltf(filepath=str(options.folder / f"{name}.glb"), export_format="GLB", export_yup=False)
        (options.folder / f"{name}.json").write_text(json.dumps(description(name, balls, near, opacity), indent=1))
        bpy.ops.render.render(write_still=True)
        measure(file)


main()
