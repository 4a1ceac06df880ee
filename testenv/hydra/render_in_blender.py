"""Renders scenes through Blender's HydraRenderEngine, and what the plug-in was given by the program. Runs with the module bpy.

Arguments: a JSON file with addon (folder of alabaster_hydra.py), program, scenes (names; none: all), width, height, samples,
cycles (true: compares the brightness with Cycles, too), out (folder). Prints a line "SCENE {json}" for each.
"""
import json
import os
import pathlib
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
job = json.loads(pathlib.Path(sys.argv[1]).read_text())
sys.path[:0] = [str(HERE.parent / "blender"), job["addon"]]

import bpy  # noqa: E402
import numpy  # noqa: E402

import alabaster_hydra  # noqa: E402
import scenes  # noqa: E402


def textured_board():
    """An image file as colour, looked up by a map of corners."""
    scenes.camera()
    scenes.floor()
    board = scenes.mesh("board", [(-1.5, 0, 0), (1.5, 0, 0), (1.5, 0.8, 2), (-1.5, 0.8, 2)], [(0, 1, 2, 3)])
    board.data.uv_layers.new(name="map").data.foreach_set("uv", [0, 0, 2, 0, 2, 1, 0, 1])
    image = scenes.picture("squares", 64, 64, lambda u, v: (0.9, 0.3, 0.1) if (u < 0.5) != (v < 0.3) else (0.1, 0.4, 0.8))
    image.filepath_raw, image.file_format = str(pathlib.Path(job["out"]) / "squares.png"), "PNG"
    image.save()
    material = scenes.principled("board", Roughness=0.5)
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.load(image.filepath_raw)
    material.node_tree.links.new(texture.outputs["Color"], material.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
    board.data.materials.append(material)
    scenes.lit()


SCENES = {**scenes.SCENES, "textured_board": textured_board}


def view(engine):
    scene = bpy.context.scene
    render = scene.render
    render.engine = engine
    render.resolution_x, render.resolution_y, render.resolution_percentage = job["width"], job["height"], 100
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.image_settings.color_mode = "RGBA"
    return scene


def picture(name, engine):
    """The pixels that Blender writes, and the seconds that they took."""
    file = pathlib.Path(job["out"]) / f"{name}.{engine.lower()}.exr"
    bpy.context.scene.render.filepath = str(file)
    begun = time.monotonic()
    bpy.ops.render.render(write_still=True)
    return load(file), time.monotonic() - begun


def load(file):
    image = bpy.data.images.load(str(file))
    pixels = numpy.empty(image.size[0] * image.size[1] * 4, numpy.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(-1, 4)


def by_hydra(name):
    scene = view("ALABASTER_HYDRA")
    scene.hydra.export_method = "HYDRA"
    written = pathlib.Path(job["out"]) / f"{name}.alab"
    scene["alabaster"] = {"samples": job["samples"], "filter": "box", "writeScene": str(written)}
    return (*picture(name, "ALABASTER_HYDRA"), written)


def by_cycles(name):
    scene = view("CYCLES")
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", job["samples"], False, False
    cycles.pixel_filter_type = "BOX"
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 8
    return picture(name, "CYCLES")[0]


def compare(name):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    SCENES[name]()
    hydra, seconds, written = by_hydra(name)
    told = {"name": name, "seconds": seconds, "mean": float(hydra[:, :3].mean())}
    # Now, because Blender deletes its copies of images with the next scene.
    done = subprocess.run([job["program"], "render", "--quiet", "--allow-outside", str(written)], capture_output=True, text=True)
    told["error"] = done.stderr.strip()[-300:] if done.returncode else ""
    if not told["error"]:
        program = load(written.with_suffix(".exr"))
        told["pixels_that_differ"] = int((hydra.view(numpy.uint32) != program.view(numpy.uint32)).any(axis=1).sum())
    if job["cycles"]:
        told["over_cycles"] = (hydra[:, :3].mean(axis=0) / by_cycles(name)[:, :3].mean(axis=0)).tolist()
    print("\nSCENE " + json.dumps(told), flush=True)


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    alabaster_hydra.register()
    try:
        for name in job["scenes"] or SCENES:
            compare(name)
    finally:
        alabaster_hydra.unregister()  # Blender 4 ends badly with an engine of Python's
    print("\nVERSION " + bpy.app.version_string, flush=True)
    sys.stdout.flush()
    os._exit(0)


main()
