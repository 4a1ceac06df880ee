"""Shader nodes as parameters of schemas/disney_material.json."""
import math

from . import disney_group, images, principled
from .sockets import ONE, Source, Texture, Value

BLACK = {"baseColor": (0.0, 0.0, 0.0), "specular": 0.0}
# Disney's diffuse at this roughness reflects what Lambert's does, within 1 % of any view and 3 % at grazing ones.
LAMBERT = {"specular": 0.0, "ior": 1.0, "roughness": 0.43}


def translate(reader, source):
    """Inputs of the surface node. `source` is linked to a socket of shaders."""
    if not isinstance(source, Source):
        return dict(BLACK)
    if disney_group.is_ours(source.node):
        return disney_group.translate(reader, source)
    known = SHADERS.get(source.node.type)
    if known is None:
        reader.note(f"shader '{source.node.name}' is not translated; the surface is black")
        return dict(BLACK)
    return dict(reader.once("surface", source, lambda: known(reader, source)) or BLACK)


def is_holdout(source):
    return isinstance(source, Source) and source.node.type == "HOLDOUT"


def holdout(_reader, _source):
    """Black to all but the camera, for which the mesh is a hold-out."""
    return dict(BLACK)


def _bump(reader, source, surface):
    normal = source.input("Normal")
    if normal is not None:
        relief(reader, reader.source(normal, source.groups), surface)
    return surface


def relief(reader, source, surface, into="normal"):
    """A Normal Map or Bump node as the surface's `normal` or `bump`, or the coat's `coatNormal`."""
    if not isinstance(source, Source):
        return
    node = source.node
    if node.type == "NORMAL_MAP":
        strength = reader.input(source, "Strength").number
        value = reader.input(source, "Color")
        if node.space != "TANGENT" or not value.textures:
            reader.note(f"node '{node.name}': only an image of tangent space is translated")
            return
        parameters = dict(value.textures[0].parameters)
        if node.uv_map and "st" not in parameters:
            parameters["st"] = images.uv_primvar(node.uv_map)
        texture = Texture(parameters, "rgb", (2 * strength, 2 * strength, 2.0), (-strength, -strength, -1.0))
        surface[into] = [(reader.node(texture), "rgb")]
    elif node.type == "BUMP" and into == "normal":
        height = reader.input(source, "Height")
        scale = reader.input(source, "Strength").number * reader.input(source, "Distance").number
        if not height.textures:
            return
        surface["bump"] = reader.number(reader.changed(height, (-scale if node.invert else scale,) * 3, (0.0, 0.0, 0.0)))[:1]
        if isinstance(reader.source(source.input("Normal"), source.groups), Source):
            reader.note(f"node '{node.name}': a normal map below a bump map is not translated")
    else:
        reader.note(f"node '{node.name}' at a normal is not translated")


def displace(reader, output, method, surface):
    """The material's displacement: of points, or as bump."""
    source = reader.source(output.inputs["Displacement"])
    if not isinstance(source, Source):
        return
    if source.node.type != "DISPLACEMENT":
        reader.note(f"node '{source.node.name}' at the displacement is not translated")
        return
    height = reader.input(source, "Height")
    scale, midlevel = reader.input(source, "Scale").number, reader.input(source, "Midlevel").number
    if not height.textures:
        return
    if method == "BUMP":
        surface.setdefault("bump", reader.number(reader.changed(height, (scale,) * 3, (0.0, 0.0, 0.0)))[:1])
        return
    reader.network.displacement = "displacement"
    reader.network.nodes["displacement"] = {"type": "AlabasterDisplacement", "displacement": reader.number(height)[0],
                                            "scale": scale, "midlevel": midlevel}


def diffuse(reader, source):
    return _bump(reader, source, {**LAMBERT, "baseColor": reader.color(reader.input(source, "Color"))})


def glossy(reader, source):
    surface = {"baseColor": reader.color(reader.input(source, "Color")), "metallic": 1.0,
               "roughness": reader.number(reader.input(source, "Roughness"))}
    return _bump(reader, source, surface)


def anisotropic(reader, source):
    surface = glossy(reader, source)
    stretch, turns = (reader.input(source, name) for name in ("Anisotropy", "Rotation"))
    if stretch is None:
        return surface
    amount = reader.mean(stretch, "anisotropy")[0]
    # Positive values stretch the highlight across the tangent, ours along it.
    surface["anisotropic"] = min(abs(amount), 1.0)
    surface["anisotropicRotation"] = (reader.mean(turns, "rotation")[0] + (0.25 if amount > 0 else 0.0)) % 1.0
    return surface


def sheen(reader, source):
    """Fibres over black. The sigma of Velvet counts as their roughness."""
    if source.node.type == "BSDF_VELVET":
        reader.note(f"shader '{source.node.name}': fibres of another model stand in for it")
    rough = reader.input(source, "Roughness", "Sigma")
    surface = {**BLACK, "sheen": 1.0, "sheenTint": 0.0, "sheenColor": reader.color(reader.input(source, "Color")),
               "sheenRoughness": min(max(reader.mean(rough, "roughness of a sheen")[0], 0.07), 1.0)}
    return _bump(reader, source, surface)


def glass(reader, source):
    """Cycles takes the colour at each surface, ours its root."""
    color = reader.input(source, "Color")
    surface = {"baseColor": reader.color(color if color.textures else Value(tuple(c * c for c in color.constant))),
               "specTrans": 1.0, "roughness": reader.number(reader.input(source, "Roughness")),
               "ior": max(1.0, reader.input(source, "IOR").number)}
    return _bump(reader, source, surface)


def absorption(reader, source):
    """Beer and Lambert's law: (1 - colour) times the density is absorbed per unit."""
    density = max(0.0, sum(reader.mean(reader.input(source, "Density"), "density")) / 3)
    sigma = [max(0.0, 1 - c) * density for c in reader.mean(reader.input(source, "Color"), "colour of a volume")]
    if max(sigma) <= 0:
        return {}
    distance = 1 / max(sigma)
    return {"attenuationColor": tuple(math.exp(-s * distance) for s in sigma), "attenuationDistance": distance}


def emission(reader, source):
    strength = reader.input(source, "Strength").number
    color = reader.input(source, "Color")
    return {**BLACK, "emission": reader.color(reader.changed(color, (strength,) * 3, (0.0, 0.0, 0.0)))}


def subsurface(reader, source):
    surface = dict(LAMBERT)
    body = {name: reader.input(source, name) for name in ("Radius", "IOR", "Anisotropy")}
    scale = principled.number_of(reader, reader.input(source, "Scale"), "subsurface scale")
    principled.scatter(reader, surface, reader.input(source, "Color"), body, scale, source.node.falloff)
    return _bump(reader, source, surface)


def translucent(reader, source):
    color = reader.input(source, "Color")
    return _bump(reader, source, {**LAMBERT, "baseColor": (0.0, 0.0, 0.0), "diffTrans": 2.0, "diffTransColor": reader.color(color)})


def transparent(reader, source):
    color = reader.input(source, "Color").number
    if color < 0.999:
        reader.note(f"shader '{source.node.name}': only its mean counts, as opacity")
    return {**BLACK, "opacity": max(0.0, 1 - color)}


def mix(reader, source):
    """With transparency: opacity. Two surfaces without textures: the means of their parameters. Else the heavier one."""
    node = source.node
    a, b = (reader.source(node.inputs[i], source.groups) for i in (1, 2))
    factor = reader.value(node.inputs[0], source.groups)
    for this, other, flipped in ((a, b, False), (b, a, True)):
        if isinstance(this, Source) and this.node.type == "BSDF_TRANSPARENT":
            surface = translate(reader, other)
            share = reader.changed(factor, (-1.0,) * 3, ONE) if flipped else factor
            surface["opacity"] = reader.number(share)
            return surface
    first, second = translate(reader, a), translate(reader, b)
    f = factor.number
    numbers = all(not isinstance(v, list) for surface in (first, second) for v in surface.values())
    if factor.textures or not numbers or not 0 < f < 1:
        if 0 < f < 1 or factor.textures:
            reader.note(f"shader '{node.name}' mixes surfaces with textures; the one that counts more is used")
        return second if f > 0.5 else first
    reader.note(f"shader '{node.name}': the parameters of both surfaces are mixed instead of their light")
    return {name: _between(first.get(name, principled.DEFAULTS[name]), second.get(name, principled.DEFAULTS[name]), f)
            for name in {**first, **second}}


def _between(a, b, f):
    if isinstance(a, bool):
        return b if f > 0.5 else a
    if isinstance(a, (int, float)):
        return a * (1 - f) + b * f
    return tuple(x * (1 - f) + y * f for x, y in zip(a, b))


def _gloss_over(reader, source, parts):
    """A body and a Glossy shader: one surface with a specular of that colour. It grows towards grazing views; that of Cycles does not."""
    gloss = next((p for p in parts if isinstance(p, Source) and p.node.type in {"BSDF_GLOSSY", "BSDF_ANISOTROPIC"}), None)
    body = next((p for p in parts if p is not gloss), None)
    if gloss is None or not isinstance(body, Source):
        reader.note(f"shader '{source.node.name}': of a sum only the first surface is translated")
        return translate(reader, parts[0])
    surface = translate(reader, body)
    tint = reader.mean(reader.input(gloss, "Color"), "colour of a reflection")
    surface.update(specular=1.0, ior=1.5, specularColor=tuple(c / 0.04 for c in tint),
                   roughness=reader.number(reader.input(gloss, "Roughness")))
    return surface


def add(reader, source):
    """A surface and its emission, or a body and its gloss."""
    parts = [reader.source(socket, source.groups) for socket in source.node.inputs[:2]]
    glow = next((p for p in parts if isinstance(p, Source) and p.node.type == "EMISSION"), None)
    rest = next((p for p in parts if p is not glow), None)
    if glow is None:
        return _gloss_over(reader, source, parts)
    surface = translate(reader, rest)
    held, light = surface.get("emission", (0.0, 0.0, 0.0)), emission(reader, glow)["emission"]
    both_constant = not isinstance(held, list) and not isinstance(light, list)
    if any(held) and not both_constant:
        reader.note(f"shader '{source.node.name}': of two emissions with textures only one is translated")
    surface["emission"] = tuple(x + y for x, y in zip(held, light)) if both_constant else light
    return surface


SHADERS = {
    "BSDF_PRINCIPLED": principled.translate, "BSDF_DIFFUSE": diffuse, "BSDF_GLOSSY": anisotropic, "BSDF_METALLIC": glossy,
    "BSDF_ANISOTROPIC": anisotropic, "BSDF_SHEEN": sheen, "BSDF_VELVET": sheen,
    "BSDF_GLASS": glass, "BSDF_REFRACTION": glass, "EMISSION": emission, "SUBSURFACE_SCATTERING": subsurface,
    "BSDF_TRANSLUCENT": translucent, "BSDF_TRANSPARENT": transparent, "MIX_SHADER": mix, "ADD_SHADER": add,
    "HOLDOUT": holdout,
}
principled.relief = relief
