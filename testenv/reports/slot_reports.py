"""Every texture of a glTF material shows what its specification says: channel, colour space, coordinates and transform."""
import math

import numpy as np
from made_images import flat, png, to_linear
from made_models import CUBE, CUBE_SIDES, UV, Model
from public_reports import report

LIGHTS = [{"name": "sky", "type": "domeLight", "intensity": .3},
          {"name": "key", "type": "rectLight", "width": 2, "height": 2, "intensity": 10, "position": [2, 1, 3], "target": [0, 0, 0]}]
TEXEL = (60, 200, 128, 180)
OTHERS = (230, 20, 250, 40)
CORE = {"baseColorFactor": [.8, .6, .4, 1], "metallicFactor": 0, "roughnessFactor": .4}
EXT = "KHR_materials_"
LINEAR = [to_linear(v) for v in TEXEL[:3]]
R, G, B, A = (v / 255 for v in TEXEL)

# name: (extension, texture, its layer without the texture, the layer of the same look without it; None: a texture of one colour)
SLOTS = {
    "base colour": (None, "baseColorTexture", {**CORE, "baseColorFactor": [1, .5, 1, 1]},
                    {**CORE, "baseColorFactor": [LINEAR[0], LINEAR[1] / 2, LINEAR[2], 1]}),
    "metal, roughness": (None, "metallicRoughnessTexture", {**CORE, "metallicFactor": .5, "roughnessFactor": .7},
                         {**CORE, "metallicFactor": B / 2, "roughnessFactor": .7 * G}),
    "coat": ("clearcoat", "clearcoatTexture", {"clearcoatFactor": .9}, {"clearcoatFactor": .9 * R}),
    "coat's roughness": ("clearcoat", "clearcoatRoughnessTexture", {"clearcoatFactor": 1, "clearcoatRoughnessFactor": .6},
                         {"clearcoatFactor": 1, "clearcoatRoughnessFactor": .6 * G}),
    "coat's normal": ("clearcoat", "clearcoatNormalTexture", {"clearcoatFactor": 1}, None),
    "sheen": ("sheen", "sheenColorTexture", {"sheenColorFactor": [1, .5, 1], "sheenRoughnessFactor": .5},
              {"sheenColorFactor": [LINEAR[0], LINEAR[1] / 2, LINEAR[2]], "sheenRoughnessFactor": .5}),
    "sheen's roughness": ("sheen", "sheenRoughnessTexture", {"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": .9},
                          {"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": .9 * A}),
    "specular": ("specular", "specularTexture", {"specularFactor": .9}, {"specularFactor": .9 * A}),
    "specular colour": ("specular", "specularColorTexture", {"specularColorFactor": [2, 1, 1]},
                        {"specularColorFactor": [2 * LINEAR[0], LINEAR[1], LINEAR[2]]}),
    "transmission": ("transmission", "transmissionTexture", {"transmissionFactor": .9}, {"transmissionFactor": .9 * R}),
    "film": ("iridescence", "iridescenceTexture", {"iridescenceFactor": 1}, {"iridescenceFactor": R}),
    "film's thickness": ("iridescence", "iridescenceThicknessTexture",
                         {"iridescenceFactor": 1, "iridescenceThicknessMinimum": 200, "iridescenceThicknessMaximum": 600},
                         {"iridescenceFactor": 1, "iridescenceThicknessMinimum": 0, "iridescenceThicknessMaximum": 200 + 400 * G}),
    "anisotropy": ("anisotropy", "anisotropyTexture", {"anisotropyStrength": .8, "anisotropyRotation": .3}, None),
    "diffuse transmission": ("diffuse_transmission", "diffuseTransmissionTexture", {"diffuseTransmissionFactor": .9},
                             {"diffuseTransmissionFactor": .9 * A}),
    "its colour": ("diffuse_transmission", "diffuseTransmissionColorTexture",
                   {"diffuseTransmissionFactor": .5, "diffuseTransmissionColorFactor": [1, .5, 1]},
                   {"diffuseTransmissionFactor": .5, "diffuseTransmissionColorFactor": [LINEAR[0], LINEAR[1] / 2, LINEAR[2]]}),
    "diffuse of glossiness": ("pbrSpecularGlossiness", "diffuseTexture", {"diffuseFactor": [1, 1, 1, 1], "specularFactor": [.04] * 3, "glossinessFactor": .6},
                              {"diffuseFactor": [*LINEAR, 1], "specularFactor": [.04] * 3, "glossinessFactor": .6}),
    "specular, glossiness": ("pbrSpecularGlossiness", "specularGlossinessTexture", {"specularFactor": [.2, .2, .2], "glossinessFactor": .9}, None),
    "normal": ("", "normalTexture", {}, None),
    "emission": ("", "emissiveTexture", {"emissiveFactor": [1, .5, 1]}, {"emissiveFactor": [LINEAR[0], LINEAR[1] / 2, LINEAR[2]]}),
}


def look(case, extension, layer, texture=None, image=None, transform=None):
    """A square whose material has this layer, over a grey one; every attribute that a layer needs is given."""
    model = Model()
    material = {"pbrMetallicRoughness": CORE, "doubleSided": True}
    layer = dict(layer)
    if texture:
        layer[texture] = {"index": model.image(image), **({"extensions": {"KHR_texture_transform": transform}} if transform else {})}
    if transform:
        model.use("KHR_texture_transform")
    if extension is None:
        material["pbrMetallicRoughness"] = layer
    elif extension == "":
        material.update(layer)
    else:
        model.use(EXT + extension)
        material["extensions"] = {EXT + extension: layer}
    attributes = {"TEXCOORD_0": [(.1, .1)] * 4 if transform else UV, "TEXCOORD_1": UV, "TANGENT": [(1, 0, 0, 1)] * 4}
    model.square(model.add("materials", material), attributes)
    model.node(mesh=model.mesh(model.primitive([np.multiply(p, (.8, .5, .1)) + (0, 0, -1) for p in CUBE], CUBE_SIDES)))
    return case.render(model.write(case.folder / "model.glb"), lights=LIGHTS, samples=16).rgb()


@report("three.js 13844, glTF-Sample-Models 267, glTF-Blender-IO 657", "each texture of each layer: channel, colour space, texCoord and transform")
def slots(case):
    grid = np.empty((4, 4, 4), int)
    grid[:] = OTHERS
    grid[1, 2] = TEXEL
    # within the texel of column 2 and row 1, whatever the rotation
    transform = {"offset": [.625, .375], "scale": [.01, .01], "rotation": .7, "texCoord": 1}
    for name, (extension, texture, layer, constant) in SLOTS.items():
        one = look(case, extension, layer, texture, png(flat(*TEXEL)))
        of_grid = look(case, extension, layer, texture, png(grid), transform)
        plain = look(case, extension, layer)
        case.true(f"{name} has an effect", np.abs(one - plain).max() > 2e-3, np.abs(one - plain).max())
        case.near(f"{name}, transformed: largest difference", np.abs(of_grid - one).max(), 0, 2e-3)
        if constant is not None:
            case.near(f"{name}, as a constant: largest difference", np.abs(look(case, extension, constant) - one).max(), 0, 4e-3)


def mapped_normals(case, coordinates, textures):
    """The normals in the left and the right half of a square, whose primitives have a material for each texture."""
    model = Model()
    model.use("KHR_texture_transform")
    image = model.image(png(flat(190, 140, 230)))
    halves = [[(x, y, 0) for x, y in ((-1, -1), (0, -1), (0, 1), (-1, 1))], [(x, y, 0) for x, y in ((0, -1), (1, -1), (1, 1), (0, 1))]]
    primitives = []
    for points, texture in zip(halves, textures):
        material = model.add("materials", {"normalTexture": {"index": image, **texture}, "pbrMetallicRoughness": {"metallicFactor": 0}})
        sets = {f"TEXCOORD_{i}": [of(x / 2 + .5, .5 - y / 2) for x, y, _ in points] for i, of in enumerate(coordinates)}
        primitives.append(model.primitive(points, attributes={"NORMAL": [(0, 0, 1)] * 4, **sets}, material=material))
    model.node(mesh=model.mesh(*primitives))
    picture = case.render(model.write(case.folder / "normals.glb"), aovs=["normal"], lights=LIGHTS[:1])
    normals = np.stack([picture.layers["N." + c] for c in "XYZ"], -1)
    return normals[4, 1], normals[4, 6]


@report("glTF 1637, glTF-Sample-Viewer 592, Second Life viewer 234", "tangents of a normal map follow its own set and its transform, in each part of a mesh")
def tangents_of_maps(case):
    angle, scale = .6, (2, .5)

    def plain(u, v):
        return u, v

    def turned(u, v):
        u, v = u * scale[0], v * scale[1]
        return math.cos(angle) * u + math.sin(angle) * v + .1, -math.sin(angle) * u + math.cos(angle) * v + .2
    transform = {"extensions": {"KHR_texture_transform": {"offset": [.1, .2], "rotation": angle, "scale": list(scale)}}}
    mirror = {"extensions": {"KHR_texture_transform": {"scale": [-1, 1]}}}
    straight, _ = mapped_normals(case, [plain], [{}, {}])
    right, _ = mapped_normals(case, [turned], [{}, {}])
    mirrored, _ = mapped_normals(case, [lambda u, v: (-u, v)], [{}, {}])
    case.true("the directions differ", np.abs(straight - right).max() > .1 and np.abs(straight - mirrored).max() > .1)
    case.near("a set and another", mapped_normals(case, [plain, turned], [{}, {"texCoord": 1}]), [straight, right], 3e-3)
    case.near("a set and a transform", mapped_normals(case, [plain], [{}, transform]), [straight, right], 3e-3)
    case.near("a transform and a mirror image", mapped_normals(case, [plain], [transform, mirror]), [right, mirrored], 3e-3)
