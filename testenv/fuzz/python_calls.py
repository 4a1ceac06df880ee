#!/usr/bin/env python3
"""Calls every function of the Python module with arguments of any type and value, in processes of their own: none crashes, none
waits without end, and nothing is raised but errors that a caller can understand.

  python_calls.py [--seed 1] [--processes 4] [--seconds 5] [--threads 1]

One thread repeats the calls of its seed. Each process writes the call that it is in to a file, which a crash leaves behind.
With sanitizers (-DALABASTER_SANITIZE=address,undefined; Python itself has none, so that they are loaded first):

  LD_PRELOAD="$(gcc -print-file-name=libasan.so) $(gcc -print-file-name=libstdc++.so)" ASAN_OPTIONS=detect_leaks=0 \\
    PYTHONPATH=BUILD/python testenv/fuzz/python_calls.py --processes 60 --seconds 60
"""
import argparse
import array
import copy
import ctypes
import faulthandler
import itertools
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "unit/python"))
import hdalabaster  # noqa: E402
from square_scene import BACK, CORNERS, square  # noqa: E402

try:
    import numpy
except ImportError:
    numpy = None

PATHS = ["/square", "/part", "/wax", "/dome", "/camera", "/settings", "/many", "/new", "/gone", ""]
TEXTS = PATHS + ["color", "depth", "primId", "colour", "st", "points", "normals", "a\0b", "\udcff", "\ud800", "é" * 3000, "surface.baseColor",
                 "surface.", ".", "constant", "vertex", "faceVarying", "rectLight", "catmullClark", "loop", "guide", "lambert", "identity"]
NUMBERS = [0, 1, 2, 3, 7, -1, -5, 255, 1 << 20, 1 << 31, -1 << 31, 1 << 32, 1 << 63, 1 << 64, 1 << 200, 0.0, -0.0, 0.5, 1.5, 1e-300, 1e300,
           float("nan"), float("inf"), float("-inf"), True, False, None, complex(1, 2)]
FILES = ["scene.json", "image.exr", "image.png", "gone.json", "gone.glb", "image", b"image\xff.exr", pathlib.Path("image.exr"), "a\0.json"]
FORMATS = ["f4", "f8", "f2", "i4", "i8", "u1", "u8", "?", ">f4", ">i4", "c8", "S3", "U2", "O", "V0", "S0", "M8[s]", "f4,i2", "longdouble"]
ALLOWED = (hdalabaster.Error, TypeError, ValueError, LookupError, ArithmeticError, MemoryError, BufferError, OSError, AttributeError)


class Hostile:
    """An object whose every method may fail, return something else or change what is read."""

    def __init__(self, calls, victim):
        self.calls, self.victim = calls, victim

    def act(self, usual):
        action = self.calls.random.randrange(8)
        if action == 0:
            raise ZeroDivisionError
        if action == 1:
            self.victim.clear()
        if action == 2:
            self.victim.extend([0.0] * 3)
        if action == 3:
            return self.calls.random.choice(["text", None, -1, 1 << 70, 0.5, self])
        return usual

    def __len__(self):
        return self.act(3)

    def __getitem__(self, index):
        return self.act(0.5)

    def __float__(self):
        return self.act(0.5)

    def __index__(self):
        return self.act(1)

    def __bool__(self):
        return self.act(True)

    def __fspath__(self):
        return self.act("gone.json")

    def __repr__(self):
        return "hostile"


def endless():
    value = [0.0]
    value.append(value)
    return value


class RandomCalls:
    def __init__(self, seed):
        self.random = random.Random(seed)
        self.scenes = [square(report=lambda *_: None), square(report=lambda *_: self.act())]
        self.scenes[0].set_render_settings("/settings", camera="/camera", width=8, height=8, samples=1)
        self.scenes[0].set_mesh("/part", CORNERS, [[0, 1, 2, 3]], instancer="/many")
        self.scenes[0].set_instancer("/many", {"/part": [0, 1]}, translations=[(0, 0, 0), (1, 0, 0)])
        self.renderers = [hdalabaster.Renderer(self.scenes[0], samples=2, report=lambda *_: None), hdalabaster.Renderer(report=lambda *_: self.act())]
        self.renders = [self.renderers[0].start(width=8, height=8, camera="/camera", aovs=["color", "depth"])]
        self.displays = [hdalabaster.Display()]
        self.others = [self.renders[0].pixels()] if self.renders[0].wait() else []
        self.ticks = itertools.count()

    def act(self):
        if self.random.randrange(20) == 0:
            raise KeyError("the host's")

    # Values -----------------------------------------------------------------------------------------
    def number(self):
        return self.random.choice(NUMBERS)

    def text(self):
        return self.random.choice(TEXTS)

    def real(self):
        return self.random.choice([self.random.random(), self.random.uniform(-3, 3), 0.0, 1.0, 2])

    def numbers(self, count):
        return [self.real() for _ in range(count)]

    def points(self):
        return self.random.choice([CORNERS, self.floats(12), array.array("f", self.numbers(12)), [self.numbers(3) for _ in range(4)]])

    def floats(self, count):
        values = self.numbers(count)
        return self.random.choice([values, tuple(values), array.array("f", values), array.array("d", values),
                                   numpy.array(values, self.random.choice(["f4", "f8", "f2"])) if numpy else values])

    def indices(self):
        values = [self.random.randrange(-1, 6) for _ in range(self.random.choice([0, 3, 4, 6]))]
        return self.random.choice([values, [values], array.array(self.random.choice("bhilq"), values), [[0, 1, 2, 3]], [0, 1, 2]])

    def matrix(self):
        return self.random.choice([None, BACK, self.floats(16), [self.numbers(4) for _ in range(4)]])

    def motion(self, value):
        return [(self.real(), value()) for _ in range(self.random.randrange(3))]

    def array(self):
        if not numpy or self.random.randrange(4) == 0:
            raw = bytearray(self.random.randrange(0, 64, 8))
            kinds = [lambda: array.array(self.random.choice("bBhHiIlLqQfd"), bytes(raw)), lambda: memoryview(raw), lambda: memoryview(raw)[::-1],
                     lambda: memoryview(raw).cast("d"), lambda: (ctypes.c_float * 12)(*self.numbers(12)), lambda: (ctypes.c_long * 3)(0, 1, 2),
                     lambda: ((ctypes.c_int * 3) * 2)(), lambda: ctypes.c_double(1), lambda: raw, lambda: bytes(raw)]
            return self.random.choice(kinds)()
        made = numpy.zeros(self.random.choice([(), (0,), (4,), (4, 3), (4, 2), (3, 4), (2, 4, 4), (8, 8, 4), (0, 3), (3, 0), (4, 3, 1, 1), (1,) * 20]),
                           self.random.choice(FORMATS))
        change = self.random.randrange(6)
        if change == 0:
            made = made[..., ::-1] if made.ndim else made
        if change == 1:
            made = numpy.asfortranarray(made)
        if change == 2:
            made.flags.writeable = False
        if change == 3 and made.dtype.itemsize == 4 and made.size and made.dtype.names is None:
            unaligned = numpy.zeros(made.nbytes + 1, "u1")[1:]
            made = unaligned.view(made.dtype).reshape(made.shape)
        if change == 4:
            made = numpy.broadcast_to(made, (2,) + made.shape)
        return made

    def anything(self, depth=0):
        kinds = [self.number, self.text, self.array, lambda: self.numbers(self.random.randrange(18)), self.indices, self.points, self.matrix,
                 lambda: self.random.choice(TEXTS).encode("utf-8", "surrogatepass"), lambda: bytearray(b"123"), object, endless, lambda: {1, 2},
                 lambda: iter([1.0]), lambda: (lambda *_: self.act()), lambda: self.hostile(), lambda: self.primvar(),
                 lambda: self.random.choice(self.scenes + self.renderers + self.renders + self.displays + self.others), lambda: float]
        if depth < 3:
            kinds += [lambda: [self.anything(depth + 1) for _ in range(self.random.randrange(4))],
                      lambda: tuple(self.anything(depth + 1) for _ in range(self.random.randrange(4))),
                      lambda: {self.random.choice([self.text(), 1, None]): self.anything(depth + 1) for _ in range(self.random.randrange(3))}]
        return self.random.choice(kinds)()

    def hostile(self):
        victim = self.numbers(4)
        thing = Hostile(self, victim)
        victim.append(thing)
        return self.random.choice([thing, victim, [victim], {"surface": thing}])

    def primvar(self):
        try:
            return hdalabaster.Primvar(self.usual(self.anything, self.points), self.usual(self.text, lambda: "vertex"),
                                     motion=self.usual(self.anything, lambda: self.motion(self.points)))
        except ALLOWED:
            return None

    def usual(self, wild, tame):
        return wild() if self.random.randrange(4) == 0 else tame()

    def named(self, **options):
        """Some of the options, each mostly with a value that suits it."""
        chosen = {name: self.usual(self.anything, make) for name, make in options.items() if self.random.randrange(3) == 0}
        if self.random.randrange(30) == 0:
            chosen["unknown"] = self.anything()
        return chosen

    def parameters(self, *names):
        return self.named(**{name: self.random.choice([self.real, lambda: self.numbers(3), self.text]) for name in names})

    def frame(self):
        size = lambda: self.random.choice([0, 1, 4, 8, -5, 1 << 30])  # noqa: E731
        return {"width": 8, "height": 8, "camera": "/camera", **self.named(
            width=size, height=size, aovs=lambda: self.random.sample(["color", "depth", "primId", "primvars:x", "nothing"], 2),
            camera=lambda: {"transform": self.matrix(), **self.parameters("focalLength", "fStop", "clipPlanes")}, settings=self.path,
            window=lambda: (0, 0, 4, self.random.randrange(8)), pixel_aspect=self.real, render_tags=lambda: ["guide"], roots=lambda: ["/"],
            excluded=lambda: [self.path()])}

    def path(self):
        return self.random.choice(PATHS)

    def progress(self):
        return self.usual(self.anything, lambda: lambda now: next(self.ticks) % 3 != 0)

    def memory(self):
        return self.usual(self.array, lambda: memoryview(bytearray(8 * 8 * 16)).cast("f", (8, 8, 4)))

    # Calls: a function and its arguments --------------------------------------------------------------
    def scene_calls(self):
        s, w = self.random.choice(self.scenes), lambda tame: self.usual(self.anything, tame)
        places = {"transforms": lambda: self.floats(32), "translations": lambda: self.floats(6), "rotations": lambda: self.floats(8),
                  "scales": lambda: self.floats(6)}
        return [
            (s.load, [self.random.choice(FILES)], lambda: self.named(overrides=lambda: ["samples=1"], camera=self.text, time=self.real)),
            (s.write, [self.usual(lambda: self.random.choice(FILES), lambda: "scene.json")], lambda: self.named(
                overrides=lambda: {"samples": 1}, width=lambda: 8, camera=self.path)),
            (s.remove, [w(self.path)], dict), (getattr, [s, "prims"], dict),
            (s.set_mesh, [w(self.path), w(self.points), w(self.indices)], lambda: self.named(
                counts=lambda: [4], primvars=lambda: {"st": self.floats(8), self.text(): self.anything()}, material=self.path,
                transform=self.matrix, scheme=self.text, refine_level=lambda: self.random.choice([0, 1, 2, -1, 1 << 30]),
                instancer=self.path, visible=lambda: True, double_sided=lambda: False, cull_style=self.text, left_handed=lambda: True,
                holes=self.indices, invisible_faces=self.indices, subsets=lambda: {self.path(): self.indices()}, render_tag=self.text,
                categories=lambda: [self.text()], motion=lambda: self.motion(self.matrix), subdiv_tags=lambda: self.named(
                    crease_indices=self.indices, crease_lengths=self.indices, crease_weights=lambda: self.floats(2),
                    corner_indices=self.indices, corner_weights=lambda: self.floats(1), interpolate_boundary=self.text))),
            (s.set_primvar, [w(self.path), w(self.text), w(self.points)], lambda: self.named(interpolation=self.text)),
            (s.set_transform, [w(self.path), w(self.matrix)], dict), (s.set_visible, [w(self.path), w(lambda: True)], dict),
            (s.bind_material, [w(self.path), w(self.path)], dict),
            (s.set_instancer, [w(self.path), w(lambda: {"/part": self.indices()})], lambda: self.named(
                transform=self.matrix, parent=self.path, motion=lambda: self.motion(self.matrix), **places)),
            (s.set_instance_values, [w(self.path), w(lambda: self.random.choice([0, 1, 2, 1 << 63]))], lambda: self.named(**places)),
            (s.set_material, [w(self.path)], lambda: self.parameters("baseColor", "roughness", "scatterDistance", "file")),
            (s.set_material, [w(self.path)], lambda: self.named(displacement=self.text, nodes=lambda: {
                "surface": {"baseColor": w(lambda: ("image", "rgb"))}, "image": self.named(type=lambda: "AlabasterTexture", file=self.text)})),
            (s.set_light, [w(self.path), w(self.text)], lambda: self.parameters("intensity", "color", "lightLink", "exposure")),
            (s.set_camera, [w(self.path), w(self.matrix)], lambda: {**self.parameters("focalLength", "clipPlanes", "clippingRange", "shutterClose"),
                                                                    **self.named(motion=lambda: self.motion(self.matrix))}),
            (s.set_render_settings, [w(self.path)], lambda: self.named(
                camera=self.path, width=lambda: 8, height=lambda: 8, pixel_aspect=self.real, crop=lambda: (0, 0, 4, 4), frame=self.real,
                samples=lambda: 1, subsurface=self.text)),
            (s.set_parameter, [w(self.path), w(self.text), w(self.real)], dict), (hdalabaster.Scene, [], lambda: self.named(report=lambda: lambda *_: self.act())),
            (hdalabaster.Primvar, [self.anything()], lambda: self.named(interpolation=self.text, indices=self.indices, role=self.text))]

    def renderer_calls(self):
        r, w = self.random.choice(self.renderers), lambda tame: self.usual(self.anything, tame)
        return [
            (r.show, [w(lambda: self.scenes[0])], dict), (r.get, [w(lambda: "samples")], dict), (r.describe_settings, [], dict), (r.stats, [], dict),
            (r.set, [], lambda: self.named(samples=lambda: 2, subsurface=self.text, targetError=self.real, adaptive=lambda: True, threads=lambda: 2)),
            (r.progress, [], dict), (r.command, [w(lambda: self.random.choice(["dumpScene", "requirements", "tracePixel", "flush", ""]))],
                                     lambda: self.named(x=lambda: 1, y=lambda: 1, sample=lambda: 0)),
            (r.start, [], self.frame), (r.render, [], lambda: {**self.frame(), "progress": lambda now: next(self.ticks) % 3 != 0}),
            (r.record, [self.random.choice(FILES)], lambda: {"progress": self.progress(), **self.named(
                settings=self.path, aovs=lambda: ["normal"], keep_going=lambda: True)}),
            (r.stop, [], dict), (r.restart, [], dict), (r.pause, [], dict), (r.resume, [], dict),
            (hdalabaster.Renderer, [self.usual(self.anything, hdalabaster.Scene)], lambda: self.named(samples=lambda: 1, ocio=self.text)),
            (hdalabaster.Display, [self.random.choice([None, "gone.ocio", 5])], lambda: self.named(display=self.text, exposure=self.real))]

    def render_calls(self):
        r, w = self.random.choice(self.renders), lambda tame: self.usual(self.anything, tame)
        display = self.random.choice(self.displays)
        return [
            (r.update, [], self.frame), (r.wait, [w(lambda: 0.001)], dict), (r.wait, [0.05, self.progress()], dict), (getattr, [r, "state"], dict),
            (r.cancel, [], dict), (r.pixels, [w(lambda: "color")], dict), (r.__getitem__, [w(lambda: "depth")], dict),
            (r.read, ["color", self.memory()], dict), (r.show, ["color", self.memory()], lambda: self.named(display=lambda: display, top_down=bool)),
            (r.pick, [(0, 0, 4, 4)], dict),
            (setattr, [display, "exposure", w(self.real)], dict),
            (copy.copy, [self.anything()], dict), (copy.deepcopy, [r], dict), (lambda kind: kind.__new__(kind), [hdalabaster.Scene], dict),
            (lambda: self.others.append(hdalabaster.Pixels.__new__(hdalabaster.Pixels)), [], dict), (self.others.clear, [], dict)]

    def one(self, note):
        function, arguments, options = self.random.choice(self.random.choice([self.scene_calls, self.renderer_calls, self.render_calls])())
        options = options()
        note(lambda: f"{getattr(function, '__qualname__', function)} {arguments!r} {options!r}")
        try:
            self.keep(function(*arguments, **options))
        except ALLOWED as error:
            if "unknown reason" in str(error) or "Unable to cast" in str(error):
                raise AssertionError(str(error)) from error

    def keep(self, made):
        for kind, held in [(hdalabaster.Scene, self.scenes), (hdalabaster.Renderer, self.renderers), (hdalabaster.Render, self.renders),
                           (hdalabaster.Display, self.displays), (hdalabaster.Pixels, self.others)]:
            if isinstance(made, kind):
                held.append(made)
                if len(held) > 3:
                    held.pop(self.random.randrange(1, 3))


def child(seed, seconds, threads, file):
    faulthandler.dump_traceback_later(seconds + 100, exit=True)
    random_calls, end, failed, calls = RandomCalls(seed), time.monotonic() + seconds, [], [0]

    def note(call):
        calls[0] += 1
        if threads == 1:
            file.seek(0)
            file.truncate()
            file.write(call())
            file.flush()

    def work():
        try:
            while time.monotonic() < end and not failed:
                random_calls.one(note)
        except BaseException as error:  # noqa: B902
            failed.append(error)
            raise

    workers = [threading.Thread(target=work) for _ in range(threads - 1)]
    for worker in workers:
        worker.start()
    work()
    for worker in workers:
        worker.join()
    print(f"seed {seed}: {calls[0]} calls")
    return 1 if failed else 0


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--processes", type=int, default=4)
    options.add_argument("--seconds", type=float, default=5)
    options.add_argument("--threads", type=int, default=1)
    options.add_argument("--child", metavar="FILE", help=argparse.SUPPRESS)
    given = options.parse_args()
    if given.child:
        with open(given.child, "w", errors="backslashreplace") as file:
            return child(given.seed, given.seconds, given.threads, file)
    bad = 0
    for seed in range(given.seed, given.seed + given.processes):
        with tempfile.TemporaryDirectory() as folder:
            note = os.path.join(folder, "call")
            done = subprocess.run([sys.executable, "-X", "faulthandler", os.path.abspath(__file__), "--child", note, "--seed", str(seed),
                                   "--seconds", str(given.seconds), "--threads", str(given.threads)], cwd=folder, capture_output=True, text=True)
            print(done.stdout, end="", flush=True)
            if done.returncode != 0:
                bad += 1
                print(f"seed {seed} ended with {done.returncode} in {pathlib.Path(note).read_text()[:2000]}\n{done.stderr[-6000:]}", flush=True)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
