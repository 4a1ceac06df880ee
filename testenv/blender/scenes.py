"""Scenes of Blender, made by script. Each is a function of its name; DIFFERS says why ours differs from Cycles, if it does."""
import math

import bpy
import mathutils

MODERN = bpy.app.version >= (4, 0, 0)

# Largest difference of the means that is expected, in per cent, and why it is above 2.
DIFFERS = {}


def expected(percent, why, only=None):
    """only: "3" or "4", the generation of the Principled BSDF that it is about."""
    def keep(function):
        if only is None or only == ("4" if MODERN else "3"):
            DIFFERS[function.__name__] = percent, why
        return function
    return keep


# Parts ----------------------------------------------------------------------------------------------
def link(name, data, location=(0, 0, 0), rotation=(0, 0, 0)):
    ob = bpy.data.objects.new(name, data)
    ob.location, ob.rotation_euler = location, rotation
    bpy.context.scene.collection.objects.link(ob)
    return ob


def camera(eye=(0, -6, 3), target=(0, 0, 0.4), lens=50):
    data = bpy.data.cameras.new("camera")
    data.lens = lens
    ob = link("camera", data, eye)
    ob.rotation_euler = (mathutils.Vector(target) - ob.location).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = ob
    return ob


def principled(name, **inputs):
    """Names with underscores for blanks. Specular is 0 unless it is given."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    node = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    renamed = {"Specular": "Specular IOR Level", "Transmission": "Transmission Weight", "Clearcoat": "Coat Weight",
               "Clearcoat_Roughness": "Coat Roughness", "Sheen": "Sheen Weight", "Subsurface": "Subsurface Weight"}
    for key, value in {"Specular": 0.0, **inputs}.items():
        key = renamed.get(key, key) if MODERN else key
        node.inputs[key.replace("_", " ")].default_value = (*value, 1.0) if isinstance(value, tuple) and len(value) == 3 and "Radius" not in key else value
    return material


def diffuse(name="grey", color=(0.6, 0.5, 0.4)):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (*color, 1)
    material.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def mesh(name, points, faces, material=None, location=(0, 0, 0), smooth=False):
    data = bpy.data.meshes.new(name)
    data.from_pydata(points, [], faces)
    data.polygons.foreach_set("use_smooth", [smooth] * len(faces))
    if material:
        data.materials.append(material)
    data.update()
    return link(name, data, location)


def floor(material=None, size=4):
    corners = [(-size, -size, 0), (size, -size, 0), (size, size, 0), (-size, size, 0)]
    return mesh("floor", corners, [(0, 1, 2, 3)], material or diffuse("floor", (0.5, 0.5, 0.5)))


def ball(material, location=(0, 0, 0.8), radius=0.8, rings=24, name="ball"):
    points, faces, around = [], [], 2 * rings
    for i in range(1, rings):
        for j in range(around):
            a, b = math.pi * i / rings, 2 * math.pi * j / around
            points.append((radius * math.sin(a) * math.cos(b), radius * math.sin(a) * math.sin(b), radius * math.cos(a)))
    top, bottom = len(points), len(points) + 1
    points += [(0, 0, radius), (0, 0, -radius)]
    for j in range(around):
        k = (j + 1) % around
        faces.append((top, j, k))
        faces += [(i * around + j, (i + 1) * around + j, (i + 1) * around + k, i * around + k) for i in range(rings - 2)]
        faces.append((bottom, (rings - 2) * around + k, (rings - 2) * around + j))
    return mesh(name, points, faces, material, location, True)


CUBE_POINTS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
CUBE_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def light(kind, energy, location=(0, 0, 0), target=(0, 0, 0), **values):
    data = bpy.data.lights.new(kind, kind)
    data.energy = energy
    if hasattr(data, "use_soft_falloff"):
        data.use_soft_falloff = False
    for key, value in values.items():
        setattr(data, key, value)
    ob = link(kind, data, location)
    ob.rotation_euler = (mathutils.Vector(target) - ob.location).to_track_quat("-Z", "Y").to_euler()
    return ob


def sky(color, strength=1.0):
    world = bpy.context.scene.world = bpy.data.worlds.new("world")
    world.use_nodes = True
    node = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    node.inputs["Color"].default_value = (*color, 1)
    node.inputs["Strength"].default_value = strength
    return world, node


def picture(name, width, height, pixel, is_float=False, space=None):
    """A generated image; pixel(u, v) gives three or four numbers."""
    image = bpy.data.images.new(name, width, height, float_buffer=is_float)
    if space:
        image.colorspace_settings.name = space
    values = []
    for y in range(height):
        for x in range(width):
            color = tuple(pixel((x + 0.5) / width, (y + 0.5) / height))
            values += color if len(color) == 4 else (*color, 1.0)
    image.pixels.foreach_set(values)
    return image


def textured_by_a_missing_image():
    """(material, image): its base colour and its alpha are those of an image whose file is missing."""
    image = bpy.data.images.new("gone", 4, 4)
    image.source, image.filepath = "FILE", "/nowhere/gone.png"
    material = principled("textured")
    tree = material.node_tree
    texture, shader = tree.nodes.new("ShaderNodeTexImage"), tree.nodes["Principled BSDF"]
    texture.image = image
    tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    tree.links.new(texture.outputs["Alpha"], shader.inputs["Alpha"])
    return material, image


def stage(material=None):
    camera()
    floor()
    return ball(material or diffuse())


# Lights ---------------------------------------------------------------------------------------------
def point_light():
    stage()
    light("POINT", 150, (1.5, -1.5, 3), shadow_soft_size=0.25)
    light("POINT", 60, (-2, -1, 2), shadow_soft_size=0.0, color=(0.4, 0.6, 1.0))


def spot_light():
    stage()
    light("SPOT", 400, (1.5, -2, 3.5), (0, 0, 0.4), shadow_soft_size=0.05, spot_size=math.radians(50), spot_blend=0.4)
    light("SPOT", 400, (-2, -1, 3), (0, 0, 0), shadow_soft_size=0.0, spot_size=math.radians(70), spot_blend=1.0, color=(1, 0.5, 0.3))


def sun_light():
    stage()
    light("SUN", 3, (1, -1.5, 3), angle=math.radians(4))


def area_square_and_rectangle():
    stage()
    light("AREA", 90, (1.5, -1.5, 3), shape="SQUARE", size=1.0)
    light("AREA", 60, (-2, -1, 2.5), shape="RECTANGLE", size=2.0, size_y=0.5, color=(0.4, 0.7, 1.0))


def area_disk_and_ellipse():
    stage()
    light("AREA", 90, (1.5, -1.5, 3), shape="DISK", size=1.0)
    light("AREA", 60, (-2, -1, 2.5), shape="ELLIPSE", size=2.0, size_y=0.5, color=(1.0, 0.6, 0.3))


def lights_in_the_picture():
    camera((0, -6, 2), (0, 0, 1))
    floor()
    light("POINT", 100, (-1, 0, 1.2), shadow_soft_size=0.3).visible_camera = True
    light("AREA", 60, (1.2, 0, 1.2), (0, -3, 1), shape="RECTANGLE", size=1.0, size_y=1.5).visible_camera = True
    light("AREA", 60, (0, -1, 1.2), (0, -3, 1), shape="SQUARE", size=0.5)  # Blender hides lights from cameras by default


def world_colour():
    stage()
    sky((0.4, 0.6, 1.0), 0.7)


def world_image_turned():
    stage()
    world, background = sky((1, 1, 1), 1.3)
    tree = world.node_tree
    texture, mapping, coordinates = (tree.nodes.new(kind) for kind in (
        "ShaderNodeTexEnvironment", "ShaderNodeMapping", "ShaderNodeTexCoord"))

    def pixel(u, v):
        bright = 6.0 if abs(u - 0.3) < 0.08 and abs(v - 0.7) < 0.1 else 0.2
        return bright, bright * (0.5 + 0.5 * v), 0.3 + 0.5 * u
    texture.image = picture("environment", 64, 32, pixel, True)
    mapping.inputs["Rotation"].default_value = (0.3, 0.2, 1.1)
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])


# Materials ------------------------------------------------------------------------------------------
def lit():
    sky((1, 1, 1), 0.3)
    light("AREA", 120, (1.5, -2, 3), shape="RECTANGLE", size=1.5, size_y=1.0)


def principled_diffuse():
    stage(principled("diffuse", Base_Color=(0.7, 0.4, 0.2), Roughness=0.5))
    lit()


def metal():
    stage(principled("metal", Base_Color=(0.9, 0.6, 0.3), Metallic=1.0, Roughness=0.35, Specular=0.5))
    lit()


def brushed_metal():
    """A highlight that stretches along a direction between u and v."""
    camera((0, -4, 3), (0, 0, 0), 60)
    ob = floor(principled("brushed", Base_Color=(0.8, 0.7, 0.6), Metallic=1.0, Roughness=0.4, Specular=0.5, Anisotropic=0.8,
                          Anisotropic_Rotation=0.1), 2)
    ob.data.uv_layers.new(name="map").data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    tree = ob.data.materials[0].node_tree
    tangent = tree.nodes.new("ShaderNodeTangent")
    tangent.direction_type = "UV_MAP"
    tree.links.new(tangent.outputs[0], tree.nodes["Principled BSDF"].inputs["Tangent"])
    tree.nodes["Principled BSDF"].distribution = "GGX"  # from Blender 4.0 on another one, which adds light between facets
    light("AREA", 60, (0.3, 2, 2), shape="DISK", size=0.5)


def dielectric():
    stage(principled("plastic", Base_Color=(0.1, 0.3, 0.6), Roughness=0.3, Specular=0.5))
    lit()


def coat():
    stage(principled("coat", Base_Color=(0.6, 0.1, 0.1), Roughness=0.6, Specular=0.5, Clearcoat=1.0, Clearcoat_Roughness=0.1))
    lit()


def glass():
    stage(principled("glass", Base_Color=(0.9, 0.95, 1.0), Roughness=0.0, Specular=0.5, Transmission=1.0, IOR=1.45))
    lit()


def emission():
    material = principled("glow", Base_Color=(0.2, 0.2, 0.2), Roughness=0.5)
    node = material.node_tree.nodes["Principled BSDF"]
    node.inputs["Emission Color" if MODERN else "Emission"].default_value = (1, 0.6, 0.3, 1)
    node.inputs["Emission Strength"].default_value = 2.0
    stage(material)
    sky((0.1, 0.1, 0.1))


@expected(5.0, "Cycles enters a body by refraction through its rough surface, ours by Disney's diffuse factors", "4")
def subsurface():
    camera()
    material = principled("wax", Base_Color=(0.8, 0.6, 0.4), Roughness=0.6, Subsurface=1.0, Subsurface_Radius=(0.3, 0.15, 0.08))
    node = material.node_tree.nodes["Principled BSDF"]
    node.subsurface_method = "RANDOM_WALK"
    if MODERN:
        node.inputs["Subsurface Scale"].default_value = 0.3
    else:
        node.inputs["Subsurface Color"].default_value = (0.8, 0.6, 0.4, 1)
    floor()
    ball(material)
    lit()


@expected(3.5, "Disney's diffuse lobe instead of Lambert's, seen at the normals of the map")
def textures_and_normal_map():
    camera()
    floor()
    ob = mesh("board", [(-1.5, 0, 0), (1.5, 0, 0), (1.5, 0.8, 2), (-1.5, 0.8, 2)], [(0, 1, 2, 3)], None)
    for name, offset in (("first", 0.0), ("second", 0.5)):
        layer = ob.data.uv_layers.new(name=name)
        layer.data.foreach_set("uv", [0 + offset, 0, 2 + offset, 0, 2 + offset, 1, 0 + offset, 1])
    material = principled("board", Roughness=0.5)
    tree = material.node_tree
    node = tree.nodes["Principled BSDF"]
    color, relief, mapping, second, normal = (tree.nodes.new(kind) for kind in (
        "ShaderNodeTexImage", "ShaderNodeTexImage", "ShaderNodeMapping", "ShaderNodeUVMap", "ShaderNodeNormalMap"))
    color.image = picture("squares", 64, 64, lambda u, v: (0.9, 0.3, 0.1) if (u < 0.5) != (v < 0.3) else (0.1, 0.4, 0.8))
    relief.image = picture("relief", 64, 64, lambda u, v: (0.5 + 0.3 * math.sin(12.566 * u), 0.5 + 0.2 * math.cos(6.283 * v), 0.9),
                           space="Non-Color")
    mapping.inputs["Rotation"].default_value = (0, 0, 0.4)
    mapping.inputs["Location"].default_value = (0.2, 0.1, 0)
    mapping.inputs["Scale"].default_value = (1.5, 1.0, 1.0)
    second.uv_map = normal.uv_map = "second"
    tree.links.new(second.outputs[0], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], color.inputs["Vector"])
    tree.links.new(second.outputs[0], relief.inputs["Vector"])
    tree.links.new(color.outputs["Color"], node.inputs["Base Color"])
    tree.links.new(relief.outputs["Color"], normal.inputs["Color"])
    tree.links.new(normal.outputs[0], node.inputs["Normal"])
    ob.data.materials.append(material)
    light("SUN", 3, (1, -1.5, 3), angle=0.02)
    sky((1, 1, 1), 0.2)


# Geometry, cameras ----------------------------------------------------------------------------------
def instances():
    camera((0, -9, 5), (0, 0, 0))
    floor(size=6)
    held = bpy.data.collections.new("held")
    first = mesh("cube", CUBE_POINTS, CUBE_FACES, diffuse("red", (0.7, 0.2, 0.1)))
    second = ball(diffuse("blue", (0.1, 0.3, 0.7)), (0, 0, 1.6), 0.6, 12)
    for ob in (first, second):
        bpy.context.scene.collection.objects.unlink(ob)
        held.objects.link(ob)
    for i in range(9):
        ob = link(f"place{i}", None, (2 * (i % 3) - 2, 2 * (i // 3) - 2, 0.5), (0, 0, 0.3 * i))
        ob.instance_type, ob.instance_collection = "COLLECTION", held
        ob.scale = (0.4, 0.4, 0.3 + 0.05 * i)
    for i in range(4):
        link(f"twin{i}", first.data, (i - 1.5, -3.5, 0.2)).scale = (0.2, 0.2, 0.2)
    light("SUN", 3, (1, -1.5, 3), angle=0.05)
    sky((1, 1, 1), 0.3)


def subdivision_with_creases():
    camera()
    floor()
    ob = mesh("cage", [(x * 0.5 + 0.5, y, z) for x, y, z in CUBE_POINTS], CUBE_FACES[1:], diffuse(), (0, 0, 0.9), True)
    ob.scale = (0.8, 0.8, 0.8)
    mirror = ob.modifiers.new("mirror", "MIRROR")
    mirror.use_clip = True
    refine = ob.modifiers.new("refine", "SUBSURF")
    refine.levels = refine.render_levels = 3
    top = [e.index for e in ob.data.edges if all(ob.data.vertices[v].co.z > 0.5 for v in e.vertices)]
    if MODERN:
        crease = ob.data.attributes.new("crease_edge", "FLOAT", "EDGE")
        for index in top:
            crease.data[index].value = 0.8
    else:
        for index in top:
            ob.data.edges[index].crease = 0.8
    light("AREA", 120, (1.5, -2, 3), shape="RECTANGLE", size=1.5, size_y=1.0)
    sky((1, 1, 1), 0.3)


def motion_blur():
    camera()
    floor()
    ob = ball(diffuse("ball", (0.8, 0.3, 0.1)), (0, 0, 0.6), 0.5)
    bar = mesh("bar", [(x * 1.2, y * 0.1, z * 0.1) for x, y, z in CUBE_POINTS], CUBE_FACES, diffuse("bar", (0.2, 0.6, 0.3)), (0, 0, 1.6))
    for frame, place, angle in ((0, -1, 0), (2, 1, 1.6)):
        ob.location.x = place
        ob.keyframe_insert("location", frame=frame)
        bar.rotation_euler.y = angle
        bar.keyframe_insert("rotation_euler", frame=frame)
    for moving in (ob, bar):
        linear(moving)
    scene = bpy.context.scene
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.8
    scene.frame_set(1)
    light("SUN", 3, (1, -1.5, 3), angle=0.05)
    sky((1, 1, 1), 0.3)


def linear(ob):
    action = ob.animation_data.action
    curves = action.fcurves if hasattr(action, "fcurves") else [
        c for layer in action.layers for strip in layer.strips for bag in strip.channelbags for c in bag.fcurves]
    for curve in curves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"


def depth_of_field():
    eye = camera((0, -5, 1.5), (0, 0, 0.7), 60)
    eye.data.dof.use_dof, eye.data.dof.focus_distance, eye.data.dof.aperture_fstop = True, 5.0, 0.3
    eye.data.shift_x, eye.data.shift_y = 0.05, -0.03
    floor()
    for i in range(4):
        ball(diffuse(f"ball{i}", (0.2 + 0.2 * i, 0.5, 0.8 - 0.2 * i)), (1.2 * i - 1.8, 2 * i - 3, 0.5), 0.5, 12)
    light("SUN", 3, (1, -1.5, 3), angle=0.05)
    sky((1, 1, 1), 0.3)


def orthographic_cutout():
    """Opacity by an image's alpha, under a parallel camera."""
    eye = camera((3, -5, 3), (0, 0, 0.5))
    eye.data.type, eye.data.ortho_scale = "ORTHO", 4.5
    floor()
    ob = mesh("leaf", [(-1, 0, 0.1), (1, 0, 0.1), (1, 0, 2), (-1, 0, 2)], [(0, 1, 2, 3)])
    ob.data.uv_layers.new(name="map").data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    material = principled("leaf", Roughness=0.5)
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.interpolation = "Closest"
    texture.image = picture("leaf", 16, 16, lambda u, v: (0.2, 0.6, 0.2, 1.0 if (u - 0.5) ** 2 + (v - 0.5) ** 2 < 0.16 else 0.0))
    node = tree.nodes["Principled BSDF"]
    tree.links.new(texture.outputs["Color"], node.inputs["Base Color"])
    tree.links.new(texture.outputs["Alpha"], node.inputs["Alpha"])
    ob.data.materials.append(material)
    light("SUN", 3, (1, -1.5, 3), angle=0.05)
    sky((1, 1, 1), 0.3)


SCENES = {function.__name__: function for function in (
    point_light, spot_light, sun_light, area_square_and_rectangle, area_disk_and_ellipse, lights_in_the_picture, world_colour,
    world_image_turned, principled_diffuse, metal, brushed_metal, dielectric, coat, glass, emission, subsurface,
    textures_and_normal_map, instances, subdivision_with_creases, motion_blur, depth_of_field, orthographic_cutout)}
