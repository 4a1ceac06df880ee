"""Further reports: compressed geometry, transforms, volumes, and images whose headers say how their values are meant."""
import struct

import numpy as np
from made_images import FLOAT, exr, flat, hdr, png, rgbe, tiff, to_linear
from made_models import CORNERS, CUBE, CUBE_SIDES, Model
from image_reports import SEEN, show, sky
from model_reports import COLOR, seen
from public_reports import report

DOME = [{"name": "sky", "type": "domeLight"}]
HALF = [(x / 2, y / 2, z) for x, y, z in CORNERS]


def middle_half(case, model, what, **more):
    """The square from -1/2 to 1/2 covers the middle 4 x 4 of 8 x 8 pixels."""
    right = np.zeros((8, 8))
    right[2:6, 2:6] = 1
    case.near(what, seen(case, model, **more).layers["A"], right, 3e-3)


@report("godot 44798, gdx-gltf 50, vircadia 957", "vertex colours of unsigned shorts and bytes without the flag 'normalized', as Blender 2.91 wrote them")
def colors_without_flag(case):
    for kind, most in (("u1", 255), ("u2", 65535)):
        for components in (3, 4):
            model = Model()
            stored = model.accessor([tuple(int(c * most) for c in (*COLOR, 1)[:components])] * 4, kind)
            model.square(model.unlit(), {"COLOR_0": stored})
            case.near(f"{kind}, {components} components", seen(case, model).middle[:3], COLOR, 4e-3)


@report("glTF-Sample-Viewer 609", "a node of scale 0 whose mesh has a skin: the joints alone place it")
def skin_of_no_size(case):
    model = Model()
    joint = model.node()
    mesh = model.mesh(model.primitive(HALF, attributes={"JOINTS_0": model.accessor([(0, 0, 0, 0)] * 4, "u1"), "WEIGHTS_0": [(1, 0, 0, 0)] * 4},
                                      material=model.unlit((*COLOR, 1))))
    model.node(mesh=mesh, skin=model.add("skins", {"joints": [joint]}), scale=[0, 0, 0])
    middle_half(case, model, "the square")


@report("glTF-Blender-IO 409, glTF 971", "a node of scale 0 along one axis is flat, and not gone")
def flat_node(case):
    for scale, turn in (([1, 1, 0], [0, 0, 0, 1]), ([0, 1, 1], [0, np.sqrt(.5), 0, np.sqrt(.5)]), ([1, 0, 1], [np.sqrt(.5), 0, 0, np.sqrt(.5)])):
        model = Model()
        cube = model.mesh(model.primitive([np.multiply(p, .5) for p in CUBE], CUBE_SIDES, material=model.unlit((*COLOR, 1), doubleSided=True)))
        model.node(mesh=cube, scale=scale, rotation=[float(v) for v in turn])
        middle_half(case, model, f"scale {scale}")


@report("FBX2glTF 31, genesis-world 3334, filament 3638", "normals below mirrored and stretched nodes")
def stretched_normals(case):
    normal = np.array([.6, 0, .8])
    for scale in ([4, 1, 1], [-1, 1, 1], [-4, 1, 1], [1, -2, 1]):
        model = Model()
        white = model.add("materials", {"pbrMetallicRoughness": {"metallicFactor": 0}, "doubleSided": True})
        model.square(white, {"NORMAL": [normal] * 4}, scale=scale)
        right = normal / scale
        picture = seen(case, model, aovs=["normal"], lights=DOME)
        case.near(f"scale {scale}", picture.layer("N.X", "N.Y", "N.Z"), right / np.linalg.norm(right), 4e-3)


@report("arnold-usd 83", "a scattering body below a mirrored node, and one of clockwise faces, look as the body itself")
def mirrored_body(case):
    means = []
    lights = [*DOME, {"name": "key", "type": "distantLight", "position": [0, 0, 9], "target": [0, 0, 0], "intensity": 2}]
    for scale, sides in (([1, 1, 1], CUBE_SIDES), ([-1, 1, 1], CUBE_SIDES), ([-1, -1, -1], CUBE_SIDES)):
        model = Model()
        model.node(mesh=model.mesh(model.primitive([np.multiply(p, .6) for p in CUBE], sides, material=model.add("materials", {
            "extensions": {"ALAB_materials_disney": {"baseColor": [.8, .6, .4], "scatterDistance": [.2, .1, .05], "specular": 0}}}))),
            scale=scale)
        model.use("ALAB_materials_disney")
        picture = seen(case, model, lights=lights, samples=256)
        case.true(f"no message, scale {scale}", "not closed" not in picture.text, picture.text)
        means.append(picture.mean[:3])
    case.near("means", means[1:], [means[0]] * 2, 4e-3)


def glass(case, size, scale, **layers):
    """The middle of a glass cube before a white sky."""
    model = Model()
    model.use(*layers, "KHR_materials_ior")
    material = {"pbrMetallicRoughness": {"baseColorFactor": layers.pop("color", [1, 1, 1, 1]), "metallicFactor": 0, "roughnessFactor": 0},
                "extensions": {**layers, "KHR_materials_ior": {"ior": 1}}}
    model.json["extensionsUsed"] = sorted(material["extensions"])
    model.node(mesh=model.mesh(model.primitive([np.multiply(p, size / 2) for p in CUBE], CUBE_SIDES, material=model.add("materials", material))),
               scale=[scale] * 3)
    return seen(case, model, lights=[{**DOME[0], "visibleToCamera": True}], samples=64).middle[:3]


@report("three.js 22971, Babylon.js 10151, Bloom 133", "attenuation counts in the scene's units, below scaled nodes, too")
def attenuation_of_scaled(case):
    color, distance = [.1, .5, .9], .8
    for size, scale in ((1, 1), (.5, 2), (2, .25)):
        got = glass(case, size, scale, KHR_materials_transmission={"transmissionFactor": 1},
                    KHR_materials_volume={"thicknessFactor": 1, "attenuationColor": color, "attenuationDistance": distance})
        case.near(f"edge {size}, scale {scale}", got, np.power(color, size * scale / distance), 4e-3)


@report("glTF-Sample-Viewer 393", "a volume without transmission changes nothing")
def volume_alone(case):
    pictures = []
    for extensions in ({}, {"KHR_materials_volume": {"thicknessFactor": 1, "attenuationColor": [.1, .5, .9], "attenuationDistance": .1}}):
        model = Model()
        model.use(*extensions)
        model.square(model.add("materials", {"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": extensions}))
        pictures.append(seen(case, model, lights=DOME).rgb())
    case.near("the largest difference", np.abs(pictures[1] - pictures[0]).max(), 0, 1e-6)


@report("OpenUSD 1269", "four values in one image: alpha 0 does not blacken the others")
def packed_values(case):
    pictures = []
    for alpha in (255, 0):
        model = Model()
        texture = {"index": model.image(png(flat(0, 180, 90, alpha)))}
        model.square(model.add("materials", {"pbrMetallicRoughness": {"metallicRoughnessTexture": texture, "baseColorFactor": [.9, .6, .3, 1]}}))
        pictures.append(seen(case, model, lights=DOME).rgb())
    case.near("the largest difference", np.abs(pictures[1] - pictures[0]).max(), 0, 1e-6)


@report("tev 87, tev 101", "colours of an EXR are multiplied by its alpha, so that opacity does not darken them once more")
def associated_exr(case):
    texel = dict(zip("RGBA", (.5, .25, .125, .5)))
    data = exr(4, 4, {c: (np.full((4, 4), v), FLOAT, 1, 1) for c, v in texel.items()})
    straight = [to_linear(255 * v) for v in (1, .5, .25)]
    case.near("blended", show(case, data, "a.exr", alphaMode="BLEND").mean, [v / 2 for v in straight] + [.5], 1e-2)
    case.near("opaque, as it is stored", show(case, data, "a.exr").middle, [to_linear(255 * v) for v in (.5, .25, .125)] + [1], 3e-3)
    glow = exr(4, 4, {c: (np.full((4, 4), v), FLOAT, 1, 1) for c, v in zip("RGBA", (.5, .25, .125, 0))})
    case.near("light where nothing is covered", sky(case, glow, "glow.exr").middle[:3], [.5, .25, .125])


@report("OpenImageIO 3675, OpenImageIO 960", "TIFF says whether its colours are multiplied by alpha")
def associated_tiff(case):
    for extra, texel, name in ((2, (200, 100, 50, 128), "apart"), (1, (100, 50, 25, 128), "multiplied")):
        data = tiff(np.full((4, 4, 4), texel, np.uint8), extra=[(338, 3, [extra])])
        case.near(name, show(case, data, "a.tif", alphaMode="BLEND").mean, [v * 128 / 255 for v in SEEN] + [128 / 255], 1.5e-2)
    nothing = tiff(np.full((4, 4, 4), (200, 100, 50, 0), np.uint8), extra=[(338, 3, [2])])
    case.near("alpha 0, opaque", show(case, nothing, "a.tif").middle, SEEN + [1], 3e-3)


@report("OpenImageIO 1022", "TIFF of 16-bit floats")
def half_tiff(case):
    value = np.empty((8, 16, 3), "f2")
    value[:] = 1.5, .5, .25
    for order in "<>":
        case.near(f"order {order}", sky(case, tiff(value, order, sample_format=3), "a.tif").middle[:3], [1.5, .5, .25])


@report("three.js 31911, DJV 826", "an EXR of a compression that came later is refused by name")
def later_compression(case):
    data = bytearray(exr(16, 8, {c: (np.full((8, 16), 1.), FLOAT, 1, 1) for c in "RGB"}))
    data[data.index(b"compression\0compression\0") + 28] = 10  # HTJ2K of OpenEXR 3.4
    try:
        case.true("refused", False, sky(case, bytes(data), "a.exr").middle)
    except RuntimeError as refusal:
        case.true("refused by name", "exit code 3" in str(refusal) and "compression" in str(refusal), refusal)


@report("darktable 18414, OpenCV 13551", "Radiance pictures whose first line has the name of another program")
def other_programs(case):
    for program in ("#?AUTOPANO11", "#?VRAY", "#?RGBE", "#?RADIANCE"):
        case.near(program, sky(case, hdr(16, 8, rgbe(1, .5, .25), (program, "FORMAT=32-bit_rle_rgbe")), "a.hdr").middle[:3], [1, .5, .25])


@report("stb 1667, image-rs 2465, Pillow 5829", "TGA whose first pixel lies at each of the four corners")
def tga_corners(case):
    texels = np.array([[(20 + 60 * x, 20 + 60 * y, 250 - 40 * x - 15 * y) for x in range(4)] for y in range(4)], np.uint8)
    right = np.vectorize(to_linear)(texels)
    for origin, rows, columns in ((0x00, -1, 1), (0x10, -1, -1), (0x20, 1, 1), (0x30, 1, -1)):
        stored = texels[::rows, ::columns, ::-1]
        data = struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, 4, 4, 24, origin) + stored.tobytes()
        model = Model()
        (case.folder / "a.tga").write_bytes(data)
        model.square(model.unlit(texture=model.texture(model.add("images", {"uri": "a.tga"}))))
        picture = case.render(model.write(case.folder / "model.gltf"), size=(4, 4))
        case.near(f"origin {origin >> 4}", picture.rgb(), right, 3e-3)
