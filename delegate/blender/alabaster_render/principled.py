"""The Principled BSDF of both generations: Blender's until 3.6, and from 4.0 on."""
import math

import bpy

from . import schema, subsurface

MODERN = bpy.app.version >= (4, 0, 0)
DEFAULTS = {name: tuple(p.default) if p.kind == "color" else p.default for name, p in schema.parameters("disney_material").items()}
relief = None  # shaders.relief, which needs this module


def translate(reader, source):
    surface = {"roughness": reader.number(reader.input(source, "Roughness"), "g"),
               "metallic": reader.number(reader.input(source, "Metallic"), "b"),
               "anisotropic": reader.number(reader.input(source, "Anisotropic"))}
    if surface["anisotropic"]:
        surface["anisotropicRotation"] = reader.number(reader.input(source, "Anisotropic Rotation"))
    opacity = reader.number(reader.input(source, "Alpha"))
    if opacity != 1.0:
        surface["opacity"] = opacity
    _base(reader, source, surface)
    _specular(reader, source, surface)
    _layers(reader, source, surface)
    _emission(reader, source, surface)
    relief(reader, reader.source(source.input("Normal"), source.groups), surface)
    coat = source.input("Clearcoat Normal", "Coat Normal")
    relief(reader, reader.source(coat, source.groups), surface, "coatNormal")
    return surface


def _base(reader, source, surface):
    color = reader.input(source, "Base Color")
    weight = reader.input(source, "Subsurface", "Subsurface Weight")
    share = 1.0 if MODERN and weight.textures else number_of(reader, weight, "subsurface weight")
    if share <= 0:
        surface["baseColor"] = reader.color(_glass_color(reader, source, color))
        return
    scale = share if not MODERN else number_of(reader, reader.input(source, "Subsurface Scale"), "subsurface scale")
    if not MODERN:
        color = reader.mixed(color, reader.input(source, "Subsurface Color"), weight)
    body = {name: reader.input(source, f"Subsurface {name}") for name in ("Radius", "IOR", "Anisotropy")}
    scatter(reader, surface, color, body, scale, source.node.subsurface_method)
    if MODERN and (share < 1 or weight.textures):
        surface["subsurfaceWeight"] = reader.number(weight)


def number_of(reader, value, what):
    return sum(reader.mean(value, what)) / 3


def scatter(reader, surface, color, body, scale, method):
    """baseColor and what scatters below it. body: values of Radius, IOR and Anisotropy."""
    asked = number_of(reader, body["Anisotropy"], "subsurface anisotropy") if body["Anisotropy"] else 0.0
    ior = number_of(reader, body["IOR"], "subsurface IOR") if body["IOR"] else 1.4
    depends = subsurface.depends_on_color(method)
    albedo = reader.mean(color, "mean free path, which depends on the colour,") if depends else (0.8,) * 3
    factors = tuple(scale * f for f in subsurface.path_factors(method, albedo, ior, asked))
    surface["baseColor"] = reader.color(color)
    surface["meanFreePath"] = reader.color(reader.changed(body["Radius"], factors, (0.0, 0.0, 0.0)))
    surface["scatterAnisotropy"] = subsurface.anisotropy(method, asked)


def _glass_color(reader, source, color):
    """Until 3.6 a clear body takes the colour at each surface; from 4.0 on its root, as here."""
    if MODERN or color.textures or reader.input_number(source, "Transmission") < 1:
        return color
    return type(color)(tuple(c * c for c in color.constant))


def _specular(reader, source, surface):
    transmission = reader.input(source, "Transmission", "Transmission Weight")
    if transmission.textures or transmission.number > 0:
        surface["specTrans"] = reader.number(transmission)
    level = reader.input(source, "Specular", "Specular IOR Level")
    ior = reader.input_number(source, "IOR")
    clear = transmission.number > 0
    if MODERN:
        f0 = ((ior - 1) / (ior + 1)) ** 2 * (2 * level.number)
        surface["specularColor"] = reader.color(reader.input(source, "Specular Tint"))
    else:
        f0 = 0.08 * level.number
        surface["specularTint"] = reader.number(reader.input(source, "Specular Tint"))
    if level.textures:
        surface["ior"], surface["specular"] = 1.5, reader.number(reader.changed(level, (2.0,) * 3, (0.0,) * 3))
        reader.note("a texture of specular above one half is clamped there")
    elif clear:
        surface["ior"] = max(1.0, ior)
    else:
        root = math.sqrt(min(f0, 0.36))
        surface["ior"] = (1 + root) / (1 - root)


def _layers(reader, source, surface):
    coat = reader.input(source, "Clearcoat", "Coat Weight")
    roughness = reader.input(source, "Clearcoat Roughness", "Coat Roughness")
    if coat.textures or coat.number > 0:
        # Until 3.6 Blender's coat is a quarter as strong, as Disney's is, but a layer of GGX already.
        share = coat if MODERN else reader.changed(coat, (0.25,) * 3, (0.0,) * 3)
        surface["coat"], surface["coatRoughness"] = reader.number(share), reader.number(roughness)
        if MODERN:
            surface["coatIor"] = max(1.0, reader.input_number(source, "Coat IOR"))
            surface["coatColor"] = reader.color(reader.input(source, "Coat Tint"))
    sheen = reader.input(source, "Sheen", "Sheen Weight")
    if sheen.textures or sheen.number > 0:
        surface["sheen"] = reader.number(sheen)
        if MODERN:
            surface["sheenTint"] = 0.0
            surface["sheenColor"] = reader.color(reader.input(source, "Sheen Tint"))
            surface["sheenRoughness"] = max(reader.input_number(source, "Sheen Roughness"), 0.01)
        else:
            surface["sheenTint"] = reader.number(reader.input(source, "Sheen Tint"))
    film = reader.input_number(source, "Thin Film Thickness")
    if film > 0:
        surface.update(iridescence=1.0, iridescenceThickness=film, iridescenceIor=max(1.0, reader.input_number(source, "Thin Film IOR")))


def _emission(reader, source, surface):
    strength = reader.input_number(source, "Emission Strength")
    color = reader.input(source, "Emission", "Emission Color")
    if strength > 0 and (color.textures or max(color.constant) > 0):
        surface["emission"] = reader.color(reader.changed(color, (strength,) * 3, (0.0, 0.0, 0.0)))
