#!/usr/bin/env python3
"""Tests the conversions between renderers, and that a neutral scene is the scene."""
import json
import math
import pathlib
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "statistical" / "calibration")]

import formulas  # noqa: E402
import neutral_scene  # noqa: E402
from pictures import Picture, block_means  # noqa: E402

CUBE_POINTS = [(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]
CUBE_FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


class Media(unittest.TestCase):
    def test_alpha_is_chandrasekhars(self):
        """1 - alpha of a half-space with albedo .2, .5, .8 and .95, solved to 6 digits."""
        for albedo, complement in ((0.2, 0.390325), (0.5, 0.0886639), (0.8, 0.00941522), (0.95, 4.9482e-4)):
            self.assertAlmostEqual((1 - formulas.exact_alpha(albedo)) / complement, 1, places=4)

    def test_cycles_walks_with_our_alpha(self):
        for albedo in (0.01, 0.1, 0.45, 0.8, 0.97):
            alpha = formulas.exact_alpha(albedo)
            self.assertAlmostEqual(formulas.cycles_alpha(formulas.cycles_albedo(alpha)), alpha, places=9)

    def test_mean_free_path(self):
        self.assertAlmostEqual(formulas.mean_free_path(0.8, 2.0), 2.2)
        self.assertAlmostEqual(formulas.cycles_radius(0.8, 2.0), 4 * math.pi * 2.2)


class Lights(unittest.TestCase):
    def test_power_of_a_sphere_is_pi_area_radiance(self):
        self.assertAlmostEqual(formulas.blender_sphere_power(3, 2), math.pi * 4 * math.pi * 2 ** 2 * 3)

    def test_look_at(self):
        x, y, z = formulas.look_at((0, 0, 5), (0, 0, 0))
        self.assertEqual((x, y, z), ([1, 0, 0], [0, 1, 0], [0, 0, 1]))

    def test_ior_of_f0(self):
        self.assertAlmostEqual(formulas.ior_from_f0(formulas.f0_from_ior(1.4)), 1.4)
        self.assertAlmostEqual(formulas.principled_specular(formulas.f0_from_ior(1.5)), 0.5)


class Geometry(unittest.TestCase):
    def test_catmull_clark_of_a_cube(self):
        """Known: corners go to 5/9, edges to 3/4 of the cube's, faces stay."""
        points, quads = neutral_scene.catmull_clark(CUBE_POINTS, CUBE_FACES)
        self.assertEqual((len(points), len(quads)), (8 + 6 + 12, 24))
        for before, after in zip(CUBE_POINTS, points):
            for a, b in zip(before, after):
                self.assertAlmostEqual(b, a * 5 / 9)
        edge = max(points[14], key=abs)
        self.assertAlmostEqual(abs(edge), 0.75)

    def test_normals_point_out_of_the_refined_cube(self):
        points, quads = neutral_scene.catmull_clark(CUBE_POINTS, CUBE_FACES)
        for p, n in zip(points, neutral_scene.area_normals(points, neutral_scene.fan(quads))):
            self.assertGreater(sum(a * b for a, b in zip(p, n)), 0.5)

    def test_open_edges_keep_their_plane_and_corners(self):
        points, quads = neutral_scene.catmull_clark([(0.0, 0, 0), (1.0, 0, 0), (1.0, 1, 0), (0.0, 1, 0)], [[0, 1, 2, 3]])
        self.assertEqual(points[:4], [(0.0, 0, 0), (1.0, 0, 0), (1.0, 1, 0), (0.0, 1, 0)])
        self.assertEqual(len(quads), 4)

    def test_polygons_and_welding(self):
        polygons = neutral_scene.polygons_of([0, 1, 2, 0, 2, 3, 4, 5, 6])
        self.assertEqual(polygons, [[0, 1, 2, 3], [4, 5, 6]])
        points, faces = neutral_scene.weld([(0, 0, 0), (1, 0, 0), (0, 0, 0), (0, 1, 0)], [[0, 1, 3], [2, 1, 3]])
        self.assertEqual((len(points), faces), (3, [[0, 1, 2], [0, 1, 2]]))


class Scenes(unittest.TestCase):
    def test_a_written_mesh_is_read_back(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name) / "slab"
            neutral_scene.write_slab(folder)
            glb = neutral_scene.Glb(folder / "scene.glb")
            primitive = glb.json["meshes"][0]["primitives"][0]
            points = glb.accessor(primitive["attributes"]["POSITION"])
            normals = glb.accessor(primitive["attributes"]["NORMAL"])
            indices = glb.accessor(primitive["indices"])
        self.assertEqual(len(indices), 36)
        self.assertEqual((min(p[1] for p in points), max(p[1] for p in points)), (-2, 0))
        triangles = list(zip(indices[0::3], indices[1::3], indices[2::3]))
        for n, own in zip(normals, neutral_scene.area_normals(points, triangles)):
            self.assertAlmostEqual(sum(a * b for a, b in zip(n, own)), 1)

    def test_specular_becomes_ior(self):
        material = neutral_scene.neutral_material("m", {"ior": 1.5, "specular": 0.5, "baseColor": [0.1, 0.2, 0.3]})
        self.assertAlmostEqual(formulas.f0_from_ior(material["ior"]), 0.02)
        self.assertNotIn("specular", material)

    def test_what_has_no_counterpart_is_named(self):
        with self.assertRaisesRegex(neutral_scene.Unsupported, "anisotropic of material m"):
            neutral_scene.neutral_material("m", {"anisotropic": 0.5})
        with tempfile.TemporaryDirectory() as name:
            file = pathlib.Path(name) / "scene.json"
            neutral_scene.write_slab(pathlib.Path(name))
            for broken in ({"gltf": [{"file": "model.gltf"}]},
                           {"gltf": [{"file": "scene.glb"}], "materials": [{"match": "wax", "set": {"roughness": 1}}]}):
                file.write_text(json.dumps({"lights": [], **broken}))
                with self.assertRaises(neutral_scene.Unsupported):
                    neutral_scene.write_neutral(file, pathlib.Path(name) / "out")


class Blocks(unittest.TestCase):
    def test_means_of_whole_blocks(self):
        plane = [float(y * 5 + x) for y in range(3) for x in range(5)]
        means = block_means(Picture(5, 3, [plane] * 3), 2)
        self.assertEqual((means.width, means.height, means.planes[1]), (2, 1, [3.0, 5.0]))


if __name__ == "__main__":
    unittest.main()
