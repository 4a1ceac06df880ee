"""Materials of Blender as networks of AlabasterDisney. README.md has the table of what becomes what."""
import dataclasses
from typing import NamedTuple

from . import shaders
from .sockets import Reader, Source


class Wanted(NamedTuple):
    """Names of UV maps and of colour attributes that materials read."""
    maps: frozenset = frozenset()
    colors: frozenset = frozenset()

    @staticmethod
    def of(materials):
        maps, colors = set(), set()
        for material in materials:
            if material.use_nodes and material.node_tree:
                _find(material.node_tree, maps, colors, set())
        return Wanted(frozenset(maps), frozenset(colors))

    def __sub__(self, other):
        """True if there is a name that the other has not."""
        return bool(self.maps - other.maps or self.colors - other.colors)


def _find(tree, maps, colors, seen):
    if tree in seen:
        return
    seen.add(tree)
    for node in tree.nodes:
        if node.type in {"UVMAP", "NORMAL_MAP"} and node.uv_map:
            maps.add(node.uv_map)
        elif node.type == "VERTEX_COLOR":
            colors.add(node.layer_name)
        elif node.type == "ATTRIBUTE":
            maps.add(node.attribute_name)
            colors.add(node.attribute_name)
        elif node.type == "GROUP" and node.node_tree:
            _find(node.node_tree, maps, colors, seen)


@dataclasses.dataclass
class Network:
    """nodes of hdalabaster.Scene.set_material, and the one that displaces. Properties of meshes: holdout, where the surface is a
    Holdout shader, and left_out, where there is a volume alone."""
    nodes: dict = dataclasses.field(default_factory=lambda: {"surface": {}})
    displacement: str = ""
    holdout: bool = False
    left_out: bool = False

    def role(self):
        return self.holdout, self.left_out


def translate(material, note):
    """None is Blender's look of a mesh without material."""
    network = Network()
    surface = network.nodes["surface"]
    if material is None:
        surface.update(baseColor=(0.8, 0.8, 0.8), roughness=0.5)
        return network
    if not material.use_nodes or not material.node_tree:
        surface.update(baseColor=tuple(material.diffuse_color)[:3], metallic=material.metallic, roughness=material.roughness)
        return network
    reader = Reader(network, lambda text: note(f"material '{material.name}': {text}"))
    output = material.node_tree.get_output_node("CYCLES") or material.node_tree.get_output_node("ALL")
    if output is None:
        surface.update(baseColor=(0, 0, 0), specular=0.0)
        return network
    source = reader.source(output.inputs["Surface"])
    network.holdout = shaders.is_holdout(source)
    surface.update(shaders.translate(reader, source))
    volume = reader.source(output.inputs["Volume"])
    if isinstance(volume, Source) and volume.node.type == "VOLUME_ABSORPTION" and "specTrans" in surface:
        surface.update(shaders.absorption(reader, volume))
    elif isinstance(volume, Source):
        network.left_out = not isinstance(source, Source)
        reader.note("the volume is not translated" + ("; it has no surface, so its faces are left out" if network.left_out else ""))
    if network.left_out:
        surface["opacity"] = 0.0
    shaders.displace(reader, output, _displacement_method(material), surface)
    return network


def _displacement_method(material):
    return getattr(material, "displacement_method", None) or material.cycles.displacement_method
