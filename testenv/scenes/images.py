"""Writes images beside the scenes: 16-bit heights as PNG, and radiance as HDR. Standard library only."""
import math
import struct
import zlib


def heights_png(width, height, value):
    """Bytes of a 16-bit grey PNG; value(u, v) in 0..1 at the texel centres, v up."""
    rows = bytearray()
    for y in range(height):
        rows.append(0)
        for x in range(width):
            h = value((x + 0.5) / width, 1 - (y + 0.5) / height)
            rows.extend(struct.pack(">H", min(65535, max(0, round(h * 65535)))))

    def chunk(tag, data):
        return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))

    header = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(rows), 9)) +
            chunk(b"IEND", b""))


def rgbe(rgb):
    """Four bytes of Radiance's shared-exponent format (Ward 1991)."""
    largest = max(rgb)
    if largest < 1e-32:
        return bytes(4)
    mantissa, exponent = math.frexp(largest)
    return bytes([int(c * mantissa * 256 / largest) for c in rgb] + [exponent + 128])


def write_hdr(path, width, height, radiance):
    """radiance(row, column), row 0 at the top. Flat scanlines: no run lengths. Colours never start with the first two bytes
    of a run-length line."""
    rows = b"".join(rgbe(radiance(row, column)) for row in range(height) for column in range(width))
    path.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width) + rows)
