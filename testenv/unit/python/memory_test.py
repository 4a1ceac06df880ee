"""Tests of the Python module's memory; alabaster_test.py runs them."""
import ctypes
import functools
import gc
import unittest
import weakref

import hdalabaster
from square_scene import CORNERS, draw, moved, square

try:
    import numpy
except ImportError:
    numpy = None


class MallocInfo(ctypes.Structure):
    _fields_ = [(name, ctypes.c_size_t) for name in ["arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks",
                                                     "uordblks", "fordblks", "keepcost"]]


def allocated():
    """Bytes that are in use; those that malloc keeps for later do not count."""
    gc.collect()
    mallinfo2 = ctypes.CDLL(None).mallinfo2
    mallinfo2.restype = MallocInfo
    info = mallinfo2()
    return info.uordblks + info.hblkhd


class Memory(unittest.TestCase):
    @unittest.skipUnless(numpy, "numpy is missing")
    # promise: embedding.arrays.python
    def test_arrays_are_not_copied(self):
        render = draw(hdalabaster.Renderer(square(), samples=4))
        first, second = render.pixels().numpy(), numpy.asarray(render.pixels())
        self.assertEqual((first.shape, first.dtype), ((16, 16, 4), numpy.float32))
        self.assertEqual(first.ctypes.data, second.ctypes.data)
        self.assertEqual(first.strides, (-256, 16, 4))
        into = numpy.empty((16, 16, 4), numpy.float32)
        render.read("color", into)
        self.assertTrue((into == first).all())
        with self.assertRaises(hdalabaster.ArgumentError):
            render.read("color", into[:8].copy())
        with self.assertRaises(ValueError):
            render.read("color", into[:, ::-1])

    @unittest.skipUnless(numpy, "numpy is missing")
    def test_shows_pixels_in_an_array_of_the_host(self):
        scene = square()
        render = draw(hdalabaster.Renderer(scene, samples=4))
        linear = numpy.zeros((16, 16, 4), numpy.float32)
        self.assertTrue(render.show("color", linear, top_down=False))
        self.assertTrue((linear[::-1] == render.pixels().numpy()).all())
        linear[:] = 7
        self.assertTrue(render.show("color", linear, top_down=False))
        self.assertTrue((linear == 7).all())  # it was up to date
        display = hdalabaster.Display()
        shown = numpy.zeros((16, 16, 4), numpy.uint8)
        self.assertTrue(render.show("color", shown, display))
        middle = int(shown[8, 8, 0])
        display.exposure = -1.0
        self.assertTrue(render.show("color", shown, display))
        self.assertTrue(0 < shown[8, 8, 0] < middle)
        self.assertFalse(render.show("color", numpy.zeros((8, 16, 4), numpy.float32)))
        with self.assertRaises(ValueError):
            render.show("color", numpy.zeros((16, 16, 4), numpy.int64))

    @unittest.skipUnless(numpy, "numpy is missing")
    def test_arrays_outlive_everything(self):
        render = draw(hdalabaster.Renderer(square(), samples=4))
        pixels = render.pixels().numpy()
        before = pixels.copy()
        del render
        gc.collect()
        draw(hdalabaster.Renderer(square(), samples=1))
        self.assertTrue((pixels == before).all())

    @unittest.skipUnless(numpy, "numpy is missing")
    def test_lent_arrays_live_as_long_as_the_scene_and_no_longer(self):
        points = numpy.array(CORNERS, numpy.float32)
        scene = square()
        scene.set_mesh("/square", points, numpy.array([[0, 1, 2, 3]], numpy.int32), material="/wax")
        with self.assertRaises(ValueError):
            points.resize((5, 3))  # it is exported
        renderer = hdalabaster.Renderer(scene, samples=4)
        picture = draw(renderer).pixels().numpy().copy()
        strided = numpy.asfortranarray(numpy.array(CORNERS, numpy.float64))
        scene.set_mesh("/square", strided, [[0, 1, 2, 3]], material="/wax")  # converted
        self.assertTrue((draw(renderer).pixels().numpy() == picture).all())
        scene.prims  # a call gives back what the library has returned
        points.resize((5, 3), refcheck=False)

    def test_a_thousand_renders(self):
        scene = square()
        renderer = hdalabaster.Renderer(scene, samples=1)

        def render_thousand():
            for i in range(1000):
                scene.set_transform("/square", moved(i / 1000))
                draw(renderer)
            return allocated()

        settled = render_thousand()
        self.assertLess(render_thousand() - settled, 1 << 15)

    def test_a_hundred_renderers(self):
        for i in range(100):
            draw(hdalabaster.Renderer(square(), samples=1))
            if i == 19:
                settled = allocated()
        # Malloc keeps up to 42 kB more for threads on a busy machine.
        self.assertLess(allocated() - settled, 1 << 16)

class Host:
    """Owns what it hears of, as a viewport does."""

    def __init__(self, of, make_report):
        def report(who):
            return {"report": make_report(self)} if who == of else {}
        self.heard = []
        self.scene = square(**report("scene"))
        self.renderer = hdalabaster.Renderer(self.scene, samples=1, **report("renderer"))
        self.render = draw(self.renderer)
        self.pixels = self.render.pixels()

    def hear(self, *message):
        self.heard.append(message)


class Circles(unittest.TestCase):
    REPORTS = {"a method": lambda host: host.hear, "a lambda": lambda host: lambda *message: host.hear(*message),
               "a partial": lambda host: functools.partial(Host.hear, host)}

    def test_the_collector_frees_a_host_that_hears_of_what_it_owns(self):
        for of in "nobody", "scene", "renderer":
            for what, make_report in self.REPORTS.items():
                host = Host(of, make_report)
                seen = [weakref.ref(host), weakref.ref(host.hear.__self__)]
                del host
                gc.collect()
                self.assertEqual([one() for one in seen], [None, None], f"{of} {what}")

    def test_the_collector_leaves_what_is_in_use(self):
        for keep in "renderer", "render", "pixels":
            host = Host("renderer", lambda host: host.hear)
            kept, seen = getattr(host, keep), weakref.ref(host)
            del host
            gc.collect()
            self.assertIsNotNone(seen(), keep)  # through the report
            seen().scene.set_mesh("/square", CORNERS, [[0, 1, 2, 9]], material="/wax")
            draw(seen().renderer)
            self.assertTrue(seen().heard, keep)
            del kept
            gc.collect()
            self.assertIsNone(seen(), keep)
