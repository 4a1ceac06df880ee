"""The value of a socket of a node tree: a constant times textures, each of them scaled and biased."""
import math
from typing import NamedTuple

from . import images

ONE = (1.0, 1.0, 1.0)
DEEPEST = 100  # nodes behind each other; each takes five of the 1000 frames that Python allows
WRAPS = {"REPEAT": "repeat", "EXTEND": "clamp", "CLIP": "black", "MIRROR": "mirror"}
CHANNELS = {"Red": "r", "Green": "g", "Blue": "b", "R": "r", "G": "g", "B": "b"}


class Source(NamedTuple):
    """An output of a node. groups: the group nodes around it, innermost first."""
    node: object
    output: object
    groups: tuple

    def input(self, *socket_names):
        """The node's input of one of these names, None where it has none."""
        for name in socket_names:
            found = self.node.inputs.get(name)
            if found is not None:
                return found
        return None


class Texture(NamedTuple):
    """A lookup: parameters of an AlabasterTexture node, or None for the mesh's colours. image: Blender's, for its mean."""
    parameters: dict
    channel: str = "rgb"
    scale: tuple = ONE
    bias: tuple = (0.0, 0.0, 0.0)
    image: object = None

    def changed(self, scale, bias):
        """scale * this + bias"""
        return self._replace(scale=multiplied(self.scale, scale), bias=tuple(b * s + c for b, s, c in zip(self.bias, scale, bias)))

    def mean(self):
        """Three numbers, and whether all texels have them. A mesh's colours count as middle grey."""
        rgba, even = images.mean(self.image) if self.image else ((0.5,) * 4, False)
        picked = rgba[:3] if self.channel == "rgb" else (rgba["rgba".index(self.channel)],) * 3
        return tuple(c * s + b for c, s, b in zip(picked, self.scale, self.bias)), even


class Value:
    """constant * the product of the textures."""

    def __init__(self, constant, textures=()):
        self.constant, self.textures = constant, tuple(textures)

    @property
    def number(self):
        return sum(self.constant) / 3


def multiplied(a, b):
    return tuple(x * y for x, y in zip(a, b))


def three(value):
    """The default of a socket as three numbers."""
    if isinstance(value, (int, float)):
        return (float(value),) * 3
    return tuple(value)[:3]


class Reader:
    """network: where textures become nodes. note(text) hears of what is approximated."""

    def __init__(self, network, note):
        self.network, self.note = network, note
        self.held, self.depth = {}, 0

    def once(self, kind, source, make):
        """make(), whose result is held for each output of a node: many links may lead to it. None: it is nested too deep."""
        key = (kind, source.node, source.output.identifier, source.groups)
        if key not in self.held:
            if self.depth == DEEPEST:
                self.note(f"node '{source.node.name}' is behind {DEEPEST} others and is not translated")
                return None
            self.depth += 1
            try:
                self.held[key] = make()
            finally:
                self.depth -= 1
        return self.held[key]

    # Following links ------------------------------------------------------------------------------
    def source(self, socket, groups=()):
        """The output that is linked to a socket, through reroutes, groups and muted nodes; a socket where none is. Links that
        close a circle are not valid, and count for nothing, as in Blender."""
        while True:
            usable = (one for one in socket.links if one.is_valid and not getattr(one, "is_muted", False))
            link = next(usable, None) if socket.is_linked else None
            if link is None:
                return socket
            node, output = link.from_node, link.from_socket
            if node.type == "REROUTE":
                socket = node.inputs[0]
            elif node.mute:
                through = next((one for one in node.internal_links if one.to_socket == output), None)
                if through is None:
                    return socket
                socket = through.from_socket
            elif node.type == "GROUP_INPUT" and groups:
                socket, groups = by_identifier(groups[0].inputs, output), groups[1:]
            elif node.type == "GROUP" and node.node_tree and not node.node_tree.get("alabaster"):
                inner = next((one for one in node.node_tree.nodes if one.type == "GROUP_OUTPUT" and one.is_active_output), None)
                if inner is None:
                    return socket
                socket, groups = by_identifier(inner.inputs, output), (node, *groups)
            else:
                return Source(node, output, groups)

    def value(self, socket, groups=()):
        """A socket of numbers or colours."""
        source = self.source(socket, groups)
        if not isinstance(source, Source):
            return Value(three(source.default_value) if hasattr(source, "default_value") else (0.0, 0.0, 0.0))
        known = NODES.get(source.node.type)
        value = self.once("value", source, lambda: known(self, source)) if known else None
        if value is None:
            self.note(f"node '{source.node.name}' at '{socket.name}' is not translated; the value of the socket is used")
            return Value(three(socket.default_value) if hasattr(socket, "default_value") else (0.0, 0.0, 0.0))
        return value

    def input(self, source, *names):
        """The value of the node's input of one of these names, None where it has none."""
        socket = source.input(*names)
        return self.value(socket, source.groups) if socket is not None else None

    def input_number(self, source, *names):
        value = self.input(source, *names)
        return value.number if value else 0.0

    def mean(self, value, what):
        """Three numbers for what takes no texture: of images their mean."""
        result, uneven = value.constant, False
        for texture in value.textures:
            color, even = texture.mean()
            result, uneven = multiplied(result, color), uneven or not even
        if uneven:
            self.note(f"the {what} takes no texture; it is that of the mean")
        return result

    # Arithmetic -----------------------------------------------------------------------------------
    def changed(self, value, scale, bias):
        """scale * value + bias"""
        if not value.textures:
            return Value(tuple(v * s + b for v, s, b in zip(value.constant, scale, bias)))
        if not any(bias):
            return Value(multiplied(value.constant, scale), value.textures)
        if len(value.textures) > 1:
            self.note("a sum with a product of textures is not translated; the product is used")
            return value
        return Value(ONE, [value.textures[0].changed(multiplied(value.constant, scale), bias)])

    def mixed(self, a, b, factor):
        """a (1 - factor) + b factor"""
        if factor.textures and not a.textures and not b.textures:
            return self.changed(factor, tuple(y - x for x, y in zip(a.constant, b.constant)), a.constant)
        f = factor.number
        if factor.textures:
            self.note("a mix of textures by a texture is not translated; its brighter half is used")
            return b
        if f <= 0 or f >= 1:
            return a if f <= 0 else b
        if not b.textures:
            return self.changed(a, (1 - f,) * 3, multiplied(b.constant, (f,) * 3))
        if not a.textures:
            return self.changed(b, (f,) * 3, multiplied(a.constant, (1 - f,) * 3))
        self.note("a mix of two textures is not translated; the one that counts more is used")
        return b if f > 0.5 else a

    # Into the network -----------------------------------------------------------------------------
    def color(self, value):
        """For an input that takes a colour."""
        return self.put(value, value.constant, None)

    def number(self, value, channel="r"):
        """For an input that takes a number; of a coloured texture, one channel."""
        return self.put(value, value.number, channel)

    def put(self, value, constant, channel):
        if not value.textures:
            return constant
        first = value.textures[0]
        textures = [first.changed(value.constant, (0.0, 0.0, 0.0)), *value.textures[1:]]
        if first.parameters is None and value.constant != ONE:
            self.note("a mesh's colours cannot be scaled; they are used as they are")
        return [(self.node(texture), channel if channel and texture.channel == "rgb" else texture.channel) for texture in textures]

    def node(self, texture):
        """The name of the network's node of a texture."""
        if texture.parameters is None:
            made = {"type": "AlabasterPrimvar"}
        else:
            mean = (sum(texture.scale) / 3, sum(texture.bias) / 3)
            made = {"type": "AlabasterTexture", **texture.parameters, "scale": (*texture.scale, mean[0] if texture.channel == "a" else 1.0),
                    "bias": (*texture.bias, mean[1] if texture.channel == "a" else 0.0)}
        for name, held in self.network.nodes.items():
            if held == made:
                return name
        name = f"texture{len(self.network.nodes)}"
        self.network.nodes[name] = made
        return name


def by_identifier(sockets, wanted):
    return next(one for one in sockets if one.identifier == wanted.identifier)


# Nodes ----------------------------------------------------------------------------------------------
def image(reader, source):
    node = source.node
    if node.image is None:
        return Value((0.0, 0.0, 0.0))  # Blender's pink would be a surprise in a final frame
    if node.projection != "FLAT":
        reader.note(f"image '{node.image.name}': projection {node.projection.lower()} is not translated; the UV map is used")
    alpha = source.output.name == "Alpha"
    if images.is_missing(node.image, reader.note):
        return Value(ONE if alpha else images.MISSING)
    file, space = images.file_of(node.image, reader.note)
    if not file:
        return None
    parameters = {"file": file, "sourceColorSpace": space, "wrapS": WRAPS[node.extension],
                  "wrapT": WRAPS[node.extension], "filter": "nearest" if node.interpolation == "Closest" else "linear"}
    parameters.update(placement(reader, reader.source(node.inputs["Vector"], source.groups), source))
    return Value(ONE, [Texture(parameters, "a" if alpha else "rgb", image=node.image)])


def placement(reader, source, of):
    """Texture coordinates of an image: st and its placement."""
    if not isinstance(source, Source):
        return {}
    return reader.once("placement", source, lambda: _placement(reader, source, of)) or {}


def _placement(reader, source, of):
    node = source.node
    if node.type == "UVMAP":
        return {"st": images.uv_primvar(node.uv_map)} if node.uv_map else {}
    if node.type == "ATTRIBUTE":
        return {"st": images.uv_primvar(node.attribute_name)}
    if node.type == "TEX_COORD" and source.output.name == "UV":
        return {}
    if node.type == "MAPPING":
        inner = placement(reader, reader.source(node.inputs["Vector"], source.groups), of)
        if "stScale" in inner:
            reader.note(f"node '{node.name}': of two mappings only the first is translated")
            return inner
        return {**inner, **mapped(reader, node)}
    reader.note(f"node '{node.name}' before the image of '{of.node.name}' is not translated; the UV map is used")
    return {}


def mapped(reader, node):
    """A mapping in the plane: uv' = R (scale uv) + location, and its inverse. Ours acts on v down."""
    location, rotation, scale = (node.inputs[name].default_value[:] if name in node.inputs else same
                                 for name, same in (("Location", (0, 0, 0)), ("Rotation", (0, 0, 0)), ("Scale", (1, 1, 1))))
    if any(socket.is_linked for socket in node.inputs[1:]) or abs(rotation[0]) + abs(rotation[1]) > 1e-6:
        reader.note(f"node '{node.name}': linked inputs and rotations out of the plane are not translated")
    angle, x, y = rotation[2], *location[:2]
    if node.vector_type == "TEXTURE":
        if angle and abs(scale[0] - scale[1]) > 1e-6 * abs(scale[0]):
            reader.note(f"node '{node.name}': an uneven scale with a rotation is not translated exactly")
        scale = [1 / s if s else 0.0 for s in scale]
        angle = -angle
        x, y = (-(math.cos(angle) * x - math.sin(angle) * y) * scale[0], -(math.sin(angle) * x + math.cos(angle) * y) * scale[1])
    elif node.vector_type == "VECTOR":
        x = y = 0.0
    elif node.vector_type == "NORMAL":
        reader.note(f"node '{node.name}': type normal is not translated")
        return {}
    # With d = 1 - v: u' = ox + c sx u + s sy d and 1 - v' = oy - s sx u + c sy d, so the constants of u' and v' decide ox, oy.
    c, s = math.cos(angle), math.sin(angle)
    return {"stScale": tuple(scale[:2]), "stRotation": angle, "stOffset": (x - s * scale[1], 1 - y - c * scale[1])}


def math_node(reader, source):
    value = math_value(reader, source)
    if value is None or not source.node.use_clamp:
        return value
    if value.textures:
        reader.note(f"node '{source.node.name}': the clamp of a texture is not translated")
        return value
    return Value(tuple(min(max(c, 0.0), 1.0) for c in value.constant))


def math_value(reader, source):
    """The result before the clamp."""
    node = source.node
    a, b, c = ([reader.value(socket, source.groups) for socket in node.inputs] + [Value(ONE)] * 3)[:3]
    kind = node.operation
    if kind == "MULTIPLY":
        return Value(multiplied(a.constant, b.constant), a.textures + b.textures)
    if kind in {"ADD", "SUBTRACT", "MULTIPLY_ADD"}:
        if kind == "MULTIPLY_ADD":
            a, b = Value(multiplied(a.constant, b.constant), a.textures + b.textures), c
        sign = -1.0 if kind == "SUBTRACT" else 1.0
        if not b.textures:
            return reader.changed(a, ONE, multiplied(b.constant, (sign,) * 3))
        return reader.changed(b, (sign,) * 3, a.constant) if not a.textures else None
    if a.textures or b.textures:
        return None
    x, y = a.number, b.number
    simple = {"DIVIDE": lambda: x / y if y else 0.0, "POWER": lambda: x ** y if x >= 0 else 0.0, "MAXIMUM": lambda: max(x, y),
              "MINIMUM": lambda: min(x, y), "SQRT": lambda: math.sqrt(max(x, 0.0)), "ABSOLUTE": lambda: abs(x)}
    try:
        return Value((simple[kind](),) * 3) if kind in simple else None
    except (OverflowError, ZeroDivisionError):  # a power may have no finite value
        return None


def mix_parts(node):
    """(factor, a, b, blend type) of both generations of mix nodes; None for one that mixes no colours or numbers."""
    if node.type == "MIX_RGB":
        return node.inputs[0], node.inputs[1], node.inputs[2], node.blend_type
    wanted = {"RGBA": "Color", "FLOAT": "Float", "VECTOR": "Vector"}.get(node.data_type)
    if wanted is None:
        return None
    inputs = [one for one in node.inputs if one.enabled and not one.hide]
    factor = next(one for one in inputs if one.name == "Factor")
    a, b = (next(one for one in inputs if one.name == name) for name in "AB")
    return factor, a, b, node.blend_type if node.data_type == "RGBA" else "MIX"


def mix(reader, source):
    parts = mix_parts(source.node)
    if parts is None:
        return None
    factor, a, b = (reader.value(socket, source.groups) for socket in parts[:3])
    blend = parts[3]
    if blend == "MIX":
        return reader.mixed(a, b, factor)
    if factor.textures:
        return None
    f = factor.number
    if blend == "MULTIPLY":
        b = b if f >= 1 else reader.mixed(Value(ONE), b, factor)
        return Value(multiplied(a.constant, b.constant), a.textures + b.textures)
    if blend in {"ADD", "SUBTRACT"} and not (a.textures and b.textures):
        sign = f if blend == "ADD" else -f
        return (reader.changed(a, ONE, multiplied(b.constant, (sign,) * 3)) if not b.textures
                else reader.changed(b, (sign,) * 3, a.constant))
    return None


def invert(reader, source):
    factor, color = (reader.value(socket, source.groups) for socket in source.node.inputs[:2])
    if factor.textures:
        return None
    f = factor.number
    return reader.changed(color, (1 - 2 * f,) * 3, (f,) * 3)


def separate(reader, source):
    value = reader.value(source.node.inputs[0], source.groups)
    channel = CHANNELS.get(source.output.name)
    if channel is None or getattr(source.node, "mode", "RGB") != "RGB":
        return None
    index = "rgb".index(channel)
    picked = [Texture(t.parameters, channel if t.channel == "rgb" else t.channel, (t.scale[index],) * 3, (t.bias[index],) * 3, t.image)
              for t in value.textures]
    return Value((value.constant[index],) * 3, picked)


def map_range(reader, source):
    node = source.node
    if node.data_type != "FLOAT" or node.interpolation_type != "LINEAR":
        return None
    x, low, high, to_low, to_high = (reader.value(socket, source.groups) for socket in node.inputs[:5])
    if any(one.textures for one in (low, high, to_low, to_high)) or high.number == low.number:
        return None
    rate = (to_high.number - to_low.number) / (high.number - low.number)
    return reader.changed(x, (rate,) * 3, (to_low.number - rate * low.number,) * 3)


def blackbody(_, source):
    return None if source.node.inputs[0].is_linked else Value(tuple(_kelvin(source.node.inputs[0].default_value)))


def _kelvin(kelvin):
    """Rec. 709 of a blackbody, of luminance 1 (Kim et al.'s fit of its chromaticity)."""
    t = min(max(kelvin, 1667.0), 25000.0)
    x = (-0.2661239e9 / t ** 3 - 0.2343589e6 / t ** 2 + 0.8776956e3 / t + 0.179910 if t < 4000 else
         -3.0258469e9 / t ** 3 + 2.1070379e6 / t ** 2 + 0.2226347e3 / t + 0.240390)
    if t < 2222:
        y = -1.1063814 * x ** 3 - 1.34811020 * x ** 2 + 2.18555832 * x - 0.20219683
    elif t < 4000:
        y = -0.9549476 * x ** 3 - 1.37418593 * x ** 2 + 2.09137015 * x - 0.16748867
    else:
        y = 3.0817580 * x ** 3 - 5.87338670 * x ** 2 + 3.75112997 * x - 0.37001483
    big_x, big_z = x / y, (1 - x - y) / y
    return [max(0.0, value) for value in (3.2409699 * big_x - 1.5373832 - 0.4986108 * big_z,
                                          -0.9692436 * big_x + 1.8759675 + 0.0415551 * big_z,
                                          0.0556301 * big_x - 0.2039770 + 1.0569715 * big_z)]


def light_path(reader, source):
    """Evaluates Light Path as for camera rays, because all rays see one surface."""
    reader.note(f"node '{source.node.name}': all rays see what those of the camera see")
    return Value(ONE if source.output.name == "Is Camera Ray" else (0.0, 0.0, 0.0))


NODES = {
    "TEX_IMAGE": image,
    "LIGHT_PATH": light_path,
    "RGB": lambda _, source: Value(three(source.output.default_value)),
    "VALUE": lambda _, source: Value(three(source.output.default_value)),
    "VERTEX_COLOR": lambda _, source: Value(ONE, [Texture(None)]) if source.output.name == "Color" else None,
    "ATTRIBUTE": lambda _, source: Value(ONE, [Texture(None)]) if source.output.name == "Color" else None,
    "MATH": math_node,
    "MIX": mix,
    "MIX_RGB": mix,
    "INVERT": invert,
    "SEPARATE_COLOR": separate,
    "SEPRGB": separate,
    "MAP_RANGE": map_range,
    "BLACKBODY": blackbody,
}
