"""Tests of materials and their images. addon_test.py runs them."""
import pathlib
import tempfile
import types
import unittest
import unittest.mock

import bpy
import numpy

import scenes
from alabaster_render import disney_group, images, materials, shaders, sockets, subsurface, sync, world
from synced_scene import Watched, fresh


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
        for name, p in disney_group.PARAMETERS.items():
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

    def chain(self, kind, count, *inputs):
        """A material whose base colour is the last of `count` nodes, each linked to these inputs of the next."""
        material = scenes.principled("chain")
        tree, last = material.node_tree, None
        for _ in range(count):
            node = tree.nodes.new(kind)
            for name in inputs if last else ():
                tree.links.new(last.outputs[0], node.inputs[name])
            last = node
        tree.links.new(last.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
        return material

    def test_links_in_a_circle_count_for_nothing(self):
        for kind, name in (("ShaderNodeMixRGB", 1), ("NodeReroute", 0)):
            material = self.chain(kind, 2, name)
            nodes = [node for node in material.node_tree.nodes if node.bl_idname == kind]
            material.node_tree.links.new(nodes[1].outputs[0], nodes[0].inputs[name])
            self.assertEqual(len(self.translate(material).nodes["surface"]["baseColor"]), 3)
        scene = bpy.context.scene
        scene.world = bpy.data.worlds.new("circle")
        scene.world.use_nodes = True
        tree = scene.world.node_tree
        texture, first, second = (tree.nodes.new(kind) for kind in ("ShaderNodeTexEnvironment", *["ShaderNodeMapping"] * 2))
        texture.image = scenes.picture("sky", 4, 4, lambda u, v: (u, v, 0))
        for source, target in ((first, second), (second, first), (first, texture)):
            tree.links.new(source.outputs[0], target.inputs["Vector"])
        tree.links.new(texture.outputs[0], tree.nodes["Background"].inputs["Color"])
        self.assertIn("texture:file", world.translate(scene, scene.world, self.notes.append)[1])

    def test_a_node_is_read_once_however_many_links_lead_to_it(self):
        material = self.chain("ShaderNodeMath", 14, 0, 1)
        with unittest.mock.patch.dict(sockets.NODES, {"MATH": unittest.mock.Mock(side_effect=sockets.math_node)}):
            self.translate(material)
            self.assertEqual(sockets.NODES["MATH"].call_count, 14)
        tree = material.node_tree
        last = tree.nodes["Principled BSDF"]
        for _ in range(10):
            mix = tree.nodes.new("ShaderNodeMixShader")
            for i in (1, 2):
                tree.links.new(last.outputs[0], mix.inputs[i])
            last = mix
        tree.links.new(last.outputs[0], tree.get_output_node("ALL").inputs["Surface"])
        with unittest.mock.patch.dict(shaders.SHADERS, {"MIX_SHADER": unittest.mock.Mock(side_effect=shaders.mix)}):
            self.translate(material)
            self.assertEqual(shaders.SHADERS["MIX_SHADER"].call_count, 10)

    def test_nodes_behind_many_others_are_noted(self):
        self.translate(self.chain("ShaderNodeMixRGB", 300, 1))
        self.assertTrue(any("is behind 100 others" in note for note in self.notes), self.notes)

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

    def test_pixels_of_any_number_of_channels(self):
        def pixels(channels, *values):
            held = types.SimpleNamespace(foreach_get=lambda out: out.__setitem__(slice(None), values))
            return images._pixels(types.SimpleNamespace(size=(1, 2), channels=channels, pixels=held)).tolist()
        self.assertEqual(pixels(1, 0.25, 0.5), [[0.25, 0.25, 0.25, 1], [0.5, 0.5, 0.5, 1]])
        self.assertEqual(pixels(2, 0.25, 1, 0.5, 0), [[0.25, 0.25, 0.25, 1], [0.5, 0.5, 0.5, 0]])
        self.assertEqual(pixels(3, 1, 0, 0.5, 0, 1, 0), [[1, 0, 0.5, 1], [0, 1, 0, 1]])
        self.assertEqual(pixels(4, 1, 0, 0.5, 0, 0, 1, 0, 1), [[1, 0, 0.5, 0], [0, 1, 0, 1]])

    def test_a_sequence_in_a_space_that_is_converted(self):
        """Blender has no pixels of it; those of the file that it names are used, and a note says so."""
        with tempfile.TemporaryDirectory() as folder:
            for frame in (1, 2):
                made = scenes.picture(f"frame{frame}", 4, 4, lambda u, v, f=frame: (0.25 * f,) * 3)
                made.filepath_raw, made.file_format = f"{folder}/{frame:03}.png", "PNG"
                made.save()
            image = bpy.data.images.load(f"{folder}/002.png")
            image.source = "SEQUENCE"
            before = len(bpy.data.images)
            with unittest.mock.patch.object(images.colors, "name_of", lambda _: ""):
                file, _ = images.file_of(image, self.notes.append)
            written = numpy.frombuffer(pathlib.Path(file).read_bytes()[-4 * 4 * 16:], numpy.float32)
            self.assertAlmostEqual(float(written[0]), 0.2140, places=2)  # sRGB 0.5
            self.assertEqual(["of a sequence" in note for note in self.notes], [True])
            self.assertAlmostEqual(images.mean(image)[0][0], 0.2140, places=2)
            self.assertEqual(len(bpy.data.images), before)

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
        material, image = scenes.textured_by_a_missing_image()
        surface = self.translate(material).nodes["surface"]
        self.assertEqual((surface["baseColor"], surface.get("opacity", 1.0)), ((1.0, 0.0, 1.0), 1.0))
        self.assertTrue(all("/nowhere/gone.png" in note for note in self.notes) and self.notes)
        world_of, background = scenes.sky((1, 1, 1))
        sky = world_of.node_tree.nodes.new("ShaderNodeTexEnvironment")
        sky.image = image
        world_of.node_tree.links.new(sky.outputs["Color"], background.inputs["Color"])
        parameters = world.translate(bpy.context.scene, world_of, self.notes.append)[1]
        self.assertEqual((parameters["color"], "texture:file" in parameters), ([1.0, 0.0, 1.0], False))

    def test_what_is_below_the_surface_takes_textures_of_its_own(self):
        color, radius = (0.8, 0.5, 0.25), (0.5, 0.25, 0.125)

        def body(links=None):
            material = scenes.principled("body", Subsurface=1.0, Subsurface_Radius=radius, Base_Color=color)
            tree = material.node_tree
            node = tree.nodes["Principled BSDF"]
            node.subsurface_method = "RANDOM_WALK" if scenes.MODERN else "RANDOM_WALK_FIXED_RADIUS"
            if scenes.MODERN:
                node.inputs["Subsurface Scale"].default_value = 0.5
            else:
                node.inputs["Subsurface Color"].default_value = (*color, 1)
            for name, pixel in (links or {}).items():
                texture = tree.nodes.new("ShaderNodeTexImage")
                texture.image = scenes.picture(name, 4, 4, pixel, True, "Non-Color")
                tree.links.new(texture.outputs["Color"], node.inputs[name])
            self.notes.clear()
            return self.translate(material).nodes
        expected = body()["surface"]["meanFreePath"]
        colours = ["Base Color"] if scenes.MODERN else ["Base Color", "Subsurface Color"]
        coloured = body(links={name: lambda u, v: (u, v, 0.5) for name in colours})["surface"]
        self.assertEqual((coloured["meanFreePath"], isinstance(coloured["baseColor"], list), self.notes), (expected, True, []))
        nodes = body(links={"Subsurface Radius": lambda u, v: (u, v, 0.5)})
        (texture, output), = nodes["surface"]["meanFreePath"]
        self.assertEqual((output, self.notes), ("rgb", []))
        for scale, r, mfp in zip(nodes[texture]["scale"], radius, expected):
            self.assertAlmostEqual(scale * r, mfp, places=6)
        if scenes.MODERN:
            self.assertEqual(body(links={"Subsurface Scale": lambda u, v: (0.5,) * 3})["surface"]["meanFreePath"], expected)
            weighted = body(links={"Subsurface Weight": lambda u, v: (u,) * 3})["surface"]
            self.assertEqual((weighted["meanFreePath"], isinstance(weighted["subsurfaceWeight"], list), self.notes), (expected, True, []))

    def test_subsurface_radius(self):
        """The rules by version and method; --widths measures that they are Cycles'."""
        walk = "RANDOM_WALK" if scenes.MODERN else "RANDOM_WALK_FIXED_RADIUS"
        whole = bpy.app.version >= (5, 2, 0)
        self.assertAlmostEqual(subsurface.mean_free_path(walk, 1.0, 0.8, 1.4), 1.0 if whole else 0.0795775, places=6)
        if whole:
            self.assertAlmostEqual(subsurface.mean_free_path("RANDOM_WALK_LEGACY", 1.0, 0.8, 1.4), 0.0795775, places=6)
            self.assertAlmostEqual(subsurface.path_factors("RANDOM_WALK", [0.8] * 3, 1.4, 0.5)[0], 1.0, places=6)
        # Christensen and Burley's profile is as wide for every albedo; A = 0.8 makes the factor of Chiang, Kutz and Burley 1.1.
        burley = subsurface.path_factors("BURLEY", [0.8, 0.5, 0.2], 1.4)
        for found, scale in zip(burley, (1.1, 1.715, 2.96)):
            self.assertAlmostEqual(found, 0.079577 * scale, places=5)
