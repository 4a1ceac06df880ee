"""Cryptomatte as Blender has it: names of objects and materials, and the fields of a render that compositors find them by."""
import json

import numpy

KINDS = {"use_pass_cryptomatte_object": "Object", "use_pass_cryptomatte_material": "Material", "use_pass_cryptomatte_asset": "Asset"}
NO_MATERIAL = "default_surface"  # as Cycles calls it


def wanted(view_layer):
    """(AOV, name of the pass) of each pair of ranks."""
    pairs = (min(16, view_layer.pass_cryptomatte_depth) + 1) // 2
    return [(f"crypto{kind}{pair:02}", f"Crypto{kind}{pair:02}") for switch, kind in KINDS.items() if getattr(view_layer, switch)
            for pair in range(pairs)]


def murmur(text):
    """MurmurHash3_x86_32 with seed 0."""
    data, bits = text.encode(), 0xffffffff
    value, whole = 0, len(data) // 4 * 4

    def mixed(k):
        k = k * 0xcc9e2d51 & bits
        return (k << 15 | k >> 17) * 0x1b873593 & bits
    for at in range(0, whole, 4):
        value ^= mixed(int.from_bytes(data[at:at + 4], "little"))
        value = ((value << 13 | value >> 19) * 5 + 0xe6546b64) & bits
    if whole < len(data):
        value ^= mixed(int.from_bytes(data[whole:], "little"))
    value ^= len(data)
    for shift, factor in ((16, 0x85ebca6b), (13, 0xc2b2ae35)):
        value = (value ^ value >> shift) * factor & bits
    return value ^ value >> 16


def key(name):
    """The number that stands for a name in the pixels: a hash whose bits are those of a normal float."""
    value = murmur(name)
    return value ^ 1 << 23 if value >> 23 & 255 in (0, 255) else value


def rename(pixels, known, names):
    """Gives the keys of pixels other names. known: {name: key in hexadecimal}, names: {name: the other}."""
    table = sorted((int(digits, 16), key(names.get(name, name))) for name, digits in known.items())
    before, after = (numpy.array(column, numpy.uint32) for column in zip(*table)) if table else (numpy.empty(0, numpy.uint32),) * 2
    renamed = numpy.array(pixels, numpy.float32)
    bits = renamed.view(numpy.uint32)
    for channel in (0, 2):
        at = numpy.searchsorted(before, bits[..., channel]).clip(max=max(len(before) - 1, 0))
        if len(before):
            bits[..., channel] = numpy.where(before[at] == bits[..., channel], after[at], bits[..., channel])
    return renamed


def stamp(result, view_layer, known):
    """The fields that Cycles writes. known: for each kind, the names."""
    for switch, kind in KINDS.items():
        if getattr(view_layer, switch):
            layer = f"{view_layer.name}.Crypto{kind}"
            prefix = f"cryptomatte/{murmur(layer):08x}"[:len("cryptomatte/") + 7]
            manifest = {name: f"{key(name):08x}" for name in sorted(known[kind])}
            for field, value in (("name", layer), ("hash", "MurmurHash3_32"), ("conversion", "uint32_to_float32"),
                                 ("manifest", json.dumps(manifest, ensure_ascii=False, separators=(",", ":")))):
                result.stamp_data_add_field(f"{prefix}/{field}", value)
