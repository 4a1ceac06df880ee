"""The world as a dome light."""
import mathutils

from . import images, names

# Rows are our axes in Blender's world: x where its y is, y where its z is, z where its x is. So the middle of an image, which
# Cycles looks up along +x, lies on our +z.
TO_WORLD = mathutils.Matrix(((0, 1, 0), (0, 0, 1), (1, 0, 0))).transposed()


def _linked(socket):
    """The node that is linked to a socket; None where none is. Links that close a circle are not valid."""
    return next((link.from_node for link in socket.links if link.is_valid), None)


def _background(world):
    output = world.node_tree.get_output_node("ALL")
    return _linked(output.inputs["Surface"]) if output else None


def _rotation(texture, note):
    """The matrix that takes a direction of the world to the one that the image is looked up by."""
    node = _linked(texture.inputs["Vector"])
    turned = mathutils.Matrix.Identity(3)
    while node:
        if node.type == "MAPPING" and not node.inputs["Rotation"].is_linked:
            one = mathutils.Euler(node.inputs["Rotation"].default_value, "XYZ").to_matrix()
            turned = turned @ (one.transposed() if node.vector_type == "TEXTURE" else one)
            if any(node.inputs[name].default_value[:] != same for name, same in (("Scale", (1, 1, 1)), ("Location", (0, 0, 0)))
                   if name in node.inputs and node.inputs[name].enabled):
                note("world: the location and scale of a mapping are not translated")
            node = _linked(node.inputs["Vector"])
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
        texture = _linked(node.inputs["Color"])
        if texture:
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
