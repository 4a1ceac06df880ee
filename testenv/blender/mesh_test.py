"""Tests of meshes. addon_test.py runs them."""
import re
import unittest
import unittest.mock

import bpy
import numpy

import scenes
from alabaster_render import hair, materials, meshes
from synced_scene import SyncedScene, dump, fresh


class Meshes(unittest.TestCase):
    def setUp(self):
        fresh()

    def extract(self, ob, viewport=False):
        depsgraph = bpy.context.evaluated_depsgraph_get()
        return meshes.extract(ob.evaluated_get(depsgraph), depsgraph, True, viewport, materials.Wanted())

    def test_subdivision_at_the_end_of_the_stack_is_refinement(self):
        scenes.subdivision_with_creases()
        cage = self.extract(bpy.data.objects["cage"], True)
        self.assertEqual((cage["scheme"], cage["refine_level"]), ("catmullClark", 3))
        self.assertEqual(len(cage["counts"]), 10)  # mirrored, and not subdivided
        self.assertAlmostEqual(float(cage["subdiv_tags"]["crease_weights"].max()), 6.4, places=4)
        self.assertTrue(bpy.data.objects["cage"].modifiers["refine"].show_viewport)

    def test_flat_faces_and_modifiers_after_it_are_applied(self):
        scenes.subdivision_with_creases()
        ob = bpy.data.objects["cage"]
        ob.modifiers.new("after", "TRIANGULATE")
        self.assertNotIn("scheme", self.extract(ob, True))
        ob.modifiers.remove(ob.modifiers["after"])
        ob.data.polygons.foreach_set("use_smooth", [False] * len(ob.data.polygons))
        ob.data.update()
        self.assertGreater(len(self.extract(ob, True)["counts"]), 100)

    def test_arrays_are_lent(self):
        mesh = self.extract(scenes.ball(None))
        self.assertFalse(mesh["points"].flags.writeable)
        self.assertEqual((mesh["points"].dtype, mesh["indices"].dtype), (numpy.float32, numpy.int32))

    @unittest.skipIf(meshes.CORNER_NORMALS, "Blender from 4.1 on has a fixed order")
    def test_normals_are_the_same_in_each_frame(self):
        """Blender's own sums differ in the last bits, by the order in which its threads come. Corners beside a sharp edge have sums
        of a fixed order."""
        ball = scenes.ball(None)
        cube = scenes.link("cube", scenes.mesh("cube", scenes.CUBE_POINTS, scenes.CUBE_FACES, smooth=True).data.copy())
        cube.data.use_auto_smooth, cube.data.auto_smooth_angle = True, 3.1
        for edge in cube.data.edges:
            edge.use_edge_sharp = set(edge.vertices) <= set(scenes.CUBE_FACES[0])
        read, random = meshes.array, numpy.random.default_rng(5)

        def other_order(collection, attribute, dtype, width=1):
            values = read(collection, attribute, dtype, width)
            summed = numpy.full(len(values), attribute == "vector")
            if attribute == "normal" and isinstance(collection[0], bpy.types.MeshLoop):
                of_vertices = numpy.array([ob.data.vertices[corner.vertex_index].normal for corner in collection])
                summed = abs(values - of_vertices).max(axis=1) < 1e-5
                self.assertEqual(summed.tolist().count(False), 12)
            if not summed.any():
                return values
            off = random.choice(numpy.array([1 - 6e-8, 1, 1 + 1.2e-7], numpy.float32), values.shape)
            return numpy.where(summed.reshape(-1, *[1] * (values.ndim - 1)), values * off, values)
        for ob in (ball, cube):
            plain = self.extract(ob)["primvars"]["normals"].values
            ours, blenders = meshes.vertex_normals(ob.data), [vertex.normal for vertex in ob.data.vertices]
            numpy.testing.assert_allclose(ours, blenders, atol=2e-6)
            with unittest.mock.patch.object(meshes, "array", other_order):
                numpy.testing.assert_array_equal(self.extract(ob)["primvars"]["normals"].values, plain)

    def test_other_kinds_of_objects(self):
        data = bpy.data.curves.new("text", "FONT")
        data.body, data.extrude = "A", 0.1
        self.assertGreater(len(self.extract(scenes.link("text", data))["counts"]), 4)


def grow(ball):
    ball.data.materials.append(scenes.diffuse("fur"))
    settings = ball.modifiers.new("hair", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count, settings.hair_length, settings.material = "HAIR", 20, 0.5, 2
    settings.display_step = settings.render_step = 3
    settings.root_radius, settings.tip_radius, settings.radius_scale, settings.use_close_tip = 1, 0.5, 0.01, False
    return settings


class Hair(unittest.TestCase):
    def setUp(self):
        fresh()
        self.notes = []

    def furry(self):
        ball = scenes.ball(scenes.diffuse("skin"), (1, 2, 3), radius=1, name="furry")
        return ball, grow(ball)

    def fields(self, ball):
        evaluated = ball.evaluated_get(bpy.context.evaluated_depsgraph_get())
        return hair.of_system(evaluated, next(hair.systems(evaluated, True)), True)

    def test_strands_of_particles_stand_on_their_object_and_thin_out(self):
        ball, settings = self.furry()
        made = self.fields(ball)
        strands = made["points"].reshape(20, 9, 3)
        numpy.testing.assert_allclose(numpy.linalg.norm(strands[:, 0], axis=1), 1, atol=0.01)
        numpy.testing.assert_allclose(numpy.linalg.norm(strands[:, -1], axis=1), 1.5, atol=0.03)
        numpy.testing.assert_allclose(made["widths"][:9], 0.01 - 0.005 * numpy.arange(9) / 8, rtol=1e-5)
        settings.child_type, settings.child_percent = "SIMPLE", 5
        self.assertEqual(len(self.fields(ball)["curve_vertex_counts"]), 100)

    @unittest.skipIf(bpy.app.version < (4, 0, 0), "Blender has no operator that makes them")
    def test_hair_curves_are_curves_with_their_radii(self):
        bpy.ops.object.curves_random_add()
        ob = bpy.context.object.evaluated_get(bpy.context.evaluated_depsgraph_get())
        made = hair.extract(ob, self.notes.append, materials.Wanted())
        self.assertEqual((made["kind"], made["basis"], made["wrap"], self.notes), ("basisCurves", "catmullRom", "pinned", []))
        self.assertEqual(sum(made["curve_vertex_counts"]), len(made["points"]))
        radii = [one.value for one in ob.data.attributes["radius"].data]
        numpy.testing.assert_allclose(made["widths"], 2 * numpy.array(radii, numpy.float32))


    def test_point_clouds_have_the_colours_that_materials_read(self):
        try:
            bpy.ops.object.pointcloud_random_add()
        except AttributeError:
            self.skipTest("Blender has no operator that makes them")
        data = bpy.context.object.data
        tint = data.attributes.new("tint", "FLOAT_COLOR", "POINT")
        tint.data.foreach_set("color", numpy.linspace(0, 1, 4 * len(data.points), dtype=numpy.float32))
        ob = bpy.context.object.evaluated_get(bpy.context.evaluated_depsgraph_get())
        self.assertEqual(hair.extract(ob, self.notes.append, materials.Wanted())["primvars"], {})
        made = hair.extract(ob, self.notes.append, materials.Wanted(colors=frozenset({"tint"})))
        color = made["primvars"]["displayColor"]
        self.assertEqual((made["kind"], color.interpolation, self.notes), ("points", "vertex", []))
        numpy.testing.assert_allclose(color.values, numpy.linspace(0, 1, 4 * len(made["points"])).reshape(-1, 4)[:, :3], rtol=1e-6)


class HairEdits(SyncedScene):
    def places(self):
        """Of the ball and its hair."""
        return {name: place for name, place in re.findall(r"instance (\S+) prim.*\n  transform (.*)", dump(self.watched.scene)) if "own" in name}

    def test_hair_goes_where_its_object_goes_and_with_it(self):
        self.after(lambda: grow(self.ball))
        self.assertEqual((list(self.watched.scene.prims.values()).count("basisCurves"), self.notes), (1, []))
        before = self.places()
        self.assertEqual((len(before), len(set(before.values()))), (2, 1), before)
        self.after(lambda: setattr(self.ball.location, "x", 5))
        after = self.places()
        self.assertEqual((after.keys(), len(set(after.values()))), (before.keys(), 1), after)
        self.assertNotEqual(after, before)
        self.after(lambda: self.ball.modifiers.remove(self.ball.modifiers["hair"]))
        self.assertNotIn("basisCurves", self.watched.scene.prims.values())
