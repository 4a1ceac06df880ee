"""Pictures as flat lists of numbers, and their error against a reference."""
import itertools
import pathlib
import re
import struct
import subprocess
import zlib

ERROR_FLOOR = 0.05  # kErrorFloor of core/convergence/frame_error.h
PIXEL = re.compile(r"^ *Pixel \((\d+), (\d+)\): (\S+) (\S+) (\S+)", re.M)


class Picture:
    """width, height, and red, green and blue as three lists of width * height numbers."""

    def __init__(self, width, height, planes):
        self.width, self.height, self.planes = width, height, planes


def read_exr(file):
    """Reads red, green and blue, the first three channels of Alabaster's EXR files."""
    data = pathlib.Path(file).read_bytes()
    attributes, at = exr_attributes(data)
    if attributes["compression"] == ZIP:
        return read_zip_lines(data, at, attributes)
    text = subprocess.run(["oiiotool", "--dumpdata", str(file)], check=True, capture_output=True, text=True).stdout
    pixels = PIXEL.findall(text)
    width, height = (int(side) + 1 for side in pixels[-1][:2])
    if len(pixels) != width * height:
        raise ValueError(f"{file}: oiiotool reported {len(pixels)} of {width} x {height} pixels")
    return Picture(width, height, [[float(pixel[2 + c]) for pixel in pixels] for c in range(3)])


ZIP = b"\3"  # compression of 16 lines at a time


def exr_attributes(data):
    """{name: bytes} of a header, and where it ends."""
    attributes, at = {}, 8
    while data[at]:
        end = data.index(0, at)
        name, at = data[at:end].decode(), data.index(0, end + 1) + 1
        size, = struct.unpack_from("<i", data, at)
        attributes[name], at = data[at + 4:at + 4 + size], at + 4 + size
    return attributes, at + 1


def exr_channels(text):
    """[(name, format of struct)] in the file's order."""
    channels, at = [], 0
    while text[at]:
        end = text.index(0, at)
        kind, = struct.unpack_from("<i", text, end + 1)
        channels.append((text[at:end].decode(), "Ief"[kind]))
        at = end + 17
    return channels


def read_layers(file):
    """{channel: its numbers, row by row} of an EXR file that Alabaster has written."""
    data = pathlib.Path(file).read_bytes()
    attributes, at = exr_attributes(data)
    return read_zip_channels(data, at, attributes)


def read_zip_lines(data, at, attributes):
    """Red, green and blue."""
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    planes = read_zip_channels(data, at, attributes)
    return Picture(x1 - x0 + 1, y1 - y0 + 1, [planes[name] for name in "RGB"])


def read_zip_channels(data, at, attributes):
    """The format that Alabaster writes, without a library, so that machines with Python alone can calibrate."""
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height, channels = x1 - x0 + 1, y1 - y0 + 1, exr_channels(attributes["channels"])
    planes = {name: [] for name, _ in channels}
    for chunk in range((height + 15) // 16):
        offset, = struct.unpack_from("<Q", data, at + 8 * chunk)
        y, size = struct.unpack_from("<ii", data, offset)
        lines = min(16, y1 + 1 - y)
        whole = lines * width * sum(struct.calcsize(kind) for _, kind in channels)
        raw = data[offset + 8:offset + 8 + size]
        if size < whole:  # each byte but the first is a difference, and the even bytes come before the odd ones
            flat = bytes(itertools.accumulate(zlib.decompress(raw), lambda a, b: (a + b - 128) & 255))
            raw = bytearray(whole)
            raw[::2], raw[1::2] = flat[:(whole + 1) // 2], flat[(whole + 1) // 2:]
        place = 0
        for _ in range(lines):
            for name, kind in channels:
                planes[name].extend(struct.unpack_from(f"<{width}{kind}", raw, place))
                place += width * struct.calcsize(kind)
    return planes


def block_means(picture, size):
    """The picture of the means of size x size pixels. Incomplete blocks at the right and at the end are left out."""
    across, down, planes = picture.width // size, picture.height // size, []
    for plane in picture.planes:
        rows = (plane[y * picture.width:(y + 1) * picture.width] for y in range(down * size))
        sums = [[sum(row[x * size:(x + 1) * size]) for x in range(across)] for row in rows]
        planes.append([sum(sums[y * size + k][x] for k in range(size)) / size ** 2 for y in range(down) for x in range(across)])
    return Picture(across, down, planes)


class Reference:
    """The mean of independent renders. Their scatter gives its own noise, which does not count as an error of other pictures."""

    def __init__(self, parts):
        count, first = len(parts), parts[0]
        self.width, self.height = first.width, first.height
        self.planes, self.variance = [], []
        for channel in range(3):
            planes = [part.planes[channel] for part in parts]
            mean = [sum(values) / count for values in zip(*planes)]
            self.planes.append(mean)
            self.variance.append([sum((v - m) ** 2 for v in values) / (count * (count - 1))
                                  for values, m in zip(zip(*planes), mean)])
        self.scales = self._scales()

    def _scales(self):
        """L^2 + f^2 of every pixel, as defined in core/convergence/frame_error.h."""
        w, h = self.width, self.height
        levels = [sum(rgb) / 3 for rgb in zip(*self.planes)]
        floor = ERROR_FLOOR * sum(levels) / len(levels)
        scales = []
        for y in range(h):
            for x in range(w):
                near = [levels[j * w + i] for j in range(max(0, y - 1), min(h, y + 2))
                        for i in range(max(0, x - 1), min(w, x + 2))]
                scales.append((sum(near) / len(near)) ** 2 + floor ** 2)
        return scales

    def squared_error(self, picture):
        """E^2 of `picture` against the reference's limit. The reference's noise is subtracted, so that the expectation is right;
        the result may be negative where the reference is as noisy as the picture."""
        total = 0.0
        for mine, theirs, variance in zip(self.planes, picture.planes, self.variance):
            total += sum(((b - a) ** 2 - v) / s for a, b, v, s in zip(mine, theirs, variance, self.scales))
        return total / 3 / len(self.scales)

    def own_squared_error(self):
        return sum(sum(v / s for v, s in zip(variance, self.scales)) for variance in self.variance) / 3 / len(self.scales)

    def squared_difference(self, ones, others):
        """E^2 of the mean of pictures against the mean of others that have the same random numbers, one by one, and the noise of it.
        The noise is subtracted."""
        count, total, noise = len(ones), 0.0, 0.0
        for channel in range(3):
            differences = [[a - b for a, b in zip(one.planes[channel], other.planes[channel])] for one, other in zip(ones, others)]
            for values, scale in zip(zip(*differences), self.scales):
                mean = sum(values) / count
                variance = sum((v - mean) ** 2 for v in values) / (count * (count - 1))
                total += (mean ** 2 - variance) / scale
                noise += variance / scale
        return total / 3 / len(self.scales), noise / 3 / len(self.scales)
