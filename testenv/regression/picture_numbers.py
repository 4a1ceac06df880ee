#!/usr/bin/env python3
"""Numbers of pictures that have a right answer: AOV error against many seeds, the sums of layers, the lights that are added to a scene
without any, the poles of a dome. Needs the Python module and numpy.
"""
import json
import pathlib
import tempfile
import unittest

import hdalabaster
import numpy as np
from feature_scenes import ball
from small_scene import HEIGHT, KEY, WIDTH, small_scene
from gltf_writer import Document
from images import write_hdr

SUMS = {"color": ("diffuse", "specular", "subsurface", "emission"),
        "subsurface": ("subsurfaceUnscattered", "subsurfaceSingle", "subsurfaceMultiple")}
LAYERS = ["color", *SUMS["color"], *SUMS["subsurface"], "nonfiniteSamples"]


def render(renderer, aovs, **frame):
    """{AOV: array} of a render that has ended; color without alpha."""
    done = renderer.render(**{"width": WIDTH, "height": HEIGHT, "aovs": aovs, **frame})
    found = {aov: np.array(done.pixels(aov).numpy(), dtype=float) for aov in aovs}
    found["color"] = found["color"][..., :3]
    return found


class PictureNumbers(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    # promise: pipeline.aov.error
    def test_error_is_the_deviation_over_seeds(self):
        """The estimate takes a pixel's samples as independent. They are better than that: the deviation is 0.78 of it here."""
        renderer = hdalabaster.Renderer(small_scene(self.folder), samples=16)
        pictures = []
        for seed in range(100):
            renderer.set(seed=seed)
            pictures.append(render(renderer, ["color", "error"], camera="/camera"))
        brightness = np.array([p["color"].mean(axis=-1) for p in pictures])
        measured = brightness.var(axis=0, ddof=1).sum()
        estimated = (np.array([p["error"] for p in pictures]) ** 2).mean(axis=0).sum()
        self.assertTrue(0.65 < (measured / estimated) ** 0.5 < 1.1, (measured / estimated) ** 0.5)

    def check_sums(self, found):
        for whole, parts in SUMS.items():
            total = sum(found[part] for part in parts)
            off = np.abs(found[whole] - total) / (np.abs(found[whole]) + sum(np.abs(found[part]) for part in parts) + 1e-30)
            self.assertLess(off.max(), 1e-5, whole)
            self.assertGreater(min(np.abs(found[part]).max() for part in parts if part != "emission"), 0)

    # promise: pipeline.aov.sums
    def test_layers_add_up_under_exposure(self):
        pictures = []
        for stops in (0.0, 3.0):
            scene = small_scene(self.folder)
            scene.set_light("/sky", "domeLight", intensity=0.3, visibleToCamera=True)
            scene.set_parameter("/camera", "exposure", stops)
            pictures.append(render(hdalabaster.Renderer(scene, samples=4), LAYERS, camera="/camera"))
            self.check_sums(pictures[-1])
        for layer in LAYERS[:-1]:
            self.assertTrue((8 * pictures[0][layer] == pictures[1][layer]).all(), layer)

    # promise: pipeline.aov.nonfinite
    def test_layers_add_up_where_samples_are_not_finite(self):
        scene = small_scene(self.folder)
        scene.set_parameter("/camera", "exposure", 64.0)
        scene.set_light("/key", "rectLight", KEY, width=0.6, height=0.6, intensity=1e22)
        found = render(hdalabaster.Renderer(scene, samples=4), LAYERS, camera="/camera")
        bad = found["nonfiniteSamples"]
        self.assertTrue((bad > 0).any() and (bad < 4).any())
        self.assertTrue(((0 < bad) & (bad < 4) & (found["color"].max(axis=-1) > 0)).any())  # the others of the pixel remain
        self.check_sums(found)

    def ball_without_light(self, studio, samples, material):
        """Color of 48x32 pixels."""
        doc = Document("picture_numbers.py")
        doc.add_node("ball", doc.add_mesh("ball", ball(1.0, 4), doc.add_material("ball", material)))
        doc.write_glb(self.folder / "ball.glb")
        (self.folder / "ball.json").write_text(json.dumps({"gltf": [{"file": "ball.glb"}], "settings": {"studio": studio}}))
        scene = hdalabaster.Scene()
        loaded = scene.load(str(self.folder / "ball.json"))
        return render(hdalabaster.Renderer(scene, samples=samples), ["color"], settings=loaded["settings"], width=48, height=32)["color"]

    def white_ball(self, studio):
        """Mean radiance of the parts of a white ball to the upper left and to the lower right."""
        color = self.ball_without_light(studio, 64, {"baseColor": [0.8, 0.8, 0.8], "roughness": 1.0, "specular": 0.0})
        return color[9:14, 17:22].mean(), color[18:22, 27:31].mean()

    def test_a_scene_without_light_is_lit_well(self):
        """White that faces the key light is near 1, which views show a little below white, and the other side is not black."""
        for studio, bright, dark in (("auto", (0.8, 1.3), (0.2, 0.5)), ("off", (0.7, 1.0), (0.3, 0.7))):
            key, fill = self.white_ball(studio)
            self.assertTrue(bright[0] < key < bright[1] and dark[0] < fill < dark[1], (studio, key, fill))

    def test_a_mirror_shows_the_studio(self):
        """The sky and the key light, whose radiances are 0.2 and 8, of which the color of the latter passes 0.982."""
        color = self.ball_without_light("auto", 16, {"baseColor": [1.0, 1.0, 1.0], "roughness": 0.0, "metallic": 1.0})
        sky, key = color[7:10, 24:30].mean(), color[11:13, 18:21].mean()
        self.assertTrue(abs(sky / 0.2 - 1) < 0.02 and abs(key / (8 * 0.982) - 1) < 0.05, (sky, key))

    def test_a_pole_of_a_dome_shows_its_own_row(self):
        rows = [3.0, 1.0, 1.0, 0.25]
        write_hdr(self.folder / "sky.hdr", 8, 4, lambda y, x: (rows[y], rows[y] / 2, 0.125))
        scene = hdalabaster.Scene()
        scene.set_light("/sky", "domeLight", **{"texture:file": str(self.folder / "sky.hdr"), "visibleToCamera": True})
        for row, up in ((0, 1), (3, -1)):
            # The camera looks along -z.
            scene.set_camera("/camera", [[1, 0, 0, 0], [0, 0, up, 0], [0, -up, 0, 0], [0, 0, 0, 1]], focalLength=0.5, horizontalAperture=0.036,
                             verticalAperture=0.024)
            color = render(hdalabaster.Renderer(scene, samples=4), ["color"], camera="/camera")["color"]
            self.assertTrue(np.allclose(color[..., 0], rows[row], rtol=0.02), (up, color[..., 0].min(), color[..., 0].max()))


if __name__ == "__main__":
    unittest.main()
