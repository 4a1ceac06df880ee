"""The world as a dome light."""
import mathutils

from . import images, names

# Rows are our axes in Blender's world: x where its y is, y where its z is, z where its x is. So the middle of an image, which
# Cycles looks up along +x, lies on our +z.
TO_WORLD = mathutils.Matrix(((0, 1, 0), (0, 0, 1), (1, 0, 0))).transposed()


def _background(world):
    output = world.node_tree.get_output_node("ALL")
    links = output.inputs["Surface"].links if output else []
    return links[0].from_node if links else None


def _rotation(texture, note):
    """The matrix that takes a direction of the world to the one that the image is looked up by."""
    links = texture.inputs["Vector"].links
    node = links[0].from_node if links else None
    turned = mathutils.Matrix.Identity(3)
    while node:
        if node.type == "MAPPING" and not node.inputs["Rotation"].is_linked:
            one = mathutils.Euler(node.inputs["Rotation"].default_value, "XYZ").to_matrix()
            turned = turned @ (one.transposed() if node.vector_type == "TEXTURE" else one)
            if any(node.inputs[name].default_value[:] != same for name, same in (("Scale", (1, 1, 1)), ("Location", (0, 0, 0)))
                   if name in node.inputs and node.inputs[name].enabled):
                note("world: the location and scale of a mapping are not translated")
            links = node.inputs["Vector"].links
            node = links[0].from_node if links else None
        elif node.type == "TEX_COORD":
            node = None
        else:
            note(f"world: node '{node.name}' before the image is not translated")
            node = None
    return turned


def translate(scene, world, note):
    """(transform, parameters) of a dome light, or None for a black world."""
    parameters = {"intensity": 1.0, "visibleToCamera": not scene.render.film_transparent}
    turned = mathutils.Matrix.Identity(3)
    if not world.use_nodes or not world.node_tree:
        parameters["color"] = list(world.color)
    else:
        node = _background(world)
        if node is None:
            return None
        if node.type != "BACKGROUND":
            note(f"world: node '{node.name}' is not translated; a Background node is expected")
            return None
        parameters["intensity"] = max(0.0, node.inputs["Strength"].default_value)
        parameters["color"] = [max(0.0, c) for c in node.inputs["Color"].default_value[:3]]
        if node.inputs["Color"].links:
            texture = node.inputs["Color"].links[0].from_node
            if texture.type == "TEX_ENVIRONMENT" and texture.image and texture.projection == "EQUIRECTANGULAR":
                parameters["color"] = [1.0, 1.0, 1.0]
                if images.is_missing(texture.image, note):
                    parameters["color"] = list(images.MISSING)
                else:
                    parameters["texture:file"] = images.environment(texture.image, note)
                    turned = _rotation(texture, note)
            elif texture.type == "RGB":
                parameters["color"] = list(texture.outputs[0].default_value[:3])
            else:
                note(f"world: node '{texture.name}' is not translated; the colour of its socket is used")
    placed = (turned.transposed() @ TO_WORLD).to_4x4()
    return names.matrix(placed), parameters
