"""Tests of what sees and what lights objects, and of meshes that deform. addon_test.py runs them."""
import re
import subprocess
import tempfile
import types
import unittest

import bpy
import numpy

import role_scenes
import scenes
from alabaster_render import motion, roles, sync
from synced_scene import SyncedScene, Watched, dump, fresh

HELD_OUT, UNSEEN = "  holdout true\n", "  visibleToCamera false\n"


def instances_of(scene):
    """Lines of the dump about each instance."""
    return ("\n" + dump(scene)).split("\nmaterial ")[0].split("\ninstance ")[1:]


class Roles(SyncedScene):
    def own_in(self, name, **options):
        """The ball in a collection of the view layer with these options."""
        held = role_scenes.held_in(name, [self.ball])
        for option, value in options.items():
            setattr(bpy.context.view_layer.layer_collection.children[held.name], option, value)

    def shown(self):
        """Lines of the dump about the ball."""
        return next(part for part in instances_of(self.watched.scene) if part.startswith("/mesh/own "))

    def test_a_hold_out_is_a_mesh(self):
        self.assertNotIn(HELD_OUT, self.shown())
        for value in (True, False):
            calls = self.after(lambda v=value: setattr(self.ball, "is_holdout", v))
            self.assertEqual((calls, HELD_OUT in self.shown()), ([("set_mesh", "/mesh/own")], value))

    def test_a_collection_that_is_held_out(self):
        self.assertEqual(self.after(lambda: self.own_in("held", holdout=True)), [("set_mesh", "/mesh/own")])
        self.assertIn(HELD_OUT, self.shown())

    def test_a_holdout_shader(self):
        def assign():
            self.ball.data.materials[0] = role_scenes.holdout_shader("hole")

        def mend():
            tree = self.ball.data.materials[0].node_tree
            shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
            tree.links.new(shader.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"])
        self.assertIn(("set_mesh", "/mesh/own"), self.after(assign))
        self.assertIn(HELD_OUT, self.shown())
        self.assertEqual(self.after(mend), [("set_material", "/material/hole"), ("set_mesh", "/mesh/own")])
        self.assertNotIn(HELD_OUT, self.shown())
        self.assertEqual(self.notes, [])

    def test_an_edit_inside_a_group_makes_a_hold_out(self):
        group = bpy.data.node_groups.new("inner", "ShaderNodeTree")
        if hasattr(group, "interface"):
            group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
        else:
            group.outputs.new("NodeSocketShader", "Shader")
        end, plain, hole = (group.nodes.new(kind) for kind in ("NodeGroupOutput", "ShaderNodeBsdfDiffuse", "ShaderNodeHoldout"))
        group.links.new(plain.outputs[0], end.inputs[0])
        tree = self.ball.data.materials[0].node_tree
        outer = tree.nodes.new("ShaderNodeGroup")
        outer.node_tree = group
        tree.links.new(outer.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"])
        self.sync.sync(bpy.context.evaluated_depsgraph_get())
        self.after(lambda: None)
        self.assertNotIn(HELD_OUT, self.shown())
        self.after(lambda: group.links.new(hole.outputs[0], end.inputs[0]))
        self.assertIn(HELD_OUT, self.shown())

    def test_a_holdout_shader_beside_another_is_noted(self):
        self.ball.data.materials.append(role_scenes.holdout_shader("hole"))
        self.sync.sync(bpy.context.evaluated_depsgraph_get())
        self.assertNotIn(HELD_OUT, self.shown())
        self.assertIn("Holdout", self.notes[0])

    def test_what_is_not_translated_is_noted(self):
        self.ball.visible_glossy = False
        self.sync.sync(bpy.context.evaluated_depsgraph_get())
        self.assertEqual(["ray visibility" in note for note in self.notes], [True])

    def test_a_shadow_catcher(self):
        self.assertEqual(self.after(lambda: setattr(self.ball, "is_shadow_catcher", True)), [("set_mesh", "/mesh/own")])
        self.assertIn("  shadowCatcher true\n", self.shown())

    def test_what_the_camera_does_not_see(self):
        for edit in (lambda: setattr(self.ball, "visible_camera", False), lambda: self.own_in("indirect", indirect_only=True)):
            self.assertEqual(self.after(edit), [("set_mesh", "/mesh/own")])
            self.assertIn(UNSEEN, self.shown())
            self.ball.visible_camera = True
            self.sync.sync(bpy.context.evaluated_depsgraph_get())

    def test_a_hold_out_among_what_is_only_indirect_is_seen(self):
        self.after(lambda: (self.own_in("indirect", indirect_only=True), setattr(self.ball, "is_holdout", True)))
        self.assertEqual((HELD_OUT in self.shown(), UNSEEN in self.shown()), (True, False))

    def test_what_an_instancer_places_is_seen_as_it_is(self):
        self.after(lambda: setattr(bpy.data.objects["place4"], "visible_camera", False))
        parts = [part for part in instances_of(self.watched.scene) if UNSEEN in part]
        self.assertEqual(sorted({part.split()[0] for part in parts}), ["/mesh/ball#2", "/mesh/cube#2"])


@unittest.skipUnless("lightgroup" in bpy.types.Object.bl_rna.properties, "no light groups before Blender 3.2")
class LightGroups(unittest.TestCase):
    """A ball that a lamp, a glowing plane and the world light, each of a group, and a second lamp of none."""

    def setUp(self):
        fresh()
        scene, layer = bpy.context.scene, bpy.context.view_layer
        scenes.camera((0, -4, 1.5), (0, 0, 0.5))
        scenes.floor(scenes.diffuse("floor"))
        scenes.ball(scenes.diffuse("ball"), (0, 0, 0.6), name="ball")
        lamps = [bpy.data.objects.new(name, bpy.data.lights.new(name, "POINT")) for name in ("warm lamp", "plain lamp")]
        for lamp, place, power, color in zip(lamps, ((-1.5, -2, 2), (1.5, -2, 2.5)), (90, 60), ((1, 0.5, 0.1), (0.2, 1, 0.4))):
            lamp.location, lamp.data.energy, lamp.data.color, lamp.data.shadow_soft_size = place, power, color, 0.3
            scene.collection.objects.link(lamp)
        bpy.ops.mesh.primitive_plane_add(size=1, location=(0, 1.5, 1.5), rotation=(1.2, 0, 0))
        self.screen = bpy.context.object
        glow = bpy.data.materials.new("glow")
        glow.use_nodes = True
        glow.node_tree.nodes.clear()
        output, emission = (glow.node_tree.nodes.new("ShaderNode" + kind) for kind in ("OutputMaterial", "Emission"))
        emission.inputs["Color"].default_value = (0.1, 0.3, 1, 1)
        emission.inputs["Strength"].default_value = 4
        glow.node_tree.links.new(emission.outputs[0], output.inputs["Surface"])
        self.screen.data.materials.append(glow)
        scene.world = bpy.data.worlds.new("sky")
        scene.world.use_nodes = True
        scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.4
        for name in ("warm", "screens", "sky of Überlingen"):
            layer.lightgroups.add(name=name)
        lamps[0].lightgroup, lamps[1].lightgroup, self.screen.lightgroup = "warm", "gone", "screens"
        scene.world.lightgroup = "sky of Überlingen"
        scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 48, 32, 100

    def passes(self, engine):
        """The means of 8 x 8 pixels of each pass, by name."""
        scene = bpy.context.scene
        scene.render.engine = engine
        held = scene.cycles if engine == "CYCLES" else scene.alabaster
        held.samples = 64
        if engine == "CYCLES":
            held.use_denoising = held.use_adaptive_sampling = False
        settings = scene.render.image_settings
        if hasattr(settings, "media_type"):
            settings.media_type = "MULTI_LAYER_IMAGE"  # Blender 5
        settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
        if hasattr(settings, "use_exr_interleave"):
            settings.use_exr_interleave = True  # Blender 5: all layers in one part
        with tempfile.TemporaryDirectory() as folder:
            scene.render.filepath = folder + "/layers.exr"
            bpy.ops.render.render(write_still=True)
            return blocks_of_layers(folder + "/layers.exr")

    def test_passes_are_those_of_cycles(self):
        theirs, ours = self.passes("CYCLES"), self.passes("ALABASTER")
        groups = ["Combined_warm", "Combined_screens", "Combined_sky of Überlingen"]
        self.assertEqual(sorted(name for name in ours if name.startswith("Combined_")), sorted(groups))
        for name in groups:
            self.assertGreater(theirs[name].mean(), 0.01, name)
            self.assertLess(abs(ours[name].mean() / theirs[name].mean() - 1), 0.04, name)
            off = numpy.sqrt(((ours[name] - theirs[name]) ** 2).mean()) / theirs[name].mean()
            self.assertLess(off, 0.12, name)
        for name, both in (("theirs", theirs), ("ours", ours)):
            rest = both["Combined"] - sum(both[group] for group in groups)
            self.assertGreater(rest.mean(), 0.01, f"{name}: the lamp whose group is gone is in no pass")
            self.assertGreater(rest[..., 1].mean(), 2 * rest[..., 0].mean(), name)

    def test_what_has_no_group_is_as_before(self):
        watched, notes = Watched(), []
        exporter = sync.SceneSync(watched, False, notes.append)
        exporter.sync(bpy.context.evaluated_depsgraph_get())
        text = dump(watched.scene)
        self.assertEqual(sorted(line.strip() for line in text.splitlines() if "lightGroup" in line),
                         ["lightGroup screens", "lightGroup sky of Überlingen", "lightGroup warm"])
        while len(bpy.context.view_layer.lightgroups):
            bpy.ops.scene.view_layer_remove_lightgroup()
        exporter.sync(bpy.context.evaluated_depsgraph_get())
        self.assertNotIn("lightGroup", dump(watched.scene))
        self.assertEqual(notes, [])

    def test_too_many_groups_are_noted(self):
        for number in range(70):
            bpy.context.view_layer.lightgroups.add(name=f"group {number}")
        notes = []
        sync.SceneSync(Watched(), False, notes.append).sync(bpy.context.evaluated_depsgraph_get())
        self.assertEqual(notes, [f"of the light groups the first {roles.MOST_GROUPS} are translated"])
        bpy.context.scene.alabaster.samples = 1
        bpy.context.scene.render.engine = "ALABASTER"
        bpy.context.scene.render.resolution_percentage = 25
        bpy.ops.render.render()


def blocks_of_layers(file, size=8):
    """The red, green and blue of each layer as means of blocks. Blender's Python reads one layer, so oiiotool parts them."""
    told = subprocess.run(["oiiotool", "--info", "-v", file], capture_output=True, text=True, check=True).stdout
    names = re.search(r"channel list: (.*)", told).group(1).split(", ")
    found = {}
    for name in names:
        layer = name.removesuffix(".R").removeprefix("ViewLayer.")
        if layer == name or not name.endswith(".R"):
            continue
        part = f"{file}.{len(found)}.exr"
        channels = ",".join(name[:-1] + letter for letter in "RGB")
        subprocess.run(["oiiotool", file, "--ch", channels, "--chnames", "R,G,B", "-o", part], check=True)
        image = bpy.data.images.load(part)
        pixels = numpy.empty(image.size[0] * image.size[1] * 4, numpy.float32)
        image.pixels.foreach_get(pixels)
        pixels = pixels.reshape(image.size[1], image.size[0], 4)[..., :3]
        found[layer] = pixels.reshape(image.size[1] // size, size, -1, size, 3).mean(axis=(1, 3))
    return found


@unittest.skipUnless(roles.LINKS_LIGHT, "lights have no links before Blender 4")
class LightLinks(SyncedScene):
    def link(self, state, objects, kind="receiver_collection", below=False):
        """A collection of objects, or of a collection of them, as a link of the sun."""
        collection = held = bpy.data.collections.new("links")
        if below:
            held = bpy.data.collections.new("below")
            collection.children.link(held)
        for ob in objects:
            held.objects.link(ob)
        for entry in collection.collection_children if below else collection.collection_objects:
            entry.light_linking.link_state = state
        setattr(bpy.data.objects["SUN"].light_linking, kind, collection)
        self.sync.sync(bpy.context.evaluated_depsgraph_get())

    def linked(self):
        return sorted({part.split()[0] for part in instances_of(self.watched.scene) if "  category collection links\n" in part})

    def test_included_objects_alone(self):
        self.link("INCLUDE", [self.ball])
        self.assertEqual(self.linked(), ["/mesh/own"])

    def test_objects_of_a_collection_that_is_included(self):
        self.link("INCLUDE", [self.ball], below=True)
        self.assertEqual(self.linked(), ["/mesh/own"])

    def test_all_but_excluded_objects(self):
        self.link("EXCLUDE", [self.ball])
        self.assertEqual(self.linked(), ["/mesh/ball", "/mesh/cube", "/mesh/floor"])

    def test_an_instancer_is_linked_with_what_it_places(self):
        self.link("INCLUDE", [bpy.data.objects["place4"]], "blocker_collection")
        self.assertEqual(self.linked(), ["/mesh/ball#2", "/mesh/cube#2"])

    def test_a_link_is_a_light_and_meshes(self):
        calls = self.after(lambda: self.link("INCLUDE", [self.ball]))
        self.assertEqual({call for call in calls if call[0] != "set_instancer"} - {("set_mesh", "/mesh/own")}, {("set_light", "/light/SUN")})


class Deformation(unittest.TestCase):
    def setUp(self):
        fresh()
        self.notes = []

    def sampled(self):
        """The library's scene of the frame, after the shutter's poses were taken."""
        scene, watched = bpy.context.scene, Watched()
        made = sync.SceneSync(watched, False, self.notes.append)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        engine = types.SimpleNamespace(frame_set=lambda frame, part: scene.frame_set(frame, subframe=part))
        motion.sample(engine, depsgraph, motion.Shutter(scene), made)
        made.sync(bpy.context.evaluated_depsgraph_get())
        return made

    def test_shape_keys_and_armatures_have_poses(self):
        role_scenes.deforming_meshes()
        bpy.data.objects["soft"].modifiers["refine"].show_viewport = False  # the depsgraph at hand is a viewport's
        made = self.sampled()
        self.assertEqual(sorted(key[1] for key in made.deformation), ["bar", "soft", "tall"])
        key = next(key for key in made.deformation if key[1] == "tall")
        times, heights = zip(*((time, float(pose["points"][:, 2].max())) for time, pose in made.deformation[key]))
        self.assertEqual(times, (-0.5, -0.25, 0.0, 0.25, 0.5))
        for time, height in zip(times, heights):
            self.assertAlmostEqual(height, 1.0 + 0.25 * (1 + time), places=5)
        self.assertEqual(len(made.deformation[("object", "soft")][0][1]["counts"]), 6)  # the cage, which the library refines
        self.assertEqual(self.notes, [])

    def test_what_stands_still_has_no_poses(self):
        role_scenes.deforming_meshes()
        bpy.data.objects["tall"].data.shape_keys.animation_data_clear()
        self.assertEqual(sorted(key[1] for key in self.sampled().deformation), ["bar", "soft"])

    def test_new_faces_are_noted(self):
        role_scenes.deforming_meshes()
        bevel = bpy.data.objects["bar"].modifiers.new("array", "ARRAY")
        for frame, count in ((0, 1), (1, 2), (2, 3)):
            bevel.count = count
            bevel.keyframe_insert("count", frame=frame)
        self.sampled()
        self.assertEqual(["'bar'" in note and "faces change" in note for note in self.notes], [True])
