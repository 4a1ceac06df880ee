"""Tests of what the Python module takes as arguments, and what it says to the rest; alabaster_test.py runs them."""
import array
import ctypes
import gc
import json
import math
import pathlib
import sys
import tempfile
import unittest

import hdalabaster
from square_scene import BACK, CORNERS, draw, pixel, square

try:
    import numpy
except ImportError:
    numpy = None

SOURCES = pathlib.Path(__file__).resolve().parents[3]
TEXTS = ["123", b"123", bytearray(b"123")]


def nested(depth):
    value = [0.0]
    for _ in range(depth):
        value = [value]
    return value


def endless():
    value = []
    value.append(value)
    return value


class Sequence:
    """A sequence whose methods are given."""

    def __init__(self, length=lambda: 3, item=lambda i: float(i)):
        self.length, self.item = length, item

    def __len__(self):
        return self.length()

    def __getitem__(self, index):
        return self.item(index)


class Number:
    def __init__(self, **methods):
        self.methods = methods

    def __float__(self):
        return self.methods["real"]()

    def __index__(self):
        return self.methods["whole"]()


def fail(*_):
    return 1 // 0


# Every place of a function that takes numbers: its name in messages, and the call.
def places(scene, renderer):
    return [
        ("baseColor", lambda v: scene.set_material("/m", baseColor=v)),
        ("baseColor", lambda v: scene.set_material("/m", nodes={"surface": {"baseColor": [v, v, v]}})),
        ("transform", lambda v: scene.set_camera("/c", v)),
        ("transform", lambda v: scene.set_transform("/square", v)),
        ("motion", lambda v: scene.set_camera("/c", motion=[(0, v), (1, v)])),
        ("points", lambda v: scene.set_mesh("/n", points=v, indices=[0])),
        ("points", lambda v: scene.set_mesh("/n", points=[v, v, v], indices=[0])),
        ("indices", lambda v: scene.set_mesh("/n", points=CORNERS, indices=v)),
        ("indices", lambda v: scene.set_mesh("/n", points=CORNERS, indices=[v])),
        ("counts", lambda v: scene.set_mesh("/n", points=CORNERS, indices=[0, 1, 2], counts=v)),
        ("holes", lambda v: scene.set_mesh("/n", points=CORNERS, indices=[0, 1, 2], holes=v)),
        ("subsets", lambda v: scene.set_mesh("/n", points=CORNERS, indices=[0, 1, 2], subsets={"/wax": v})),
        ("crease_weights", lambda v: scene.set_mesh("/n", points=CORNERS, indices=[0, 1, 2], subdiv_tags={"crease_weights": v})),
        ("indices of points", lambda v: scene.set_mesh("/n", points=hdalabaster.Primvar(CORNERS, indices=v), indices=[0, 1, 2])),
        ("normals", lambda v: scene.set_primvar("/square", "normals", v)),
        ("st", lambda v: scene.set_primvar("/square", "st", [v, v])),
        ("prototypes", lambda v: scene.set_instancer("/i", {"/square": v})),
        ("translations", lambda v: scene.set_instancer("/i", {"/square": [0]}, translations=v)),
        ("window", lambda v: renderer.start(width=8, height=8, window=v)),
        ("crop", lambda v: scene.set_render_settings("/r", crop=v)),
    ]


class Arguments(unittest.TestCase):
    def setUp(self):
        self.scene = square()
        self.renderer = hdalabaster.Renderer(self.scene, samples=1)

    def test_text_is_never_a_sequence_of_numbers(self):
        for text in TEXTS:
            for name, call in places(self.scene, self.renderer)[isinstance(text, str):]:  # a str is a parameter, the first one
                with self.assertRaisesRegex((TypeError, ValueError), name, msg=f"{name} {text}") as caught:
                    call(text)
                self.assertIs(caught.exception.__class__, TypeError, caught.exception)
        for name in ["intensity", "exposure"]:
            for text in TEXTS[1:]:
                with self.assertRaisesRegex(TypeError, name):
                    self.scene.set_light("/l", "domeLight", **{name: text})
        with self.assertRaisesRegex(TypeError, "width"):
            self.renderer.start(width="8")
        with self.assertRaisesRegex(TypeError, "aovs"):
            self.renderer.start(aovs="color")
        with self.assertRaisesRegex(TypeError, "aovs"):
            self.renderer.record("a.exr", aovs="color")

    def test_fields_of_any_name(self):
        scene = hdalabaster.Scene()
        quad = dict(points=CORNERS, indices=[[0, 1, 2, 3]])
        maps = {name: hdalabaster.Primvar([(0.0, 0.0)] * 4, "faceVarying") for name in ["uv:Faces", "leafCounts", "uv:indices:"]}
        scene.set_mesh("/m", primvars=maps, categories=("near", "far"), **quad)
        scene.set("/c", "camera", clip_planes=[(0, 0, 1, 0), (0, 1, 0, 0)], shutter_close=0.5)
        scene.edit("/m", {"transform:samples": [(0, None), (1, None)]}, transform=None)
        with self.assertRaisesRegex(hdalabaster.ArgumentError, "did you mean 'invisibleFaces'"):
            scene.set_mesh("/m", invisible_face=[0] * 9, **quad)

    def test_a_text_in_a_list_of_numbers(self):
        with self.assertRaisesRegex(TypeError, "baseColor.*str"):
            self.scene.set_material("/wax", baseColor=("0.9", "0.6", "0.3"))
        with self.assertRaisesRegex(TypeError, "points.*str"):
            self.scene.set_mesh("/m", points=["a"], indices=[0])

    def test_recursion_is_bounded(self):
        lists = {}
        lists["itself"] = endless()
        wide = []
        wide.extend([wide] * 1000)
        a, b = [], []
        a.append(b), b.append(a)
        for values in [endless(), wide, a, nested(100000), {"a": 1}, (endless(),)]:
            for name, call in places(self.scene, self.renderer):
                with self.assertRaises((TypeError, ValueError), msg=name):
                    call(values)
        selves = {}
        selves["surface"] = selves
        with self.assertRaisesRegex(TypeError, "surface"):
            self.scene.set_material("/m", nodes=selves)
        with self.assertRaisesRegex(TypeError, "parameters"):
            self.renderer.start(camera={"transform": BACK, "parameters": {"focalLength": 1.0}})

    def test_methods_of_the_host_may_fail(self):
        shrinking = []
        shrinking.extend([Number(real=lambda: shrinking.clear() or 1.0, whole=lambda: shrinking.clear() or 1)] * 9)
        growing = [0.0]
        growing[0] = Number(real=lambda: growing.append(0.0) or 1.0, whole=lambda: growing.append(0) or 1)
        hostile = [Sequence(length=fail), Sequence(item=fail), Sequence(length=lambda: -1), Sequence(length=lambda: "3"),
                   [Number(real=fail, whole=fail)], Number(real=fail, whole=fail), [Number(real=lambda: "1", whole=lambda: "1")],
                   [Number(real=lambda: None, whole=lambda: 1 << 80)], shrinking, [1 << 5000], [None], [[]] * 3, {1, 2}, iter([1.0]),
                   [float("nan")], [complex(1, 2)], object(), Exception, [lambda: 1], type]
        allowed = (TypeError, ValueError, ArithmeticError, LookupError, hdalabaster.Error)
        for value in hostile + [growing]:
            for name, call in places(self.scene, self.renderer):
                try:
                    call(value)
                except allowed:
                    pass
        draw(self.renderer)

    def test_a_dict_may_change_while_it_is_read(self):
        primvars = {}

        def change(_):
            primvars.clear()
            gc.collect()
            return 0.5

        primvars.update({name: Sequence(length=lambda: 4, item=change) for name in "abcdefgh"})
        self.scene.set_mesh("/square", CORNERS, [[0, 1, 2, 3]], primvars=primvars, material="/wax")
        self.assertEqual(primvars, {})
        with self.assertRaisesRegex(TypeError, "key of primvars"):
            self.scene.set_mesh("/square", CORNERS, [[0, 1, 2, 3]], primvars={1: [0.5] * 4})

    def test_indices_are_whole_numbers_of_32_bits(self):
        for wrong, kind, says in [([0.75, 1.75, 2.75], TypeError, "indices.*float"), ([0.0, 1.0, 2.0], TypeError, "indices.*float"),
                                  ([1 << 32, 1, 2], ValueError, "indices.*4294967296"), ([-1 << 31 << 31, 1, 2], ValueError, "indices")]:
            with self.assertRaisesRegex(kind, says):
                self.scene.set_mesh("/m", CORNERS, wrong)
        for letter, wrong, kind in [("d", [0.75, 1, 2], TypeError), ("f", [0, 1, 2], TypeError), ("q", [1 << 32, 1, 2], ValueError),
                                    ("Q", [(1 << 64) - 1, 1, 2], ValueError), ("I", [(1 << 32) - 1, 1, 2], ValueError)]:
            with self.assertRaisesRegex(kind, "indices"):
                self.scene.set_mesh("/m", CORNERS, array.array(letter, wrong))
        for letter in "bBhHiIlLqQ":
            self.scene.set_mesh("/m", CORNERS, array.array(letter, [0, 1, 2]))
        self.scene.set_mesh("/m", CORNERS, (ctypes.c_long * 3)(0, 1, 2), holes=array.array("d"))
        self.scene.set_primvar("/square", "mixed", [1, 2.5, 3, 4])

    def test_rows_of_another_length_are_refused(self):
        """Nine numbers in three rows are three points, and six in three rows are none."""
        self.scene.set_mesh("/m", [0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 1, 2])
        wrong = [[(0, 0), (1, 0), (0, 1)], [(0, 0, 0, 1), (1, 0, 0, 1), (0, 1, 0, 1)]]
        for points in wrong + ([numpy.zeros((3, 2), numpy.float32), numpy.zeros((3, 4))] if numpy else []):
            with self.assertRaisesRegex(ValueError, r"points.*\(n, 3\)"):
                self.scene.set_mesh("/m", points, [0, 1, 2])
        with self.assertRaisesRegex(ValueError, "points: row 1 has 2 numbers, and the first has 3"):
            self.scene.set_mesh("/m", [(0, 0, 0), (1, 0), (0, 1, 0, 5)], [0, 1, 2])
        with self.assertRaisesRegex(TypeError, "left_handed must be a bool, not str"):
            self.scene.set_mesh("/m", [0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 1, 2], left_handed="no")
        with self.assertRaisesRegex(ValueError, r"clip.*\(n, 4\)"):
            self.scene.set_camera("/c", clipPlanes=[(1, 2), (3, 4)])
        with self.assertRaisesRegex(ValueError, r"rotations.*\(n, 4\)"):
            self.scene.set_instancer("/i", {"/m": [0]}, rotations=[(1, 0)] * 4)
        for matrices in ([BACK], BACK, [[c for row in BACK for c in row]]):
            self.scene.set_instancer("/i", {"/m": [0]}, transforms=matrices)

    def test_rows_of_several_lengths_are_faces_of_several_sizes(self):
        five = CORNERS + [(2, 0, 0)]

        def covered(indices, counts=None):
            self.scene.set_mesh("/square", five, indices, counts, material="/wax")
            view = memoryview(draw(self.renderer).pixels())
            return sum(view[y, x, 3] for y in range(16) for x in range(16))

        right = covered([0, 1, 2, 3, 1, 4, 2], [4, 3])
        self.assertGreater(right, covered([[0, 1, 2, 3]]))
        rows = [[0, 1, 2, 3], [1, 4, 2]]
        for same in [rows, rows[::-1], tuple(map(tuple, rows)), [array.array("i", row) for row in rows]]:
            self.assertEqual(covered(same), right)
        self.assertEqual(covered(rows, [4, 3]), right)
        for wrong, counts, says in [(rows, [3, 4], "row 0 has 4 corners, and counts says 3"), (rows, [7], "2 rows"),
                                    ([[0, 1, 2], 3], None, "element 1"), ([0, 1, 2, [3]], None, "element 3 is a row"),
                                    ([[[0, 1, 2]]], None, "shape")]:
            with self.assertRaisesRegex(ValueError, "indices.*" + says):
                covered(wrong, counts)
        for name, call in [("holes", lambda v: self.scene.set_mesh("/m", five, rows, holes=v)),
                           ("subsets", lambda v: self.scene.set_mesh("/m", five, rows, subsets={"/wax": v})),
                           ("st", lambda v: self.scene.set_primvar("/square", "st", v))]:
            with self.assertRaisesRegex(ValueError, name + ".*: row 1 has 1 numbers, and the first has 2"):
                call([[0, 1], [0]])
        with self.assertRaisesRegex(ValueError, "transform must have 4 x 4"):
            self.scene.set_transform("/square", [[1, 0, 0, 0, 0, 1, 0, 0], [0, 0, 1, 0, 0, 0, 0, 1]])

    def test_a_misspelt_field_is_named_before_its_value_is_read(self):
        moves = [(0, BACK), (1, BACK)]
        text = "/camera: a camera has no field 'transform:sample'; did you mean 'transform:samples'"
        for call in (lambda: self.scene.set("/camera", "camera", {"transform:sample": moves}),
                     lambda: self.scene.edit("/camera", {"transform:sample": moves})):
            with self.assertRaisesRegex(hdalabaster.ArgumentError, text):
                call()
        with self.assertRaisesRegex(TypeError, "focalLength must be a number"):
            self.scene.edit("/camera", focalLength=moves, horizontalAperture=0.036)

    def test_fractions_are_no_whole_numbers(self):
        nan, infinite = float("nan"), float("inf")
        for name in "samples", "maxDepth", "seed":
            for wrong in 2.5, nan, infinite, 1e300:
                for call in [lambda v: hdalabaster.Renderer(self.scene, **v), lambda v: self.renderer.set(**v),
                             lambda v: self.scene.set_render_settings("/r", **v)]:
                    with self.assertRaisesRegex((ValueError, TypeError), name, msg=f"{name} {wrong}"):
                        call({name: wrong})
        with self.assertRaisesRegex(hdalabaster.ArgumentError, "'samples'.*a whole number"):
            self.renderer.set(samples=2.5)
        self.renderer.set(samples=2, timeLimit=2.5, adaptive=False)
        self.assertEqual((self.renderer.get("samples"), self.renderer.get("timeLimit")), (2, 2.5))
        self.renderer.set(samples=3.0)
        self.assertEqual(self.renderer.get("samples"), 3)

    def test_names_in_messages(self):
        for call, kind, says in [
                (lambda: self.renderer.render(width=-5, height=8), ValueError, "width.*-5"),
                (lambda: self.renderer.render(width=8, height=-5), ValueError, "height.*-5"),
                (lambda: self.scene.set_render_settings("/r", width=-5), ValueError, "width.*-5"),
                (lambda: self.renderer.render(width=8.5), TypeError, "width.*float"),
                (lambda: self.scene.set_render_settings("/r", width=8.5), TypeError, "width.*float"),
                (lambda: self.renderer.start(aovs=["colour"]), LookupError, "'colour'.*color"),
                (lambda: self.renderer.start(aovs=["xx"]), LookupError, "'xx'"),
                (lambda: self.renderer.start(camera=5), TypeError, "camera.*int"),
                (lambda: self.renderer.start(window=(0, 0, 1)), ValueError, "window"),
                (lambda: self.renderer.set(samples=1 << 80), ValueError, "samples"),
                (lambda: self.renderer.set(samples=[1, 2, 3, 4, 5]), ValueError, "samples"),
                (lambda: self.renderer.set(samples={}), TypeError, "samples.*dict"),
                (lambda: hdalabaster.Renderer(5), TypeError, "scene.*int"),
                (lambda: self.renderer.show(5), TypeError, "scene.*int"),
                (lambda: self.scene.set_mesh("/m", CORNERS, [0, 1, 2], refine_level="2"), TypeError, "refine_level.*str"),
                (lambda: self.scene.set_mesh("/m", CORNERS, [0, 1, 2], visible="no"), TypeError, "visible.*str"),
                (lambda: self.scene.set_mesh("/m", CORNERS, [0, 1, 2], material=5), TypeError, "material.*int"),
                (lambda: self.scene.set_mesh("/m", CORNERS, [0, 1, 2], subsets=[1]), TypeError, "subsets.*list"),
                (lambda: self.scene.set_material("/m", nodes=[1]), TypeError, "nodes.*list"),
                (lambda: self.scene.load(5), TypeError, "file.*int"),
                (lambda: self.scene.load(None), TypeError, "file.*None"),
                (lambda: self.renderer.record(5), TypeError, "file.*int"),
                (lambda: hdalabaster.Display(5), TypeError, "color_config.*int"),
        ]:
            with self.assertRaisesRegex(kind, says):
                call()
        render = draw(self.renderer)
        for wrong, kind in [("1", TypeError), (float("nan"), ValueError)]:
            with self.assertRaisesRegex(kind, "seconds"):
                render.wait(wrong)
        with self.assertRaisesRegex(TypeError, "progress.*int"):
            render.wait(progress=5)

    @unittest.skipUnless(numpy, "numpy is missing")
    def test_types_of_arrays_in_messages(self):
        points = numpy.array(CORNERS, numpy.float32)
        for wrong, says in [(points.astype(">f4"), ">f"), (points.astype(str), "w"), (points.astype(complex), "Zd"),
                            (points.astype(object), "O"), (points.astype(numpy.longdouble), "g"),
                            (numpy.zeros(4, [("x", "f4"), ("y", "i2")]), "T{"), (numpy.zeros(4, "S3"), "3s")]:
            with self.assertRaisesRegex(TypeError, "points: arrays of type '.*" + says + ".*float32"):
                self.scene.set_mesh("/m", wrong, [0, 1, 2])

    @unittest.skipUnless(numpy, "numpy is missing")
    def test_arrays_of_every_layout(self):
        points = numpy.array(CORNERS, numpy.float32)
        wide = numpy.zeros((8, 6), numpy.float32)
        wide[::2, ::2] = points
        unaligned = numpy.zeros(points.nbytes + 1, numpy.uint8)
        unaligned[1:] = points.view(numpy.uint8).reshape(-1)
        read_only = points.copy()
        read_only.flags.writeable = False
        before = pixel(draw(self.renderer), 8, 8)
        for same in [points[::-1][::-1], numpy.asfortranarray(points), wide[::2, ::2], unaligned[1:].view(numpy.float32).reshape(4, 3),
                     read_only, points.astype(numpy.float16), points.astype(numpy.int8), points.astype(numpy.float64), memoryview(points)]:
            self.scene.set_mesh("/square", same, [[0, 1, 2, 3]], material="/wax")
            self.assertEqual(pixel(draw(self.renderer), 8, 8), before)
        for empty in [numpy.zeros((0, 3), numpy.float32), numpy.zeros(0), [], numpy.zeros((3, 0)), numpy.zeros((0, 0, 7), numpy.int32)]:
            self.scene.set_mesh("/e", empty, empty)
        released = memoryview(points)
        released.release()
        with self.assertRaises(ValueError):
            self.scene.set_mesh("/m", released, [0, 1, 2])

    def test_names_and_files_of_any_bytes(self):
        for call in [lambda t: self.scene.remove(t), lambda t: self.scene.set_mesh(t, CORNERS, [0, 1, 2]),
                     lambda t: self.scene.set_mesh("/m", CORNERS, [0, 1, 2], material=t), lambda t: self.scene.load(t),
                     lambda t: self.scene.load(pathlib.Path(t)), lambda t: self.renderer.set(subsurface=t),
                     lambda t: self.renderer.start(aovs=[t]), lambda t: self.renderer.record(t),
                     lambda t: self.scene.set_material("/m", nodes={t: {}}), lambda t: hdalabaster.Primvar([1.0], t)]:
            with self.assertRaisesRegex(ValueError, "zero character|null"):
                call("/a\0b")
        odd = "/\udcff"
        self.scene.set_mesh(odd, CORNERS, [0, 1, 2])
        self.assertIn(odd, self.scene.prims)
        with self.assertRaisesRegex(hdalabaster.NotFoundError, "ff"):
            self.scene.remove("/gone\udcff")
        with self.assertRaisesRegex(hdalabaster.SceneError, "ff"):
            self.scene.load(b"/gone\xff.json")
        with self.assertRaises(hdalabaster.Error):
            self.scene.remove("/" + "é" * 5000)
        heard = []
        renderer = hdalabaster.Renderer(report=lambda *message: heard.append(message), samples=1)
        scene = square()
        renderer.show(scene)
        scene.set_mesh(odd, CORNERS, [[0, 1, 2, 3]], material="/gone\udcff")
        draw(renderer)
        self.assertTrue(any("ff" in message[2] for message in heard), heard)
        with tempfile.TemporaryDirectory() as folder:
            scene.set_render_settings("/r", camera="/camera", width=8, height=8)
            scene.remove(odd)
            file = folder + "/\udcff.exr"
            self.assertEqual(renderer.record(file), [file])

    def test_objects_that_were_not_initialised(self):
        for kind in [hdalabaster.Scene, hdalabaster.Renderer, hdalabaster.Render, hdalabaster.Pixels, hdalabaster.Display, hdalabaster.Primvar]:
            bare = kind.__new__(kind)
            for name in dir(kind):
                if name.startswith("__") or name == "numpy":
                    continue
                with self.assertRaises(TypeError, msg=f"{kind} {name}"):
                    member = getattr(bare, name)
                    member()
            with self.assertRaises(TypeError):
                self.scene.set_mesh("/m", bare, [0, 1, 2])
            with self.assertRaises((TypeError, BufferError)):  # by version of pybind11
                memoryview(bare)
            with self.assertRaises(TypeError):
                hdalabaster.Renderer(bare)
        scene = hdalabaster.Scene.__new__(hdalabaster.Scene)
        scene.__init__()
        self.assertEqual(scene.prims, {})

    def test_a_failed_update_leaves_the_render_as_it_was(self):
        render = draw(self.renderer)
        for wrong in [{"aovs": ["color", "nothing"]}, {"width": -1}, {"width": 1 << 30, "height": 1 << 30}, {"camera": "/camera", "aovs": [5]}]:
            with self.assertRaises((hdalabaster.Error, TypeError, ValueError)):
                render.update(**wrong)
        render.update()
        self.assertTrue(render.wait())
        self.assertEqual(memoryview(render["color"]).shape, (16, 16, 4))

    def test_clip_planes(self):
        def alpha(**camera):
            self.scene.set_camera("/camera", BACK, focalLength=0.05, horizontalAperture=0.036, verticalAperture=0.036, **camera)
            render = draw(self.renderer)
            view = memoryview(render.pixels())
            return sum(view[y, x, 3] for y in range(16) for x in range(16))

        whole = alpha()
        planes = [[1, 0, 0, 0], [0, 1, 0, 0]]
        given = [planes[:1], planes] + ([numpy.float32(planes[:1]), numpy.array(planes)] if numpy else [])
        for value in given:
            self.assertAlmostEqual(alpha(clipPlanes=value), whole / 2 ** len(value), delta=whole / 20)
        self.assertAlmostEqual(alpha(clipPlanes=planes * 2), whole / 4, delta=whole / 20)
        self.assertEqual(alpha(clipPlanes=[]), whole)
        self.scene.set_parameter("/camera", "clipPlanes", planes)
        self.assertAlmostEqual(memoryview(draw(self.renderer).pixels())[2, 2, 3], 0)
        with self.assertRaisesRegex(ValueError, "clipPlanes"):
            alpha(clipPlanes=[1, 0, 0])

    def test_memory_for_pixels(self):
        render = draw(self.renderer)
        for wrong in [b"abc", bytearray(16), memoryview(bytearray(1024)), array.array("f", [0] * 1024)]:
            with self.assertRaises((ValueError, BufferError, TypeError, hdalabaster.Error)):
                render.show("color", wrong)
        for wrong in [5, None, "abc", [1.0]]:
            with self.assertRaises(TypeError):
                render.show("color", wrong)
            with self.assertRaises(TypeError):
                render.read("color", wrong)
        with self.assertRaises(TypeError):
            render.show("color", bytearray(1024), display=5)

        def zeros(letter, *shape):
            memory = bytearray(array.array(letter).itemsize * math.prod(shape))
            return memoryview(memory).cast(letter, shape) if len(shape) > 1 else memoryview(memory).cast(letter)

        render = draw(self.renderer, aovs=["color", "primId"])
        for aov, wrong in [("color", zeros("d", 16, 16, 4)), ("color", zeros("i", 16, 16, 4)), ("color", zeros("f", 32, 16, 4)),
                           ("color", zeros("f", 16, 4, 16)), ("color", zeros("B", 16 * 16 * 16)), ("color", zeros("f", 16)),
                           ("primId", zeros("f", 16, 16)), ("primId", zeros("q", 16, 16)), ("primId", zeros("I", 16, 16))]:
            with self.assertRaisesRegex(ValueError, "the pixels are of type '[fi]'.*shape.*and the array is of type"):
                render.read(aov, wrong)
        for wrong in zeros("f", 16, 16, 4).toreadonly(), zeros("f", 32 * 16 * 4)[::2]:
            with self.assertRaisesRegex(ValueError, "array"):
                render.read("color", wrong)
        with self.assertRaisesRegex(ValueError, "int32 shows no fractions"):
            render.show("color", zeros("i", 16, 16))
        self.assertTrue(render.show("primId", zeros("i", 16, 16)))
        shaped, flat = zeros("f", 16, 16, 4), zeros("f", 16 * 16 * 4)
        render.read("color", shaped), render.read("color", flat)
        self.assertEqual(shaped.tobytes(), flat.tobytes())
        self.assertEqual(shaped[8, 8, 3], 1)
        if numpy:
            for wrong in [numpy.zeros((16, 16, 0)), numpy.zeros(()), numpy.zeros((16, 16, 4, 1)), numpy.zeros((16, 16), "V0"),
                          numpy.zeros((16, 16, 4), ">f4")]:
                with self.assertRaises((ValueError, hdalabaster.Error)):
                    render.show("color", wrong)
            for wrong in [numpy.empty((8, 8, 8), object), numpy.zeros((16, 16), "f4,f4,f4,f4"), numpy.zeros((16, 16), "S16")]:
                self.assertEqual(wrong.nbytes, 16 * 16 * 16)
                with self.assertRaisesRegex(ValueError, "type"):  # pixels are no pointers
                    render.read("color", wrong)


class Fields(unittest.TestCase):
    """Each row of the tables: a wrong word and a misspelt name get the sentences of C, C++, descriptions and --set."""

    def test_each_row_says_what_it_takes(self):
        scene = hdalabaster.Scene()
        calls = {"disney_material": scene.set_material, "camera": scene.set_camera, "render_settings": scene.set_render_settings,
                 "lights": lambda path, **given: scene.set_light(path, "rectLight", **given)}
        for schema, call in calls.items():
            text = (SOURCES / "schemas" / f"{schema}.json").read_text()
            for name, row in json.loads(text)["properties"].items():
                with self.subTest(schema=schema, name=name):
                    with self.assertRaisesRegex(hdalabaster.ArgumentError, f"did you mean '(surface.)?{name}'"):
                        call("/it", **{name + "x": 1.0})
                    words = row.get("enum")
                    if words:
                        says = f"'(surface.)?{name}' must be one of {', '.join(words)}, and is \"{words[-1]}x\"; did you mean '{words[-1]}'"
                        with self.assertRaisesRegex(hdalabaster.ArgumentError, says):
                            call("/it", **{name: words[-1] + "x"})


class KeptArrays(unittest.TestCase):
    """An array is exported while the library reads it, and only then: array.array refuses to grow while it is."""

    def setUp(self):
        self.scene = square()
        self.renderer = hdalabaster.Renderer(self.scene, samples=1)
        self.floats = array.array("f", [c for corner in CORNERS for c in corner])
        self.ints = array.array("i", [0, 1, 2, 3])

    def assert_released(self, what):
        for held in (self.floats, self.ints):
            before = len(held)
            try:
                held.append(0)
            except BufferError:
                self.fail(f"{what}: the array is still exported")
            held.pop()
            self.assertEqual(len(held), before)

    def test_after_every_failure(self):
        floats, ints, scene = self.floats, self.ints, self.scene
        gone = hdalabaster.Scene()
        points = hdalabaster.Primvar(floats, "vertex", indices=ints, motion=[(0, floats), (1, floats)])
        failures = {
            "an empty path": lambda: scene.set_mesh("", floats, ints),
            "an unknown cull style": lambda: scene.set_mesh("/m", floats, ints, cull_style="x"),
            "an unknown option": lambda: scene.set_mesh("/m", floats, ints, colour=1),
            "a wrong transform": lambda: scene.set_mesh("/m", floats, ints, transform=[1]),
            "wrong counts": lambda: scene.set_mesh("/m", floats, ints, counts="4"),
            "a wrong interpolation": lambda: scene.set_mesh("/m", hdalabaster.Primvar(floats, "x"), ints),
            "wrong holes": lambda: scene.set_mesh("/m", floats, ints, holes=[.5]),
            "wrong primvars": lambda: scene.set_mesh("/m", points, ints, primvars={"st": "no", "a": b""}),
            "motion of what has none": lambda: scene.set_primvar("/square", "x", hdalabaster.Primvar(floats, motion=[(0, floats)])),
            "no such mesh": lambda: scene.set_primvar("/gone", "x", floats),
            "no path of a primvar": lambda: scene.set_primvar("", "x", floats),
            "no name": lambda: scene.set_primvar("/square", "", floats),
            "a wrong name": lambda: scene.set_primvar("/square", "a\0", floats),
            "wrong subdivision": lambda: scene.set_mesh("/m", floats, ints, subdiv_tags={"crease_weights": floats, "x": 1}),
            "wrong subsets": lambda: scene.set_mesh("/m", floats, ints, subsets={"/wax": ints, "/x": [.5]}),
            "an instancer without a path": lambda: scene.set_instancer("", {"/square": ints}, translations=floats),
            "wrong instances": lambda: scene.set_instancer("/i", {"/square": ints}, translations=floats, scales="1"),
            "no such instancer": lambda: scene.set_instance_values("/gone", 0, translations=floats),
            "two kinds of values": lambda: scene.set_instance_values("/gone", 0, translations=floats, scales=floats),
            "values that are wrong later": lambda: scene.set_instance_values("/gone", 0, translations=floats, scales=[1]),
            "a wrong frame": lambda: self.renderer.start(camera={"motion": [(0, floats)]}, width=-1),
            "memory that is too small": lambda: draw(self.renderer).read("color", floats),
            "memory of a wrong shape": lambda: draw(self.renderer).show("color", floats),
            "no such AOV": lambda: draw(self.renderer).read("depth", floats),
            "a wrong parameter": lambda: scene.set_parameter("/gone", "clipPlanes", floats),
            "a wrong setting": lambda: self.renderer.set(samples=floats),
        }
        self.assertEqual(gone.prims, {})
        for what, call in failures.items():
            with self.assertRaises(Exception, msg=what):
                call()
            self.assert_released(what)

    def test_after_success(self):
        """The scene holds them until it holds others; then a call gives them back."""
        for replace in [lambda: self.scene.remove("/square"), lambda: self.scene.clear(),
                        lambda: self.scene.set_mesh("/square", CORNERS, [[0, 1, 2, 3]])]:
            self.scene.set_mesh("/square", hdalabaster.Primvar(self.floats, motion=[(0, self.floats), (1, self.floats)]), self.ints,
                                counts=[4], subsets={"/wax": self.ints})
            self.scene.set_primvar("/square", "x", self.floats, "constant")
            self.scene.set_camera("/camera", BACK)
            draw(self.renderer)
            with self.assertRaises(BufferError):
                self.floats.append(0)
            replace()
            self.scene.set_camera("/camera", BACK)
            draw(self.renderer)
            self.scene.prims
            self.assert_released("after an edit")
        self.scene.set_mesh("/square", self.floats, self.ints, counts=[4])
        draw(self.renderer)
        del self.renderer, self.scene
        gc.collect()
        hdalabaster.Scene().prims
        self.assert_released("without the scene")

    def test_objects_are_released(self):
        before = sys.getrefcount(self.floats)
        for _ in range(10):
            self.scene.set_mesh("/square", self.floats, self.ints, counts=[4])
            with self.assertRaises(Exception):
                self.scene.set_mesh("", self.floats, self.ints)
        self.scene.remove("/square")
        draw(self.renderer)
        self.scene.prims
        self.assertEqual(sys.getrefcount(self.floats), before)
