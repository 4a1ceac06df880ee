"""Tests of the passes that compositors take, beside those of Cycles. addon_test.py runs them."""
import json
import pathlib
import re
import tempfile
import unittest

import bpy
import numpy

import scenes
from synced_scene import fresh

SIZE = 96, 72


def scatter(ob, place):
    """Geometry nodes that put a cube, and another object, at a point each."""
    group = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
    if hasattr(group, "interface"):
        group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        group.outputs.new("NodeSocketGeometry", "Geometry")
    cube, info, joined, end = (group.nodes.new(kind) for kind in (
        "GeometryNodeMeshCube", "GeometryNodeObjectInfo", "GeometryNodeJoinGeometry", "NodeGroupOutput"))
    cube.inputs["Size"].default_value = (0.3, 0.3, 0.3)
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = bpy.data.objects["bare"], True
    for made, socket, at, size in ((cube, "Mesh", place, 1), (info, "Geometry", (-place[0], *place[1:]), 0.15)):
        point, many = group.nodes.new("GeometryNodeMeshLine"), group.nodes.new("GeometryNodeInstanceOnPoints")
        point.inputs["Count"].default_value, point.inputs["Start Location"].default_value = 1, at
        many.inputs["Scale"].default_value = (size, size, size)
        group.links.new(point.outputs["Mesh"], many.inputs["Points"])
        group.links.new(made.outputs[socket], many.inputs["Instance"])
        group.links.new(many.outputs[0], joined.inputs[0])
    group.links.new(joined.outputs[0], end.inputs[0])
    ob.modifiers.new("scatter", "NODES").node_group = group


def crowd():
    """Objects that share a mesh, a mesh of two materials, a family, instances of a collection and of geometry nodes, strands, and one of
    no material; in motion and out of focus."""
    scenes.camera()
    scenes.floor()
    scenes.sky((1, 1, 1))
    left = scenes.ball(scenes.diffuse("red", (0.8, 0.1, 0.1)), (-1.6, 0, 0.5), 0.5, 12, "left")
    right = scenes.link("right", left.data, (1.6, 0, 0.5))
    scenes.link("grandparent", None)
    scenes.link("parent", None).parent = bpy.data.objects["grandparent"]
    child = scenes.mesh("child", scenes.CUBE_POINTS, scenes.CUBE_FACES, scenes.diffuse("green", (0.1, 0.7, 0.1)), (0, 0, 0.5))
    child.parent, child.scale = bpy.data.objects["parent"], (0.4, 0.4, 0.4)
    child.data.materials.append(scenes.diffuse("blue/half", (0.1, 0.1, 0.8)))
    child.data.polygons.foreach_set("material_index", [0, 1, 0, 1, 0, 1])
    scenes.mesh("bare", scenes.CUBE_POINTS, scenes.CUBE_FACES, None, (0, 1.6, 0.3)).scale = (0.3, 0.3, 0.3)
    pebble = scenes.ball(bpy.data.materials["red"], (0, 0, 0), 0.25, 8, "pebble")
    pebble.pass_index, bpy.data.materials["red"].pass_index = 7, 3
    held = bpy.data.collections.new("held")
    held.objects.link(pebble)
    bpy.context.scene.collection.objects.unlink(pebble)
    for number in range(2):
        place = scenes.link(f"place {number}", None, (-0.8 + 1.6 * number, -1.3, 0.25))
        place.instance_type, place.instance_collection = "COLLECTION", held
    scattered = scenes.mesh("scattered", [(0, 0, 0)], [], bpy.data.materials["green"])
    scattered.parent = bpy.data.objects["parent"]
    scatter(scattered, (1.2, -1.9, 0.3))
    strands = left.modifiers.new("hair", "PARTICLE_SYSTEM").particle_system.settings
    strands.type, strands.count, strands.hair_length = "HAIR", 30, 0.5
    scene = bpy.context.scene
    for frame in (1, 2):
        right.location.z = 0.3 + 0.8 * (frame - 1)
        right.keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.camera.data.dof.use_dof, scene.camera.data.dof.focus_distance, scene.camera.data.dof.aperture_fstop = True, 6.0, 0.3
    for each in (scene.render, getattr(scene, "cycles", None)):
        if hasattr(each, "motion_blur_position"):
            each.motion_blur_position = "CENTER"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *SIZE, 100
    scene.alabaster.samples = scene.cycles.samples = 256
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = scene.alabaster.adaptive = scene.alabaster.denoise = False
    scene.cycles.max_bounces = 0
    scene.cycles.pixel_filter_type, scene.alabaster.filter = "BOX", "box"
    scene.cycles.filter_width = 1.0


def matte_node(tree, kind, name):
    """A Cryptomatte node of the render, of one name."""
    node = tree.nodes.new("CompositorNodeCryptomatteV2")
    node.source, node.scene = "RENDER", bpy.context.scene
    node.layer_name = f"{bpy.context.view_layer.name}.Crypto{kind}"
    node.matte_id = name
    return node


def rendered(engine, wanted, layers=()):
    """Mattes by the compositor's nodes, {(kind, name): rows}; outputs of the layer by name; and the manifests of a file."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.use_nodes = True
    tree = scene.node_tree
    tree.nodes.clear()
    source, composite = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new("CompositorNodeComposite")
    tree.links.new(source.outputs["Image"], composite.inputs["Image"])
    with tempfile.TemporaryDirectory() as folder:
        out = tree.nodes.new("CompositorNodeOutputFile")
        out.base_path, out.format.file_format, out.format.color_depth, out.format.color_mode = folder, "OPEN_EXR", "32", "RGBA"
        out.file_slots.clear()
        named = {}
        for number, what in enumerate((*wanted, *layers)):
            named[what] = f"slot{number}_"
            out.file_slots.new(named[what])
            socket = matte_node(tree, *what).outputs["Matte"] if isinstance(what, tuple) else source.outputs[what]
            tree.links.new(socket, out.inputs[number])
        scene.render.image_settings.file_format, scene.render.filepath = "OPEN_EXR_MULTILAYER", folder + "/layers.exr"
        bpy.ops.render.render(write_still=True)
        header = (pathlib.Path(folder) / "layers.exr").read_bytes()[:1 << 16]
        shown = {}
        for what, slot in named.items():
            image = bpy.data.images.load(next(str(file) for file in pathlib.Path(folder).glob(slot + "*")))
            pixels = numpy.empty(image.size[0] * image.size[1] * 4, numpy.float32)
            image.pixels.foreach_get(pixels)
            shown[what] = pixels.reshape(SIZE[1], SIZE[0], 4)[..., 0 if isinstance(what, tuple) else slice(3)]
            bpy.data.images.remove(image)
    fields = {}
    for match in re.finditer(rb"(cryptomatte/[0-9a-f]{7})/(\w+)\x00string\x00", header):
        size = int.from_bytes(header[match.end():match.end() + 4], "little")
        fields.setdefault(match[1].decode(), {})[match[2].decode()] = header[match.end() + 4:match.end() + 4 + size].decode()
    return shown, fields


@unittest.skipUnless("node_tree" in bpy.types.Scene.bl_rna.properties, "Blender 5 has another compositor")
class Passes(unittest.TestCase):
    def setUp(self):
        fresh()
        crowd()
        self.layer = bpy.context.view_layer

    def both(self, *wanted):
        return rendered("CYCLES", *wanted), rendered("ALABASTER", *wanted)

    def test_mattes_have_the_names_and_the_coverage_of_cycles(self):
        """Through motion and depth of field, by the compositor's nodes: linked duplicates, families, instances, strands, two materials of a mesh."""
        layer = self.layer
        layer.use_pass_cryptomatte_object = layer.use_pass_cryptomatte_material = layer.use_pass_cryptomatte_asset = True
        layer.pass_cryptomatte_depth = 8
        names = {"Object": ["floor", "left", "right", "child", "bare", "pebble", "scattered"],
                 "Material": ["floor", "red", "green", "blue/half", "default_surface"], "Asset": ["grandparent", "left", "pebble"]}
        wanted = [(kind, name) for kind, held in names.items() for name in held]
        (theirs, their_fields), (ours, our_fields) = self.both(wanted)
        for what in wanted:
            difference = numpy.abs(ours[what] - theirs[what])
            self.assertGreater(theirs[what].sum(), 20, what)
            self.assertLess(difference.max(), 0.2, what)
            self.assertLess(abs(ours[what].sum() / theirs[what].sum() - 1), 0.02, what)
        self.assertEqual(our_fields.keys(), their_fields.keys())
        for prefix, fields in our_fields.items():
            known = json.loads(their_fields[prefix]["manifest"])
            self.assertEqual({**fields, "manifest": ""}, {**their_fields[prefix], "manifest": ""})
            manifest = json.loads(fields["manifest"])
            self.assertEqual(manifest, {name: known[name] for name in manifest})
            self.assertLessEqual(set(names[fields["name"].rsplit("Crypto", 1)[1]]), set(manifest))

    def test_data_passes_are_those_of_cycles(self):
        """Where Cycles takes the mean of a pixel and not its closest sample, but for the tenth of pixels at edges."""
        scene, layer = bpy.context.scene, self.layer
        scene.render.use_motion_blur = scene.camera.data.dof.use_dof = False
        for name in ("position", "uv", "object_index", "material_index", "ambient_occlusion"):
            setattr(layer, "use_pass_" + name, True)
        bpy.data.objects["floor"].data.uv_layers.new()
        most = {"Position": 0.12, "UV": 0.02, "IndexOB": 0.0, "IndexMA": 0.0, "AO": 0.03}
        (theirs, _), (ours, _) = self.both((), most)
        for name in most:
            self.assertGreater(theirs[name].std(), 0.1, name)
            self.assertLessEqual(numpy.percentile(numpy.abs(ours[name] - theirs[name]).max(axis=2), 90), most[name], name)
