"""Drives Blender's window as a user would: viewport, edits, camera, Escape. Runs inside Blender with a display.

Arguments: a JSON file with addon, module (folders), out (folder for screenshots), edits (their number), patience (seconds). Prints
"WINDOW {json}", and before it a line "AT seconds step pictures" whenever a step begins. Where Blender's main loop does not come round
for `patience` seconds, the process ends with Python's stacks.
"""
import collections
import faulthandler
import json
import pathlib
import subprocess
import sys
import time
import types

import bpy
import mathutils
import numpy

job = json.loads(pathlib.Path(sys.argv[sys.argv.index("--") + 1]).read_text())
sys.path[:0] = [job["addon"], job["module"]]
bpy.context.preferences.view.show_splash = False
import alabaster_render  # noqa: E402
from alabaster_render import engine, viewport  # noqa: E402

alabaster_render.register()
told = {}
Picture = collections.namedtuple("Picture", "time middle covered ms blank")  # middle: the mean colour there, where the cube is
started = time.monotonic()
drawn = []
spent = []  # seconds in calls of the add-on's viewport


def middle(pixels):
    if pixels is None:
        return numpy.zeros(3)
    height, width = pixels.shape[:2]
    return pixels[height // 2 - 12:height // 2 + 12, width // 2 - 12:width // 2 + 12, :3].mean(axis=(0, 1))


def watched(draw):
    def seen(self, context, depsgraph):
        begun = time.monotonic()
        draw(self, context, depsgraph)
        stats = self.renderer.stats()
        blank = self.pixels is None or not self.pixels[..., 3].any()
        drawn.append(Picture(time.monotonic(), middle(self.pixels), stats.get("covered", 0.0), 1e3 * (time.monotonic() - begun), blank))
    return seen


def timed(method):
    def call(*args):
        begun = time.monotonic()
        method(*args)
        spent.append(time.monotonic() - begun)
    return call


viewport.Viewport.draw = watched(timed(viewport.Viewport.draw))
viewport.Viewport.update = timed(viewport.Viewport.update)


def resident():
    """MB that the process holds."""
    lines = pathlib.Path("/proc/self/status").read_text().splitlines()
    return int(next(line for line in lines if line.startswith("VmRSS")).split()[1]) / 1024


def space():
    return next(a for a in bpy.context.window_manager.windows[0].screen.areas if a.type == "VIEW_3D").spaces[0]


def screenshot(name):
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, screen=window.screen, area=window.screen.areas[0]):
        bpy.ops.screen.screenshot(filepath=str(pathlib.Path(job["out"]) / f"{name}.png"))


def wait_for(name, since, done, timeout=60.0):
    """Yields until a picture is drawn for which done(picture); tells how many milliseconds after `since`."""
    while time.monotonic() - since < timeout:
        found = next((p for p in drawn if p.time >= since and done(p)), None)
        if found:
            told[name] = round(1e3 * (found.time - since))
            return
        yield 0.01
    told[name] = None


def at(step):
    print(f"AT {time.monotonic() - started:.1f} {step} {len(drawn)}", flush=True)


def rest(seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        yield 0.05


def set_colour(color):
    material = bpy.data.objects["Cube"].data.materials[0]
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*color, 1)


def viewport_story():
    bpy.context.scene.render.engine = "ALABASTER"
    bpy.context.scene.alabaster.viewport_samples = 1000
    at("viewport")
    begun = time.monotonic()
    space().shading.type = "RENDERED"
    yield from wait_for("first_picture_ms", begun, lambda p: p.covered >= 1 and not p.blank)
    yield from rest(4)
    screenshot("viewport")
    for name, edit in (("material", lambda: set_colour((0.9, 0.2, 0.05))),
                       ("transform", lambda: setattr(bpy.data.objects["Cube"].location, "x", -4))):
        at(name)
        before, begun = drawn[-1].middle, time.monotonic()
        edit()
        yield from wait_for(f"{name}_edit_ms", begun, lambda p, b=before: abs(p.middle - b).max() > 0.2 * b.max())
        yield from rest(3)
        screenshot(f"after_{name}")
    waits = []
    at("camera")
    for i in range(20):
        begun = time.monotonic()
        region = space().region_3d
        region.view_rotation = region.view_rotation @ mathutils.Quaternion((0, 1, 0), 0.06)
        yield from wait_for("camera", begun, lambda p: True)
        waits.append(told.pop("camera"))
        if i == 10:
            screenshot("during_a_camera_move")
    told["camera_move_ms"] = {"median": sorted(waits)[10], "largest": max(waits)}
    told["blank_pictures_in_camera_moves"] = sum(p.blank for p in drawn[-20:])
    yield from rest(2)
    screenshot("after_camera_moves")


def edit_story():
    yield from rest(0.5)
    before, begun, own = [resident()], time.monotonic(), sum(spent)
    for i in range(job["edits"]):
        if i % 50 == 0:
            at(f"edit {i}")
        if i % 2:
            set_colour((0.2 + 0.6 * (i % 10) / 10, 0.3, 0.5))
        else:
            bpy.data.objects["Cube"].location.x = 0.01 * (i % 50)
        yield 0.02
        if i == job["edits"] // 5:
            yield from rest(1)
            before.append(resident())
    seconds, own = time.monotonic() - begun, sum(spent) - own
    yield from rest(2)
    told["edits"] = {"number": job["edits"], "seconds": round(seconds), "of_these_in_the_add_on": round(own), "MB_at_first": round(before[0]), "MB_after_a_fifth": round(before[-1]),
                     "MB_at_last": round(resident())}


def escape_story():
    at("escape")
    ended, looked = [], []
    engine.time = types.SimpleNamespace(monotonic=lambda: (looked.append(time.monotonic()), looked[-1])[1])
    bpy.app.handlers.render_cancel.append(lambda *_: ended.append(time.monotonic()))
    bpy.app.handlers.render_complete.append(lambda *_: ended.append(time.monotonic()))
    space().shading.type = "SOLID"
    scene = bpy.context.scene
    scene.alabaster.samples, scene.render.resolution_percentage = 100000, 50
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, screen=window.screen):
        bpy.ops.render.render("INVOKE_DEFAULT")
    beats = [time.monotonic()]
    while len(looked) < 30 or len(beats) < 5:
        if beats[-1] - beats[0] > job["patience"]:
            raise TimeoutError(f"F12 has asked {len(looked)} times for Escape within {job['patience']} seconds")
        yield 0.01
        beats.append(time.monotonic())
    beats = sorted(b - a for a, b in zip(beats, beats[1:]))
    told["beat_of_the_window_ms"] = {"median": round(1e3 * beats[len(beats) // 2]), "largest": round(1e3 * beats[-1])}
    keys = subprocess.run(["xdotool", "getactivewindow"], capture_output=True, text=True)
    target = ["--window", keys.stdout.strip()] if keys.returncode == 0 else []
    begun = time.monotonic()
    subprocess.run(["xdotool", "key", *target, "Escape"])
    while not ended and time.monotonic() - begun < 20:
        yield 0.01
    # Until Blender tells the engine, and from then until its job is over.
    told["escape_ms"] = [round(1e3 * (looked[-1] - begun)), round(1e3 * (ended[0] - looked[-1]))] if ended else None


def disable_story():
    """The add-on is disabled while a frame is being rendered."""
    at("disable")
    yield from rest(1)
    begun = []
    render = engine.AlabasterRenderEngine.refine
    engine.AlabasterRenderEngine.refine = lambda *rest: (begun.append(True), render(*rest))
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, screen=window.screen):
        bpy.ops.render.render("INVOKE_DEFAULT")
    while not begun:
        yield 0.01
    start = time.monotonic()
    alabaster_render.unregister()
    told["disable_ms"] = round(1e3 * (time.monotonic() - start))
    yield from rest(2)


def stories():
    yield from viewport_story()
    yield from edit_story()
    draws = [p.ms for p in drawn]
    told["draw_ms"] = {"median": round(sorted(draws)[len(draws) // 2], 1), "largest": round(max(draws), 1)}
    window = bpy.context.window_manager.windows[0]
    told["version"] = bpy.app.version_string
    told["window"] = [window.width, window.height]
    yield from escape_story()
    yield from disable_story()


running = stories()


def step():
    faulthandler.dump_traceback_later(job["patience"], exit=True)
    try:
        return next(running)
    except StopIteration:
        print("\nWINDOW " + json.dumps(told), flush=True)
    except Exception as error:
        print(f"\nFAILED {type(error).__name__}: {error}", flush=True)
    bpy.ops.wm.quit_blender()
    return None


bpy.app.timers.register(step, first_interval=1.5)
