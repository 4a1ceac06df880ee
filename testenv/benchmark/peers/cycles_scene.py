"""Renders a neutral scene (neutral_scene.py) with Cycles. Runs inside Blender 3.4 (blender -b -P) or with the module bpy.

Arguments: a JSON file with scene (folder), width, height, threads and renders, a list of samples, seed and output (.exr).
Prints one line "PEER {json}" with Blender's version and the CPU seconds of each render, scene preparation included.
"""
import json
import math
import pathlib
import resource
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import bpy  # noqa: E402
import mathutils  # noqa: E402

import formulas  # noqa: E402
import neutral_scene  # noqa: E402

MODERN = bpy.app.version >= (4, 0, 0)  # the second Principled BSDF


def set_input(node, value, *names):
    """Sets the input that has one of these names; the first name is that of the older version."""
    for name in names:
        if name in node.inputs:
            node.inputs[name].default_value = value
            return
    raise KeyError(names)


def add_volume(tree, kind, coefficients, color_of):
    """A volume whose node multiplies a density by a colour."""
    node, density = tree.nodes.new(kind), max(coefficients)
    node.inputs["Density"].default_value = density
    node.inputs["Color"].default_value = (*[color_of(c / density) for c in coefficients], 1.0)
    return node.outputs["Volume"]


def make_clear(material, disney):
    """Smooth or rough glass, and what light meets within."""
    tree = material.node_tree
    tree.nodes.clear()
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    glass = tree.nodes.new("ShaderNodeBsdfGlass")
    glass.inputs["Color"].default_value = (1, 1, 1, 1)
    glass.inputs["Roughness"].default_value, glass.inputs["IOR"].default_value = disney["roughness"], disney["ior"]
    tree.links.new(glass.outputs["BSDF"], out.inputs["Surface"])
    distances, scatters, absorbs = disney.get("scatterDistance", [0, 0, 0]), [0, 0, 0], [0, 0, 0]
    if max(distances) > 0:
        alpha = [formulas.exact_alpha(a) for a in disney["baseColor"]]
        total = [1 / formulas.mean_free_path(a, d) for a, d in zip(disney["baseColor"], distances)]
        scatters, absorbs = [a * t for a, t in zip(alpha, total)], [(1 - a) * t for a, t in zip(alpha, total)]
    elif "attenuationDistance" in disney:
        absorbs = [-math.log(max(c, 1e-6)) / disney["attenuationDistance"] for c in disney["attenuationColor"]]
    volumes = []
    if max(scatters) > 0:
        volumes.append(add_volume(tree, "ShaderNodeVolumeScatter", scatters, lambda share: share))
    if max(absorbs) > 0:
        volumes.append(add_volume(tree, "ShaderNodeVolumeAbsorption", absorbs, lambda share: 1 - share))
    if len(volumes) == 2:
        both = tree.nodes.new("ShaderNodeAddShader")
        for volume, socket in zip(volumes, both.inputs):
            tree.links.new(volume, socket)
        volumes = [both.outputs["Shader"]]
    if volumes:
        tree.links.new(volumes[0], out.inputs["Volume"])
    return material


def make_material(name, disney):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    if disney.get("specTrans", 0) == 1:
        return make_clear(material, disney)
    node = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    color = disney["baseColor"]
    f0 = formulas.f0_from_ior(disney["ior"])
    distances = disney.get("scatterDistance", [0, 0, 0])
    if max(distances) > 0:
        radius = [formulas.cycles_radius(a, d) for a, d in zip(color, distances)]
        color = [formulas.cycles_albedo(formulas.exact_alpha(a)) for a in color]
        node.subsurface_method = "RANDOM_WALK" if MODERN else "RANDOM_WALK_FIXED_RADIUS"
        set_input(node, radius, "Subsurface Radius")
        set_input(node, 1.0, "Subsurface", "Subsurface Weight")
        if MODERN:
            set_input(node, 1.0, "Subsurface Scale")
        else:
            set_input(node, (*color, 1.0), "Subsurface Color")
    node.distribution = "GGX"
    set_input(node, (*color, 1.0), "Base Color")
    set_input(node, disney["metallic"], "Metallic")
    set_input(node, disney["roughness"], "Roughness")
    if MODERN:
        set_input(node, 1.5, "IOR")
    set_input(node, formulas.principled_specular(f0), "Specular", "Specular IOR Level")
    # Disney's clearcoat is a quarter as strong as a layer of ior 1.5; the older Principled BSDF has that factor itself.
    coat = disney.get("clearcoat", 0.0)
    set_input(node, 0.25 * coat if MODERN else coat, "Clearcoat", "Coat Weight")
    set_input(node, formulas.coat_roughness(disney.get("clearcoatGloss", 1.0)), "Clearcoat Roughness", "Coat Roughness")
    set_input(node, disney.get("sheen", 0.0), "Sheen", "Sheen Weight")
    if not MODERN:
        set_input(node, disney.get("sheenTint", 0.5), "Sheen Tint")
    return material


def make_meshes(folder):
    glb = neutral_scene.Glb(folder / "scene.glb")
    materials = [make_material(m["name"], m["extensions"]["ALAB_materials_disney"]) for m in glb.json["materials"]]
    for entry in glb.json["meshes"]:
        primitive = entry["primitives"][0]
        mesh = bpy.data.meshes.new("mesh")
        indices = glb.accessor(primitive["indices"])
        triangles = list(zip(indices[0::3], indices[1::3], indices[2::3]))
        mesh.from_pydata(glb.accessor(primitive["attributes"]["POSITION"]), [], triangles)
        mesh.polygons.foreach_set("use_smooth", [True] * len(triangles))
        if not MODERN:
            mesh.use_auto_smooth = True  # custom normals take effect only with it
        mesh.normals_split_custom_set_from_vertices(glb.accessor(primitive["attributes"]["NORMAL"]))
        mesh.materials.append(materials[primitive["material"]])
        mesh.update()
        bpy.context.scene.collection.objects.link(bpy.data.objects.new("mesh", mesh))


def placement(position, target, up):
    x, y, z = formulas.look_at(position, target, up)
    return mathutils.Matrix([[x[i], y[i], z[i], position[i]] for i in range(3)] + [[0, 0, 0, 1]])


def make_light(light):
    radiance = light.get("intensity", 1)
    if light["type"] == "domeLight":
        make_world(light, radiance)
        return
    if light["type"] == "rectLight":
        data = bpy.data.lights.new(light["name"], "AREA")
        data.shape, data.size, data.size_y = "RECTANGLE", light.get("width", 1), light.get("height", 1)
        data.energy = formulas.blender_rect_power(radiance, data.size * data.size_y)
    else:
        data = bpy.data.lights.new(light["name"], "POINT")
        data.shadow_soft_size = light.get("radius", 0.5)
        data.energy = formulas.blender_sphere_power(radiance, data.shadow_soft_size)
        if MODERN:
            data.use_soft_falloff = False
    data.color = light.get("color", [1, 1, 1])
    data.cycles.use_multiple_importance_sampling = True
    item = bpy.data.objects.new(light["name"], data)
    position = light.get("position", [0, 0, 0])
    below = [position[0], position[1], position[2] - 1]
    item.matrix_world = placement(position, light.get("target", below), light.get("up", [0, 1, 0]))
    item.visible_camera = light.get("visibleToCamera", False)
    bpy.context.scene.collection.objects.link(item)


def make_world(light, radiance):
    world = bpy.context.scene.world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    tree = world.node_tree
    background = next(n for n in tree.nodes if n.type == "BACKGROUND")
    color = light.get("color", [1, 1, 1])
    background.inputs["Strength"].default_value = radiance
    background.inputs["Color"].default_value = (*color, 1.0)
    world.cycles_visibility.camera = light.get("visibleToCamera", False)
    if not light.get("texture:file"):
        return
    if color != [1, 1, 1]:
        raise neutral_scene.Unsupported("a coloured dome with a texture")
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(light["texture:file"])
    # Ours: y up, the centre of the image towards +z, its left quarter +x. Cycles: z up, +x, +y.
    turn = tree.nodes.new("ShaderNodeMapping")
    turn.vector_type = "VECTOR"
    turn.inputs["Rotation"].default_value = mathutils.Matrix([[0, 0, 1], [1, 0, 0], [0, 1, 0]]).to_euler("XYZ")
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Generated"], turn.inputs["Vector"])
    tree.links.new(turn.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])


def make_camera(camera):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.sensor_height, data.lens = camera.get("verticalAperture", 24), camera.get("focalLength", 50)
    data.clip_start, data.clip_end = 1e-4, 1e4
    if camera.get("fStop", 0) > 0:
        data.dof.use_dof, data.dof.aperture_fstop = True, camera["fStop"]
        data.dof.focus_distance = camera["focusDistance"]
    item = bpy.data.objects.new("camera", data)
    look = camera["lookAt"]
    item.matrix_world = placement(look["eye"], look["target"], look.get("up", [0, 1, 0]))
    bpy.context.scene.collection.objects.link(item)
    bpy.context.scene.camera = item


def make_settings(job, settings):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = job["width"], job["height"], 100
    scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.image_settings.exr_codec, scene.render.image_settings.color_mode = "ZIP", "RGB"
    scene.render.use_persistent_data = False
    cycles = scene.cycles
    cycles.device, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", False, job["adaptive"] > 0
    cycles.adaptive_threshold, cycles.adaptive_min_samples = job["adaptive"], 0  # 0: chosen by the threshold
    cycles.pixel_filter_type = "BOX"
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = job["blurGlossy"]
    depth = settings["maxDepth"]
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = depth
    if any(m.node_tree.nodes.get("Volume Scatter") for m in bpy.data.materials):  # ours counts no bounce within
        cycles.max_bounces = cycles.volume_bounces = cycles.transmission_bounces = 1024
    cycles.caustics_reflective = cycles.caustics_refractive = True


def render(task):
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = task["samples"], task["seed"]
    if scene.cycles.use_adaptive_sampling and task["samples"] > 1:
        scene.cycles.samples = 4 * task["samples"]
    scene.render.filepath = task["output"]
    before = resource.getrusage(resource.RUSAGE_SELF)
    bpy.ops.render.render(write_still=True)
    after = resource.getrusage(resource.RUSAGE_SELF)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    job = json.loads(pathlib.Path(arguments[0]).read_text())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    folder = pathlib.Path(job["scene"])
    description = json.loads((folder / "scene.json").read_text())
    make_meshes(folder)
    for light in description["lights"]:
        make_light(light)
    make_camera(description["camera"])
    make_settings(job, description["settings"])
    seconds = [render(task) for task in job["renders"]]
    print("\nPEER " + json.dumps({"version": bpy.app.version_string, "cpuSeconds": seconds}), flush=True)


if __name__ == "__main__":
    main()
