"""The world as a dome light."""
import mathutils

from . import images, names
from .sockets import ONE, Reader, Source, Texture, Value, multiplied

# Rows are our axes in Blender's world: x where its y is, y where its z is, z where its x is. So the middle of an image, which
# Cycles looks up along +x, lies on our +z.
TO_WORLD = mathutils.Matrix(((0, 1, 0), (0, 0, 1), (1, 0, 0))).transposed()


class WorldReader(Reader):
    """Environment textures are textures whose parameters hold their source."""

    def value(self, socket, groups=()):
        source = self.source(socket, groups)
        if isinstance(source, Source) and source.node.type == "TEX_ENVIRONMENT" and source.node.image:
            return Value(ONE, [Texture({"source": source}, image=source.node.image)])
        return super().value(socket, groups)


def _background(reader, source):
    """The Background node that lights the scene, None where there is none. The camera may see another one."""
    while isinstance(source, Source) and source.node.type == "MIX_SHADER":
        factor = reader.source(source.node.inputs[0], source.groups)
        if not (isinstance(factor, Source) and factor.node.type == "LIGHT_PATH" and factor.output.name == "Is Camera Ray"):
            break
        reader.note("the background that lights the scene is also the one that the camera sees")
        source = reader.source(source.node.inputs[1], source.groups)
    if not isinstance(source, Source):
        return None
    if source.node.type != "BACKGROUND":
        reader.note(f"node '{source.node.name}' is not translated; a Background node is expected")
        return None
    return source


def _rotation(reader, source, note):
    """The matrix that takes a direction of the world to the one that the image is looked up by."""
    source = reader.source(source.node.inputs["Vector"], source.groups)
    turned = mathutils.Matrix.Identity(3)
    while isinstance(source, Source):
        node = source.node
        if node.type == "MAPPING" and not node.inputs["Rotation"].is_linked:
            one = mathutils.Euler(node.inputs["Rotation"].default_value, "XYZ").to_matrix()
            turned = turned @ (one.transposed() if node.vector_type == "TEXTURE" else one)
            if any(node.inputs[name].default_value[:] != same for name, same in (("Scale", (1, 1, 1)), ("Location", (0, 0, 0)))
                   if name in node.inputs and node.inputs[name].enabled):
                note("world: the location and scale of a mapping are not translated")
            source = reader.source(node.inputs["Vector"], source.groups)
            continue
        if node.type != "TEX_COORD":
            note(f"world: node '{node.name}' before the image is not translated")
        elif source.output.name == "Object" and node.object:
            turned = turned @ node.object.matrix_world.to_3x3().normalized().transposed()
        break
    return turned


def _image(reader, texture, note):
    """(colour, parameters, rotation) of an environment texture."""
    source = texture.parameters["source"]
    image = source.node.image
    if images.is_missing(image, note):
        return images.MISSING, {}, mathutils.Matrix.Identity(3)
    if source.node.projection != "EQUIRECTANGULAR":
        note(f"world: image '{image.name}': projection {source.node.projection.lower()} is not translated; its mean is used")
        return texture.mean()[0], {}, mathutils.Matrix.Identity(3)
    if any(texture.bias):
        note("world: a sum with an image is not translated; the image is used")
    return texture.scale, {"texture:file": images.environment(image, note)}, _rotation(reader, source, note)


def translate(scene, world, note):
    """(transform, parameters) of a dome light, or None for a black world."""
    parameters = {"intensity": 1.0, "visibleToCamera": not scene.render.film_transparent}
    turned = mathutils.Matrix.Identity(3)
    if not world.use_nodes or not world.node_tree:
        parameters["color"] = list(world.color)
    else:
        reader = WorldReader(None, lambda text: note(f"world: {text}"))
        output = world.node_tree.get_output_node("CYCLES") or world.node_tree.get_output_node("ALL")
        source = _background(reader, reader.source(output.inputs["Surface"])) if output else None
        if source is None:
            return None
        strength = reader.mean(reader.input(source, "Strength"), "strength")
        color = reader.input(source, "Color")
        parameters["intensity"] = max(0.0, sum(strength) / 3)
        tint = color.constant
        for texture in color.textures:
            if "source" in (texture.parameters or {}) and "texture:file" not in parameters:
                one, image, turned = _image(reader, texture, note)
                parameters.update(image)
            else:
                one = reader.mean(Value(ONE, [texture]), "world")
            tint = multiplied(tint, one)
        parameters["color"] = [max(0.0, c) for c in tint]
    placed = (turned.transposed() @ TO_WORLD).to_4x4()
    return names.matrix(placed), parameters
