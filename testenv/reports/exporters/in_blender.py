"""Inputs of kinds.py by Blender's exporters: blender -b --factory-startup --python in_blender.py -- FOLDER"""
import math
import pathlib
import sys

import bmesh
import bpy

folder = pathlib.Path(sys.argv[-1])


def clear():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def material(name, color=(.8, .8, .8, 1)):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    made.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = color
    return made


def add(name, mesh, *materials):
    for one in materials:
        mesh.materials.append(one)
    made = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(made)
    return made


def ball(name="ball", smooth=True):
    mesh, made = bpy.data.meshes.new(name), bmesh.new()
    bmesh.ops.create_uvsphere(made, u_segments=32, v_segments=16, radius=1, calc_uvs=True)
    made.to_mesh(mesh)
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
    return mesh


def export(name, **options):
    bpy.ops.export_scene.gltf(filepath=str(folder / name), export_format="GLB", **options)


def edit(mesh, change):
    made = bmesh.new()
    made.from_mesh(mesh)
    change(made)
    made.to_mesh(mesh)
    made.free()
    mesh.update()


def materials_of_one_mesh():
    for name, slots in (("one", 1), ("two", 2)):
        clear()
        mesh = ball()
        add("head", mesh, *(material(f"m{i}") for i in range(slots)))
        for polygon in mesh.polygons:
            polygon.material_index = int(slots == 2 and polygon.center.x > .3 and polygon.center.z > 0)
        export(f"01_blender_{name}.glb")


def doubled():
    for name in ("single", "doubled"):
        clear()
        mesh = ball()

        def double(made):
            copy = bmesh.ops.duplicate(made, geom=made.faces)["geom"]
            bmesh.ops.reverse_faces(made, faces=[f for f in copy if isinstance(f, bmesh.types.BMFace)])
        if name == "doubled":
            edit(mesh, double)
        add("ball", mesh, material("m"))
        export(f"08_blender_{name}.glb")


def split_cube():
    for name in ("smooth", "flat"):
        clear()
        bpy.ops.mesh.primitive_cube_add(size=2)
        mesh = bpy.context.object.data
        mesh.polygons.foreach_set("use_smooth", [name == "smooth"] * 6)
        export(f"09_blender_{name}.glb", export_texcoords=name == "flat")


def layers_of_a_render():
    clear()
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.cycles.device, scene.cycles.use_denoising = "CPU", False
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 16, 8, 100
    world = bpy.data.worlds.new("w")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (1, .5, .25, 1)
    scene.world = world
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.view_layers[0].use_pass_z = True
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    scene.render.filepath = str(folder / "12_blender.exr")
    bpy.ops.render.render(write_still=True)


def loose_and_internal():
    for name in ("14_blender_clean", "14_blender_loose", "15_blender_clean", "15_blender_internal"):
        clear()
        mesh = ball()
        if "loose" in name:
            edit(mesh, lambda made: made.verts.new((300, 0, 0)))
        if "internal" in name:
            ring = [v.index for v in mesh.vertices if abs(v.co.z) < 1e-4]
            ring.sort(key=lambda i: math.atan2(mesh.vertices[i].co.y, mesh.vertices[i].co.x))

            def close(made):
                made.verts.ensure_lookup_table()
                made.faces.new([made.verts[i] for i in ring])
            edit(mesh, close)
        add("ball", mesh, material("m"))
        export(name + ".glb", use_mesh_vertices="loose" in name)


def tangents_without_coordinates():
    clear()
    bpy.ops.mesh.primitive_plane_add(size=2)
    plane = bpy.context.object
    plane.rotation_euler = (math.pi / 2, 0, 0)
    for corner in plane.data.uv_layers[0].data:
        corner.uv = (0.5, 0.5)
    made = material("m")
    image = bpy.data.images.new("n", 4, 4)
    image.colorspace_settings.name = "Non-Color"
    image.pixels = [.9, .5, .85, 1] * 16
    nodes, links = made.node_tree.nodes, made.node_tree.links
    texture, turned = nodes.new("ShaderNodeTexImage"), nodes.new("ShaderNodeNormalMap")
    texture.image = image
    links.new(texture.outputs[0], turned.inputs["Color"])
    links.new(turned.outputs[0], nodes["Principled BSDF"].inputs["Normal"])
    plane.data.materials.append(made)
    export("17_blender.glb", export_tangents=True)


def collapsed_coordinates():
    clear()
    bpy.ops.mesh.primitive_monkey_add()
    mesh = bpy.context.object.data
    for i, corner in enumerate(mesh.uv_layers[0].data):
        corner.uv = (round(corner.uv[0] * 6) / 6, round(corner.uv[1] * 6) / 6)
    bpy.ops.export_scene.obj(filepath=str(folder / "19_blender.obj"), use_materials=False)


for make in (materials_of_one_mesh, doubled, split_cube, layers_of_a_render, loose_and_internal, tangents_without_coordinates, collapsed_coordinates):
    make()
