"""Differences between two files that two programs wrote, as sentences. Dates, times and memory are not compared, and no attributes
and statistics that the program of BASE does not know."""
import json
import pathlib
import re
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "statistical/calibration"))
from pictures import exr_attributes, exr_channels, read_zip_channels  # noqa: E402

# Attributes of EXR files, and keys of statistics.
VOLATILE = re.compile(r"DateTime|capDate|seconds|wall|cpu|clocktime|memory|versions|^scene$|software|progress", re.I)
TIFF_VOLATILE = {270, 305, 306, 700}  # description, software, date, XMP
TIFF_STRIPS = (273, 279)  # where they are, and their sizes


def differences(name, base, present):
    """`base` and `present` are bytes."""
    if base == present:
        return []
    return COMPARE[pathlib.Path(name).suffix](base, present)


def exr(base, present):
    (first, at), (second, place) = exr_attributes(base), exr_attributes(present)
    found = []
    kinds, others = ({name: kind for name, kind in exr_channels(of["channels"])} for of in (first, second))
    layers = {f"{name}.X": name for name in kinds if "." not in name}  # of one channel, without a letter in BASE

    def named(channels):
        return {layers.get(name, name): value for name, value in channels.items()}

    others = named(others)
    if kinds != others:
        found.append(f"channels: {sorted(kinds.items() - others.items())} in BASE, now {sorted(others.items() - kinds.items())}")
    if first["dataWindow"] != second["dataWindow"]:
        return found + ["the data windows differ"]
    x0, _, x1, _ = struct.unpack("<4i", first["dataWindow"])
    pixels, others = read_zip_channels(base, at, first), named(read_zip_channels(present, place, second))
    for channel in sorted(pixels.keys() & others.keys()):
        found += numbers_differ(f"channel {channel}", pixels[channel], others[channel], x1 - x0 + 1)
    return found + [f"attribute {key}: {shown(value)} in BASE, now {shown(second.get(key))}"
                    for key, value in sorted(first.items()) if key != "channels" and not VOLATILE.search(key) and second.get(key) != value]


def shown(value):
    """An attribute's bytes, without its type: text, a double, or a whole number and a float."""
    if value is None:
        return "none"
    if value.isalnum():
        return repr(value.decode())
    return "%d or %g" % struct.unpack("<if", value + value) if len(value) == 4 else "%g" % struct.unpack("<d", value) if len(value) == 8 else repr(value)


def same(a, b):
    return a == b or (a != a and b != b)


def numbers_differ(what, base, present, width):
    off = [i for i, (a, b) in enumerate(zip(base, present)) if not same(a, b)]
    if not off:
        return []
    worst = max(off, key=lambda i: abs(base[i] - present[i]) if base[i] == base[i] and present[i] == present[i] else float("inf"))
    return [f"{what}: {len(off)} of {len(base)} values differ, most at ({worst % width}, {worst // width}): {base[worst]:g} in BASE, "
            f"now {present[worst]:g}, by {abs(base[worst] - present[worst]):.3g}"]


def chunks(data, start, header):
    """The parts of a PNG or JPEG besides text: [(tag, bytes)]."""
    found, at = [], start
    while at < len(data):
        tag, size, begin = header(data, at)
        found.append((tag, data[begin:begin + size]))
        at = begin + size
    return found


def png(base, present):
    def header(data, at):
        size, tag = struct.unpack_from(">I4s", data, at)
        return tag, size + 4, at + 8  # with its checksum
    kept = [[c for c in chunks(data, 8, header) if c[0] not in (b"tEXt", b"zTXt", b"iTXt", b"tIME", b"eXIf")] for data in (base, present)]
    return parts_differ(*kept)


def jpeg(base, present):
    def header(data, at):
        marker, size = struct.unpack_from(">HH", data, at)
        return marker, len(data) - at - 2 if marker == 0xFFDA else size, at + 2  # a scan ends the file
    kept = [[c for c in chunks(data, 2, header) if not 0xFFE0 <= c[0] <= 0xFFEF and c[0] != 0xFFFE] for data in (base, present)]
    return parts_differ(*kept)


def parts_differ(base, present):
    if base == present:
        return []
    off = [a[0] for a, b in zip(base, present) if a != b]
    return [f"the picture differs (parts {off or 'that one of them lacks'}); see the EXR of the same run for where"]


def tiff(base, present):
    first, second = tiff_tags(base), tiff_tags(present)
    return [f"TIFF tag {tag} differs" if tag != "pixels" else "the picture differs" for tag in first.keys() | second.keys()
            if first.get(tag) != second.get(tag)]


def tiff_tags(data):
    """{tag: value, "pixels": bytes} of a small TIFF in the machine's order."""
    order = "<" if data[:2] == b"II" else ">"
    at, = struct.unpack_from(order + "I", data, 4)
    count, = struct.unpack_from(order + "H", data, at)
    sizes, tags = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 7: 1, 11: 4}, {}
    for i in range(count):
        tag, kind, number = struct.unpack_from(order + "HHI", data, at + 2 + 12 * i)
        size, place = sizes[kind] * number, at + 10 + 12 * i
        if size > 4:
            place, = struct.unpack_from(order + "I", data, place)
        tags[tag] = data[place:place + size]
    places, lengths = ([v for v, in struct.iter_unpack(order + "I" if len(tags[tag]) % 4 == 0 else order + "H", tags[tag])] for tag in TIFF_STRIPS)
    pixels = b"".join(data[p:p + n] for p, n in zip(places, lengths))
    return {"pixels": pixels, **{t: v for t, v in tags.items() if t not in TIFF_VOLATILE.union(TIFF_STRIPS)}}


def flat(value, name=""):
    """{path: value} of what JSON holds, without what is VOLATILE."""
    if isinstance(value, dict):
        return {k: v for key, held in value.items() if not VOLATILE.search(key) for k, v in flat(held, f"{name}.{key}" if name else key).items()}
    if isinstance(value, list):
        return {k: v for i, held in enumerate(value) for k, v in flat(held, f"{name}[{i}]").items()}
    return {name: value}


def stats(base, present):
    first, second = flat(json.loads(base)), flat(json.loads(present))
    return [f"{key}: {first.get(key)} in BASE, now {second.get(key)}" for key in sorted(first)
            if key not in second or first[key] != second[key]]


NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def text(base, present):
    """Only its numbers, in order, are compared."""
    first, second = (NUMBER.findall(t.decode()) for t in (base, present))
    if first == second:
        return []
    at = next((i for i, (a, b) in enumerate(zip(first, second)) if a != b), min(len(first), len(second)))
    return [f"number {at + 1} of {len(first)} (now of {len(second)}): {first[at:at + 1]} in BASE, now {second[at:at + 1]}"]


COMPARE = {".exr": exr, ".png": png, ".jpg": jpeg, ".tif": tiff, ".json": stats, ".txt": text}
