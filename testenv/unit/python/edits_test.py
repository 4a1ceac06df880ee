"""Tests of edits of several values, which are all made or none."""
import unittest

import hdalabaster
from square_scene import BACK, CORNERS, draw, moved, pixel, square

BOX = ([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)],
       [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])


def milk(stone, lamp=False, clear=False):
    """A box of milk with a stone, which is at `stone`, and seen or not a lamp."""
    scene = hdalabaster.Scene()
    scene.set_mesh("/milk", *BOX, material="/white")
    scene.set_mesh("/stone", [[0.4 * c for c in p] for p in BOX[0]], BOX[1], material="/dark", transform=moved(*stone))
    scene.set_material("/white", baseColor=(1, 1, 1), scatterDistance=(.3, .3, .3), specTrans=1, roughness=0)
    scene.set_material("/dark", **look(clear))
    scene.set_light("/dome", "domeLight", intensity=1)
    if lamp:
        set_lamp(scene)
    scene.set_camera("/camera", BACK, focalLength=0.05, horizontalAperture=0.036, verticalAperture=0.036)
    return scene


def look(clear):
    return dict(baseColor=(1, 1, 1), specTrans=1, ior=1.5) if clear else dict(baseColor=(0, 0, 0))


def set_lamp(scene):
    scene.set_light("/lamp", "sphereLight", moved(0.5, 0.5), radius=0.3, intensity=20)


class Edits(unittest.TestCase):
    def test_values_of_instances_are_all_set_or_none(self):
        scene = square()
        scene.set_mesh("/square", CORNERS, [[0, 1, 2, 3]], instancer="/many", transform=None)
        scene.set_instancer("/many", {"/square": [0, 1]}, translations=[(-9, 0, 0), (0, 0, 0)], scales=[(1, 1, 1)] * 2)
        away, here = [(70, 0, 0), (70, 0, 0)], [(0, 0, 0), (0, 0, 0)]
        small, far = [(.1, .1, .1)] * 2, [(0, 90, 0)]
        cases = {
            "motion": dict(translations=hdalabaster.Primvar(away, motion=[(0, here), (1, here)])),
            "indices": dict(translations=hdalabaster.Primvar(away, indices=[0, 1])),
            "one is beyond the end": dict(translations=away, scales=small + small),
            "one is not there": dict(translations=away, rotations=[(1, 0, 0, 0)]),
            "one is of another type": dict(translations=away, scales=[(1, 0, 0, 0)] * 2),
        }
        renderer = hdalabaster.Renderer(scene, samples=4)
        for what, values in cases.items():
            with self.assertRaises((ValueError, TypeError, hdalabaster.Error), msg=what):
                scene.set_instance_values("/many", 0, **values)
            self.assertEqual(pixel(draw(renderer, aovs=["instanceId"]), 8, 8, "instanceId"), 1, what)
        scene.set_instance_values("/many", 1, translations=far, scales=[(1, 1, 1)])
        render = draw(renderer, aovs=["instanceId"])
        self.assertNotEqual(pixel(render, 8, 8, "instanceId"), 1)

    def test_a_part_of_the_values_by_instance_is_replaced(self):
        scene = square()
        scene.set_mesh("/square", CORNERS, [[0, 1, 2, 3]], instancer="/many", material="/tinted")
        scene.set_material("/tinted", nodes={"surface": {"baseColor": ("tint", "rgb"), "roughness": ("worn", "r")},
                                             "tint": {"type": "AlabasterPrimvar", "varname": "tint"},
                                             "worn": {"type": "AlabasterPrimvar", "varname": "worn_out"}})
        scene.set_instancer("/many", {"/square": [0, 1]}, translations=[(-9, 0, 0), (0, 0, 0)],
                            **{"primvars:tint": [(0.5, 0.5, 0.5)] * 2, "primvars:worn_out": [1, 1]})
        renderer = hdalabaster.Renderer(scene, samples=4)

        def seen():
            render = draw(renderer, aovs=["albedo", "primvars:tint", "primvars:worn_out"])
            red, _, blue = pixel(render, 8, 8, "albedo")
            return pixel(render, 8, 8, "primvars:tint"), pixel(render, 8, 8, "primvars:worn_out")[0], (red > blue) - (red < blue)
        self.assertEqual(seen(), ([0.5, 0.5, 0.5], 1, 0))
        red = memoryview(bytearray(24)).cast("f", (2, 3))
        red[1, 0] = 0.75
        scene.set_instance_values("/many", 0, tint=red, worn_out=[0, 0.5])
        self.assertEqual(seen(), ([0.75, 0, 0], 0.5, 1))
        scene.set_instance_values("/many", 1, **{"primvars:tint": [(0, 0, 0.25)]}, translations=[(0, 0, 0)])
        last = ([0, 0, 0.25], 0.5, -1)
        self.assertEqual(seen(), last)
        rest = [(1, 1, 1)] * 2
        for wrong, text in [(dict(tint=rest), "the values of tint are 2, and 2 from number 1 on go beyond their end"),
                            (dict(tint=[0.5]), "tint are of type float3, and those given are of type float"),
                            (dict(tnit=rest), "no primvar tnit; did you mean 'tint'"),
                            (dict(tint=hdalabaster.Primvar(rest, indices=[0, 1])), "numbers alone"),
                            (dict(tint="red"), "must be an array")]:
            with self.assertRaisesRegex(hdalabaster.Error if "Primvar" not in str(wrong) else ValueError, text):
                scene.set_instance_values("/many", 1, **wrong)
        self.assertEqual(seen(), last)

    # promise: embedding.instances.unmatched
    def test_instancers_and_meshes_that_do_not_find_each_other_are_reported_once(self):
        heard = []
        scene = square()
        renderer = hdalabaster.Renderer(scene, report=lambda *message: heard.append(message[1:]), samples=1)

        def messages(prototypes):
            scene.set_instancer("/many", prototypes, translations=[(0, 0, 0), (1, 0, 0)])
            for _ in range(2):
                draw(renderer)
            return [heard.pop() for _ in range(len(heard))]
        fault = "instancer.prototype", "/many"
        unnamed = "prototypes:/square: it does not name this instancer (its field 'instancer'); its instances are not drawn"
        self.assertEqual(messages({"/square": [0, 1]}), [(*fault, unnamed)])
        scene.edit("/square", instancer="/many")
        self.assertEqual(messages({"/square": [0, 1]}), [])
        unknown = "prototypes:/sqare: there is no mesh or instancer of that path; its instances are not drawn; did you mean '/square'?"
        self.assertEqual(messages({"/sqare": [0, 1]}), [(*fault, unknown)])
        self.assertEqual(messages({"/sqare": [0, 1], "/square": [1]}), [], "is known")
        self.assertEqual(messages({"/gone": [], "/square": [1]}), [], "an empty list draws nothing")
        scene.set_mesh("/other", CORNERS, [[0, 1, 2, 3]], instancer="/many")
        self.assertEqual(messages({"/square": [0, 1]}),
                         [(*fault, "/other names this instancer, which has no prototypes:/other; it is not drawn")])

    def test_a_body_with_contents_has_the_bytes_of_a_fresh_scene(self):
        def picture(renderer):
            return bytes(draw(renderer).pixels("color"))
        away, here, aside = (3, 0, 0), (-.3, .1, .2), (.2, -.7, .2)  # the last stands out of the milk
        scene = milk(away)
        renderer = hdalabaster.Renderer(scene, samples=2)
        before = picture(renderer)
        edits = [
            (lambda: scene.set_transform("/stone", moved(*here)), dict(stone=here)),
            (lambda: scene.set_transform("/stone", moved(*aside)), dict(stone=aside)),
            (lambda: scene.set_material("/dark", **look(True)), dict(stone=aside, clear=True)),
            (lambda: set_lamp(scene), dict(stone=aside, clear=True, lamp=True)),
            (lambda: scene.remove("/lamp"), dict(stone=aside, clear=True)),
            (lambda: scene.set_transform("/stone", moved(*away)), dict(stone=away, clear=True))]
        for edit, fresh in edits:
            edit()
            after = picture(renderer)
            self.assertNotEqual(after, before, fresh)
            self.assertEqual(after, picture(hdalabaster.Renderer(milk(**fresh), samples=2)), fresh)
            before = after

    def test_bones_are_walls_in_the_set_of_the_flesh(self):
        scene = milk((-.1, .1, .1))
        scene.set_material("/white", baseColor=(1, 1, 1), scatterDistance=(1, 1, 1))
        scene.set_primvar("/milk", "subsurfaceSet", "hand", "constant")
        renderer = hdalabaster.Renderer(scene, samples=64)
        without = pixel(draw(renderer), 8, 8)[0]
        scene.set_primvar("/stone", "subsurfaceSet", "hand", "constant")
        self.assertLess(pixel(draw(renderer), 8, 8)[0], 0.9 * without)

    def test_settings_are_all_set_or_none(self):
        renderer = hdalabaster.Renderer(square(), samples=4)
        for wrong in [{"samples": 9, "subsurface": "x"}, {"samples": 9, "sampels": 3}, {"seed": 1, "maxDepth": -1}]:
            with self.assertRaises(ValueError):
                renderer.set(**wrong)
            self.assertEqual((renderer.get("samples"), renderer.get("seed")), (4, 0), wrong)
