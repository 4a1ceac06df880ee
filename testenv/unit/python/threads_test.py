"""Tests of the Python module's objects in several threads; alabaster_test.py runs them."""
import array
import faulthandler
import itertools
import os
import random
import tempfile
import threading
import time
import unittest

import hdalabaster
from square_scene import BACK, CORNERS, draw, moved, square

AOVS = ["color", "cameraDepth", "primId", "normal", "albedo", "primvars:" + "a" * 32, "primvars:" + "b" * 28]
SECONDS_PER_PAIR = 0.006
ALLOWED = (hdalabaster.Error, KeyError, ValueError)


def in_threads(calls, seconds):
    """Loops each call in a thread. Returns the errors that are not in ALLOWED."""
    end, unexpected = time.monotonic() + seconds, []

    def loop(call):
        while time.monotonic() < end and not unexpected:
            try:
                call()
            except ALLOWED:
                pass
            except BaseException as error:  # noqa: B902
                unexpected.append(error)

    threads = [threading.Thread(target=loop, args=(call,)) for call in calls]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return unexpected


class Objects:
    """One of each class, and every method of theirs as a call without arguments."""

    def __init__(self, folder):
        self.random = random.Random(1)
        self.scene = square(report=lambda *_: None)
        self.scene.set_instancer("/many", {"/part": [0, 1]}, translations=[(0, 0, 0), (1, 0, 0)])
        self.scene.set_mesh("/part", CORNERS, [[0, 1, 2, 3]], instancer="/many")
        self.scene.set_render_settings("/settings", camera="/camera", width=8, height=8, samples=1)
        self.file = folder + "/scene.alab"
        self.scene.write(self.file)
        self.other = square()
        self.renderer = hdalabaster.Renderer(self.scene, samples=2, report=lambda *_: None)
        self.render = self.renderer.render(width=8, height=8, aovs=["color", "cameraDepth"])
        self.display = hdalabaster.Display()
        self.pixels = self.render.pixels()
        self.points = array.array("f", [c for corner in CORNERS for c in corner])
        self.into = array.array("f", bytes(8 * 8 * 16))
        self.memory = memoryview(self.into).cast("B").cast("f", (8, 8, 4))
        self.bytes = memoryview(bytearray(8 * 8 * 4)).cast("B", (8, 8, 4))
        self.image = folder + "/image.exr"

    def some_aovs(self):
        return self.random.sample(AOVS, self.random.randrange(1, 5))

    def calls(self):
        scene, renderer, render = self.scene, self.renderer, self.render
        return {
            "load": lambda: scene.load(self.file)["notes"],
            "write": lambda: scene.write(self.file),
            "prims": lambda: scene.prims,
            "remove": lambda: scene.remove("/gone"),
            "set prim": lambda: scene.set("/lamp", "sphereLight", radius=self.random.random()),
            "edit": lambda: scene.edit("/dome", intensity=self.random.random()),
            "set_mesh": lambda: scene.set_mesh("/square", self.points, [[0, 1, 2, 3]], material="/wax"),
            "set_primvar": lambda: scene.set_primvar("/square", "x", self.points, "constant"),
            "set_transform": lambda: scene.set_transform("/square", moved(self.random.random())),
            "set_visible": lambda: scene.set_visible("/square", True),
            "bind_material": lambda: scene.bind_material("/square", "/wax"),
            "set_instancer": lambda: scene.set_instancer("/many", {"/part": [0, 1]}, translations=[(0, 0, 0), (1, 0, 0)]),
            "set_instance_values": lambda: scene.set_instance_values("/many", 1, translations=[(2, 0, 0)]),
            "set_material": lambda: scene.set_material("/wax", baseColor=(0.5, 0.5, self.random.random())),
            "set_light": lambda: scene.set_light("/dome", "domeLight", intensity=self.random.random()),
            "set_camera": lambda: scene.set_camera("/camera", BACK, focalLength=0.05),
            "set_render_settings": lambda: scene.set_render_settings("/settings", camera="/camera", width=8, height=8, samples=1),
            "set_parameter": lambda: scene.set_parameter("/wax", "surface.baseColor", (0.1, 0.2, 0.3)),
            "show scene": lambda: renderer.show(scene),
            "show other": lambda: renderer.show(self.other),
            "set": lambda: renderer.set(samples=self.random.randrange(1, 4)),
            "get": lambda: renderer.get("samples"),
            "describe": lambda: renderer.describe_settings(),
            "stats": lambda: renderer.stats(),
            "progress": lambda: renderer.progress(),
            "command": lambda: renderer.command("dumpScene"),
            "start": lambda: renderer.start(width=8, height=8, aovs=self.some_aovs()),
            "render": lambda: renderer.render(width=8, height=8, progress=lambda _: True),
            "record": lambda: renderer.record(self.image, progress=lambda _: renderer.get("samples")),
            "stop": lambda: renderer.stop(),
            "restart": lambda: renderer.restart(),
            "pause and resume": lambda: (renderer.pause(), renderer.resume()),
            "update": lambda: render.update(width=self.random.choice([4, 8]), height=8, aovs=self.some_aovs()),
            "wait": lambda: render.wait(0.001),
            "state": lambda: render.state,
            "cancel": lambda: render.cancel(),
            "pixels": lambda: memoryview(render.pixels("color")).tobytes(),
            "read": lambda: render.read("color", self.into),
            "show": lambda: render.show("color", self.memory),
            "show displayed": lambda: render.show("color", self.bytes, self.display),
            "pick": lambda: render.pick((0, 0, 4, 4)),
            "exposure": lambda: setattr(self.display, "exposure", self.random.random()),
            "look": lambda: memoryview(self.pixels).tobytes(),
            "new display": lambda: hdalabaster.Display(exposure=1.0),
        }


class Threads(unittest.TestCase):
    def setUp(self):
        faulthandler.dump_traceback_later(300, exit=True)
        self.addCleanup(faulthandler.cancel_dump_traceback_later)

    def test_two_threads_update_one_render(self):
        for aovs in [lambda r: ["color"], lambda r: r.sample(AOVS, r.randrange(1, 7))]:
            renderer = hdalabaster.Renderer(square(), samples=2, report=lambda *_: None)
            render = renderer.start(width=4, height=4, camera="/camera")
            chance = random.Random(2)
            self.assertEqual(in_threads([lambda: render.update(aovs=aovs(chance), width=4, height=4)] * 2, 2), [])
            render.update(width=16, height=16, aovs=["color"])
            self.assertTrue(render.wait())
            self.assertEqual(memoryview(render.pixels()).shape, (16, 16, 4))

    # promise: embedding.threads.python
    def test_every_pair_of_methods(self):
        with tempfile.TemporaryDirectory() as folder:
            calls = Objects(folder).calls()
            documented = {name for kind in [hdalabaster.Scene, hdalabaster.Renderer, hdalabaster.Render] for name in vars(kind)
                          if not name.startswith("_")}
            missing = documented - {word for name in calls for word in name.split()} - {"describe_settings", "clear"}
            self.assertEqual(missing, set())
            for (one, first), (two, second) in itertools.combinations_with_replacement(calls.items(), 2):
                self.assertEqual(in_threads([first, second], SECONDS_PER_PAIR), [], f"{one} and {two}")

    def test_all_methods_from_many_threads(self):
        with tempfile.TemporaryDirectory() as folder:
            objects = Objects(folder)
            calls = list(objects.calls().values())
            self.assertEqual(in_threads([lambda: random.choice(calls)()] * 6, 4), [])
            objects.renderer.show(objects.scene)
            objects.scene.set_camera("/camera", BACK, focalLength=0.05, horizontalAperture=0.036, verticalAperture=0.036)
            self.assertEqual(draw(objects.renderer).state, "converged")

    def test_callbacks_of_two_recordings_use_the_renderer(self):
        """Each holds the renderer while its callback waits for Python's lock, and the other one's thread for the renderer."""
        with tempfile.TemporaryDirectory() as folder:
            objects = Objects(folder)
            calls = objects.calls()
            safe = [calls[name] for name in ["get", "stats", "state", "show", "pixels", "prims", "set_light", "set", "wait"]]

            def progress(_):
                for call in safe:
                    call()
                time.sleep(0.001)

            def record(name):
                objects.renderer.record(folder + name, progress=progress)

            self.assertEqual(in_threads([lambda: record("/a.exr"), lambda: record("/b.exr"), calls["update"], calls["set_mesh"]], 2), [])

    def test_loads_of_two_threads(self):
        """A load returns the texts of its own file."""
        with tempfile.TemporaryDirectory() as folder:
            objects = Objects(folder)
            names = ["/one", "/another" * 20]
            for name in names:
                scene = square()
                scene.set_render_settings("/settings", camera="/camera", width=8, height=8)
                os.makedirs(folder + name)
                scene.write(folder + name + "/scene.alab")
            scene, wrong = hdalabaster.Scene(report=lambda *_: None), []

            def load(name):
                scene.clear()
                loaded = scene.load(folder + name + "/scene.alab")
                if not loaded["settings"].startswith("/") or not loaded["settings"].isprintable():
                    wrong.append(loaded)

            self.assertEqual(in_threads([lambda n=n: load(n) for n in names * 2], 2), [])
            self.assertEqual(wrong, [])
            del objects
