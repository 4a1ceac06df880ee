"""Tests of nodes of lights and worlds, and of shaders that older files use. addon_test.py runs them."""
import math
import unittest

import bpy
import mathutils

import scenes
from alabaster_render import lights, materials, sync, world
from synced_scene import Watched, fresh


class Nodes(unittest.TestCase):
    def setUp(self):
        fresh()
        self.notes = []

    def light(self, kind="AREA"):
        light = bpy.data.lights.new("lamp", kind)
        light.use_nodes = True
        return light, next(n for n in light.node_tree.nodes if n.type == "EMISSION")

    def parameters(self, light):
        made = lights.translate(light, mathutils.Matrix.Identity(4), True, self.notes.append)
        return made and made[2]

    def link(self, owner, kind, to, name):
        node = owner.node_tree.nodes.new(kind)
        owner.node_tree.links.new(node.outputs[0], to.inputs[name])
        return node

    def surface(self, *kinds):
        """The surface of these shaders, added."""
        material = bpy.data.materials.new("old")
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        output, made = tree.nodes.new("ShaderNodeOutputMaterial"), [tree.nodes.new("ShaderNode" + kind) for kind in kinds]
        last = made[0]
        if len(made) > 1:
            last = tree.nodes.new("ShaderNodeAddShader")
            for i, node in enumerate(made):
                tree.links.new(node.outputs[0], last.inputs[i])
        tree.links.new(last.outputs[0], output.inputs["Surface"])
        return material, made, output

    def test_nodes_of_a_light(self):
        light, emission = self.light()
        plain = self.parameters(light)["intensity"]
        self.link(light, "ShaderNodeBlackbody", emission, "Color").inputs[0].default_value = 2500
        self.link(light, "ShaderNodeValue", emission, "Strength").outputs[0].default_value = 4
        parameters = self.parameters(light)
        self.assertAlmostEqual(parameters["intensity"], 4 * plain, places=5)
        red, green, blue = parameters["color"]
        self.assertTrue(red > 2 * green > 4 * blue > 0, parameters["color"])
        self.assertAlmostEqual(0.2126 * red + 0.7152 * green + 0.0722 * blue, 1, places=2)
        self.assertEqual(self.notes, [])
        self.link(light, "ShaderNodeTexNoise", emission, "Color")
        self.parameters(light)
        self.assertIn("Noise Texture", self.notes[0])

    def test_portals_and_lights_without_shadows(self):
        light, _ = self.light()
        light.cycles.is_portal = True
        self.assertIsNone(self.parameters(light))
        light.cycles.is_portal = False
        light.use_shadow = False
        if hasattr(light.cycles, "cast_shadow"):
            light.cycles.cast_shadow = False
        self.assertIsNotNone(self.parameters(light))
        self.assertEqual(["shadows" in note for note in self.notes], [True])

    def test_nodes_of_a_world(self):
        held, background = scenes.sky((1, 1, 1))
        image = self.link(held, "ShaderNodeTexEnvironment", background, "Color")
        image.image = scenes.picture("sky", 8, 4, lambda u, v: (u, v, 1), is_float=True)
        reroute = held.node_tree.nodes.new("NodeReroute")
        held.node_tree.links.new(image.outputs[0], reroute.inputs[0])
        held.node_tree.links.new(reroute.outputs[0], background.inputs["Color"])
        self.link(held, "ShaderNodeValue", background, "Strength").outputs[0].default_value = 3
        parameters = world.translate(bpy.context.scene, held, self.notes.append)[1]
        self.assertIn("texture:file", parameters)
        self.assertEqual((parameters["color"], parameters["intensity"]), ([1.0, 1.0, 1.0], 3.0))
        multiply = held.node_tree.nodes.new("ShaderNodeMixRGB")
        multiply.blend_type, multiply.inputs[0].default_value = "MULTIPLY", 1.0
        multiply.inputs[2].default_value = (0.5, 0.25, 1, 1)
        held.node_tree.links.new(image.outputs[0], multiply.inputs[1])
        held.node_tree.links.new(multiply.outputs[0], background.inputs["Color"])
        parameters = world.translate(bpy.context.scene, held, self.notes.append)[1]
        self.assertEqual((parameters["color"], "texture:file" in parameters), ([0.5, 0.25, 1.0], True))
        self.assertEqual(self.notes, [])

    def test_an_empty_turns_a_world(self):
        held, background = scenes.sky((1, 1, 1))
        image = self.link(held, "ShaderNodeTexEnvironment", background, "Color")
        image.image = scenes.picture("sky", 8, 4, lambda u, v: (u, v, 1), is_float=True)
        before = world.translate(bpy.context.scene, held, self.notes.append)[0]
        place = held.node_tree.nodes.new("ShaderNodeTexCoord")
        place.object = bpy.data.objects.new("turn", None)
        bpy.context.scene.collection.objects.link(place.object)
        place.object.rotation_euler = (0, 0, math.pi / 2)
        bpy.context.view_layer.update()
        held.node_tree.links.new(place.outputs["Object"], image.inputs["Vector"])
        after = world.translate(bpy.context.scene, held, self.notes.append)[0]
        quarter = mathutils.Matrix.Rotation(math.pi / 2, 4, "Z")
        turned = mathutils.Matrix(before).transposed()
        for row, right in zip(mathutils.Matrix(after).transposed(), quarter @ turned):
            for got, wanted in zip(row, right):
                self.assertAlmostEqual(got, wanted, places=5)

    def test_absorption(self):
        material, (glass,), output = self.surface("BsdfGlass")
        volume = material.node_tree.nodes.new("ShaderNodeVolumeAbsorption")
        volume.inputs["Color"].default_value, volume.inputs["Density"].default_value = (0.5, 0.05, 0.1, 1), 1.5
        material.node_tree.links.new(volume.outputs[0], output.inputs["Volume"])
        surface = materials.translate(material, self.notes.append).nodes["surface"]
        for color, transmitted in zip((0.5, 0.05, 0.1), surface["attenuationColor"]):
            self.assertAlmostEqual(-math.log(transmitted) / surface["attenuationDistance"], 1.5 * (1 - color), places=4)
        self.assertEqual(self.notes, [])

    def test_shaders_of_older_files(self):
        material, (gloss, body), _ = self.surface("BsdfGlossy", "SubsurfaceScattering")
        gloss.inputs["Color"].default_value = (0.04, 0.02, 0.01, 1)
        surface = materials.translate(material, self.notes.append).nodes["surface"]
        self.assertIn("meanFreePath", surface)
        for got, right in zip(surface["specularColor"], (1, 0.5, 0.25)):
            self.assertAlmostEqual(got, right, places=5)
        material, (stretched,), _ = self.surface("BsdfAnisotropic")
        stretched.inputs["Anisotropy"].default_value = 0.5
        surface = materials.translate(material, self.notes.append).nodes["surface"]
        self.assertEqual((surface["metallic"], surface["anisotropic"]), (1.0, 0.5))
        self.assertEqual(self.notes, [])

    def test_what_is_not_drawn_is_noted(self):
        ball = scenes.ball(scenes.diffuse("fur"), name="furry")
        cloud = bpy.data.objects.new("cloud", bpy.data.volumes.new("cloud"))
        bpy.context.scene.collection.objects.link(cloud)
        for name in ("a", "b"):
            ball.data.color_attributes.new(name, "FLOAT_COLOR", "POINT")
            material, (diffuse,), _ = self.surface("BsdfDiffuse")
            self.link(material, "ShaderNodeVertexColor", diffuse, "Color").layer_name = name
            ball.data.materials.append(material)
        sync.SceneSync(Watched(), False, self.notes.append).sync(bpy.context.evaluated_depsgraph_get())
        for text in ("'cloud': volumes", "colour attributes"):
            self.assertTrue(any(text in note for note in self.notes), (text, self.notes))
