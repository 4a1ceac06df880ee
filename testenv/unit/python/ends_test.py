"""Tests of the ends of a process that uses the Python module: exits, forks, other interpreters. alabaster_test.py runs them."""
import multiprocessing
import os
import pathlib
import subprocess
import sys
import textwrap
import unittest

import hdalabaster
from square_scene import draw, square

START = """
import atexit, gc, os, sys, threading, time
import square_scene
from square_scene import hdalabaster, square, draw
scene = square()
scene.set_render_settings("/settings", camera="/camera", width=256, height=256)
renderer = hdalabaster.Renderer(scene, samples=1 << 20)
frame = dict(width=256, height=256, camera="/camera")
"""


def run(code, start=START):
    # Python 3.12 and later warn of each fork of a process with threads, which is what the tests try.
    return subprocess.run([sys.executable, "-W", "ignore::DeprecationWarning", "-c", start + textwrap.dedent(code)],
                          capture_output=True, text=True, timeout=60, cwd=pathlib.Path(__file__).parent)


def picture_in_a_child(_):
    return bytes(draw(hdalabaster.Renderer(square(), samples=2, report=lambda *_: None))["color"])


class Ends(unittest.TestCase):
    def assert_ends(self, code, says="", start=START):
        done = run(code, start)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, says, ""), code)

    def test_a_daemon_thread_uses_the_library(self):
        for work in [
                "renderer.render(**frame)",
                "renderer.render(progress=lambda p: True, **frame)",
                "renderer.render(progress=lambda p: time.sleep(9), **frame)",
                "renderer.start(**frame).wait()",
                "renderer.record('/dev/null/a.exr', progress=lambda p: None)",
                "renderer.record(os.devnull + '.exr')",
                "r = renderer.start(**frame)\n    while True: r.wait(.01)",
                "r = renderer.start(**frame)\n    while True: r.update(); r.state",
                "while True: scene.set_transform('/square', None); scene.prims",
                "while True: hdalabaster.Renderer(square(), samples=1)",
                "while True: draw(hdalabaster.Renderer(square(), samples=1)).pixels()"]:
            code = f"def work():\n    {work}\nthreading.Thread(target=work, daemon=True).start()\ntime.sleep(.3)\n"
            for _ in range(2):
                done = run(code)
                self.assertEqual(done.returncode, 0, work + done.stderr)
                self.assertNotIn("terminate", done.stderr)

    def test_a_recording_daemon_thread_and_a_render_of_the_same_renderer(self):
        self.assert_ends("""
            kept = renderer.start(**frame)
            pixels = None
            folder = __import__("tempfile").mkdtemp()
            atexit.register(__import__("shutil").rmtree, folder)
            threading.Thread(target=lambda: renderer.record(folder + "/a.exr", progress=lambda p: None), daemon=True).start()
            time.sleep(.3)
            """)

    def test_exit_functions_and_finalizers_may_use_the_library(self):
        self.assert_ends("""
            renderer.set(samples=1)
            later = lambda: print(draw(renderer).state)
            """, "converged\n", "import atexit\natexit.register(lambda: later())\n" + START)
        self.assert_ends("""
            class Last:
                def __del__(self, renderer=renderer, draw=draw):
                    renderer.set(samples=1)
                    print(draw(renderer).state)
            last = Last()
            """, "converged\n")

    def test_exit_functions_may_join_threads_that_use_the_library(self):
        """Functions that were registered before the import run after the module's own."""
        for work in ["renderer.render(**frame)", "while True: renderer.stats()", "while True: scene.prims",
                     "while True: draw(hdalabaster.Renderer(square(), samples=1))"]:
            self.assert_ends(f"""
                def work():
                    try:
                        {work}
                    except RuntimeError as error:
                        pass
                thread = threading.Thread(target=work, daemon=True)
                thread.start()
                time.sleep(.2)
                """, "joined\n", "import atexit\natexit.register(lambda: print('joined') if not thread.join() else None)\n" + START)

    def test_objects_in_cycles_and_globals(self):
        self.assert_ends("""
            class Cycle: pass
            cycle = Cycle()
            cycle.itself, cycle.scene, cycle.renderer = cycle, scene, hdalabaster.Renderer(square(), report=lambda *_: cycle)
            cycle.render = cycle.renderer.start(**frame)
            cycle.render.wait(.1)
            cycle.pixels = cycle.render.pixels()
            hdalabaster.kept = cycle.render
            sys.modules["kept"] = cycle
            """)

    def test_a_forked_child_ends(self):
        fork = """
            kept = renderer.start(**frame)
            kept.wait(.2)
            pixels = kept.pixels()
            child = os.fork()
            if child == 0:
                {in_child}
                sys.exit(7)
            print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
            """
        for in_child in ["pass", "del renderer, kept, scene", "del scene, kept, renderer, pixels; gc.collect()", "renderer = None",
                         "bytes(pixels); threading.Thread(target=lambda: square().prims).start()"]:
            self.assert_ends(fork.format(in_child=in_child), "7\n")

    def test_a_forked_child_draws_where_its_parent_has_no_renderer(self):
        draw_in_child = """
            child = os.fork()
            if child == 0:
                try:
                    own = hdalabaster.Renderer(square(), samples=1, report=lambda *_: None)
                    print(draw(own).state, end=" ", flush=True)
                except hdalabaster.Error as error:
                    print(str(error)[-8:], end=" ", flush=True)
                sys.exit(7)
            print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
            """
        for in_parent, says in [("draw(renderer.set(samples=1) or renderer)", "the fork 7\n"), ("renderer = None", "converged 7\n"),
                                ("renderer.set(samples=1); draw(renderer); renderer = None", "converged 7\n")]:
            self.assert_ends(f"{in_parent}{draw_in_child}".replace("\n            ", "\n"), says)

    # promise: embedding.forks
    def test_a_forked_child_is_told_what_it_cannot_use(self):
        for use in ["draw(renderer)", "kept.update()", "kept.wait(1)", "kept.state", "kept.show('color', memory)", "kept.pixels()",
                    "renderer.stop()", "renderer.record('a.exr')", "renderer.get('samples')", "renderer.stats()", "scene.prims",
                    "scene.clear()", "scene.set_visible('/square', True)", "scene.load('a.alab')", "scene.write('a.alab')",
                    "hdalabaster.Renderer(scene)", "renderer.show(None)"]:
            self.assert_ends(f"""
                kept = renderer.start(**frame)
                kept.wait(.2)
                memory = memoryview(bytearray(256 * 256 * 16)).cast("f", (256, 256, 4))
                child = os.fork()
                if child == 0:
                    try:
                        {use}
                    except hdalabaster.Error as error:
                        print(type(error).__name__, flush=True)
                    sys.exit(0)
                print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
                """, "ArgumentError\n0\n")

    def test_a_forked_child_gives_back_what_it_could_not_lend(self):
        for use in ["renderer.set(missing=held)", "renderer.command('dumpScene', values=held)"]:
            self.assert_ends(f"""
                held = memoryview(bytearray(64)).cast("f")
                child = os.fork()
                if child == 0:
                    try:
                        {use}
                    except hdalabaster.ArgumentError:
                        held.release()  # BufferError where it is lent
                        sys.exit(7)
                print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
                """, "7\n")

    def test_a_fork_after_a_recording(self):
        """Libraries that read and write images have threads of their own."""
        self.assert_ends("""
            renderer.set(samples=1)
            folder = __import__("tempfile").mkdtemp()
            renderer.record(folder + "/a.exr", folder + "/a.png")
            __import__("shutil").rmtree(folder)
            child = os.fork()
            if child == 0:
                sys.exit(7)
            print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
            """, "7\n")

    def test_a_fork_while_other_threads_render(self):
        self.assert_ends("""
            threading.Thread(target=lambda: renderer.render(**frame), daemon=True).start()
            time.sleep(.2)
            for _ in range(5):
                child = os.fork()
                if child == 0:
                    del renderer, scene
                    sys.exit(0)
                print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)  # else a child prints it, too
            """, "0\n" * 5)

    def test_a_progress_callback_forks(self):
        done = run("""
            def progress(_, children=[]):
                if not children:
                    children.append(os.fork())
                    if children == [0]:
                        sys.exit(7)
                    print(os.waitstatus_to_exitcode(os.waitpid(children[0], 0)[1]))
                return False
            folder = __import__("tempfile").mkdtemp()
            try:
                renderer.record(folder + "/a.exr", progress=progress)
            except hdalabaster.Cancelled:
                print("cancelled")
            """)
        self.assertEqual((done.returncode, done.stdout), (0, "7\ncancelled\n"), done.stderr)

    def test_multiprocessing(self):
        renderer = hdalabaster.Renderer(square(), samples=2)
        expected = bytes(draw(renderer)["color"])
        for method in ["forkserver", "spawn"]:
            with multiprocessing.get_context(method).Pool(2) as pool:
                self.assertEqual(pool.map(picture_in_a_child, range(3)), [expected] * 3, method)
        with multiprocessing.get_context("fork").Pool(2) as pool:
            with self.assertRaisesRegex(hdalabaster.Error, "spawn or forkserver"):
                pool.map(picture_in_a_child, range(3))
        self.assertEqual(draw(renderer).state, "converged")

    # promise: embedding.threads.python
    def test_a_subinterpreter_is_refused(self):
        try:
            import _xxsubinterpreters  # noqa: F401
        except ImportError:
            self.skipTest("Python has no module for sub-interpreters")
        code = "try:\n  import hdalabaster\nexcept ImportError as error:\n  print(error, flush=True)\nelse:\n  print('imported', flush=True)\n"
        for start in ["", "import hdalabaster\n"]:
            done = run(f"""
                import _xxsubinterpreters as interpreters
                interpreter = interpreters.create()
                interpreters.run_string(interpreter, {code!r})
                interpreters.destroy(interpreter)
                """, "import sys\nsys.path.insert(0, %r)\n" % str(pathlib.Path(hdalabaster.__file__).parents[1]) + start)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("sub-interpreter", done.stdout)
