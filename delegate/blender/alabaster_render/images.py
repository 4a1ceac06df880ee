"""Images of Blender as files that the renderer reads."""
import itertools
import pathlib
import struct
import tempfile

import bpy
import numpy

_folder = None
_numbers = itertools.count()  # a file that is written again has another name, so that the renderer reads it
_written = {}  # what has been written, by the image's name: (stamp, file)

COLOR_SPACES = {"Non-Color": "raw", "Raw": "raw", "Generic Data": "raw", "sRGB": "sRGB", "Linear": "linear",
                "Linear Rec.709": "linear", "Linear BT.709": "linear"}


def color_space(image):
    name = image.colorspace_settings.name
    return COLOR_SPACES.get(name, name)


def _scratch(suffix):
    global _folder
    if _folder is None:
        _folder = tempfile.TemporaryDirectory(prefix="alabaster_blender_")
    return pathlib.Path(_folder.name) / f"{next(_numbers)}{suffix}"


def _write_tiff(file, image):
    """The pixels, as floats without compression: every image of Blender's fits in that."""
    width, height = image.size
    pixels = numpy.empty(width * height * 4, numpy.float32)
    image.pixels.foreach_get(pixels)
    rows = pixels.reshape(height, width * 4)[::-1].tobytes()
    bits, formats = 8 + 2 + 10 * 12 + 4, 8 + 2 + 10 * 12 + 4 + 8
    start = formats + 8
    tags = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 4, bits), (259, 3, 1, 1), (262, 3, 1, 2), (273, 4, 1, start),
            (277, 3, 1, 4), (278, 4, 1, height), (279, 4, 1, len(rows)), (339, 3, 4, formats)]
    directory = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", *tag) for tag in tags) + struct.pack("<I", 0)
    body = struct.pack("<4H", 32, 32, 32, 32) + struct.pack("<4H", 3, 3, 3, 3)
    pathlib.Path(file).write_bytes(b"II*\0" + struct.pack("<I", 8) + directory + body + rows)


def _known(image, stamp, write, suffix):
    key = image.name_full
    if key in _written and _written[key][0] == stamp:
        return _written[key][1]
    file = _scratch(suffix)
    write(file)
    if key in _written:
        pathlib.Path(_written[key][1]).unlink(missing_ok=True)
    _written[key] = (stamp, str(file))
    return str(file)


def file_of(image, frame, note):
    """The name of a file with the image's pixels; one is written where they are only in Blender. Empty: there is none."""
    if image.source == "MOVIE":
        note(f"image '{image.name}': movies are not translated")
        return ""
    if image.packed_file and not image.is_dirty:
        suffix = pathlib.Path(image.filepath_raw).suffix or ".png"
        return _known(image, hash(image.packed_file.data), lambda file: file.write_bytes(image.packed_file.data), suffix)
    if image.source == "GENERATED" or image.is_dirty:
        return _known(image, _stamp(image), lambda file: _write_tiff(file, image), ".tif")
    name = bpy.path.abspath(image.filepath_raw, library=image.library)
    if image.source == "SEQUENCE":
        note(f"image '{image.name}': of a sequence, the file that it names is used")
    return name


def _stamp(image):
    """Changes when somebody paints."""
    pixels = numpy.empty(image.size[0] * image.size[1] * 4, numpy.float32)
    image.pixels.foreach_get(pixels)
    return hash(pixels.tobytes())


def space_of_file(image):
    """The colour space of what file_of names. Generated pixels are bytes of the image's own space, or linear floats."""
    if (image.source == "GENERATED" or image.is_dirty) and image.is_float:
        return "linear" if color_space(image) != "raw" else "raw"
    return color_space(image)


def clear():
    global _folder
    _written.clear()
    if _folder is not None:
        _folder.cleanup()
        _folder = None
