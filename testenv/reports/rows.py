"""The rows of reports.py: a measurement of each report's inputs, and the right answer with its slack."""
import shutil
from typing import Callable, NamedTuple

import numpy as np

from measures import Skipped, exr_file, expect, glb_file, near

BALL = (0.1747, 0.1412, 0.0743)  # the wax ball of 01, 08 and 15


class Row(NamedTuple):
    name: str
    folder: str  # the beginning of its name
    measured: str
    right: str
    check: Callable  # check(lab); raises Wrong
    round: str = "reports"


def one_body(lab):
    one, _ = lab.render("one.json")
    two, run = lab.render("two_materials.json")
    near(one.mean(), BALL, 0.015, "one.json")
    expect(one.equals(two), f"two_materials.json differs, by {np.abs(one.rgb() - two.rgb()).max():.4f} in a pixel")
    expect(not run.warnings(), run.text)


def shared_vertices(lab):
    options = ("--size", "16x16", "--spp", "1")
    apart, first = lab.render("apart.glb", *options)
    shared, second = lab.render("shared.glb", *options)
    expect(apart.equals(shared), "the pictures differ")
    expect(second.memory < 1.2 * first.memory, f"{second.memory / 1e6:.0f} MB and not {first.memory / 1e6:.0f}")


def shared_vertices_of_many(lab):
    """5000 primitives of 62,001 points: 4.7 MB, which were refused for want of 18,925 MiB."""
    side, primitives, points = 249, 5000, 249 * 249
    y, x = np.divmod(np.arange(points), side)
    positions = np.stack([x / side - 0.5, y / side - 0.5, 0 * x], 1).astype("<f4")
    quads = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    corners = np.stack([quads, quads + 1, quads + side, quads + 1, quads + side + 1, quads + side], 1).astype("<u4")
    parts = np.array_split(corners, primitives)
    binary, views, accessors = positions.tobytes(), [{"buffer": 0, "byteLength": positions.nbytes}], []
    accessors.append({"bufferView": 0, "componentType": 5126, "count": points, "type": "VEC3",
                      "min": positions.min(0).tolist(), "max": positions.max(0).tolist()})
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": part.nbytes})
        accessors.append({"bufferView": len(views) - 1, "componentType": 5125, "count": part.size, "type": "SCALAR"})
        binary += part.tobytes()
    lab.write("many.glb", glb_file({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1 + k} for k in range(primitives)]}],
        "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(binary)}]}, binary))
    _, run = lab.render("many.glb", "--size", "16x16", "--spp", "1")
    expect(run.memory < 400e6, f"{run.memory / 1e6:.0f} MB")


def no_primitives(lab):
    run = lab.run("check", "empty_primitives.gltf")
    expect(run.code in (0, 3) and run.warnings("primitives"), f"exit {run.code}: {run.text}")


def wide_jpeg(lab):
    run = lab.run("render", "plane.gltf", "-o", "w.exr", "-o", "w.jpg", "--size", "65501x2", "--spp", "1")
    written = (lab.folder / "w.exr").exists()
    expect((run.code == 2 and not written) or (run.code == 5 and written), f"exit {run.code}: {run.text}")
    expect("65500" in run.text, run.text)


def texel_range(lab):
    small, _ = lab.render("sun_5e4.json")
    large, _ = lab.render("sun_5e5.json")
    near(large.mean(), 3 * [98], 0.02, "sun_5e5")
    near(large.mean() / small.mean(), 3 * [10], 0.005, "sun_5e5 / sun_5e4")


def texel_extremes(lab):
    sky = np.ones((4, 8))
    skies = {"one": (0.1 * sky, 10), "dim": (1e-8 * sky, 1e8), "infinite": (np.where(np.arange(8) == 4, np.inf, 0 * sky), 0.001),
             "largest": (np.where(np.arange(8) == 4, 65504, 0 * sky), 0.001)}
    means = {}
    for name, (texels, intensity) in skies.items():
        lab.write(f"{name}.exr", exr_file({c: texels for c in "RGB"}))

        def change(scene, name=name, intensity=intensity):
            scene["lights"][0].update({"texture:file": f"{name}.exr", "intensity": intensity})
        lab.vary("sun_5e4.json", f"{name}.json", change)
        means[name] = lab.render(f"{name}.json")[0].mean()
    near(means["dim"], means["one"], 0.005, "1e-8 times 1e8")
    expect(means["infinite"].min() > 0, "an infinity is black")
    near(means["infinite"], means["largest"], 0.005, "an infinity")


def height_maps(lab):
    hill, _ = lab.render("hill.json")
    moved, _ = lab.render("hill_plus_100.json")
    apart = np.abs(hill.rgb() - moved.rgb())
    expect(hill.rgb().std() > 0.05, "the hill is flat")
    expect(np.percentile(apart, 99) < 0.01 * hill.mean().mean(), f"99 % of pixels lie within {np.percentile(apart, 99):.4f}")


def exr_windows(lab):
    whole, _ = lab.render("whole.json")
    cropped, _ = lab.render("cropped.json")
    for name, picture in (("whole", whole), ("cropped", cropped)):
        near(picture.mean(), (0.0686, 0.0343, 0.0172), 0.03, name)
    near(cropped.mean(), whole.mean(), 0.001, "cropped and whole")


def exr_overscan(lab):
    """A data window larger than the display window: pixels outside of that are no part of the sky."""
    inside = {c: np.full((8, 16), v) for c, v in zip("RGB", (1, 0.5, 0.25))}
    outside = {c: np.pad(rows, 4, constant_values=100) for c, rows in inside.items()}
    lab.write("inside.exr", exr_file(inside))
    lab.write("outside.exr", exr_file(outside, (-4, -4, 19, 11), (0, 0, 15, 7)))
    pictures = []
    for name in ("inside", "outside"):
        lab.vary("whole.json", f"{name}.json", lambda scene, n=name: scene["lights"][0].update({"texture:file": f"{n}.exr"}))
        pictures.append(lab.render(f"{name}.json")[0])
    near(pictures[1].mean(), pictures[0].mean(), 0.001, "a data window larger than the display window")


def doubled(lab):
    single, _ = lab.render("single.json", "--spp", "256")
    both, run = lab.render("doubled.json", "--spp", "256")
    near(both.mean(), BALL, 0.02, "doubled.json")
    near(both.mean(), single.mean(), 0.01, "doubled and single")
    rim = (single.alpha() > 0) & (single.alpha() < 1)
    near(both.mean(rim), single.mean(rim), 0.04, "the rim")
    expect(not run.warnings(), run.text)


def split_vertices(lab):
    for name in ("welded", "split_normals", "two_primitives", "degenerate"):
        picture, _ = lab.render(f"{name}.json")
        near(picture.alpha().mean(), 0.3524, 0.004, name)


def pane_with_volume(lab):
    thin, plain = lab.render("thin.json")
    volume, run = lab.render("volume.json")
    expect(not plain.warnings(), plain.text)
    same = np.allclose(thin.mean(), volume.mean(), rtol=0.02)
    said = [line for line in run.warnings() if "not closed" in line and "thin" in line]
    expect(same or said, run.text)


def farm(lab):
    with_config = {"OCIO": "show.ocio"}
    lab.run("render", "flat.json", "-o", "alone.png", "-o", "alone.exr", "--spp", "4", environment=with_config)
    run = lab.run("farm", "flat.json", "-o", "farm.png", "-o", "farm.exr", "--spp", "4", "--tasks", "2", environment=with_config)
    expect(run.code == 0, run.text)
    for job in (("task.sh", "0"), ("task.sh", "1"), ("merge.sh",)):
        run = lab.command(["sh", f"flat_farm/{job[0]}", *job[1:]], {"SHOT": "shotB"})
        if run.code == 3 and run.warnings():
            return
        expect(run.code == 0, run.text)
    pixels = [lab.command(["oiiotool", "--hash", name]).text.split()[-1] for name in ("alone.png", "farm.png")] \
        if shutil.which("oiiotool") else [png_pixels(lab.folder / name) for name in ("alone.png", "farm.png")]
    expect(pixels[0] == pixels[1], "another picture than that of one machine")


def png_pixels(file):
    """The bytes of its image chunks."""
    data, at, pixels = file.read_bytes(), 8, b""
    while at < len(data):
        size = int.from_bytes(data[at:at + 4], "big")
        if data[at + 4:at + 8] == b"IDAT":
            pixels += data[at + 8:at + 8 + size]
        at += 12 + size
    return pixels


def farm_of_other_luts(lab):
    run = lab.run("farm", "flat.json", "-o", "farm.png", "--spp", "4", "--tasks", "2", environment={"OCIO": "show.ocio"})
    expect(run.code == 0, run.text)
    (lab.folder / "luts/shotA/grade.cc").write_bytes((lab.folder / "luts/shotB/grade.cc").read_bytes())
    run = lab.command(["sh", "flat_farm/task.sh", "0"])
    expect(run.code == 3 and "grade.cc" in run.text, f"exit {run.code}: {run.text}")
    expect(not (lab.folder / "flat_farm/part.00000.checkpoint").exists(), "it has rendered")


def exr_layers(lab):
    picture, _ = lab.render("parts_depth_first.json")
    near(picture.mean(), (1, 0.5, 0.25), 0.001, "parts_depth_first")


def layers_alone(lab):
    rows = np.ones((4, 8))
    lab.write("layers.exr", exr_file({**{f"N.{c}": 7 * rows for c in "XYZ"}, **{f"diffuse.{c}": rows for c in "RGB"}}))
    lab.vary("parts_depth_first.json", "layers.json", lambda scene: scene["lights"][0].update({"texture:file": "layers.exr"}))
    run = lab.run("render", "layers.json", "-o", "x.exr")
    expect(run.code == 3 and "diffuse" in run.text and "N" in run.text, f"exit {run.code}: {run.text}")


def layer_names(lab):
    """Blender drops layers of one channel whose name has no dot (other than R, G, B, A, X, Y, Z and V)."""
    picture, _ = lab.render("plane.gltf", "--spp", "1", "--size", "8x8", "--aov", "primId", "--aov", "error", "--aov", "sampleCount")
    plain = [name for name in picture.channels if "." not in name and name not in "RGBA"]
    expect(not plain, f"{plain} have no dot")
    for layer in ("primId", "error", "sampleCount"):
        expect(any(name.startswith(layer + ".") for name in picture.channels), f"{layer} is missing: {picture.channels}")


def loose_vertex(lab):
    ball, _ = lab.render("ball.gltf", "--size", "32x32", "--spp", "4")
    loose, _ = lab.render("ball_and_loose_vertex.gltf", "--size", "32x32", "--spp", "4")
    expect(ball.equals(loose), f"the ball covers {loose.layers['A'].mean():.3f} and not {ball.layers['A'].mean():.3f}")
    archived = []
    for name in ("ball", "ball_and_loose_vertex"):
        run = lab.run("convert", f"{name}.gltf", "-o", f"{name}.alab", "--size", "32x32")
        expect(run.code == 0, run.text)
        archived.append(lab.render(f"{name}.alab", "--size", "32x32", "--spp", "4")[0])
    expect(archived[0].equals(archived[1]), "its archive shows another picture")


def require_module(lab):
    if not lab.has_module():
        raise Skipped("the Python module is not found: name its folder with --module")


def internal_face(lab):
    without, _ = lab.render("without.json")
    inside, run = lab.render("with.json")
    near(without.mean(), BALL, 0.015, "without.json")
    same = np.allclose(inside.mean(), without.mean(), rtol=0.02)
    expect(same or [line for line in run.warnings() if "three faces" in line], run.text)


def row_order(lab):
    for name in ("or_up_hdr", "or_std_hdr", "or_1_tif"):
        near(lab.render(f"{name}.json")[0].mean(), (1, 0.5, 0.25), 0.01, name)


def tiff_orientations(lab):
    """Upside down (4) with the rows of the same picture the other way round."""
    data = bytearray((lab.folder / "or_1.tif").read_bytes())
    order = "little" if data[:2] == b"II" else "big"
    at = int.from_bytes(data[4:8], order)
    tags = {}
    for i in range(int.from_bytes(data[at:at + 2], order)):
        entry = at + 2 + 12 * i
        tags[int.from_bytes(data[entry:entry + 2], order)] = entry
    number = lambda tag: int.from_bytes(data[tags[tag] + 8:tags[tag] + 10], order)  # noqa: E731
    upright, _ = lab.render("or_1_tif.json")
    data[tags[274] + 8:tags[274] + 10] = (4).to_bytes(2, order)
    lab.write("or_4.tif", bytes(data))
    lab.vary("or_1_tif.json", "or_4.json", lambda scene: scene["lights"][0].update({"texture:file": "or_4.tif"}))
    turned, _ = lab.render("or_4.json")
    expect(number(274) == 4 and turned.mean().max() < 0.01 < upright.mean().min(), f"{turned.mean()} and not 0")


def unusable_tangents(lab):
    mapped, run = lab.render("nm_zero.json")
    sound, _ = lab.render("nm_none.json")
    near(mapped.mean(), sound.mean(), 0.002, "nm_zero and nm_none")
    near(mapped.mean(), 3 * [0.535], 0.005, "nm_zero")
    expect(run.warnings("tangents"), run.text)


def cameras_of_one_name(lab):
    run = lab.run("render", "two_cameras.gltf", "--camera", "Camera", "-o", "o.png")
    expect(run.code in (2, 3) and "1_Camera" in run.text and "2_Camera" in run.text, f"exit {run.code}: {run.text}")


def collapsed_uv(lab):
    require_module(lab)
    lab.write("alabaster.py", b"from hdalabaster import *\n")  # the module's former name
    for seed in range(3):
        run = lab.python("crash_cage.py", str(seed))
        expect(run.code == 0 and "no crash" in run.text, f"exit {run.code}: {run.text}")


ROWS = [
    Row("01 primitives", "01_", "means of one and two primitives; bits", "BALL within 1.5 %; equal bits; no warning", one_body),
    Row("02 shared vertices", "02_", "bits; peak memory", "equal; 1.2 times", shared_vertices),
    Row("02 of 5000 primitives", "02_", "peak memory", "under 400 MB", shared_vertices_of_many),
    Row("03 no primitives", "03_", "exit code of check", "0 or 3, with a message", no_primitives),
    Row("04 wide JPEG", "04_", "exit code, files", "2 before rendering, or 5 with the EXR", wide_jpeg),
    Row("05 texel range", "05_", "means", "98 within 2 %; 10 times within .5 %", texel_range),
    Row("05 extremes", "05_", "1e-8 times 1e8; an infinity", ".1 times 10; 65504; .5 %", texel_extremes),
    Row("06 height maps", "06_", "difference of pixels, 99th percentile", "under 1 % of the mean", height_maps),
    Row("07 data windows", "07_", "means", ".0686 .0343 .0172 within 3 %; equal within .1 %", exr_windows),
    Row("07 overscan", "07_", "means", "equal within .1 %", exr_overscan),
    Row("08 doubled faces", "08_", "means; the rim", "BALL within 2 %; 1 %; rim 4 %; no warning", doubled),
    Row("09 split vertices", "09_", "alpha of four files", ".3524 within .4 %", split_vertices),
    Row("10 pane with volume", "10_", "mean, messages", "a pane, or a message with the remedy", pane_with_volume),
    Row("11 farm without OCIO", "11_", "pixels of the merge", "those of one machine, or refused", farm),
    Row("11 other LUTs", "11_", "exit code of a task", "3, names the LUT, has not rendered", farm_of_other_luts),
    Row("12 EXR parts", "12_", "mean", "1 .5 .25 within .1 %", exr_layers),
    Row("12 layers alone", "12_", "exit code, message", "3, names the layers", layers_alone),
    Row("13 layers", "13_", "names of channels", "none without a dot but R G B A", layer_names),
    Row("14 loose vertex", "14_", "bits of glTF and archive", "those of the ball", loose_vertex),
    Row("15 internal face", "15_", "mean, message", "the same within 2 %, or edges of three faces named", internal_face),
    Row("16 row order", "16_", "means", "1 .5 .25 within 1 %", row_order),
    Row("16 TIFF upside down", "16_", "mean", "0", tiff_orientations),
    Row("17 tangents of zero", "17_", "means, message", ".535 within .5 %, as without tangents within .2 %", unusable_tangents),
    Row("18 two cameras", "18_", "exit code, message", "refused, both paths", cameras_of_one_name),
    Row("19 collapsed uv", "19_", "exit code, 3 seeds", "no crash", collapsed_uv),
]
