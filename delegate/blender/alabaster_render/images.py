"""Images of Blender as files that the renderer reads."""
import contextlib
import glob
import itertools
import os
import pathlib
import struct
import tempfile

import bpy
import numpy

from . import colors


def uv_primvar(layer):
    """The primvar of a UV map. Its last colon keeps a map's name, such as "indices", from being the suffix of a field."""
    return f"uv:{layer}:"


_folder = None
_numbers = itertools.count()  # a file that is written again has another name, so that the renderer reads it
_written = {}  # what has been written, by the image's name and purpose: (stamp, file)
_means = {}    # by the image's name: (stamp, mean)

# Blender's names of the formats that the renderer reads.
FILE_FORMATS = {"PNG", "JPEG", "TIFF", "OPEN_EXR", "OPEN_EXR_MULTILAYER", "HDR", "WEBP", "TARGA", "TARGA_RAW"}
MISSING = (1.0, 0.0, 1.0)  # as Cycles shows it, at colours and at numbers


def _scratch(suffix):
    global _folder
    if _folder is None:
        _folder = tempfile.TemporaryDirectory(prefix="alabaster_blender_")
    return pathlib.Path(_folder.name) / f"{next(_numbers)}{suffix}"


def _pixels(image):
    """Rows of RGBA from the bottom: of byte images in their own space, of float images scene-linear."""
    width, height = image.size
    pixels = numpy.empty(width * height * image.channels, numpy.float32)
    image.pixels.foreach_get(pixels)
    if image.channels == 4 or not len(pixels):
        return pixels.reshape(-1, 4)
    pixels = pixels.reshape(height * width, image.channels)
    rgba = numpy.ones((height * width, 4), numpy.float32)
    if image.channels < 3:  # grey, with alpha or without
        rgba[:, :3] = pixels[:, :1]
        rgba[:, 3:] = pixels[:, 1:] if image.channels == 2 else 1.0
    else:
        rgba[:, :3] = pixels[:, :3]
    return rgba


@contextlib.contextmanager
def _whose_pixels_are_there(image):
    """The image, or that of the file which a sequence names: Blender has no pixels of a sequence without a frame."""
    if image.source != "SEQUENCE":
        yield image
        return
    try:
        named = bpy.data.images.load(_file_name(image))
    except RuntimeError:  # it cannot be opened, as Blender says; the renderer does, too
        yield image
        return
    try:
        named.colorspace_settings.name = image.colorspace_settings.name
        yield named
    finally:
        bpy.data.images.remove(named)


def _write_tiff(file, size, pixels):
    """The pixels, as floats without compression: every image of Blender's fits in that."""
    width, height = size
    rows = pixels.reshape(height, width * 4)[::-1].tobytes()
    bits, formats = 8 + 2 + 10 * 12 + 4, 8 + 2 + 10 * 12 + 4 + 8
    start = formats + 8
    tags = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 4, bits), (259, 3, 1, 1), (262, 3, 1, 2), (273, 4, 1, start),
            (277, 3, 1, 4), (278, 4, 1, height), (279, 4, 1, len(rows)), (339, 3, 4, formats)]
    directory = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", *tag) for tag in tags) + struct.pack("<I", 0)
    body = struct.pack("<4H", 32, 32, 32, 32) + struct.pack("<4H", 3, 3, 3, 3)
    pathlib.Path(file).write_bytes(b"II*\0" + struct.pack("<I", 8) + directory + body + rows)


def _known(image, purpose, stamp, write, suffix):
    """The file of an image for a purpose. An image may serve several: each has a file of its own."""
    key = image.name_full, purpose
    if key in _written and _written[key][0] == stamp:
        return _written[key][1]
    file = _scratch(suffix)
    write(file)
    if key in _written:
        pathlib.Path(_written[key][1]).unlink(missing_ok=True)
    _written[key] = (stamp, str(file))
    return str(file)


def _lives_in_blender(image):
    return image.source == "GENERATED" or image.is_dirty


def _file_name(image):
    return bpy.path.abspath(image.filepath_raw, library=image.library)


def is_missing(image, note):
    """True where Blender has neither a file nor pixels."""
    if image.source not in {"FILE", "SEQUENCE", "TILED"} or image.packed_file or image.is_dirty:
        return False
    name = _file_name(image)
    tiles = "*".join(glob.escape(part) for part in name.replace("<UVTILE>", "<UDIM>").split("<UDIM>"))
    if os.path.isfile(name) or (image.source == "TILED" and any(map(os.path.isfile, glob.iglob(tiles)))):
        return False
    note(f"image '{image.name}': there is no file '{name}'; magenta stands in for it")
    return True


def file_of(image, note):
    """(file, colour space) of the image's pixels; a file is written where they are only in Blender. "": there is none."""
    if image.source == "MOVIE":
        note(f"image '{image.name}': movies are not translated")
        return "", ""
    if image.source == "SEQUENCE":
        note(f"image '{image.name}': of a sequence, the file that it names is used")
    space = colors.name_of(image)
    if _lives_in_blender(image):
        pixels = _pixels(image)
        linear = image.is_float and space != "raw"
        if linear or space:
            file = _known(image, "as it is", hash(pixels.tobytes()), lambda file: _write_tiff(file, image.size, pixels), ".tif")
            return file, colors.linear() if linear else space
        return _converted(image, hash(pixels.tobytes()), note)
    if not space or (image.file_format not in FILE_FORMATS and image.source != "TILED"):
        return _converted(image, _stamp(image), note)
    if image.packed_file:
        suffix = pathlib.Path(image.filepath_raw).suffix or ".png"
        return _known(image, "as it is", _stamp(image), lambda file: file.write_bytes(image.packed_file.data), suffix), space
    return _file_name(image), space


def _converted(image, stamp, note):
    """(file, space) of an image in a space or a format that the renderer does not know."""
    if image.source == "TILED":
        note(f"image '{image.name}': tiles in colour space {image.colorspace_settings.name} are read as sRGB")
        return _file_name(image), "sRGB"
    with _whose_pixels_are_there(image) as held:
        pixels, size = _linear_pixels(held, note), tuple(held.size)
    if not len(pixels):
        return _file_name(image), "sRGB"  # damaged: the renderer says so
    key = stamp, image.colorspace_settings.name
    return _known(image, "linear", key, lambda file: _write_tiff(file, size, pixels), ".tif"), colors.linear()


def _linear_pixels(image, note):
    pixels, name = _pixels(image), image.colorspace_settings.name
    if image.is_float or image.colorspace_settings.is_data or not len(pixels):
        return pixels
    if colors.to_linear(pixels, name):
        return pixels
    if name != "sRGB":
        note(f"image '{image.name}': colour space {name} is not known here; it is read as sRGB")
    pixels[:, :3] = colors.from_srgb(pixels[:, :3])
    return pixels


def environment(image, note):
    """The name of a file for a dome light, which reads bytes as sRGB and floats as scene-linear. "": there is none."""
    name = image.colorspace_settings.name
    usual = "linear" if pathlib.Path(image.filepath_raw).suffix.lower() in {".exr", ".hdr"} else "sRGB"
    as_read = colors.EVERYWHERE.get(name) == usual and colors.name_of(image)
    if image.source in {"MOVIE", "TILED"} or (as_read and not _lives_in_blender(image)):
        return file_of(image, note)[0]
    return _converted(image, hash(_pixels(image).tobytes()) if _lives_in_blender(image) else _stamp(image), note)[0]


def _stamp(image):
    """Changes when the file does."""
    if image.packed_file:
        return hash(image.packed_file.data)
    try:
        status = os.stat(_file_name(image))
        return status.st_mtime_ns, status.st_size, _file_name(image)
    except OSError:
        return None


def mean(image):
    """(RGBA, even): the scene-linear mean, and whether all texels are alike."""
    key, stamp = image.name_full, None if _lives_in_blender(image) else (_stamp(image), image.colorspace_settings.name)
    if stamp is None or _means.get(key, (None,))[0] != stamp:
        _means[key] = stamp, _mean(image)
    return _means[key][1]


def _mean(image):
    with _whose_pixels_are_there(image) as held:
        pixels = _linear_pixels(held, lambda _: None)  # told where the file is named
    if not len(pixels):
        return (*MISSING, 1.0), True
    return tuple(float(x) for x in pixels.mean(axis=0, dtype=numpy.float64)), bool((pixels == pixels[0]).all())


def clear():
    global _folder
    _written.clear()
    _means.clear()
    if _folder is not None:
        _folder.cleanup()
        _folder = None
