"""Tests of the add-on. Runs inside Blender (blender -b -P) or with the module bpy: run_blender.py starts it.

Arguments: a JSON file with addon, module and zip.
"""
import gc
import json
import os
import pathlib
import sys
import tempfile
import threading
import time
import types
import unittest
import unittest.mock
import weakref

HERE = pathlib.Path(__file__).resolve().parent
arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
job = json.loads(pathlib.Path(arguments[0]).read_text())
sys.path[:0] = [str(HERE), job["addon"], job["module"]]

import bpy  # noqa: E402
import numpy  # noqa: E402

import alabaster  # noqa: E402
import alabaster_render  # noqa: E402
import scenes  # noqa: E402
import subsurface_widths  # noqa: E402
from role_test import Deformation, LightLinks, Roles  # noqa: E402, F401
from synced_scene import SyncedScene, Watched, dump, fresh  # noqa: E402
from alabaster_render import (disney_group, engine, images, library, materials, meshes, motion, panels, passes, presets,  # noqa: E402
                              schema, settings, subsurface, sync, world)


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

    def test_other_kinds_of_objects(self):
        data = bpy.data.curves.new("text", "FONT")
        data.body, data.extrude = "A", 0.1
        self.assertGreater(len(self.extract(scenes.link("text", data))["counts"]), 4)


class Materials(unittest.TestCase):
    def setUp(self):
        fresh()
        self.notes = []

    def translate(self, material):
        return materials.translate(material, self.notes.append)

    def test_group_has_the_schema_s_ranges(self):
        tree = disney_group.tree()
        sockets = ([one for one in tree.interface.items_tree if one.in_out == "INPUT"] if disney_group.MODERN else tree.inputs)
        held = {one.name: one for one in sockets}
        for name, p in schema.parameters("disney_material").items():
            self.assertEqual(held[name].description[:60], p.description[:60])  # Blender 3 keeps 63 bytes
            if p.kind == "float":
                self.assertAlmostEqual(held[name].default_value, p.default, places=5)
                if p.minimum is None:
                    self.assertLess(held[name].min_value, -1e30)
                else:
                    self.assertAlmostEqual(held[name].min_value, p.minimum, places=5)
                if p.maximum is not None:
                    self.assertAlmostEqual(held[name].max_value, p.maximum, places=5)
        self.assertIs(disney_group.tree(), tree)

    def test_group_becomes_its_parameters(self):
        material = bpy.data.materials.new("ours")
        node = disney_group.assign(material)
        self.assertEqual(self.translate(material).nodes["surface"], {"thin": False, "priority": 0})
        node.inputs["scatterDistance"].default_value = (0.5, 0.25, 0.125)
        node.inputs["roughness"].default_value = 0.25
        node.inputs["thin"].default_value = True
        surface = self.translate(material).nodes["surface"]
        self.assertEqual((surface["scatterDistance"], surface["roughness"], surface["thin"]), ((0.5, 0.25, 0.125), 0.25, True))

    def test_what_is_not_translated_is_noted(self):
        material = scenes.principled("noisy")
        tree = material.node_tree
        noise = tree.nodes.new("ShaderNodeTexNoise")
        tree.links.new(noise.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
        self.translate(material)
        self.assertEqual(len(self.notes), 1)
        self.assertIn("Noise Texture", self.notes[0])

    def test_arithmetic_of_textures(self):
        material = scenes.principled("inverted")
        tree = material.node_tree
        texture, invert, times = (tree.nodes.new(kind) for kind in ("ShaderNodeTexImage", "ShaderNodeInvert", "ShaderNodeMath"))
        texture.image = scenes.picture("grey", 4, 4, lambda u, v: (u, u, u), space="Non-Color")
        times.operation = "MULTIPLY"
        times.inputs[1].default_value = 0.5
        tree.links.new(texture.outputs["Color"], invert.inputs["Color"])
        tree.links.new(invert.outputs[0], times.inputs[0])
        tree.links.new(times.outputs[0], tree.nodes["Principled BSDF"].inputs["Roughness"])
        network = self.translate(material)
        (name, channel), = network.nodes["surface"]["roughness"]
        node = network.nodes[name]
        self.assertEqual((node["scale"][:3], node["bias"][:3], node["sourceColorSpace"]), ((-0.5,) * 3, (0.5,) * 3, "raw"))
        self.assertTrue(pathlib.Path(node["file"]).stat().st_size > 4 * 4 * 16)
        self.assertEqual(channel, "g")

    def test_bump(self):
        material = scenes.principled("bumpy")
        tree = material.node_tree
        texture, bump = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeBump")
        texture.image = scenes.picture("height", 4, 4, lambda u, v: (u, u, u))
        bump.inputs["Strength"].default_value, bump.inputs["Distance"].default_value = 0.5, 0.25
        tree.links.new(texture.outputs["Color"], bump.inputs["Height"])
        tree.links.new(bump.outputs[0], tree.nodes["Principled BSDF"].inputs["Normal"])
        network = self.translate(material)
        (name, channel), = network.nodes["surface"]["bump"]
        self.assertEqual((network.nodes[name]["scale"][0], channel, self.notes), (0.125, "r", []))

    def test_a_painted_image_is_another_file(self):
        image = scenes.picture("painted", 4, 4, lambda u, v: (u, v, 0))
        first, _ = images.file_of(image, self.notes.append)
        self.assertEqual(images.file_of(image, self.notes.append)[0], first)
        image.pixels[0] = 0.75
        second, _ = images.file_of(image, self.notes.append)
        self.assertNotEqual(second, first)
        self.assertFalse(pathlib.Path(first).exists())

    def test_a_packed_image_of_the_same_size_is_another_file(self):
        def packed(data):
            file = types.SimpleNamespace(size=len(data), data=data)
            space = types.SimpleNamespace(name="sRGB", is_data=False)
            image = types.SimpleNamespace(name_full="packed", source="FILE", packed_file=file, is_dirty=False, filepath_raw="a.png",
                                          colorspace_settings=space, file_format="PNG")
            return pathlib.Path(images.file_of(image, self.notes.append)[0]).read_bytes()
        self.assertEqual([packed(b"one"), packed(b"two")], [b"one", b"two"])

    def math(self, operation, *numbers, clamp=False):
        """The roughness of a surface that a Math node of constants is linked to."""
        material = scenes.principled("math")
        tree = material.node_tree
        node = tree.nodes.new("ShaderNodeMath")
        node.operation, node.use_clamp = operation, clamp
        for socket, number in zip(node.inputs, numbers):
            socket.default_value = number
        tree.links.new(node.outputs[0], tree.nodes["Principled BSDF"].inputs["Roughness"])
        return self.translate(material).nodes["surface"]["roughness"]

    def test_powers_without_a_value_are_noted(self):
        self.math("POWER", 1e30, 1e30)
        self.math("POWER", 0, -1)
        self.assertEqual(["is not translated" in note for note in self.notes], [True, True])

    def test_clamped_math(self):
        self.assertEqual((self.math("ADD", 0.75, 0.5, clamp=True), self.notes), (1.0, []))
        material = scenes.principled("clamped")
        tree = material.node_tree
        texture, twice = (tree.nodes.new(kind) for kind in ("ShaderNodeTexImage", "ShaderNodeMath"))
        texture.image = scenes.picture("clamped", 4, 4, lambda u, v: (u, u, u))
        twice.operation, twice.use_clamp = "MULTIPLY", True
        twice.inputs[1].default_value = 2
        tree.links.new(texture.outputs["Color"], twice.inputs[0])
        tree.links.new(twice.outputs[0], tree.nodes["Principled BSDF"].inputs["Roughness"])
        self.translate(material)
        self.assertEqual(["clamp" in note for note in self.notes], [True])

    def test_sum_of_two_emissions(self):
        material = bpy.data.materials.new("sum")
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        one, two, both, output, texture = (tree.nodes.new(f"ShaderNode{kind}") for kind in (
            "Emission", "Emission", "AddShader", "OutputMaterial", "TexImage"))
        for node, strength in ((one, 1), (two, 2)):
            node.inputs["Color"].default_value, node.inputs["Strength"].default_value = (0.5, 0.25, 0.0, 1), strength
        tree.links.new(one.outputs[0], both.inputs[0])
        tree.links.new(two.outputs[0], both.inputs[1])
        tree.links.new(both.outputs[0], output.inputs["Surface"])
        self.assertEqual((self.translate(material).nodes["surface"]["emission"], self.notes), ((1.5, 0.75, 0.0), []))
        texture.image = scenes.picture("glow", 4, 4, lambda u, v: (u, u, u))
        tree.links.new(texture.outputs["Color"], one.inputs["Color"])
        self.translate(material)
        self.assertEqual(["two emissions" in note for note in self.notes], [True])

    def test_a_volume_alone_is_left_out(self):
        material = bpy.data.materials.new("fog")
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        output, volume = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeVolumePrincipled")
        tree.links.new(volume.outputs[0], output.inputs["Volume"])
        network = self.translate(material)
        self.assertEqual((network.left_out, network.nodes["surface"]["opacity"], len(self.notes)), (True, 0.0, 1))
        watched = Watched()
        scenes.ball(material, name="fog")
        both = scenes.ball(material, name="both")
        both.data.materials.append(scenes.diffuse("skin"))
        sync.SceneSync(watched, False, self.notes.append).sync(bpy.context.evaluated_depsgraph_get())
        self.assertEqual([path for path, kind in watched.scene.prims.items() if kind == "mesh"], ["/mesh/both"])

    def test_a_missing_image_is_magenta(self):
        image = bpy.data.images.new("gone", 4, 4)
        image.source, image.filepath = "FILE", "/nowhere/gone.png"
        material = scenes.principled("textured")
        tree = material.node_tree
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        tree.links.new(texture.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
        tree.links.new(texture.outputs["Alpha"], tree.nodes["Principled BSDF"].inputs["Alpha"])
        surface = self.translate(material).nodes["surface"]
        self.assertEqual((surface["baseColor"], surface.get("opacity", 1.0)), ((1.0, 0.0, 1.0), 1.0))
        self.assertTrue(all("/nowhere/gone.png" in note for note in self.notes) and self.notes)
        world_of, background = scenes.sky((1, 1, 1))
        sky = world_of.node_tree.nodes.new("ShaderNodeTexEnvironment")
        sky.image = image
        world_of.node_tree.links.new(sky.outputs["Color"], background.inputs["Color"])
        parameters = world.translate(bpy.context.scene, world_of, self.notes.append)[1]
        self.assertEqual((parameters["color"], "texture:file" in parameters), ([1.0, 0.0, 1.0], False))

    def test_an_image_of_one_colour_scatters_as_the_constant(self):
        """Distances take no texture: they are those of the mean, and an image of one colour is its mean."""
        color, radius = (0.8, 0.5, 0.25), (0.5, 0.25, 0.125)

        def body(links=None):
            material = scenes.principled("body", Subsurface=1.0, Subsurface_Radius=radius, Base_Color=color)
            tree = material.node_tree
            node = tree.nodes["Principled BSDF"]
            if scenes.MODERN:
                node.inputs["Subsurface Scale"].default_value = 0.5
            else:
                node.inputs["Subsurface Color"].default_value = (*color, 1)
            for name, pixel in (links or {}).items():
                texture = tree.nodes.new("ShaderNodeTexImage")
                texture.image = scenes.picture(name, 4, 4, pixel, True, "Non-Color")
                tree.links.new(texture.outputs["Color"], node.inputs[name])
            self.notes.clear()
            return self.translate(material).nodes["surface"]["scatterDistance"]
        expected = body()
        colours = ["Base Color"] if scenes.MODERN else ["Base Color", "Subsurface Color"]
        self.assertEqual(body(links={name: lambda u, v: color for name in colours}), expected)
        self.assertEqual((body(links={"Subsurface Radius": lambda u, v: radius}), self.notes), (expected, []))
        if scenes.MODERN:
            self.assertEqual((body(links={"Subsurface Scale": lambda u, v: (0.5,) * 3}), self.notes), (expected, []))
        uneven = body(links={"Subsurface Radius": lambda u, v: tuple(r * (0.5 if u < 0.5 else 1.5) for r in radius)})
        for a, b in zip(uneven, expected):
            self.assertAlmostEqual(a, b, places=6)
        self.assertEqual(["radius" in note for note in self.notes], [True])

    def test_subsurface_radius(self):
        """The rules by version and method; --widths measures that they are Cycles'."""
        walk = "RANDOM_WALK" if scenes.MODERN else "RANDOM_WALK_FIXED_RADIUS"
        whole = bpy.app.version >= (5, 2, 0)
        self.assertAlmostEqual(subsurface.mean_free_path(walk, 1.0, 0.8, 1.4), 1.0 if whole else 0.0795775, places=6)
        if whole:
            self.assertAlmostEqual(subsurface.mean_free_path("RANDOM_WALK_LEGACY", 1.0, 0.8, 1.4), 0.0795775, places=6)
            self.assertAlmostEqual(subsurface.distances("RANDOM_WALK", [1.1] * 3, [0.8] * 3, 1.4, 0.5)[0], 2.0, places=6)
        # A = 0.8 makes the factor of Chiang, Kutz and Burley 1.1.
        self.assertAlmostEqual(subsurface.scatter_distance(1.1, 0.8), 1.0, places=6)
        # Christensen and Burley's profile is as wide for every albedo.
        burley = subsurface.distances("BURLEY", [1.0] * 3, [0.2, 0.5, 0.8], 1.4)
        self.assertEqual([round(d, 6) for d in burley], [0.079577] * 3)


class Frames(unittest.TestCase):
    def setUp(self):
        fresh()
        scenes.principled_diffuse()
        scene = bpy.context.scene
        scene.alabaster.samples = 2
        scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 40, 30, 100

    def test_passes(self):
        layer = bpy.context.view_layer
        layer.use_pass_z = layer.use_pass_normal = layer.use_pass_vector = True
        for aov in set(settings.PASSES) - {"denoised"}:
            setattr(layer.alabaster, aov, True)
        render = bpy.context.scene.render
        if hasattr(render.image_settings, "media_type"):
            render.image_settings.media_type = "MULTI_LAYER_IMAGE"  # Blender 5
        render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
        with tempfile.TemporaryDirectory() as folder:
            render.filepath = folder + "/layers.exr"
            bpy.ops.render.render(write_still=True)
            header = (pathlib.Path(folder) / "layers.exr").read_bytes()[:8000]
        for name in ("Combined.R", "Depth.Z", "Normal.X", "Vector.X", "Diffuse.R", "Albedo.G", "Sample Count.X",
                     "Nonfinite Samples.X", "Subsurface Unscattered.B"):
            self.assertTrue(name.encode() in header, name)

    def test_passes_have_their_values(self):
        held = types.SimpleNamespace(channels=1, rect=types.SimpleNamespace(foreach_set=lambda values: kept.append(values.copy())))
        kept = []
        passes.fill(held, numpy.array([[0.0, 2.0]], numpy.float32), "cameraDepth")
        self.assertEqual(kept[0].reshape(-1).tolist(), [numpy.float32(passes.FAR), 2.0])

    def test_border(self):
        render = bpy.context.scene.render
        render.use_border, render.use_crop_to_border = True, True
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.5, 1.0
        render.image_settings.file_format = "OPEN_EXR"
        with tempfile.TemporaryDirectory() as folder:
            render.filepath = folder + "/part.exr"
            bpy.ops.render.render(write_still=True)
            image = bpy.data.images.load(folder + "/part.exr")
            self.assertEqual(tuple(image.size), (20, 15))

    def pixels(self, file_name="frame.exr"):
        """F12's picture, rows from the bottom."""
        render = bpy.context.scene.render
        render.image_settings.file_format, render.image_settings.color_mode = "OPEN_EXR", "RGBA"
        with tempfile.TemporaryDirectory() as folder:
            render.filepath = f"{folder}/{file_name}"
            bpy.ops.render.render(write_still=True)
            image = bpy.data.images.load(render.filepath)
            pixels = numpy.empty(image.size[0] * image.size[1] * 4, numpy.float32)
            image.pixels.foreach_get(pixels)
            return pixels.reshape(image.size[1], image.size[0], 4)

    def test_borders_cut_where_blender_cuts(self):
        """The picture within a border is the full frame's, pixel by pixel."""
        render = bpy.context.scene.render
        random = numpy.random.default_rng(7)
        cases = [(100, 100, 100, (0.29, 0.57, 0.2, 0.7)), (97, 61, 50, (0.1, 0.9, 0.3, 0.6))]
        cases += [(int(w), int(h), int(p), tuple(sorted(x)) + tuple(sorted(y))) for w, h, p, x, y in zip(
            random.integers(40, 120, 6), random.integers(30, 90, 6), random.integers(40, 101, 6),
            random.uniform(0, 1, (6, 2)).round(2), random.uniform(0, 1, (6, 2)).round(2))]
        for width, height, percentage, (left, right, bottom, top) in cases:
            render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, percentage
            render.pixel_aspect_x = 1.5 if width % 2 else 1.0
            render.use_border = False
            full = self.pixels()
            render.use_border = True
            render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = left, right + 0.1, bottom, top + 0.1
            part = self.pixels()
            ys, xs = numpy.nonzero(part[..., 3] > 0)
            self.assertGreater(len(ys), 0)
            inside = slice(ys.min(), ys.max() + 1), slice(xs.min(), xs.max() + 1)
            case = width, height, percentage, left, right, bottom, top
            self.assertLess(float(abs(full[inside] - part[inside]).max()), 1e-6, case)  # the last bit may differ; a pixel off is 0.1

    def glowing(self, space, file):
        """A plane before the camera that glows with an image in this space."""
        fresh()
        scenes.camera((0, 0, 2), (0, 0, 0))
        image = bpy.data.images.load(file)
        image.colorspace_settings.name = space
        material = bpy.data.materials.new("glow")
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        texture, glow, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexImage", "Emission", "OutputMaterial"))
        texture.image = image
        tree.links.new(texture.outputs["Color"], glow.inputs["Color"])
        tree.links.new(glow.outputs[0], output.inputs["Surface"])
        scenes.floor(material).data.uv_layers.new(name="map")
        render = bpy.context.scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = 8, 8, 100

    def test_colour_spaces_are_blenders(self):
        """In each of Blender's spaces Cycles gives the same colour."""
        names = [item.identifier for item in bpy.types.ColorManagedInputColorspaceSettings.bl_rna.properties["name"].enum_items]
        with tempfile.TemporaryDirectory() as folder:
            fresh()
            made = scenes.picture("coloured", 4, 4, lambda u, v: (0.5, 0.25, 0.125))
            made.filepath_raw, made.file_format = f"{folder}/coloured.png", "PNG"
            made.save()
            for space in names:
                self.glowing(space, f"{folder}/coloured.png")
                bpy.context.scene.alabaster.samples = bpy.context.scene.cycles.samples = 2
                ours = self.pixels()[4, 4, :3]
                bpy.context.scene.render.engine, bpy.context.scene.cycles.use_denoising = "CYCLES", False
                theirs = self.pixels()[4, 4, :3]
                # Ours emits no negative light.
                numpy.testing.assert_allclose(ours, numpy.maximum(theirs, 0), rtol=0.01, atol=2e-3, err_msg=space)

    @unittest.skipUnless(hasattr(bpy.data, "colorspace"), "Blender before 5.0")
    def test_images_in_another_working_space(self):
        with tempfile.TemporaryDirectory() as folder:
            fresh()
            made = scenes.picture("coloured", 4, 4, lambda u, v: (0.5, 0.25, 0.125))
            made.filepath_raw, made.file_format = f"{folder}/coloured.png", "PNG"
            made.save()
            for space in ("sRGB", "Linear Rec.709", "Non-Color"):
                self.glowing(space, f"{folder}/coloured.png")
                bpy.ops.wm.set_working_color_space(working_space="ACEScg", convert_colors=True)
                scene = bpy.context.scene
                scene.alabaster.samples = scene.cycles.samples = 2
                ours = self.pixels()[4, 4, :3]
                scene.render.engine, scene.cycles.use_denoising = "CYCLES", False
                numpy.testing.assert_allclose(ours, self.pixels()[4, 4, :3], rtol=0.01, err_msg=space)

    def test_f12_without_an_image_or_a_denoiser(self):
        image = bpy.data.images.new("gone", 4, 4)
        image.source, image.filepath = "FILE", "/nowhere/gone.png"
        material = scenes.principled("textured")
        tree = material.node_tree
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        tree.links.new(texture.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
        scenes.ball(material)
        bpy.context.scene.alabaster.denoise = True
        bpy.context.view_layer.alabaster.denoised = True
        with unittest.mock.patch.dict(os.environ, {"ALABASTER_OIDN": "/nowhere"}):
            self.assertEqual(self.pixels().shape, (30, 40, 4))

    def test_a_damaged_image_is_a_warning(self):
        told = []
        notes = engine.Notes(types.SimpleNamespace.__class__)
        with unittest.mock.patch.object(engine.Notes, "tell", lambda _, severity, text: told.append(severity)):
            notes.hear("error", "image.unreadable", "a.png", "is damaged")
        self.assertEqual(told, ["WARNING"])

    def test_a_scene_that_memory_does_not_hold_fails(self):
        renderer = types.SimpleNamespace(stats=lambda: {"scene.outOfMemory": True, "scene.faults": "mesh: too large\nmore"})
        with self.assertRaisesRegex(RuntimeError, "^mesh: too large$"):
            engine.AlabasterRenderEngine.check(None, types.SimpleNamespace(state="running"), renderer)

    def test_cancel_is_prompt(self):
        scene = alabaster.Scene()
        scene.set_light("/dome", "domeLight", intensity=1)
        renderer = alabaster.Renderer(scene, samples=1 << 20)
        render = renderer.start(width=256, height=256, camera={"focalLength": 1.0})
        pressed = time.monotonic() + 0.5
        shown = []
        fake = types.SimpleNamespace(check=lambda *_: None, test_break=lambda: time.monotonic() > pressed, update_stats=lambda *_: None,
                                     update_progress=lambda _: None, show=lambda *rest: shown.append(rest[-1]))
        engine.AlabasterRenderEngine.refine(fake, renderer, render, None, [], (0, 0, 256, 256))
        self.assertLess(time.monotonic() - pressed, 1.0)
        self.assertEqual((render.state, shown[-1]), ("stopped", True))

    def test_unregistering_ends_frames_first(self):
        """Blender frees the engine below the threads that render with it."""
        frames, told = engine.Frames(), []
        frames.open()

        def render():
            with frames.one():
                while not frames.closed:
                    time.sleep(0.01)
                time.sleep(0.1)
                told.append("over")
        thread = threading.Thread(target=render)
        thread.start()
        while not frames.number:
            time.sleep(0.01)
        frames.close()
        told.append("closed")
        thread.join()
        self.assertEqual(told, ["over", "closed"])
        closing = time.monotonic() + 0.5
        fake = types.SimpleNamespace(check=lambda *_: None, test_break=lambda: time.monotonic() > closing and self.fail("goes on"),
                                     update_stats=lambda *_: None, update_progress=lambda _: None, show=lambda *_: None)
        renderer = types.SimpleNamespace(command=lambda _: None, stats=dict, progress=lambda: {"samples_total": 0, "fraction": 0.0})
        with unittest.mock.patch.object(engine, "frames", frames):
            engine.AlabasterRenderEngine.refine(fake, renderer, types.SimpleNamespace(wait=lambda _: False, cancel=lambda: None), None, [],
                                                (0, 0, 8, 8))

    def test_noise_is_told_while_a_picture_refines(self):
        scene = alabaster.Scene()
        scene.set_light("/dome", "domeLight", intensity=1)
        scene.set_mesh("/floor", [(-1, -1, -3), (1, -1, -3), (0, 1, -3)], [[0, 1, 2]])
        renderer = alabaster.Renderer(scene, samples=1 << 20)
        render = renderer.start(width=64, height=64, camera={"focalLength": 1.0})
        end = time.monotonic() + 60
        while "Noise" not in engine.status(renderer)[0] and time.monotonic() < end:
            render.wait(0.05)
        self.assertRegex(engine.status(renderer)[0], r"^Sample \d+/1048576 \| Noise [\d.]+ %")
        render.cancel()

    def test_keyed_settings_and_world_move(self):
        scene = bpy.context.scene
        strength = scene.world.node_tree.nodes["Background"].inputs["Strength"]
        for frame in (1, 2):
            scene.alabaster.samples, strength.default_value = frame, 0.25 * frame
            scene.alabaster.keyframe_insert("samples", frame=frame)
            strength.keyframe_insert("default_value", frame=frame)
        scene.frame_start, scene.frame_end = 1, 2
        scene.frame_set(1)
        heard = []

        def told(function, name):
            def call(*args):
                made = function(*args)
                heard.append((made[1] if isinstance(made, tuple) else made)[name])
                if name == "samples":
                    heard.append(made["frame"])
                return made
            return call
        with tempfile.TemporaryDirectory() as folder, \
                unittest.mock.patch.object(settings, "delegate_settings", told(settings.delegate_settings, "samples")), \
                unittest.mock.patch.object(world, "translate", told(world.translate, "intensity")):
            scene.render.filepath = folder + "/"
            bpy.ops.render.render(animation=True)
        self.assertEqual(heard, [0.25, 1, 1, 0.5, 2, 2])

    def test_a_viewport_goes_with_its_engine(self):
        fake = type("Engine", (), {})()
        view = engine.AlabasterRenderEngine.viewport(fake)
        view.begin(bpy.context.evaluated_depsgraph_get(), None)
        held = weakref.ref(fake)
        del fake, view
        gc.collect()
        self.assertIsNone(held())

    def test_a_picture_that_comes_while_one_is_shown_is_shown_next(self):
        class Render:
            """A second picture comes right after the first was copied."""
            generation = 1

            def __getitem__(self, _):
                return self

            def show(self, _, pixels, **__):
                pixels[:] = self.generation
                self.generation = 2
                return True
        view = engine.Viewport(types.SimpleNamespace.__class__, None, None)
        view.render, view.frame = Render(), {"width": 2, "height": 2}
        drawn = []
        with unittest.mock.patch.object(view.take.__globals__["gpu"], "types", types.SimpleNamespace(
                Buffer=lambda _, __, data: data.copy(), GPUTexture=lambda *_, data, **__: drawn.append(data[0]) or data)):
            view.take()
            view.take()
            view.take()
        self.assertEqual(drawn, [1, 2])

    def test_errors_reach_the_panel(self):
        bpy.context.scene.camera = None
        with self.assertRaises(RuntimeError) as raised:
            bpy.ops.render.render()
        self.assertIn("camera", str(raised.exception))


class Widths(unittest.TestCase):
    def test_walks_are_as_wide_as_cycles(self):
        """By a shadow's edge: the mean of a picture hardly depends on the distance. With a radius wrong by 4 pi this fails by a factor of 10."""
        with tempfile.TemporaryDirectory() as folder:
            job = {"out": folder, "samples": 64, "columns": 96, "rows": 8}
            for method in subsurface_widths.methods(bpy.types.ShaderNodeBsdfPrincipled, "subsurface_method"):
                row = subsurface_widths.measure(job, method, lambda: subsurface_widths.principled(method))[1]
                theirs, ours = (row[engine]["widths"] for engine in ("CYCLES", "ALABASTER"))
                self.assertTrue(all(ours[:3]) and all(theirs[:3]), row)
                self.assertLess(abs(numpy.log(numpy.divide(ours[:3], theirs[:3]))).mean(), 0.3, row)


class Panels(unittest.TestCase):
    def setUp(self):
        fresh()

    def drawn(self, panel):
        """(data, name) of each control of a panel."""
        shown = []

        class Layout:
            def prop(self, data, name, **_):
                shown.append((data, name))

            def __getattr__(self, _):
                return lambda *_, **__: self
        context = types.SimpleNamespace(scene=bpy.context.scene, view_layer=bpy.context.view_layer, collection=bpy.context.scene.collection)
        panel.draw(types.SimpleNamespace(layout=Layout(), blocks=getattr(panel, "blocks", None)), context)
        return shown

    def test_each_has_its_own_drawing(self):
        """Blender takes a class its drawing where a subclass of it is registered."""
        for panel in panels.CLASSES:
            self.assertIs(getattr(bpy.types, panel.__name__, panel), panel)

    def test_controls(self):
        for panel in panels.CLASSES:
            if issubclass(panel, bpy.types.Panel):
                for data, name in self.drawn(panel):
                    self.assertIn(name, data.bl_rna.properties, panel.__name__)
        sampling = {name for _, name in self.drawn(panels.ALABASTER_PT_sampling)}
        self.assertLessEqual({"quality", "samples", "targetError", "timeLimit", "adaptive", "denoise", "seed", "viewport_samples"}, sampling)
        shown = {name for panel in (panels.ALABASTER_PT_sampling, panels.ALABASTER_PT_paths, panels.ALABASTER_PT_subsurface,
                                    panels.ALABASTER_PT_more) for _, name in self.drawn(panel)}
        self.assertEqual(shown, {*settings.SETTINGS, "quality", "viewport_samples"})

    def test_quality_presets(self):
        group = bpy.context.scene.alabaster
        self.assertEqual(group.quality, "CUSTOM")
        for preset in presets.PRESETS:
            group.quality = preset["name"]
            self.assertEqual(group.quality, preset["name"])
            for name, value in presets.values(preset).items():
                self.assertAlmostEqual(getattr(group, name), value, places=6) if isinstance(value, float) else self.assertEqual(
                    getattr(group, name), value)
        group.samples = 77
        self.assertEqual((group.quality, group.maxDepth), ("CUSTOM", 64))


class Installation(unittest.TestCase):
    def test_another_package_of_this_name_is_passed_over(self):
        """The theme of Sphinx is called alabaster, too."""
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.dict(sys.modules), \
                unittest.mock.patch.object(sys, "path", [folder + "/theme", *sys.path]), \
                unittest.mock.patch.object(library, "HERE", pathlib.Path(folder)):
            for name, text in (("theme", ""), ("ours", "Renderer = object")):
                package = pathlib.Path(folder) / name / "alabaster"
                package.mkdir(parents=True)
                (package / "__init__.py").write_text(text)
            for name in [one for one in sys.modules if one.split(".")[0] == "alabaster"]:
                del sys.modules[name]
            with self.assertRaisesRegex(ImportError, "another package"):
                library.load()
            sys.modules["alabaster"] = types.ModuleType("alabaster")
            (pathlib.Path(folder) / "module_folder.txt").write_text(folder + "/ours")
            self.assertIn("/ours/", library.load().__file__)

    @unittest.skipUnless(job.get("zip"), "no zip")
    def test_zip(self):
        """As a new user: the zip goes into the preferences, the engine is there and renders."""
        alabaster_render.unregister()
        before = {name: sys.modules.pop(name) for name in list(sys.modules) if name.split(".")[0] == "alabaster_render"}
        path = list(sys.path)
        sys.path[:] = [one for one in path if one not in (job["addon"], job["module"])]
        try:
            bpy.ops.preferences.addon_install(filepath=job["zip"], overwrite=True)
            bpy.ops.preferences.addon_enable(module="alabaster_render")
            held = sys.modules["alabaster_render"]
            self.assertIn(os.environ["BLENDER_USER_SCRIPTS"], held.__file__)
            self.assertEqual(pathlib.Path(sys.modules["alabaster_render.library"].folders()[0]), pathlib.Path(job["module"]))
            scenes.stage()
            bpy.context.scene.render.engine = "ALABASTER"
            bpy.ops.preferences.addon_disable(module="alabaster_render")
        finally:
            sys.path[:] = path
            for name in [one for one in sys.modules if one.split(".")[0] == "alabaster_render"]:
                del sys.modules[name]
            sys.modules.update(before)
            alabaster_render.register()


alabaster_render.register()
done = unittest.main(argv=["addon_test", *arguments[1:]], exit=False, verbosity=1)
alabaster_render.unregister()
sys.stdout.flush()
sys.stderr.flush()
os._exit(0 if done.result.wasSuccessful() else 1)
