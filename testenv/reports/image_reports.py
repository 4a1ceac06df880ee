"""Reports about images: pictures show the values that the file holds."""
import struct
import zlib

import numpy as np
from made_images import FLOAT, HALF, exr, flat, hdr, icc_profile, jpeg, png, rgbe, tiff, to_linear
from made_models import Model
from public_reports import report

SEEN = [to_linear(v) for v in (200, 100, 50)]  # of bytes 200, 100, 50


def show(case, data, name="image.png", mime=None, **material):
    """An unlit square with the image as its base colour."""
    model = Model()
    if mime is None:
        (case.folder / name).write_bytes(data)
        texture = model.texture(model.add("images", {"uri": name}))
    else:
        texture = model.image(data, mime)
    model.square(model.unlit(texture=texture, **material))
    return case.render(model.write(case.folder / "model.gltf"), samples=4 if material.get("alphaMode") != "BLEND" else 1024)


def sky(case, data, name):
    """The sky that the image makes, as the camera sees it; of format EXR, HDR or TIFF, which glTF has not."""
    (case.folder / name).write_bytes(data)
    light = {"name": "sky", "type": "domeLight", "texture:file": name, "visibleToCamera": True}
    model = Model(camera=False)
    model.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": .3, "znear": .1}}]
    model.node(camera=0)
    model.square(translation=[0, 0, 50])  # behind the camera
    return case.render(model.write(case.folder / "model.gltf"), lights=[light])


@report("KTX-Software 356", "a PNG whose palette has alpha (tRNS)")
def palette_alpha(case):
    palette, alpha = [(0, 0, 0), (200, 100, 50)], bytes([255, 64])
    data = png(flat(1), palette=palette, chunks=[(b"tRNS", alpha)])
    got = show(case, data, alphaMode="BLEND")
    case.near("blend", got.mean, [c * 64 / 255 for c in SEEN] + [64 / 255], 4e-3)
    case.near("opaque", show(case, data).middle, SEEN + [1])
    key = png(flat(200, 100, 50), chunks=[(b"tRNS", struct.pack(">3H", 200, 100, 50))])
    case.near("colour key, blend", show(case, key, alphaMode="BLEND").middle, [0] * 4)
    grey = png(flat(200), chunks=[(b"tRNS", struct.pack(">H", 200))])
    case.near("grey key, mask", show(case, grey, alphaMode="MASK").middle, [0] * 4)


@report("OpenImageIO 3917", "colours of texels whose alpha is 0 are kept where alpha has no meaning")
def colour_without_alpha(case):
    data = png(flat(200, 100, 50, 0))
    case.near("opaque base colour", show(case, data).middle, SEEN + [1])
    model = Model()
    texture = {"index": model.image(data)}
    material = model.add("materials", {"emissiveFactor": [1, 1, 1], "emissiveTexture": texture,
                                       "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}})
    model.square(material)
    case.near("emission", case.render(model.write(case.folder / "emission.glb")).middle, SEEN + [1])


@report("OpenImageIO 4314", "alpha of a PNG multiplies light, not bytes")
def alpha_in_light(case):
    got = show(case, png(flat(255, 255, 255, 128)), alphaMode="BLEND")
    case.near("white of alpha 128", got.mean, [128 / 255] * 4)
    got = show(case, png(flat(65535, 65535, 65535, 32768), 16), alphaMode="BLEND")
    case.near("the same of 16 bits", got.mean, [.5] * 4)


@report("drake 18393", "PNG with 16 bits a channel, of each kind")
def sixteen_bits(case):
    for name, texel in {"RGBA": (30000, 20000, 10000, 65535), "RGB": (30000, 20000, 10000), "grey": (30000,), "grey and alpha": (30000, 65535)}.items():
        color = texel[:3] if len(texel) > 2 else texel[:1] * 3
        case.near(name, show(case, png(flat(*texel), 16)).middle, [to_linear(v / 257) for v in color] + [1], 1e-3)


@report("godot 114654, three.js 21318", "gAMA, cHRM, sRGB and ICC profiles in images are ignored, as glTF says")
def color_chunks(case):
    for name, chunks in {"gAMA 1": [(b"gAMA", struct.pack(">I", 100000))], "gAMA .3": [(b"gAMA", struct.pack(">I", 30000))],
                         "iCCP": [(b"iCCP", b"p\0\0" + zlib.compress(icc_profile(1)))],
                         "cHRM": [(b"cHRM", struct.pack(">8I", 31270, 32900, 73470, 26530, 11500, 82600, 15700, 1800))]}.items():
        case.near(name, show(case, png(flat(200, 100, 50), chunks=chunks)).middle, SEEN + [1])
    case.near("16 bits, gAMA 1", show(case, png(flat(51400, 25700, 12850), 16, chunks=[(b"gAMA", struct.pack(">I", 100000))])).middle, SEEN + [1])
    profile = (0xE2, b"ICC_PROFILE\0\1\1" + icc_profile(1))
    case.near("JPEG with a profile", show(case, jpeg([180, 128, 128], segments=[profile]), "a.jpg").middle, [to_linear(180)] * 3 + [1])


@report("ladybird 6486, libvips 1283", "JPEG of four inks, with and without Adobe's marker")
def inks(case):
    seen = [to_linear(round(c * 200 / 255)) for c in (255, 55, 100)]
    for name, data in {"marker": jpeg([255, 55, 100, 200], adobe=0), "none": jpeg([255, 55, 100, 200])}.items():
        case.near(f"stored inverted, {name}", show(case, data, "a.jpg").middle, seen + [1], 6e-3)
    case.near("YCCK", show(case, jpeg([100, 128, 128, 200], adobe=2), "a.jpg").middle, [to_linear(122)] * 3 + [1], 6e-3)
    case.near("RGB without a transform", show(case, jpeg([200, 100, 50], adobe=0), "a.jpg").middle, SEEN + [1], 3e-3)


@report("meshoptimizer 677, godot 51052", "JPEG: progressive, grey, with a media type that says PNG")
def jpeg_kinds(case):
    case.near("progressive", show(case, jpeg([180, 128, 128], progressive=True), "a.jpg").middle, [to_linear(180)] * 3 + [1])
    case.near("grey", show(case, jpeg([180]), "a.jpg").middle, [to_linear(180)] * 3 + [1])
    case.near("said to be PNG", show(case, jpeg([180]), mime="image/png").middle, [to_linear(180)] * 3 + [1])
    case.near("PNG said to be JPEG", show(case, png(flat(200, 100, 50)), mime="image/jpeg").middle, SEEN + [1])
    case.near("named .png", show(case, jpeg([180]), "a.png").middle, [to_linear(180)] * 3 + [1])


@report("OpenImageIO 4070, three.js 28134", "an EXR of luminance and chroma: its colour, or a message that names the channels")
def luminance_chroma(case):
    w = np.array([.2126, .7152, .0722])
    rgb = np.array([1, .5, .25])
    y = float(w @ rgb)
    full, half = np.full((8, 8), 1.0), np.full((4, 4), 1.0)
    data = exr(8, 8, {"Y": (full * y, HALF, 1, 1), "RY": (half * (rgb[0] - y) / y, HALF, 2, 2), "BY": (half * (rgb[2] - y) / y, HALF, 2, 2)})
    try:
        case.near("colour", sky(case, data, "a.exr").middle[:3], rgb, 5e-3)
    except RuntimeError as refusal:
        case.true("refused by name", "exit code 3" in str(refusal) and ("RY" in str(refusal) or "chroma" in str(refusal)), refusal)


@report("OpenUSD 2800", "EXR of one channel Y, of half and float")
def monochrome(case):
    for kind in (HALF, FLOAT):
        case.near("Y", sky(case, exr(16, 8, {"Y": (np.full((8, 16), 3.5), kind, 1, 1)}), "a.exr").middle[:3], [3.5] * 3)
    both = {"Y": (np.full((8, 16), 3.5), HALF, 1, 1), "A": (np.full((8, 16), 1.0), HALF, 1, 1)}
    case.near("Y and A", sky(case, exr(16, 8, both), "a.exr").middle[:3], [3.5] * 3)


@report("tinyexr 93, OpenUSD 4092", "a tiled EXR with mip levels reads its largest level")
def tiled(case):
    value = {c: (np.full((8, 16), v), HALF, 1, 1) for c, v in zip("RGB", (1, .5, .25))}
    case.near("tiles of 4 with levels", sky(case, exr(16, 8, value, tile=4), "a.exr").middle[:3], [1, .5, .25])


@report("stb 1323", "Radiance XYZE: converted, or refused by name")
def xyze(case):
    data = hdr(16, 8, rgbe(.9505, 1, 1.089), ("#?RADIANCE", "FORMAT=32-bit_rle_xyze"))
    try:
        case.near("white of D65", sky(case, data, "a.hdr").middle[:3], [1, 1, 1], 2e-2)
    except RuntimeError as refusal:
        case.true("refused by name", "exit code 3" in str(refusal) and "XYZ" in str(refusal), refusal)


@report("hdrv 15, Cinder 1756, loaders.gl 3327", "Radiance without run lengths, and headers of other writers")
def flat_hdr(case):
    texel = rgbe(1, .5, .25)
    for name, header in {"RADIANCE": ("#?RADIANCE", "FORMAT=32-bit_rle_rgbe"), "RGBE": ("#?RGBE", "FORMAT=32-bit_rle_rgbe"),
                         "comments": ("#?RADIANCE", "# made by a test", "GAMMA=1", "FORMAT=32-bit_rle_rgbe")}.items():
        case.near(name, sky(case, hdr(16, 8, texel, header), "a.hdr").middle[:3], [1, .5, .25])
    case.near("narrow, below 8 texels", sky(case, hdr(4, 2, texel), "a.hdr").middle[:3], [1, .5, .25])


@report("HDRImageViewer 54", "PRIMARIES of a Radiance header")
def primaries(case):
    wide = ("#?RADIANCE", "PRIMARIES=0.7080 0.2920 0.1700 0.7970 0.1310 0.0460 0.3127 0.3290", "FORMAT=32-bit_rle_rgbe")
    case.near("green of Rec. 2020", sky(case, hdr(16, 8, bytes([0, 128, 0, 129]), wide), "a.hdr").middle[:3], [0, 1.1329, 0], 1e-2)
    case.near("grey stays grey", sky(case, hdr(16, 8, bytes([128, 128, 128, 129]), wide), "a.hdr").middle[:3], [1, 1, 1], 5e-3)


@report("OpenImageIO 2757, TwelveMonkeys 184", "TIFF of floats: big-endian, and a plane for each channel")
def tiffs(case):
    value = np.empty((8, 16, 3), "f4")
    value[:] = 1.5, .5, .25
    for order in "<>":
        for planar in (1, 2):
            case.near(f"floats {order} planes {planar}", sky(case, tiff(value, order, planar, sample_format=3), "a.tif").middle[:3], [1.5, .5, .25])
