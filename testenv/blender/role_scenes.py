"""Scenes of what sees objects and what lights them, and of meshes that deform. As in scenes.py, each is a function of its name."""
import bpy

from scenes import CUBE_FACES, CUBE_POINTS, MODERN, ball, camera, diffuse, floor, light, linear, link, mesh, principled, sky


def held_in(name, objects):
    """A new collection of the scene that holds the objects, and no other does."""
    collection = bpy.data.collections.new(name)
    bpy.context.scene.collection.children.link(collection)
    for ob in objects:
        bpy.context.scene.collection.objects.unlink(ob)
        collection.objects.link(ob)
    return collection


def holdout_shader(name):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader, output = nodes.new("ShaderNodeHoldout"), nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def row(materials, radius=0.55, gap=1.3):
    """Balls side by side."""
    first = -0.5 * gap * (len(materials) - 1)
    return [ball(material, (first + gap * i, 0, radius), radius, 16, f"ball{i}") for i, material in enumerate(materials)]


def mirror():
    """A wall behind the objects that shows their backs."""
    material = principled("mirror", Base_Color=(0.9, 0.9, 0.9), Metallic=1.0, Roughness=0.0, Specular=0.5)
    return mesh("wall", [(-4, 2, 0), (4, 2, 0), (4, 2, 3), (-4, 2, 3)], [(0, 1, 2, 3)], material)


def hold_outs():
    """By the object, by a collection of the view layer, by a shader, and behind a film; all but the third are mirrored."""
    camera((0, -7, 2.5), (0, 0, 0.6))
    floor()
    mirror()
    bpy.context.scene.render.film_transparent = True
    balls = row([diffuse("red", (0.7, 0.2, 0.1)), diffuse("green", (0.2, 0.6, 0.2)), holdout_shader("hole"), diffuse("blue", (0.1, 0.2, 0.7))])
    balls[0].is_holdout = True
    held = held_in("held out", balls[1:2])
    bpy.context.view_layer.layer_collection.children[held.name].holdout = True
    film = diffuse("film", (0.6, 0.6, 0.1))
    tree = film.node_tree
    clear, mix = tree.nodes.new("ShaderNodeBsdfTransparent"), tree.nodes.new("ShaderNodeMixShader")
    shader = next(n for n in tree.nodes if n.type == "BSDF_DIFFUSE")
    mix.inputs[0].default_value = 0.5
    tree.links.new(clear.outputs[0], mix.inputs[1])
    tree.links.new(shader.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"])
    mesh("pane", [(-2.6, -1, 0.2), (-0.2, -1, 0.2), (-0.2, -1, 0.9), (-2.6, -1, 0.9)], [(0, 1, 2, 3)], film)
    light("SUN", 3, (1, 0.6, 3), angle=0.05)  # from behind the mirror, which makes no caustics
    sky((0.5, 0.7, 1.0), 0.5)


def shadow_catcher():
    """A floor and a wall that stand for a real room, below a sun and a sky: balls cast shadows on both, and they none on each other. All are
    dark: Cycles counts light that bounces onto catchers, too."""
    camera((0, -7, 2.5), (0, 0, 0.6))
    ground = floor(diffuse("dark", (0.02, 0.02, 0.02)))
    wall = mesh("wall", [(-4, 2, 0), (4, 2, 0), (4, 2, 3), (-4, 2, 3)], [(0, 1, 2, 3)], ground.data.materials[0])
    ground.is_shadow_catcher = wall.is_shadow_catcher = bpy.context.scene.render.film_transparent = True
    row([diffuse("red", (0.06, 0.02, 0.01)), diffuse("green", (0.02, 0.05, 0.02)), diffuse("blue", (0.01, 0.02, 0.06))])
    light("SUN", 3, (-2, -3, 4), angle=0.1)
    sky((0.5, 0.7, 1.0), 0.5)


def not_seen_by_the_camera():
    """By the object, and by a collection that is only indirect. The mirror and the floor show what the camera does not see."""
    camera((0, -7, 2.5), (0, 0, 0.6))
    floor()
    mirror()
    balls = row([diffuse("red", (0.7, 0.2, 0.1)), diffuse("green", (0.2, 0.6, 0.2)), diffuse("blue", (0.1, 0.2, 0.7))])
    balls[0].visible_camera = False
    held = held_in("indirect", balls[2:])
    bpy.context.view_layer.layer_collection.children[held.name].indirect_only = True
    light("SUN", 3, (1, 0.6, 3), angle=0.05)  # from behind the mirror, which makes no caustics
    sky((1, 1, 1), 0.3)


def keyed(block, values):
    for frame, value in values:
        block.value = value
        block.keyframe_insert("value", frame=frame)


def deforming_meshes():
    """A shape key, an armature, and a shape key below a subdivision that refines, each half way through its motion."""
    camera((0, -6, 2.5), (0, 0, 0.8))
    floor()
    tall = mesh("tall", [(0.4 * x, 0.4 * y, 0.5 + 0.5 * z) for x, y, z in CUBE_POINTS], CUBE_FACES, diffuse("red", (0.7, 0.2, 0.1)),
                (-1.6, 0, 0))
    soft = mesh("soft", [(0.5 * x, 0.5 * y, 0.6 + 0.5 * z) for x, y, z in CUBE_POINTS], CUBE_FACES, diffuse("blue", (0.1, 0.3, 0.7)),
                (1.6, 0, 0), True)
    soft.modifiers.new("refine", "SUBSURF").render_levels = 3
    for ob, shift in ((tall, (0.6, 0, 0.5)), (soft, (-0.5, 0, 0.6))):
        ob.shape_key_add(name="rest", from_mix=False)
        moved = ob.shape_key_add(name="moved", from_mix=False)
        for i, point in enumerate(CUBE_POINTS):
            if point[2] > 0:
                moved.data[i].co = [a + b for a, b in zip(ob.data.vertices[i].co, shift)]
        keyed(moved, ((0, 0.0), (2, 1.0)))
        linear(ob.data.shape_keys)
    arm()
    scene = bpy.context.scene
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.frame_set(1)
    light("SUN", 3, (1, -1.5, 3), angle=0.05)
    sky((1, 1, 1), 0.3)


def arm():
    """A bar whose upper half a bone turns."""
    heights = [0.25 * i for i in range(7)]
    points = [(x, y, z) for z in heights for x, y in ((-0.15, -0.15), (0.15, -0.15), (0.15, 0.15), (-0.15, 0.15))]
    faces = [(4 * i + j, 4 * i + (j + 1) % 4, 4 * i + 4 + (j + 1) % 4, 4 * i + 4 + j) for i in range(6) for j in range(4)]
    bar = mesh("bar", points, [*faces, (3, 2, 1, 0), (24, 25, 26, 27)], diffuse("green", (0.2, 0.6, 0.2)), (0, 0, 0), True)
    skeleton = link("skeleton", bpy.data.armatures.new("skeleton"))
    bpy.context.view_layer.objects.active = skeleton
    bpy.ops.object.mode_set(mode="EDIT")
    for name, low, high in (("lower", 0, 0.75), ("upper", 0.75, 1.5)):
        bone = skeleton.data.edit_bones.new(name)
        bone.head, bone.tail = (0, 0, low), (0, 0, high)
    bpy.ops.object.mode_set(mode="OBJECT")
    for name, inside in (("lower", lambda z: z <= 0.75), ("upper", lambda z: z > 0.75)):
        bar.vertex_groups.new(name=name).add([i for i, p in enumerate(points) if inside(p[2])], 1.0, "REPLACE")
    bar.modifiers.new("arm", "ARMATURE").object = skeleton
    bone = skeleton.pose.bones["upper"]
    bone.rotation_mode = "XYZ"
    for frame, angle in ((0, 0.0), (2, 1.0)):
        bone.rotation_euler = (angle, 0, 0.8 * angle)
        bone.keyframe_insert("rotation_euler", frame=frame)
    linear(skeleton)


def linked_lights():
    """A light for the first ball alone, one for all but the second, one whose shadows the third casts and the floor receives."""
    camera((0, -7, 3), (0, 0, 0.5))
    ground = floor()
    balls = row([diffuse("red", (0.7, 0.2, 0.1)), diffuse("green", (0.2, 0.6, 0.2)), diffuse("blue", (0.1, 0.2, 0.7))])
    first = light("AREA", 100, (-1.5, -2, 3), shape="SQUARE", size=1.0)
    second = light("SUN", 1.5, (1, -1.5, 3), angle=0.05, color=(1, 0.7, 0.4))
    third = light("POINT", 150, (1.5, 1.5, 3), shadow_soft_size=0.2, color=(0.5, 0.7, 1.0))
    for lamp, name, objects, state in ((first, "receiver_collection", [balls[0]], "INCLUDE"),
                                       (second, "receiver_collection", [balls[1]], "EXCLUDE"),
                                       (third, "blocker_collection", [balls[2], ground], "INCLUDE")):
        linked = bpy.data.collections.new(name)
        for ob in objects:
            linked.objects.link(ob)
        for entry in linked.collection_objects:
            entry.light_linking.link_state = state
        setattr(lamp.light_linking, name, linked)
    sky((1, 1, 1), 0.1)


SCENES = {function.__name__: function for function in (hold_outs, shadow_catcher, not_seen_by_the_camera, deforming_meshes)}
if MODERN:
    SCENES["linked_lights"] = linked_lights
