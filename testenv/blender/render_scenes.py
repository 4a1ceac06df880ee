"""Renders scenes of scenes.py with Alabaster and with Cycles. Runs inside Blender (blender -b -P) or with the module bpy.

Arguments: a JSON file with addon (folder that holds alabaster_render), module (folder that holds hdalabaster), scenes (names; none:
all), width, height, samples, out (folder). Prints a line "SCENE {json}" for each: mean colours, RMS differences of blocks of colour and of alpha.
"""
import json
import pathlib
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import bpy  # noqa: E402
import numpy  # noqa: E402

import role_scenes  # noqa: E402
import scenes  # noqa: E402

SCENES = {**scenes.SCENES, **role_scenes.SCENES}
BLOCK = 8  # pixels: the difference of means of blocks holds little noise


def set_up(job, engine):
    scene = bpy.context.scene
    view = scene.render
    view.engine = engine
    view.resolution_x, view.resolution_y, view.resolution_percentage = job["width"], job["height"], 100
    view.image_settings.file_format, view.image_settings.color_depth = "OPEN_EXR", "32"
    view.image_settings.color_mode = "RGBA"
    if engine == "ALABASTER":
        scene.alabaster.samples, scene.alabaster.filter = job["samples"], "box"
        return
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", job["samples"], False, False
    cycles.pixel_filter_type = "BOX"
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    depth = scene.alabaster.maxDepth
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = depth


def picture(job, name, engine):
    """The pixels (height, width, 4) and the seconds that they took."""
    set_up(job, engine)
    file = pathlib.Path(job["out"]) / f"{name}.{engine.lower()}.exr"
    bpy.context.scene.render.filepath = str(file)
    begun = time.monotonic()
    bpy.ops.render.render(write_still=True)
    seconds = time.monotonic() - begun
    image = bpy.data.images.load(str(file))
    pixels = numpy.empty(job["width"] * job["height"] * 4, numpy.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(job["height"], job["width"], 4), seconds


def blocks(pixels):
    height, width = (n // BLOCK * BLOCK for n in pixels.shape[:2])
    return pixels[:height, :width].reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, -1).mean(axis=(1, 3))


def empty():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def compare(job, name):
    empty()
    SCENES[name]()
    ours, our_seconds = picture(job, name, "ALABASTER")
    theirs, their_seconds = picture(job, name, "CYCLES")
    means = ours[..., :3].mean(axis=(0, 1)), theirs[..., :3].mean(axis=(0, 1))
    apart = blocks(ours) - blocks(theirs)
    color, alpha = (numpy.sqrt((one ** 2).mean()) for one in (apart[..., :3], apart[..., 3]))
    expected = scenes.DIFFERS.get(name, (2.0, ""))
    told = {"name": name, "ours": [float(x) for x in means[0]], "cycles": [float(x) for x in means[1]],
            "ratio": float(means[0].sum() / means[1].sum()), "channels": [float(a / b) for a, b in zip(*means)],
            "blocks": float(color / means[1].mean()), "alpha": float(alpha), "within": expected[0], "why": expected[1],
            "seconds": [our_seconds, their_seconds]}
    print("\nSCENE " + json.dumps(told), flush=True)


def main():
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    job = json.loads(pathlib.Path(arguments[0]).read_text())
    sys.path[:0] = [job["addon"], job["module"]]
    empty()
    import alabaster_render
    alabaster_render.register()
    for name in job["scenes"] or SCENES:
        compare(job, name)
    alabaster_render.unregister()  # Blender 4 ends badly with an engine of Python's
    print("\nVERSION " + bpy.app.version_string, flush=True)


if __name__ == "__main__":
    main()
