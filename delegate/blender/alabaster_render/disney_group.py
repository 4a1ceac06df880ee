"""Our material as a node group: an input for each parameter of schemas/disney_material.json, with its range and sentence."""
import bpy

from . import schema

NAME = "Alabaster Material"
MODERN = bpy.app.version >= (4, 0, 0)
PARAMETERS = {name: p for name, p in schema.parameters("disney_material").items() if p.kind != "enum"}  # sockets have no words
KINDS = {"float": "NodeSocketFloat", "int": "NodeSocketInt", "bool": "NodeSocketBool", "color": "NodeSocketColor"}
# The Principled BSDF inside stands in for ours in other engines: an input of the group, and its inputs of both generations.
PREVIEW = {"baseColor": ("Base Color",), "metallic": ("Metallic",), "roughness": ("Roughness",), "opacity": ("Alpha",),
           "specTrans": ("Transmission", "Transmission Weight"), "ior": ("IOR",), "emission": ("Emission", "Emission Color")}
VECTORS = {"scatterDistance", "meanFreePath", "subsurfaceColor"}  # sockets of colours have neither lengths nor values below 0
SOFT_MAXIMUM = {"scatterDistance": 1.0, "meanFreePath": 1.0, "attenuationDistance": 10.0, "iridescenceThickness": 1000.0}
LARGEST = 3.402823466e38


def is_ours(node):
    return node.type == "GROUP" and node.node_tree is not None and node.node_tree.get("alabaster") == NAME


def tree():
    """The group, which is made where the file has none."""
    found = next((one for one in bpy.data.node_groups if one.get("alabaster") == NAME), None)
    return found or _make()


def _socket(made, name, kind, direction="INPUT", description=""):
    if MODERN:
        return made.interface.new_socket(name, description=description, in_out=direction, socket_type=kind)
    socket = (made.inputs if direction == "INPUT" else made.outputs).new(kind, name)
    socket.description = description
    return socket


def _input(made, p):
    kind = "NodeSocketFloatFactor" if (p.kind, p.minimum, p.maximum) == ("float", 0, 1) and not MODERN else KINDS[p.kind]
    if p.name in VECTORS:
        kind = "NodeSocketVector"
    socket = _socket(made, p.name, kind, description=p.description)
    if kind == "NodeSocketColor":
        socket.default_value = (*p.default, 1.0)
        return
    socket.default_value = tuple(p.default) if p.kind == "color" else p.default
    if p.kind in {"float", "int"} or kind == "NodeSocketVector":
        if p.minimum is not None:
            socket.min_value = p.minimum
        socket.max_value = p.maximum if p.maximum is not None else (LARGEST if p.kind != "int" else 2 ** 31 - 1)


def _make():
    made = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    made["alabaster"] = NAME
    for p in PARAMETERS.values():
        _input(made, p)
    for name in ("normal", "coatNormal"):
        _socket(made, name, "NodeSocketVector").hide_value = True
    _socket(made, "BSDF", "NodeSocketShader", "OUTPUT")
    inner, begin, end = (made.nodes.new(kind) for kind in ("ShaderNodeBsdfPrincipled", "NodeGroupInput", "NodeGroupOutput"))
    begin.location, end.location = (-300, 0), (300, 0)
    for ours, theirs in PREVIEW.items():
        socket = next(inner.inputs[name] for name in theirs if name in inner.inputs)
        made.links.new(begin.outputs[ours], socket)
    inner.inputs["Emission Strength"].default_value = 1.0
    made.links.new(begin.outputs["normal"], inner.inputs["Normal"])
    made.links.new(inner.outputs[0], end.inputs[0])
    return made


def translate(reader, source):
    from . import shaders
    surface = {}
    for p in PARAMETERS.values():
        socket = source.node.inputs.get(p.name)
        if socket is None:
            continue  # a group of an older version
        value = reader.value(socket, source.groups)
        if p.kind == "bool":
            surface[p.name] = value.number > 0.5
        elif p.kind == "int":
            surface[p.name] = int(round(value.number))
        else:
            made = reader.color(value) if p.kind == "color" else reader.number(value)
            if not is_default(made, p):
                surface[p.name] = made
    for name in ("normal", "coatNormal"):
        socket = source.node.inputs.get(name)
        if socket is not None:
            shaders.relief(reader, reader.source(socket, source.groups), surface, name)
    return surface


def is_default(made, p):
    """Blender keeps floats: 0.8 is not quite 0.8."""
    if isinstance(made, list):
        return False
    given, known = (made, p.default) if p.kind == "color" else ([made], [p.default])
    return all(abs(a - b) <= 1e-6 * abs(b) for a, b in zip(given, known))


class NODE_OT_alabaster_material(bpy.types.Operator):
    bl_idname = "node.alabaster_material"
    bl_label = "Alabaster Material"
    bl_description = "Gives the active material Alabaster's own node group, with all parameters of its surface"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.active_material is not None

    def execute(self, context):
        assign(context.object.active_material)
        return {"FINISHED"}


def assign(material):
    """The group's node, as the material's surface."""
    material.use_nodes = True
    nodes = material.node_tree.nodes
    node = nodes.new("ShaderNodeGroup")
    node.node_tree, node.name, node.width = tree(), NAME, 240
    output = material.node_tree.get_output_node("ALL") or nodes.new("ShaderNodeOutputMaterial")
    node.location = (output.location.x - 320, output.location.y)
    material.node_tree.links.new(node.outputs[0], output.inputs["Surface"])
    return node
