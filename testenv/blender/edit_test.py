"""Tests of the calls that edits make. addon_test.py runs them."""
import bpy

import hdalabaster
import scenes
from alabaster_render import motion, sync, world
from synced_scene import SyncedScene, dump


class Edits(SyncedScene):
    """The calls that an edit makes, and no more."""

    def test_nothing(self):
        self.assertEqual(self.after(lambda: None), [])

    def test_a_move_is_a_transform(self):
        self.assertEqual(self.after(lambda: setattr(self.ball.location, "x", 1)), [("set_transform", "/mesh/own")])

    def test_a_colour_is_a_material(self):
        def edit():
            self.ball.data.materials[0].node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0.1, 0.9, 0.1, 1)
        self.assertEqual(self.after(edit), [("set_material", "/material/own")])

    def test_a_light_is_a_light(self):
        self.assertEqual(self.after(lambda: setattr(bpy.data.objects["SUN"].data, "energy", 9)), [("set_light", "/light/SUN")])
        self.assertEqual(self.after(lambda: setattr(bpy.data.objects["SUN"].location, "x", 3)), [("set_light", "/light/SUN")])

    def test_points_are_a_mesh(self):
        def edit():
            self.ball.data.vertices[0].co.z += 1
            self.ball.data.update()
        self.assertEqual(self.after(edit), [("set_mesh", "/mesh/own")])

    def test_an_instancer_that_moves_is_its_instancers(self):
        calls = self.after(lambda: setattr(bpy.data.objects["place4"].location, "z", 2))
        self.assertEqual({name for name, _ in calls}, {"set_instancer"})
        self.assertEqual(len(calls), 2)  # of the cubes and of the balls

    def test_removed_and_added(self):
        self.assertEqual(self.after(lambda: bpy.data.objects.remove(self.ball)), [("remove", "/mesh/own")])
        calls = self.after(lambda: scenes.ball(scenes.diffuse("new"), (0, 0, 3), name="new"))
        self.assertEqual(calls, [("set_material", "/material/new"), ("set_mesh", "/mesh/new")])

    def test_world(self):
        def edit():
            bpy.context.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 2
        self.assertEqual(self.after(edit), [("set_light", "/world")])

    def test_instances_share_their_mesh(self):
        meshes_set = [path for path, kind in self.watched.scene.prims.items() if kind == "mesh"]
        self.assertEqual(sorted(meshes_set), ["/mesh/ball", "/mesh/cube", "/mesh/floor", "/mesh/own"])

    def test_lights_of_two_instancers_are_two(self):
        held = bpy.data.collections.new("lamps")
        lamp = scenes.light("POINT", 10, (0, 0, 1))
        bpy.context.scene.collection.objects.unlink(lamp)
        held.objects.link(lamp)
        parents = [scenes.link(name, None, (x, 0, 0)) for name, x in (("left", -1), ("right", 1))]
        for parent in parents:
            parent.instance_type, parent.instance_collection = "COLLECTION", held
        self.sync.sync(bpy.context.evaluated_depsgraph_get())
        lamps = [transform for path, (_, transform, _) in
                 ((path, made) for path, made in self.sync.set_lights.items() if path.startswith("/light/POINT/"))]
        self.assertEqual(sorted(transform[3][0] for transform in lamps), [-1, 1])

    def test_places_of_two_instancers_are_two(self):
        owners = [owner for owner, _ in motion.places(bpy.context.evaluated_depsgraph_get())]
        self.assertEqual(len(owners), len(set(owners)))

    def test_subsurface_set(self):
        def edit():
            held = bpy.data.collections.new("skin")
            bpy.context.scene.collection.children.link(held)
            held.objects.link(self.ball)
            held.alabaster.subsurface_set = True
            self.ball.data.materials[0] = scenes.principled("wax", Subsurface=1.0)
        self.assertIn(("set_mesh", "/mesh/own"), self.after(edit))
        self.assertTrue("subsurfaceSet named skin" in dump(self.watched.scene))
