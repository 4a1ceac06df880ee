"""Tests of edits of several values, which are all made or none."""
import unittest

import hdalabaster
from square_scene import CORNERS, draw, pixel, square


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

    def test_settings_are_all_set_or_none(self):
        renderer = hdalabaster.Renderer(square(), samples=4)
        for wrong in [{"samples": 9, "subsurface": "x"}, {"samples": 9, "sampels": 3}, {"seed": 1, "maxDepth": -1}]:
            with self.assertRaises(ValueError):
                renderer.set(**wrong)
            self.assertEqual((renderer.get("samples"), renderer.get("seed")), (4, 0), wrong)
