#!/usr/bin/env python3
"""Tests of the Python module, with the hdalabaster that is first in PYTHONPATH.

  alabaster_test.py PROGRAM [unittest's arguments]
"""
import array
import ast
import copy
import pathlib
import pickle
import signal
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import hdalabaster
from arguments_test import Arguments, Fields, KeptArrays  # noqa: F401, unittest runs them
from documentation_test import Documentation  # noqa: F401
from doors_test import Doors  # noqa: F401
from edits_test import Edits  # noqa: F401
from ends_test import Ends  # noqa: F401
from measuring_test import Medium  # noqa: F401
from memory_test import Memory  # noqa: F401
from square_scene import BACK, CORNERS, draw, moved, pixel, square
from threads_test import Threads  # noqa: F401

TOP = pathlib.Path(__file__).resolve().parents[3]
PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else None
SCENE = str(TOP / "testenv/scenes/thick_thin/thick_thin.json")


def hdalabaster_stub(name):
    """The names that a class of the stub types."""
    stub = ast.parse(pathlib.Path(hdalabaster.__file__).with_name("__init__.pyi").read_text())
    body = next(node.body for node in stub.body if isinstance(node, ast.ClassDef) and node.name == name)
    return [line.target.id for line in body if isinstance(line, ast.AnnAssign)]


class Renders(unittest.TestCase):
    def test_square(self):
        red, green, blue, alpha = pixel(draw(hdalabaster.Renderer(square(), samples=4)), 8, 8)
        self.assertEqual(alpha, 1)
        self.assertTrue(red > green > blue > 0)

    @unittest.skipUnless(PROGRAM, "no program to compare with")
    def test_pixels_are_those_of_the_program(self):
        scene = hdalabaster.Scene()
        loaded = scene.load(SCENE, overrides=["samples=4", "resolution=[48,32]"])
        render = hdalabaster.Renderer(scene).render(settings=loaded["settings"])
        pixels = render["color"]
        self.assertEqual((pixels.width, pixels.height), (48, 32))
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            shutil.copy(pathlib.Path(SCENE).with_suffix(".glb"), folder)
            text = pathlib.Path(SCENE).read_text().rstrip()[:-1]
            (folder / "scene.json").write_text(text + ', "products": [{"file": "%s/program.exr", "dataType": "float"}]}' % name)
            subprocess.run([PROGRAM, "render", folder / "scene.json", "--set", "samples=4", "--size", "48x32", "--quiet"], check=True)
            view = memoryview(pixels)
            rows = [array.array("f", [view[y, x, c] for x in range(48) for c in range(3)]) for y in range(32)]
            with open(folder / "python.pfm", "wb") as file:
                file.write(b"PF\n48 32\n-1.0\n" + b"".join(row.tobytes() for row in reversed(rows)))
            done = subprocess.run(["oiiotool", folder / "program.exr", "--ch", "R,G,B", folder / "python.pfm", "--fail", "0",
                                   "--warn", "0", "--diff"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout)

    # promise: pipeline.archive.scene_write
    def test_a_written_scene_has_the_same_pixels(self):
        scene = square()
        scene.set_instancer("/many", {"/square": [0, 1]}, translations=[(-0.3, 0, 0), (0.4, 0, 0.1)])
        scene.set_mesh("/square", CORNERS, [[0, 1, 2, 3]], material="/wax", instancer="/many")
        frame = {"camera": "/camera", "width": 24, "height": 16}
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "copy.alab"
            scene.write(file, overrides={"samples": 4}, **frame)
            copy = hdalabaster.Scene()
            loaded = copy.load(file)
            self.assertEqual(loaded["notes"], [])
            pixels = [bytes(hdalabaster.Renderer(s, **given).render(**how)["color"])
                      for s, given, how in [(scene, {"samples": 4}, frame), (copy, {}, {"settings": loaded["settings"]})]]
            self.assertEqual(pixels[0], pixels[1])
            with self.assertRaisesRegex(hdalabaster.OutputError, "copy.txt' must end in .alab"):
                scene.write(file.with_suffix(".txt"), **frame)
            with self.assertRaisesRegex(TypeError, "aovs"):
                scene.write(file, aovs=["depth"])
            with self.assertRaisesRegex(hdalabaster.OutputError, "/gone is no camera"):
                scene.write(file, camera="/gone")

    def test_edits(self):
        scene = square()
        renderer = hdalabaster.Renderer(scene, samples=4)
        render = draw(renderer)
        before = bytes(memoryview(render.pixels()))
        scene.set_transform("/square", moved(50))
        render.update()
        self.assertTrue(render.wait())
        self.assertEqual(pixel(render, 8, 8)[3], 0)
        scene.set_transform("/square", None)
        render.update()
        render.wait()
        self.assertEqual(bytes(memoryview(render.pixels())), before)
        scene.set_parameter("/wax", "surface.baseColor", (0.1, 0.8, 0.1))
        render.update()
        render.wait()
        self.assertGreater(pixel(render, 8, 8)[1], 2 * pixel(render, 8, 8)[0])
        scene.set_visible("/square", False)
        render.update()
        render.wait()
        self.assertEqual(pixel(render, 8, 8)[3], 0)

    def test_layers_and_windows(self):
        render = draw(hdalabaster.Renderer(square(), samples=4), aovs=["color", "cameraDepth", "primId"], window=(4, 4, 12, 10))
        self.assertEqual(memoryview(render["color"]).shape, (6, 8, 4))
        self.assertAlmostEqual(pixel(render, 4, 3, "cameraDepth"), 6, places=4)
        self.assertEqual(memoryview(render["primId"]).format, "i")
        with self.assertRaises(KeyError):
            render["normal"]

    def test_pick(self):
        scene = square()
        scene.set_mesh("/square", CORNERS, [[0, 1, 2, 3]], instancer="/many")
        scene.set_instancer("/many", {"/square": [0, 2]}, translations=[(-9, 0, 0), (5, 5, 0), (0, 0, 0)])
        render = draw(hdalabaster.Renderer(scene, samples=4), aovs=["color", "primId", "instanceId", "elementId"])
        self.assertEqual(render.pick((8, 8, 9, 9)),
                         [{"path": "/square", "face": 0, "instance_id": 1, "instances": [("/many", 2)], "x": 8, "y": 8}])
        self.assertEqual(render.pick((0, 0, 1, 1)), [], "the background")
        self.assertEqual(set(render.pick((0, 0, 16, 16))[0]), set(hdalabaster_stub("Hit")))
        render.update(aovs=["color"])
        with self.assertRaisesRegex(hdalabaster.ArgumentError, "primId"):
            render.pick((8, 8, 9, 9))
        with self.assertRaises(ValueError):
            render.pick((8, 8, 9))

    def test_an_unknown_path_gets_the_nearest(self):
        scene = square()
        for call in (lambda: scene.remove("/suare"), lambda: scene.edit("/suare", visible=False),
                     lambda: scene.set_transform("/suare", None), lambda: scene.bind_material("/suare", "/wax")):
            with self.assertRaisesRegex(hdalabaster.NotFoundError, "there is no prim /suare; did you mean '/square'"):
                call()

    def test_instances(self):
        scene = square()
        scene.set_mesh("/square", CORNERS, [[0, 1, 2, 3]], instancer="/many", transform=None)
        scene.set_instancer("/many", {"/square": [0, 1]}, translations=[(-9, 0, 0), (0, 0, 0)])
        render = draw(hdalabaster.Renderer(scene, samples=4), aovs=["instanceId"])
        self.assertEqual(pixel(render, 8, 8, "instanceId"), 1)
        scene.set_instance_values("/many", 0, translations=[(0, 0, 1)])
        render.update()
        render.wait()
        self.assertEqual(pixel(render, 8, 8, "instanceId"), 0)
        with self.assertRaises(ValueError):
            scene.set_instance_values("/many", 2, translations=[(0, 0, 1)])

    def test_refined_cage_with_primvars_and_creases(self):
        scene = square()
        scene.set_mesh("/square", CORNERS, [0, 1, 2, 3], counts=[4], scheme="catmullClark", refine_level=2, material="/wax",
                       subdiv_tags={"corner_indices": [0], "corner_weights": [2.0]},
                       primvars={"st": hdalabaster.Primvar([(0, 0), (1, 0), (1, 1), (0, 1)], "faceVarying", role="textureCoordinate")})
        scene.set_material("/wax", nodes={"surface": {"baseColor": ("colors", "rgb"), "roughness": 0.4},
                                          "colors": {"type": "AlabasterPrimvar"}})
        scene.set_primvar("/square", "displayColor", [(0.1, 0.1, 0.9)] * 4)
        red, _, blue, alpha = pixel(draw(hdalabaster.Renderer(scene, samples=4)), 8, 8)
        self.assertEqual(alpha, 1)
        self.assertGreater(blue, 2 * red)

    def test_a_free_camera_and_other_arguments_of_update(self):
        scene = square()
        scene.remove("/camera")
        render = hdalabaster.Renderer(scene, samples=4).render(width=16, height=16, camera={"transform": BACK, "focalLength": 1.0,
                                                             "horizontalAperture": 0.5, "verticalAperture": 0.5})
        self.assertEqual(pixel(render, 8, 8)[3], 1)
        render.update(camera={"transform": moved(50, 0, 6), "focalLength": 1.0})
        self.assertTrue(render.wait())
        self.assertEqual(pixel(render, 8, 8)[3], 0)
        render.update(camera={"transform": BACK, "focalLength": 1.0}, width=32, height=8, aovs=["color", "cameraDepth"])
        self.assertTrue(render.wait())
        self.assertEqual(memoryview(render["cameraDepth"]).shape, (8, 32))
        with self.assertRaisesRegex(TypeError, "heigth"):
            render.update(heigth=8)

    def test_selections(self):
        scene = square()
        scene.set_mesh("/a/guide", CORNERS, [[0, 1, 2, 3]], render_tag="guide")
        scene.remove("/square")
        render = draw(hdalabaster.Renderer(scene, samples=1))
        alphas = []
        for selection in [{}, {"render_tags": ["guide"]}, {"excluded": ["/a"]}, {"excluded": [], "roots": ["/b"]}]:
            render.update(**selection)
            render.wait()
            alphas.append(pixel(render, 8, 8)[3])
        self.assertEqual(alphas, [0, 1, 0, 0])
        with self.assertRaises(TypeError):
            render.update(render_tags="guide")

    def test_mattes_of_one_selection_after_another(self):
        scene = square()
        scene.remove("/square")
        for name, x in (("/a", -1.1), ("/b", 1.1)):
            scene.set_mesh(name, [(x + i, y, 0) for i, y, _ in CORNERS], [[0, 1, 2, 3]])
        renderer = hdalabaster.Renderer(scene, samples=4)
        for roots in (["/a"], ["/b"], []):
            render = draw(renderer, aovs=["color", "cryptoObject"], roots=roots)
            self.assertEqual(set(renderer.command("names")["cryptoObject"]), set(roots or ["/a", "/b"]))
            for x, name in ((3, "/a"), (12, "/b")):
                covered = pixel(render, x, 8, "cryptoObject")[1]
                self.assertEqual(covered, 1 if name in (roots or [name]) else 0, (roots, name))

    def test_motion(self):
        scene = square()
        far = [(0, moved(-20)), (1, moved(20))]
        shutter = {"shutterOpen": 0.0, "shutterClose": 1.0}
        scene.set_camera("/camera", BACK, focalLength=0.05, horizontalAperture=0.036, verticalAperture=0.036, **shutter)
        scene.set_mesh("/square", CORNERS, [[0, 1, 2, 3]], material="/wax", motion=far)
        moving = [pixel(draw(hdalabaster.Renderer(scene, samples=256)), 8, 8)[3]]
        points = [(time, [(x + by, y, z) for x, y, z in CORNERS]) for time, by in ((0, -20), (1, 20))]
        deforming = square()
        deforming.set_camera("/camera", BACK, focalLength=0.05, horizontalAperture=0.036, verticalAperture=0.036, **shutter)
        deforming.set_mesh("/square", hdalabaster.Primvar(CORNERS, motion=points), [[0, 1, 2, 3]], material="/wax")
        moving.append(pixel(draw(hdalabaster.Renderer(deforming, samples=256)), 8, 8)[3])
        still = square()
        still.set_camera("/camera", BACK, motion=[(time, matrix) for time, matrix in far], focalLength=0.05,
                         horizontalAperture=0.036, verticalAperture=0.036, **shutter)
        moving.append(pixel(draw(hdalabaster.Renderer(still, samples=256)), 8, 8)[3])
        for alpha in moving:
            self.assertAlmostEqual(alpha, 0.05, delta=0.02)  # 2 of 40 units

    def test_a_loaded_animation_is_sampled_over_the_shutter(self):
        def poses(**options):
            scene = hdalabaster.Scene()
            scene.load(str(TOP / "testenv/scenes/motion/motion.json"), time=0.5, **options)
            renderer = hdalabaster.Renderer(scene, samples=1)
            draw(renderer)
            return [line for line in renderer.command("dumpScene").splitlines() if line.startswith("  pose")]
        self.assertEqual(poses(shutter=(0, 0)), [])
        slow = poses(shutter=(-0.5, 0.5), frames_per_second=6)
        self.assertTrue(slow)
        self.assertNotEqual(slow, poses(shutter=(-0.5, 0.5)))
        self.assertEqual(poses(shutter=(-0.5, 0.5)), poses(shutter=[-0.5, 0.5], frames_per_second=24))
        with self.assertRaisesRegex(ValueError, "two times"):
            poses(shutter=(1,))
        with self.assertRaisesRegex(hdalabaster.ArgumentError, "frames_per_second"):
            poses(frames_per_second=-1)

    # promise: pipeline.aov.motion_load
    def test_a_loaded_animation_has_its_next_frame(self):
        def fastest(**options):
            scene = hdalabaster.Scene()
            scene.load(str(TOP / "testenv/scenes/motion/motion.json"), time=0, shutter=(0, 0), **options)
            pixels = hdalabaster.Renderer(scene, samples=1).render(aovs=["motion"], width=16, height=16)["motion"]
            return max(abs(number) for row in memoryview(pixels).tolist() for pixel in row for number in pixel)
        self.assertEqual(fastest(), 0)
        self.assertGreater(fastest(next_frame=True), 0.1)

    def test_primvars_of_text_and_products_of_textures(self):
        scene = square()
        scene.set_mesh("/square", CORNERS, [0, 1, 2, 3], counts=[4], material="/wax", primvars={
            "subsurfaceSet": hdalabaster.Primvar("skin", "constant"), "displayColor": [(0.5, 0.5, 0.5)] * 4})
        scene.set_material("/wax", nodes={"surface": {"baseColor": [("colors", "rgb"), ("again", "rgb")], "scatterDistance": (1, 1, 1)},
                                          "colors": {"type": "AlabasterPrimvar"}, "again": {"type": "AlabasterPrimvar"}})
        heard = []
        renderer = hdalabaster.Renderer(scene, report=lambda *message: heard.append(message), samples=1)
        render = draw(renderer, aovs=["color", "albedo"])
        self.assertAlmostEqual(pixel(render, 8, 8, "albedo")[0], 0.25, delta=0.05)
        self.assertIn("subsurfaceSet named skin", renderer.command("dumpScene"))

    def test_flags_of_a_mesh(self):
        scene = square()
        renderer = hdalabaster.Renderer(scene, samples=1)
        ids = pixel(draw(renderer, aovs=["color", "primId"]), 8, 8, "primId")
        scene.set_primvar("/square", "holdout", True, "constant")
        render = draw(renderer, aovs=["color", "primId"])
        self.assertEqual((pixel(render, 8, 8), pixel(render, 8, 8, "primId")), ([0, 0, 0, 0], ids))
        scene.set_primvar("/square", "holdout", hdalabaster.Primvar(False, "constant"))
        self.assertEqual(pixel(draw(renderer), 8, 8)[3], 1)
        scene.set_primvar("/square", "visibleToCamera", False, "constant")
        self.assertEqual(pixel(draw(renderer, aovs=["color", "primId"]), 8, 8, "primId"), -1)

    # promise: artists.shadow_catcher, pipeline.aov.shadow
    def test_a_plate_under_a_shadow_catcher_is_the_picture(self):
        scene = square()
        scene.set_material("/wax", baseColor=(0.5, 0.5, 0.5), roughness=0, specular=0, ior=1)
        scene.set_material("/black", baseColor=(0, 0, 0), specular=0, ior=1)
        scene.set_light("/dome", "domeLight", color=(0.1, 0.2, 0.4))
        scene.set_light("/lamp", "rectLight", moved(0.6, 0.3, 2), color=(40, 30, 5), width=0.5, height=0.5)
        renderer = hdalabaster.Renderer(scene, samples=256, filter="box", maxDepth=1)
        plate = draw(renderer)
        scene.set_mesh("/card", [(0.4 * x, 0.4 * y, 0.5) for x, y, _ in CORNERS], [[0, 1, 2, 3]], material="/black")
        picture = draw(renderer)
        scene.set_primvar("/square", "shadowCatcher", True, "constant")
        caught = draw(renderer, aovs=["color", "shadow", "cryptoObject"])
        seen = [(x, y) for x in range(16) for y in range(16) if pixel(picture, x, y)[3] == 1]
        for x, y in seen:
            shadow, alpha, wanted = pixel(caught, x, y, "shadow"), pixel(caught, x, y)[3], pixel(picture, x, y)
            card = pixel(caught, x, y, "cryptoObject")[1]
            for c in range(3):
                self.assertAlmostEqual(pixel(plate, x, y)[c] * (1 - card - shadow[c]), wanted[c], delta=0.03, msg=(x, y, c))
            self.assertAlmostEqual(alpha, card + sum(shadow) / 3, delta=0.3 if 0 < card < 1 else 0.12)
        deep = max(pixel(caught, x, y, "shadow")[0] for x, y in seen)
        self.assertGreater(deep, 0.5)
        self.assertEqual(pixel(caught, 0, 0, "cryptoObject")[:2], [0, 0])

    def test_a_scene_without_a_catcher_is_told(self):
        scene, heard = square(), []
        renderer = hdalabaster.Renderer(scene, report=lambda *told: heard.append(told), samples=1)
        render = draw(renderer)
        scene.set_primvar("/square", "shadowCatcher", True, "constant")
        render.update(aovs=["color", "shadow"])  # the scene before has none
        render.wait()
        self.assertEqual(heard, [])
        scene.set_primvar("/square", "shadowCatcher", False, "constant")
        render.update()
        render.wait()
        self.assertEqual([told[1] for told in heard], ["pass.shadow"])

    def test_records_files(self):
        scene = square()
        scene.set_render_settings("/settings", camera="/camera", width=16, height=16, samples=2)
        renderer = hdalabaster.Renderer(scene)
        seen = []
        with tempfile.TemporaryDirectory() as name:
            file = pathlib.Path(name) / "a.exr"
            self.assertEqual(renderer.record(file, aovs=["normal"], progress=lambda p: seen.append(p["fraction"])), [str(file)])
            self.assertGreater(file.stat().st_size, 500)
            with self.assertRaisesRegex(hdalabaster.OutputError, "nowhere"):
                renderer.record("/nowhere/a.exr")
            scene.set_render_settings("/wide", camera="/camera", width=65501, height=1, samples=1)
            with self.assertRaisesRegex(hdalabaster.OutputError, "65500 x 65500"):
                renderer.record(pathlib.Path(name) / "a.jpg", settings="/wide")
            renderer.set(samples=1 << 20)
            with self.assertRaises(hdalabaster.Cancelled):
                renderer.record(file, progress=lambda p: False)
            with self.assertRaises(ZeroDivisionError):
                renderer.record(file, progress=lambda p: 1 / 0)
        self.assertEqual(seen[-1], 1)


class Control(unittest.TestCase):
    def test_progress_and_cancel(self):
        renderer = hdalabaster.Renderer(square(), samples=1 << 20)
        seen = []

        def progress(now):
            seen.append(now["samples_total"])
            return len(seen) < 2

        with self.assertRaises(hdalabaster.Cancelled):
            draw(renderer, progress=progress)
        self.assertEqual(seen, [1 << 20] * 2)
        renderer.set(samples=1)
        self.assertEqual(draw(renderer).state, "converged")

    def test_wait_lets_other_threads_run(self):
        renderer = hdalabaster.Renderer(square(), samples=1 << 20)
        render = renderer.start(width=16, height=16, camera="/camera")
        counted = [0]

        def count():
            end = time.monotonic() + 0.3
            while time.monotonic() < end:
                counted[0] += 1
                time.sleep(0.001)
            render.cancel()

        thread = threading.Thread(target=count)
        thread.start()
        self.assertTrue(render.wait())
        thread.join()
        self.assertGreater(counted[0], 20)
        self.assertEqual(render.state, "stopped")

    def test_calls_from_two_threads_during_a_recording(self):
        scene = square()
        scene.set_render_settings("/settings", camera="/camera", width=16, height=16, samples=1 << 20)
        renderer = hdalabaster.Renderer(scene)
        started = threading.Event()
        end = time.monotonic() + 1

        def progress(_):
            started.set()
            return time.monotonic() < end

        def others():
            started.wait()
            renderer.get("samples")  # waits for the recording, without Python's lock
            del scene.prims["/square"]

        thread = threading.Thread(target=others)
        thread.start()
        with tempfile.TemporaryDirectory() as name, self.assertRaises(hdalabaster.Cancelled):
            renderer.record(name + "/a.exr", progress=progress)
        thread.join()

    def test_ctrl_c_and_an_exit_in_the_middle_of_a_render(self):
        start = ("import alabaster_test\n"
                 "r = alabaster_test.hdalabaster.Renderer(alabaster_test.square(), samples=1 << 20)\n"
                 "held = r.start(width=64, height=64, camera='/camera')\n"
                 "print('started', flush=True)\n")
        for code, signal_sent, expected in [("try:\n  held.wait()\nexcept KeyboardInterrupt:\n  print(held.state)\n", signal.SIGINT, "stopped\n"),
                                            ("held.wait(.1)\nkept = held.pixels()\n", None, "")]:
            program = subprocess.Popen([sys.executable, "-c", start + code], stdout=subprocess.PIPE, text=True,
                                       cwd=pathlib.Path(__file__).parent)
            self.assertEqual(program.stdout.readline(), "started\n")
            if signal_sent:
                time.sleep(0.2)
                program.send_signal(signal_sent)
            self.assertEqual((program.communicate(timeout=60)[0], program.returncode), (expected, 0))

    def test_ctrl_c_in_a_callback_cancels(self):
        def interrupt(*_):
            raise KeyboardInterrupt
        renderer = hdalabaster.Renderer(square(), samples=1 << 20)
        held = renderer.start(width=64, height=64, camera="/camera")
        self.assertRaises(KeyboardInterrupt, held.wait, progress=interrupt)
        self.assertEqual(held.state, "stopped")

    def test_ctrl_c_in_a_listener_cancels(self):
        """None of the listener's later errors hides it."""
        raised = [ValueError, ValueError, KeyboardInterrupt]

        def listen(*_):
            if raised:
                raise raised.pop()
        scene = square()
        inputs = ["roughness", "metallic", "sheen", "specular"]
        scene.set_material("/wax", nodes={"surface": {name: (name, "r") for name in inputs}, **{name: {
            "type": "AlabasterTexture", "file": f"/nowhere/{name}.png"} for name in inputs}})
        renderer = hdalabaster.Renderer(scene, samples=1 << 20, report=listen)
        held = None
        with self.assertRaises(KeyboardInterrupt):
            held = renderer.start(width=64, height=64, camera="/camera")  # the images may be missed before it returns
            while True:
                held.wait()
        raised.clear()
        if held:
            self.assertEqual(held.state, "stopped")

    def test_a_cancelled_renderer_records(self):
        scene = square()
        scene.set_render_settings("/settings", camera="/camera", width=16, height=16)
        for cancel in [lambda r: draw(r, progress=lambda now: False), lambda r: r.stop(), lambda r: r.start(camera="/camera").cancel()]:
            renderer = hdalabaster.Renderer(scene, samples=1 << 20)
            try:
                cancel(renderer)
            except hdalabaster.Cancelled:
                pass
            renderer.set(samples=1)
            with tempfile.TemporaryDirectory() as name:
                self.assertEqual(renderer.record(name + "/a.exr"), [name + "/a.exr"])
            del renderer

    def test_a_render_that_is_only_polled(self):
        scene = square()
        render = hdalabaster.Renderer(scene, samples=4).start(width=16, height=16, camera="/camera")
        memory = memoryview(bytearray(16 * 16 * 16)).cast("f", (16, 16, 4))
        polls = {"show": lambda: render.show("color", memory) and memory[8, 8, 3], "pixels": lambda: pixel(render, 8, 8)[3],
                 "state": lambda: float(render.state == "converged")}
        for name, poll in polls.items():
            end = time.monotonic() + 30
            while poll() != 1:
                self.assertLess(time.monotonic(), end, name)
                time.sleep(0.01)
            scene.set_transform("/square", moved(50))
            render.update()
            while render.show("color", memory) and memory[8, 8, 3] != 0:
                self.assertLess(time.monotonic(), end, name)
            scene.set_transform("/square", None)
            render.update()

    def test_pause(self):
        renderer = hdalabaster.Renderer(square(), samples=1 << 20)
        render = renderer.start(width=16, height=16, camera="/camera")
        renderer.pause()
        self.assertFalse(render.wait(0.05))
        self.assertEqual(render.state, "paused")
        renderer.resume()
        renderer.stop()
        self.assertEqual(render.state, "stopped")

    def test_waiting_no_time_takes_an_edit_up(self):
        scene = square()
        render = draw(hdalabaster.Renderer(scene, samples=1))
        scene.set_transform("/square", moved(50))
        render.update()
        end = time.monotonic() + 30
        while not (render.wait(0) and pixel(render, 8, 8)[3] == 0):
            self.assertLess(time.monotonic(), end)

    def test_settings(self):
        renderer = hdalabaster.Renderer(samples=7)
        self.assertEqual(renderer.get("samples"), 7)
        renderer.set(samples=9, subsurface="lambert")
        self.assertEqual((renderer.get("samples"), renderer.get("subsurface")), (9, "lambert"))
        with self.assertRaisesRegex(hdalabaster.ArgumentError, "there is no setting 'sampels'; did you mean 'samples'"):
            renderer.get("sampels")
        described = renderer.describe_settings()
        self.assertIn("lambert", described["subsurface"]["choices"])
        self.assertTrue(described["samples"]["documentation"])
        self.assertEqual(renderer.progress()["fraction"], 0)
        self.assertIn("state", renderer.stats())
        scene = square()
        renderer.show(scene)
        draw(renderer)
        self.assertIn("/wax", renderer.command("dumpScene"))

    def test_statistics_tell_the_end_and_outlive_the_render(self):
        scene = square()
        renderer = hdalabaster.Renderer(scene, samples=4)
        render = draw(renderer)
        at_end = renderer.stats()
        self.assertEqual(at_end["state"], "converged")
        self.assertEqual(at_end["fractionDone"], 1)
        self.assertIn("error.relativeRmse", at_end)
        del render
        after = renderer.stats()
        self.assertEqual(after["state"], "converged")
        for name in ("error.relativeRmse", "error.low", "walk.count", "rays.camera", "numCompletedSamples", "cpuSeconds"):
            self.assertEqual(after[name], at_end[name], name)
        again = renderer.start(width=16, height=16, camera="/camera")
        again.wait()
        self.assertEqual(renderer.stats()["state"], "converged")


class Pickling(unittest.TestCase):
    def test_objects_are_neither_pickled_nor_made_from_their_base(self):
        renderer = hdalabaster.Renderer(square(), samples=1)
        render = draw(renderer)
        for made in [square(), renderer, render, render["color"], hdalabaster.Primvar([1.0])]:
            for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
                with self.assertRaises(TypeError):
                    pickle.dumps(made, protocol)
            with self.assertRaises(TypeError):
                copy.deepcopy(made)
            with self.assertRaises(TypeError):
                type(made).__base__()


class TargetError(unittest.TestCase):
    def test_a_miss_is_told(self):
        renderer = hdalabaster.Renderer(square(), samples=16, targetError=1e-5)
        render = draw(renderer)
        stats = renderer.stats()
        self.assertEqual(stats["endedBy"], "samples")
        self.assertTrue(stats["target.missed"])
        self.assertGreater(stats["target.samples"], 1000)
        self.assertGreater(stats["target.seconds"], 0)
        del render


class Errors(unittest.TestCase):
    # promise: embedding.errors
    def test_messages_are_the_library_s(self):
        with self.assertRaisesRegex(hdalabaster.SceneError, "missing.json.*no such file"):
            hdalabaster.Scene().load("missing.json")
        with self.assertRaisesRegex(hdalabaster.NotFoundError, "/missing"):
            hdalabaster.Scene().remove("/missing")
        with self.assertRaisesRegex(hdalabaster.SceneError, "nothing.ocio"):
            hdalabaster.Renderer(ocio="/nothing.ocio")
        with self.assertRaisesRegex(hdalabaster.Error, "camera"):
            hdalabaster.Renderer(square()).render(width=8, height=8, camera="/missing")
        self.assertTrue(issubclass(hdalabaster.SceneError, hdalabaster.Error))

    def test_messages_of_load_name_its_arguments(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "a.json"
            file.write_text("{}")
            for argument, value in {"camera": "nope", "dome": "nope.hdr", "shutter": (1, 0), "time": float("nan")}.items():
                with self.assertRaisesRegex(hdalabaster.SceneError, f"^{argument}") as caught:
                    hdalabaster.Scene().load(file, **{argument: value})
                self.assertNotIn("--", str(caught.exception))
            model = TOP / "testenv/scenes/hard_light/hard_light.glb"
            notes = "".join(hdalabaster.Scene().load(model, overrides=["studio=on"])["notes"])
            self.assertIn("studio=on", notes)
            self.assertNotIn("--", notes)
            for override, nearest in {"settings.samples=4": "'samples'", "Camera.fStop=1": "'camera.fStop'",
                                      "lights.key.intensity=2": "'lights/key.intensity'", "renderer.x=1": "cannot be set"}.items():
                with self.assertRaisesRegex(hdalabaster.SceneError, nearest):
                    hdalabaster.Scene().load(file, overrides=[override])

    def test_arguments(self):
        scene = square()
        for wrong in [lambda: scene.set_mesh("/a", [(1, 2)], [0, 1, 2]),
                      lambda: scene.set_mesh("/a", CORNERS, [0, 1, 2], transform=[1, 2]),
                      lambda: scene.set_primvar("/square", "st", [[[1]]]),
                      lambda: scene.set_primvar("/square", "st", [(0, 0)] * 4, "everywhere"),
                      lambda: hdalabaster.Renderer(square()).render(width=-1, height=8, aovs=["nothing"])]:
            with self.assertRaises((ValueError, LookupError)):
                wrong()
        with self.assertRaisesRegex(hdalabaster.ArgumentError, "no field 'sise'"):
            scene.set_mesh("/a", CORNERS, [0, 1, 2], sise=3)
        with self.assertRaisesRegex(hdalabaster.ArgumentError, "another delegate"):
            first, second = hdalabaster.Renderer(scene), hdalabaster.Renderer(scene)
            self.fail((first, second))

    def test_reports(self):
        heard = []
        scene = square()
        scene.remove("/wax")
        draw(hdalabaster.Renderer(scene, report=lambda *message: heard.append(message), samples=1))
        self.assertEqual([message[:3] for message in heard], [("warning", "mesh.material", "/square")])
        with self.assertLogs("hdalabaster", "WARNING") as logged:
            scene = square()
            scene.remove("/wax")
            draw(hdalabaster.Renderer(scene, samples=1))
        self.assertIn("/square", logged.output[0])


if __name__ == "__main__":
    unittest.main()
