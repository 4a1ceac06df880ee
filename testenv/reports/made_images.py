"""Writers of image files of every flavour that cameras, painters and renderers write. Standard library and numpy only."""
import struct
import zlib

import numpy as np


def chunk(tag, data):
    return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))


def png(texels, depth=8, palette=None, chunks=()):
    """`texels`: (height, width, channels) of integers; with a `palette` of rows of 3, the indices. `chunks`: (tag, data) before IDAT."""
    texels = np.asarray(texels)
    height, width, channels = texels.shape
    kind = 3 if palette is not None else {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    rows = texels.astype(">u2" if depth == 16 else "u1").reshape(height, -1)
    data = b"".join(b"\0" + row.tobytes() for row in rows)
    plte = [(b"PLTE", bytes(v for color in palette for v in color))] if palette is not None else []
    before = [c for c in chunks if c[0] != b"tRNS"]
    after = [c for c in chunks if c[0] == b"tRNS"]
    parts = [(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)), *before, *plte, *after,
             (b"IDAT", zlib.compress(data)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in parts)


def flat(*color, size=4):
    return np.full((size, size, len(color)), color)


def icc_profile(gamma):
    """A matrix profile with the primaries of Rec. 709 in another order and one exponent: a reader that uses it swaps red and green."""
    def xyz(*v):
        return b"XYZ \0\0\0\0" + b"".join(struct.pack(">i", round(c * 65536)) for c in v)
    curve = b"curv\0\0\0\0" + struct.pack(">IH", 1, round(gamma * 256)) + b"\0\0"
    description = b"desc\0\0\0\0" + struct.pack(">I", 5) + b"test\0" + bytes(79)
    tags = [(b"desc", description), (b"cprt", b"text\0\0\0\0none\0\0\0\0"), (b"wtpt", xyz(.9642, 1, .8249)), (b"rXYZ", xyz(.3851, .7169, .0971)),
            (b"gXYZ", xyz(.4361, .2225, .0139)), (b"bXYZ", xyz(.1431, .0606, .7141)), (b"rTRC", curve), (b"gTRC", curve), (b"bTRC", curve)]
    at, table, data = 128 + 4 + 12 * len(tags), b"", b""
    for name, body in tags:
        body += bytes(-len(body) % 4)
        table += name + struct.pack(">II", at + len(data), len(body))
        data += body
    body = struct.pack(">I", len(tags)) + table + data
    header = struct.pack(">I4sI4s4s4s", 128 + len(body), bytes(4), 0x02100000, b"mntr", b"RGB ", b"XYZ ") + bytes(12) + b"acsp" + bytes(28)
    return header + struct.pack(">3i", 63190, 65536, 54061) + bytes(48) + body


def segment(marker, data):
    return bytes((0xFF, marker)) + struct.pack(">H", len(data) + 2) + data


DC_BITS, DC_VALUES = (0, 1, 5, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0), range(12)


def jpeg(values, adobe=None, progressive=False, segments=()):
    """One block of 8 x 8 equal pixels. `values`: the components as they are stored; `adobe`: the transform of an APP14 marker."""
    codes, code = {}, 0
    values_left = list(DC_VALUES)
    for length, count in enumerate(DC_BITS, 1):
        for _ in range(count):
            codes[values_left.pop(0)] = format(code, f"0{length}b")
            code += 1
        code <<= 1
    bits = ""
    for v in values:
        d = v - 128
        n = abs(d).bit_length()
        bits += codes[n] + (format(d if d > 0 else d + (1 << n) - 1, f"0{n}b") if n else "")
        bits += "" if progressive else "0"  # the end of the block
    bits += "1" * (-len(bits) % 8)
    scan = bytes(int(bits[i:i + 8], 2) for i in range(0, len(bits), 8)).replace(b"\xff", b"\xff\0")
    n = len(values)
    out = b"\xff\xd8"
    for marker, data in segments:
        out += segment(marker, data)
    if adobe is not None:
        out += segment(0xEE, b"Adobe" + struct.pack(">HHHB", 100, 0, 0, adobe))
    out += segment(0xDB, b"\0" + bytes([8] * 64))
    out += segment(0xC2 if progressive else 0xC0, struct.pack(">BHHB", 8, 8, 8, n) + b"".join(bytes((i + 1, 0x11, 0)) for i in range(n)))
    out += segment(0xC4, b"\0" + bytes(DC_BITS) + bytes(DC_VALUES))
    out += segment(0xC4, b"\x10" + bytes([1] + [0] * 15) + b"\0")
    out += segment(0xDA, bytes([n]) + b"".join(bytes((i + 1, 0)) for i in range(n)) + bytes((0, 0 if progressive else 63, 0)))
    return out + scan + b"\xff\xd9"


HALF, FLOAT = 1, 2


def exr(width, height, channels, attributes=(), tile=None, flags=0):
    """`channels`: {name: (array, kind, x sampling, y sampling)}. Uncompressed; `tile`: the edge of tiles, with every mip level."""
    out = struct.pack("<II", 20000630, 2 | flags | (0x200 if tile else 0))

    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data
    names = sorted(channels)
    listed = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", channels[n][1], 0, channels[n][2], channels[n][3]) for n in names) + b"\0"
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    out += attribute("channels", "chlist", listed) + attribute("compression", "compression", b"\0")
    out += attribute("dataWindow", "box2i", box) + attribute("displayWindow", "box2i", box) + attribute("lineOrder", "lineOrder", b"\0")
    out += attribute("pixelAspectRatio", "float", struct.pack("<f", 1)) + attribute("screenWindowCenter", "v2f", bytes(8))
    out += attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    if tile:
        out += attribute("tiles", "tiledesc", struct.pack("<IIB", tile, tile, 1))
    for entry in attributes:
        out += attribute(*entry)
    out += b"\0"
    pack = {HALF: "<f2", FLOAT: "<f4"}
    blocks = []
    if tile:
        level, w, h = 0, width, height
        while True:
            for ty in range(-(-h // tile)):
                for tx in range(-(-w // tile)):
                    data = b""
                    for y in range(ty * tile, min(h, ty * tile + tile)):
                        for n in names:
                            array = channels[n][0][::1 << level, ::1 << level] if level < 20 else channels[n][0]
                            data += np.asarray(array)[y, tx * tile:min(w, tx * tile + tile)].astype(pack[channels[n][1]]).tobytes()
                    blocks.append(struct.pack("<5i", tx, ty, level, level, len(data)) + data)
            if w == 1 and h == 1:
                break
            level, w, h = level + 1, max(1, w // 2), max(1, h // 2)
    else:
        for y in range(height):
            data = b""
            for n in names:
                array, kind, _, ys = channels[n]
                if y % ys == 0:
                    data += np.asarray(array)[y // ys].astype(pack[kind]).tobytes()
            blocks.append(struct.pack("<ii", y, len(data)) + data)
    at = len(out) + 8 * len(blocks)
    for block in blocks:
        out += struct.pack("<Q", at)
        at += len(block)
    return out + b"".join(blocks)


def rgbe(r, g, b):
    exponent = int(np.ceil(np.log2(max(r, g, b) * 256 / 255)))
    return bytes(int(round(v * 2.0 ** (8 - exponent))) for v in (r, g, b)) + bytes([exponent + 128])


def hdr(width, height, texel, header=("#?RADIANCE", "FORMAT=32-bit_rle_rgbe"), first=None):
    """Texels that are equal and stored one by one, without run lengths; `first` replaces the first of each row."""
    row = (first or texel) + texel * (width - 1)
    return "\n".join([*header, "", f"-Y {height} +X {width}", ""]).encode() + row * height


def tiff(texels, order="<", planar=1, extra=(), sample_format=1):
    """`texels`: (height, width, channels); one strip for each plane. `extra`: (tag, type, values) of more tags."""
    texels = np.asarray(texels)
    height, width, channels = texels.shape
    stored = texels.astype(texels.dtype.newbyteorder(order))
    strips = [stored[..., c].tobytes() for c in range(channels)] if planar == 2 else [stored.tobytes()]
    bits = texels.dtype.itemsize * 8
    tags = [(256, 4, [width]), (257, 4, [height]), (258, 3, [bits] * channels), (259, 3, [1]), (262, 3, [2 if channels >= 3 else 1]),
            (273, 4, [0] * len(strips)), (277, 3, [channels]), (278, 4, [height]), (279, 4, [len(s) for s in strips]), (284, 3, [planar]),
            (339, 3, [sample_format] * channels), *extra]
    tags.sort()
    size = {3: "H", 4: "I"}
    at = 8 + 2 + 12 * len(tags) + 4
    blocks, places = b"", {}
    for tag, kind, values in tags:  # values that do not fit their entry lie behind the table
        if struct.calcsize(size[kind]) * len(values) > 4:
            places[tag] = at + len(blocks)
            blocks += bytes(struct.calcsize(size[kind]) * len(values))
            blocks += bytes(len(blocks) % 2)
    data_at, starts = at + len(blocks), []
    for strip in strips:
        starts.append(data_at)
        data_at += len(strip)
    table, blocks = b"", bytearray(blocks)
    for tag, kind, values in tags:
        values = starts if tag == 273 else values
        packed = struct.pack(order + size[kind] * len(values), *values)
        if tag in places:
            blocks[places[tag] - at:places[tag] - at + len(packed)] = packed
            packed = struct.pack(order + "I", places[tag])
        table += struct.pack(order + "HHI", tag, kind, len(values)) + packed.ljust(4, b"\0")
    head = (b"II" if order == "<" else b"MM") + struct.pack(order + "HIH", 42, 8, len(tags))
    return head + table + bytes(4) + bytes(blocks) + b"".join(strips)


def to_linear(byte):
    c = byte / 255
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4
