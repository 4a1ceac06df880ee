#!/usr/bin/env python3
"""Numbers of files that the program has written, for promises.toml.

  measure differing A.exr B.exr       values that differ, over all layers that both have; -1 if their layers or sizes differ
  measure error PICTURE.exr REF.exr REF.exr...    relative RMSE of a picture against the mean of independent references, without their noise
  measure level A.exr B.exr           the mean of A over that of B
  measure parts PICTURE.exr SUM PART...   the largest difference of a layer and the sum of others, over the largest value
  measure stats FILE.json KEY...      numbers of --stats; a key is a path such as error/relativeRmse; true is 1, false 0
  measure same_png A.png B.png    1 if their pixels are the same, else 0
  measure attributes A.exr B.exr      attributes of the two headers that differ, by their names
"""
import json
import math
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "statistical/calibration"))
from pictures import Reference, exr_attributes, read_exr, read_layers  # noqa: E402


def differing(a, b):
    one, other = read_layers(a), read_layers(b)
    if one.keys() != other.keys() or any(len(one[name]) != len(other[name]) for name in one):
        return -1
    return sum(x != y and not (x != x and y != y) for name in one for x, y in zip(one[name], other[name]))


def error(picture, *references):
    return math.sqrt(max(0.0, Reference([read_exr(file) for file in references]).squared_error(read_exr(picture))))


def level(a, b):
    one, other = (sum(map(sum, read_exr(file).planes)) for file in (a, b))
    return one / other


def parts(file, whole, *names):
    layers, worst, largest = read_layers(file), 0.0, 0.0
    for channel in "RGB":
        sums = layers[f"{whole}.{channel}"] if whole != "color" else layers[channel]
        terms = zip(*(layers[f"{name}.{channel}"] for name in names))
        worst = max(worst, max(abs(s - sum(t)) for s, t in zip(sums, terms)))
        largest = max(largest, max(map(abs, sums)))
    return worst / largest


def stats(file, *keys):
    values = []
    for key in keys:
        value = json.loads(pathlib.Path(file).read_text())
        for name in key.split("/"):
            value = value[int(name)] if isinstance(value, list) else value[name]
        values.append(f"{float(value):.9g}")
    return " ".join(values)


def png_pixels(file):
    """The compressed pixels, without what else a file says."""
    data, at, pixels = pathlib.Path(file).read_bytes(), 8, b""
    while at < len(data):
        size, name = struct.unpack_from(">I4s", data, at)
        pixels += data[at + 8:at + 8 + size] if name == b"IDAT" else b""
        at += 12 + size
    return pixels


def same_png(a, b):
    return int(png_pixels(a) == png_pixels(b))


def attributes(a, b):
    one, other = (exr_attributes(pathlib.Path(file).read_bytes())[0] for file in (a, b))
    return "\n".join(sorted(name for name in one.keys() | other.keys() if one.get(name) != other.get(name)))


def main():
    commands = {"differing": differing, "error": error, "level": level, "parts": parts, "stats": stats, "attributes": attributes, "same_png": same_png}
    if len(sys.argv) < 3 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    answer = commands[sys.argv[1]](*sys.argv[2:])
    print(f"{answer:.9g}" if isinstance(answer, float) else answer)


if __name__ == "__main__":
    main()
