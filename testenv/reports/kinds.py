#!/usr/bin/env python3
"""Two further cases of each kind of failing input, made by the exporters of other programs, and checked.

  kinds.py PROGRAM --node FOLDER --python PYTHON [--made FOLDER] [--only KIND]

FOLDER has a node_modules with three, @gltf-transform/core, @gltf-transform/extensions and obj2gltf; PYTHON has trimesh, pygltflib, OpenEXR,
tifffile and Pillow. Blender, assimp, oiiotool and ImageMagick are searched in $PATH. A case whose exporter is missing is skipped, by name.
kinds.md has the list with the verdicts.
"""
import argparse
import json
import math
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import numpy as np  # noqa: E402
from public_reports import Case, Picture, read_layers  # noqa: E402

CASES = []  # (kind, exporter, what is made, function)
BACK = [{"name": "back", "type": "rectLight", "width": 2, "height": 2, "intensity": 20, "position": [0, 1, -4], "target": [0, 0, 0]},
        {"name": "sky", "type": "domeLight", "intensity": 0.2}]
SKY = [{"name": "sky", "type": "domeLight"}]
SCATTERS = [{"match": "*", "set": {"baseColor": [.8, .6, .4], "scatterDistance": [.3, .2, .1]}}]
FRONT = {"lookAt": {"eye": [0, 0, 5], "target": [0, 0, 0]}, "focalLength": 50}
UP = {"lookAt": {"eye": [0, 0, 0], "target": [0, 3, -.01]}}


def case(kind, exporter, made):
    def register(function):
        CASES.append((kind, exporter, made, function))
        return function
    return register


class Made(Case):
    """Checks in the folder of what the exporters made."""

    def scene(self, model, camera=FRONT, lights=BACK, size=64, samples=64, options=(), **more):
        scene = {"models": [{"file": model}], "lights": lights, "settings": {"resolution": [size, size], "samples": samples, "studio": "off"}, **more}
        if camera:
            scene["camera"] = camera
        file = self.folder / "scene.json"
        file.write_text(json.dumps(scene))
        code, text = self.run("render", file, "-o", "out.exr", *options)
        if code != 0:
            raise RuntimeError(f"exit code {code}: {text.strip()}")
        return Picture(read_layers(self.folder / "out.exr"), (size, size), text)

    def agree(self, what, a, b, tolerance=.01):
        """The means of two pictures, relative."""
        self.near(what, np.array(a.mean[:3]) / np.array(b.mean[:3]), [1] * 3, tolerance)

    def sky(self, image, camera=UP):
        floor = self.folder / "floor.gltf"
        if not floor.exists():
            from made_models import Model
            model = Model(camera=False)
            model.square(translation=[0, -50, 0])
            model.write(floor)
        light = {"name": "sky", "type": "domeLight", "texture:file": image, "visibleToCamera": True}
        return self.scene("floor.gltf", camera, [light], 8, 4)


def body(name, tolerance=.01):
    """A body and its variant that must look alike."""
    def check(made, one, other, message=None):
        first = made.scene(one, materials=SCATTERS)
        second = made.scene(other, materials=SCATTERS)
        made.agree(name, second, first, tolerance)
        made.true("no message that the mesh is open", "not closed" not in second.text, second.text[:200])
    return check


@case(1, "Blender", "a ball of one and of two materials")
def blender_materials(made):
    body("two materials as one")(made, "01_blender_one.glb", "01_blender_two.glb")


@case(1, "obj2gltf", "an OBJ with two usemtl groups, and with one")
def obj_materials(made):
    body("two groups as one")(made, "01_obj2gltf_one.glb", "01_obj2gltf_two.glb")


@case(1, "Draco", "an OBJ with two usemtl groups, each primitive rounded to a grid of its own")
def draco_materials(made):
    body("two rounded groups as one", .015)(made, "01_obj2gltf_one.glb", "01_draco_two.glb")


def cost(made, model):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    picture = made.scene(model, None, SKY, 16, 1, options=["--stats", "stats.json"])
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before.ru_utime
    return picture, seconds, json.loads((made.folder / "stats.json").read_text())


def shared(one, many):
    def check(made):
        first, seconds, stats = cost(made, one)
        other, more_seconds, more_stats = cost(made, many)
        made.agree("the same picture", other, first, .02)
        made.true("time", more_seconds < 2 * seconds + .5, f"{seconds:.2f} s, {more_seconds:.2f} s")
        peaks = [s["peakMemory"] for s in (stats, more_stats)]
        made.true("memory", peaks[1] < 2 * peaks[0] + 2e7, peaks)
    return check


case(2, "three.js", "400 groups over one geometry")(shared("02_three_one.glb", "02_three_groups.glb"))
case(2, "pygltflib", "500 primitives that use the accessors of the whole mesh")(shared("02_pygltflib_one.glb", "02_pygltflib_shared.glb"))


def nothing(model):
    def check(made):
        code, text = made.run("check", model)
        named = re.search(r"(warning|error): .*(primitive|triangle|point)", text)
        made.true("a warning or an error that names what is missing", code in (0, 3) and named, f"{code}: {text.strip()[:200]}")
    return check


case(3, "three.js", "a mesh of an empty geometry")(nothing("03_three.glb"))
case(3, "glTF-Transform", "a mesh without primitives")(nothing("03_gltf_transform.gltf"))


@case(4, "ImageMagick reads", "a JPEG of 65500 pixels, and one of 65501 beside an EXR")
def wide_jpeg(made):
    code, text = made.run("render", "03_gltf_transform.gltf", "-o", "wide.jpg", "--size", "65500x2", "--spp", "1", "--studio", "on")
    seen = subprocess.run(["identify", "wide.jpg"], capture_output=True, text=True, cwd=made.folder).stdout
    made.true("65500", code == 0 and "65500x2" in seen, f"{code} {seen} {text[:200]}")
    code, text = made.run("render", "03_gltf_transform.gltf", "-o", "w.exr", "-o", "w.jpg", "--size", "65501x2", "--spp", "1")
    made.true("65501 refused before rendering, or the EXR is written", code == 2 or (code == 5 and (made.folder / "w.exr").exists()), f"{code} {text[:200]}")


@case(4, "libvips reads", "a TIFF of 65536 pixels, the widest picture, and a PNG that holds 65535")
def wide_tiff(made):
    code, text = made.run("render", "03_gltf_transform.gltf", "-o", "wide.tif", "--size", "65536x2", "--spp", "1", "--studio", "on")
    seen = subprocess.run(["vipsheader", "wide.tif"], capture_output=True, text=True, cwd=made.folder).stdout
    made.true("65536", code == 0 and "65536x2" in seen, f"{code} {seen} {text[:200]}")
    code, text = made.run("render", "03_gltf_transform.gltf", "-o", "wide.png", "--size", "65536x2", "--spp", "1", "--studio", "on")
    made.true("the PNG is refused before rendering", code == 2 and "65535" in text, f"{code} {text[:200]}")


def suns(name):
    def check(made):
        light = {sun: made.sun(name.format(sun)) for sun in ("5e5", "5e6", "inf", "65504")}
        made.near("ten times the sun", light["5e6"] / light["5e5"], 10, 2e-2)
        made.near("an infinity is the largest half, where no texel is larger", light["inf"] / light["65504"], 1, 2e-2)
    return check


def sun(self, image):
    self.sky(image)  # makes the floor
    light = [{"name": "sky", "type": "domeLight", "texture:file": image}]
    down = {"lookAt": {"eye": [0, 3, .01], "target": [0, 0, 0]}}
    self.plane()
    return self.scene("plane.gltf", down, light, 8, 64, materials=[{"match": "*", "set": {"baseColor": [.5] * 3}}]).mean[0]


def plane(self):
    from made_models import Model
    model = Model(camera=False)
    model.square(model.add("materials", {"name": "floor"}), rotation=[-math.sqrt(.5), 0, 0, math.sqrt(.5)], scale=[9, 9, 1])
    model.write(self.folder / "plane.gltf")


Made.sun, Made.plane = sun, plane
case(5, "OpenEXR for Python", "skies with suns of 5e5, 5e6 and infinity")(suns("05_openexr_{}.exr"))
case(5, "tifffile", "the same as TIFF of floats")(suns("05_tifffile_{}.tif"))


def hill(made, image, midlevel):
    displacement = {"file": image, "scale": .3, "midlevel": midlevel, "wrap": "clamp"}
    sun = [{"name": "sun", "type": "distantLight", "angle": 1, "normalize": True, "intensity": 3, "position": [-5, 0, 2], "target": [0, 0, 0]}]
    from made_models import Model
    n, model = 64, Model(camera=False)
    points = [(2 * x / n - 1, 2 * y / n - 1, 0) for y in range(n + 1) for x in range(n + 1)]
    quads = [[a + i for i in (0, 1, n + 2, 0, n + 2, n + 1)] for a in (y * (n + 1) + x for y in range(n) for x in range(n))]
    model.node(mesh=model.mesh(model.primitive(points, sum(quads, []), {"TEXCOORD_0": [(x / n, 1 - y / n) for y in range(n + 1) for x in range(n + 1)]},
                                               material=model.add("materials", {"name": "m"}))))
    model.write(made.folder / "grid.glb")
    return made.scene("grid.glb", {"lookAt": {"eye": [0, -2, 4], "target": [0, 0, 0]}, "focalLength": 45}, sun, 64, 16,
                      meshes=[{"match": "*", "scheme": "loop", "refineLevel": 1}], materials=[{"match": "*", "displacement": displacement}])


def same_hill(one, other, midlevel, tolerance):
    def check(made):
        a, b = hill(made, one, 0), hill(made, other, midlevel)
        difference = np.abs(a.rgb() - b.rgb())
        made.true("pictures agree", np.quantile(difference, .99) < tolerance, f"99 % within {np.quantile(difference, .99):.4f}, all within {difference.max():.4f}")
    return check


case(6, "tifffile", "heights as TIFF of floats, and 100 more of each")(same_hill("06_tifffile_hill.tif", "06_tifffile_hill_plus_100.tif", 100, .03))
case(6, "Pillow", "heights as PNG of 16 bits, and as floats")(same_hill("06_pillow_hill.png", "06_pillow_same.tif", 0, .005))


def same_sky(one, other):
    def check(made):
        a, b = made.sky(one), made.sky(other)
        made.near("the same sky", b.rgb().ravel(), a.rgb().ravel(), 1e-3)
        wide = {"lookAt": {"eye": [0, 0, 0], "target": [1, .3, 1]}, "focalLength": 12}
        a, b = made.sky(one, wide), made.sky(other, wide)
        made.near("in another direction", b.rgb().ravel(), a.rgb().ravel(), 1e-3)
    return check


case(7, "OpenEXR for Python", "a data window within the display window")(same_sky("07_openexr_whole.exr", "07_openexr_cropped.exr"))
case(7, "oiiotool", "a data window around the display window")(same_sky("07_openexr_whole.exr", "07_oiiotool_overscan.exr"))


@case(8, "Blender", "faces duplicated and flipped in one mesh")
def blender_doubled(made):
    body("as single")(made, "08_blender_single.glb", "08_blender_doubled.glb")


@case(8, "trimesh", "a mesh and its inverse, concatenated")
def trimesh_doubled(made):
    body("as single")(made, "08_trimesh_single.glb", "08_trimesh_doubled.glb")


def same_surface(one, other, scheme="loop"):
    def check(made):
        look = {"lookAt": {"eye": [2, 2, 5], "target": [0, 0, 0]}}
        refined = [{"match": "*", "scheme": scheme, "refineLevel": 4}]
        a, b = (made.scene(name, look, SKY, 64, 16, meshes=refined) for name in (one, other))
        made.near("alpha", b.mean[3], a.mean[3], 2e-3)
    return check


case(9, "Blender", "a cube shaded flat, with texture coordinates: 24 vertices")(same_surface("09_blender_smooth.glb", "09_blender_flat.glb"))
case(9, "assimp", "an OBJ cube with a normal and coordinates for each corner")(same_surface("09_assimp_welded.glb", "09_assimp_split.glb", "catmullClark"))


def pane(model):
    def check(made):
        picture = made.scene(model, FRONT, SKY, 32, 16)
        made.true("a pane, or a message", min(picture.middle[:3]) > .8 or "closed" in picture.text, f"{picture.middle} {picture.text[:200]}")
    return check


case(10, "three.js", "MeshPhysicalMaterial with a thickness on a plane")(pane("10_three.glb"))
case(10, "glTF-Transform", "KHR_materials_volume on a square")(pane("10_gltf_transform.glb"))


def farm(config):
    def check(made):
        made.plane()
        scene = {"models": [{"file": "plane.gltf"}], "lights": SKY, "camera": {"lookAt": {"eye": [0, 3, .01], "target": [0, 0, 0]}},
                 "settings": {"resolution": [16, 16], "samples": 4, "studio": "off"}}
        (made.folder / "farm.json").write_text(json.dumps(scene))
        plain = dict(os.environ)
        plain.pop("OCIO", None)

        def run(*arguments, **environment):
            return subprocess.run([made.program, *arguments], capture_output=True, text=True, cwd=made.folder, env={**plain, **environment}, timeout=300)
        own = run("render", "farm.json", "-o", "whole.png", OCIO=config)
        made.true("rendered with the config", own.returncode == 0, own.stderr[:300])
        shutil.rmtree(made.folder / "farm_farm", ignore_errors=True)
        job = run("farm", "farm.json", "-o", "farm.png", "--tasks", "2", OCIO=config)
        made.true("the job is written", job.returncode == 0, (job.stdout + job.stderr)[:300])
        text, codes = job.stdout + job.stderr, []
        for line in [*(made.folder / "farm_farm" / "tasks.txt").read_text().splitlines(), "sh farm_farm/merge.sh"]:
            done = subprocess.run(line, shell=True, capture_output=True, text=True, cwd=made.folder, timeout=300, env=plain)
            text, codes = text + done.stdout + done.stderr, codes + [done.returncode]
        farm_png, whole = made.folder / "farm.png", made.folder / "whole.png"
        same = farm_png.exists() and pixels(farm_png) == pixels(whole)
        made.true("the same pixels without $OCIO, or refused", same or (any(codes) and "OCIO" in text), f"{codes} {text[-400:]}")
    return check


def pixels(file):
    """The pixels of a PNG, by ImageMagick."""
    return subprocess.run(["convert", str(file), "-depth", "8", "rgb:-"], capture_output=True).stdout


case(11, "Blender", "Blender's own OCIO config, by $OCIO alone")(lambda made: farm(str(made.blender_config()))(made))
case(11, "OpenColorIO's examples", "a config written as in its guide, with a file of its search path")(lambda made: farm(str(made.small_config()))(made))


def blender_config(self):
    for place in ("/usr/share/blender/datafiles/colormanagement/config.ocio", "/usr/share/blender/3.4/datafiles/colormanagement/config.ocio"):
        if pathlib.Path(place).exists():
            return pathlib.Path(place)
    raise Skip("Blender's config is not found")


def small_config(self):
    folder = self.folder / "ocio"
    (folder / "tables").mkdir(parents=True, exist_ok=True)
    (folder / "tables" / "dim.spi1d").write_text("Version 1\nFrom 0.0 1.0\nLength 2\nComponents 1\n{\n0.0\n0.5\n}\n")
    (folder / "config.ocio").write_text("""ocio_profile_version: 1
search_path: tables
roles:
  default: linear
  scene_linear: linear
displays:
  Monitor:
    - !<View> {name: Dim, colorspace: dim}
active_displays: [Monitor]
active_views: [Dim]
colorspaces:
  - !<ColorSpace>
    name: linear
    family: ""
    bitdepth: 32f
    isdata: false
  - !<ColorSpace>
    name: dim
    family: ""
    bitdepth: 32f
    isdata: false
    from_reference: !<FileTransform> {src: dim.spi1d, interpolation: linear}
""")
    return folder / "config.ocio"


Made.blender_config, Made.small_config = blender_config, small_config


class Skip(Exception):
    pass


@case(12, "Blender", "a multilayer EXR: ViewLayer.Combined and ViewLayer.Depth")
def blender_layers(made):
    try:
        made.near("its colours", made.sky("12_blender.exr").middle[:3], [1, .5, .25], 1e-2)
    except RuntimeError as refusal:
        made.true("refused, with the names of its layers", "Combined" in str(refusal), refusal)


@case(12, "OpenEXR for Python", "a part depth before the part beauty; a file of normals alone")
def openexr_layers(made):
    made.near("the beauty", made.sky("12_openexr_parts.exr").middle[:3], [1, .5, .25], 1e-3)
    try:
        made.true("normals are no light", False, made.sky("12_openexr_only_normals.exr").middle)
    except RuntimeError as refusal:
        made.true("refused, with the layer's name", "it has N" in str(refusal), refusal)


AOVS = ["--aov", "primId", "--aov", "error", "--aov", "sampleCount", "--aov", "normal", "--aov", "cameraDepth"]


@case(13, "oiiotool", "the layers as names of channels")
def names_of_channels(made):
    made.run("render", "08_trimesh_single.glb", "-o", "layers.exr", "--size", "16x16", "--spp", "1", *AOVS)
    text = subprocess.run(["oiiotool", "--info", "-v", "layers.exr"], capture_output=True, text=True, cwd=made.folder).stdout
    names = re.search(r"channel list: (.*)", text)
    names = [n.split()[0] for n in names.group(1).split(",")] if names else []
    bad = [n for n in names if n not in ("R", "G", "B", "A", "Z") and not re.fullmatch(r"[\w:]+\.[A-Z]", n)]
    made.true("every channel is R, G, B, A, Z or LAYER.X", names and not bad, names)


@case(13, "OpenEXR for Python", "the channels by OpenEXR's own reader")
def read_by_openexr(made):
    made.run("render", "08_trimesh_single.glb", "-o", "layers.exr", "--size", "16x16", "--spp", "1", *AOVS)
    code = "import OpenEXR; f = OpenEXR.File('layers.exr', separate_channels=True); print(sorted(f.channels()), f.header().get('capDate'), f.header().get('type'))"
    done = subprocess.run([made.python, "-c", code], capture_output=True, text=True, cwd=made.folder)
    made.true("all layers and no fault", all(n in done.stdout for n in ("primId.X", "error.X", "sampleCount.X", "N.X", "'Z'")), done.stdout + done.stderr[-300:])
    date = re.search(r"\d{4}:\d\d:\d\d \d\d:\d\d:\d\d", done.stdout)
    made.true("capDate in the form of OpenEXR's standard", date, done.stdout[-100:])


def framed(one, other):
    def check(made):
        a, b = (made.scene(name, None, SKY, 32, 4) for name in (one, other))
        made.near("framed as without the loose point", b.mean[3], a.mean[3], 2e-2)
        made.true("the ball is seen", a.mean[3] > .1, a.mean[3])
    return check


case(14, "Blender", "a loose vertex 300 m away, exported with loose points")(framed("14_blender_clean.glb", "14_blender_loose.glb"))
case(14, "trimesh", "a vertex that no face uses, 500 m away")(framed("14_trimesh_clean.glb", "14_trimesh_loose.glb"))


def internal(one, other):
    def check(made):
        picture = made.scene(other, materials=SCATTERS)
        clean = made.scene(one, materials=SCATTERS)
        ratio = picture.mean[0] / clean.mean[0]
        named = "three" in picture.text or "more than two" in picture.text
        made.true("the same light, or a message about edges of three faces", abs(ratio - 1) < .01 or named, f"ratio {ratio:.3f}, {picture.text[:300]}")
    return check


case(15, "Blender", "a face across the inside of a ball")(internal("15_blender_clean.glb", "15_blender_internal.glb"))
case(15, "trimesh", "a disk within a ball, of the same vertices")(internal("15_trimesh_clean.glb", "15_trimesh_internal.glb"))


def upright(image):
    def check(made):
        up, down = (made.sky(image, {"lookAt": {"eye": [0, 0, 0], "target": [0, 3 * sign, -.01]}}).middle for sign in (1, -1))
        made.true("light above and none below", up[0] > .5 and down[0] < .05, f"{up[0]:.3f} above, {down[0]:.3f} below")
    return check


case(16, "Pillow", "JPEG turned by Exif's orientation 3")(upright("16_pillow.jpg"))
case(16, "Pillow", "TIFF of orientation 3")(upright("16_pillow.tif"))
case(16, "ImageMagick", "TIFF of orientation bottom-left")(upright("16_magick.tif"))


def mapped(model):
    def check(made):
        picture = made.scene(model, {"lookAt": {"eye": [0, 0, 5], "target": [0, 0, 0]}, "focalLength": 50}, SKY, 16, 4, options=["--aov", "normal"])
        n = picture.layer("N.X", "N.Y", "N.Z")
        made.true("the mapped normal is tilted, or a message", math.hypot(n[0], n[1]) > .2 or "tangent" in picture.text or "coordinates" in picture.text,
                  f"{n} {picture.text[:300]}")
        made.true("a number", all(map(math.isfinite, n)), n)
    return check


case(17, "Blender", "tangents of a plane whose texture coordinates are all equal")(mapped("17_blender.glb"))
case(17, "three.js", "computeTangents where all texture coordinates are equal")(mapped("17_three.glb"))


def ambiguous(model):
    def check(made):
        code, text = made.run("render", model, "--camera", "Camera", "-o", "out.exr", "--size", "8x8", "--spp", "1")
        named = len(set(re.findall(r"/\S*Camera\S*", text))) >= 2
        made.true("an error that lists both paths", code not in (0, 139, 134) and (named or "Camera_1" in text), f"{code}: {text[:300]}")
    return check


case(18, "three.js", "two cameras of one name")(ambiguous("18_three.glb"))
case(18, "glTF-Transform", "two nodes of one name with cameras")(ambiguous("18_gltf_transform.glb"))


def collapsed(file):
    def check(made):
        code = (HERE / "exporters" / "cage_of_obj.py")
        done = subprocess.run([sys.executable, str(code), file], capture_output=True, text=True, cwd=made.folder, timeout=300)
        if "No module named 'hdalabaster" in done.stderr:
            raise Skip("PYTHONPATH does not name the Python module")
        made.true("refined without a fault", done.returncode == 0 and "drawn" in done.stdout, f"{done.returncode} {done.stdout} {done.stderr[-200:]}")
    return check


case(19, "Blender", "an OBJ whose texture coordinates collapse within faces")(collapsed("19_blender.obj"))
case(19, "assimp", "the same OBJ written again by assimp")(collapsed("19_assimp.obj"))


CUBE_OBJ = "".join(f"v {x} {y} {z}\n" for z in (-1, 1) for y in (-1, 1) for x in (-1, 1))
CUBE_QUADS = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
CUBE_NORMALS = [(0, 0, -1), (0, 0, 1), (0, -1, 0), (0, 1, 0), (-1, 0, 0), (1, 0, 0)]


def ball_obj(groups):
    """A ball of quads and triangles with a group of faces for each material."""
    rows, columns, text = 16, 32, ["mtllib m.mtl"]
    for i in range(rows + 1):
        for j in range(columns if 0 < i < rows else 1):
            t, p = math.pi * i / rows, 2 * math.pi * j / columns
            text.append(f"v {math.sin(t) * math.cos(p):.7g} {math.cos(t):.7g} {-math.sin(t) * math.sin(p):.7g}")

    def at(i, j):
        return 1 if i == 0 else 2 + (rows - 1) * columns if i == rows else 2 + (i - 1) * columns + j % columns
    faces = {0: [], 1: []}
    for i in range(rows):
        for j in range(columns):
            corners = dict.fromkeys([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])
            faces[int(groups == 2 and j < 10 and i < 8)].append("f " + " ".join(map(str, corners)))
    for g in range(groups):
        text += [f"usemtl m{g}"] + faces[g]
    return "\n".join(text) + "\n"


def make(folder, options):
    """Runs every exporter that is there. {exporter: why not} of the others."""
    missing = {}

    def run(exporters, command, **more):
        program = command[0]
        if not program or not shutil.which(program):
            missing.update({e: f"{program or 'its option'} is missing" for e in exporters})
            return
        done = subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=600, **more)
        if done.returncode != 0 or "Traceback" in done.stdout + done.stderr:
            missing.update({e: f"{program} failed: {(done.stderr or done.stdout)[-300:]}" for e in exporters})
    for groups, name in ((1, "one"), (2, "two")):
        (folder / f"01_{name}.obj").write_text(ball_obj(groups))
    (folder / "m.mtl").write_text("newmtl m0\nKd 0.8 0.8 0.8\nnewmtl m1\nKd 0.8 0.8 0.8\n")
    (folder / "09_welded.obj").write_text(CUBE_OBJ + "".join("f " + " ".join(map(str, q)) + "\n" for q in CUBE_QUADS))
    split = CUBE_OBJ + "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n" + "".join("vn {} {} {}\n".format(*n) for n in CUBE_NORMALS)
    (folder / "09_split.obj").write_text(split + "".join("f " + " ".join(f"{v}/{c + 1}/{i + 1}" for c, v in enumerate(q)) + "\n" for i, q in enumerate(CUBE_QUADS)))
    from made_images import flat, png
    (folder / "17_normal.png").write_bytes(png(flat(230, 128, 217)))
    run(["Blender"], ["blender", "-b", "--factory-startup", "--python", HERE / "exporters" / "in_blender.py", "--", folder])
    run(["three.js", "glTF-Transform"], ["node" if options.node else None, HERE / "exporters" / "in_node.mjs", folder], cwd=options.node)
    python = ["trimesh", "pygltflib", "OpenEXR for Python", "tifffile", "Pillow"]
    run(python, [options.python, HERE / "exporters" / "in_python.py", folder])
    for name in ("one", "two"):
        tool = pathlib.Path(options.node or "/", "node_modules", ".bin", "obj2gltf")
        run(["obj2gltf"], [str(tool), "-i", folder / f"01_{name}.obj", "-o", folder / f"01_obj2gltf_{name}.glb"])
    if (folder / "01_obj2gltf_two.glb").exists():
        (folder / "with_draco.mjs").write_bytes((HERE / "exporters" / "with_draco.mjs").read_bytes())
        modules = folder / "node_modules"
        if options.node and not modules.exists():
            modules.symlink_to((options.node / "node_modules").resolve())
        run(["Draco"], ["node", folder / "with_draco.mjs", folder / "01_obj2gltf_two.glb", folder / "01_draco_two.glb"], cwd=folder)
    else:
        missing["Draco"] = "obj2gltf's file is missing"
    for source, to in (("09_welded.obj", "09_assimp_welded.glb"), ("09_split.obj", "09_assimp_split.glb"),
                              ("19_blender.obj", "19_assimp.obj")):
        if (folder / source).exists():
            run(["assimp"], ["assimp", "export", folder / source, folder / to, *([f"-f{'gltf2' if to.endswith('gltf') else 'glb2'}"] if "gl" in to[-5:] else [])])
    if (folder / "07_openexr_whole.exr").exists():
        run(["oiiotool"], ["oiiotool", folder / "07_openexr_whole.exr", "--crop", "80x48-8-8", "-o", folder / "07_oiiotool_overscan.exr"])
    if (folder / "16_pillow.tif").exists():
        run(["ImageMagick"], ["convert", folder / "16_pillow.tif", "-orient", "top-left", "-rotate", "180", "-flip", "-orient", "bottom-left", folder / "16_magick.tif"])
    return missing


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--node", type=pathlib.Path)
    parser.add_argument("--python")
    parser.add_argument("--made", type=pathlib.Path, help="a folder for what the exporters make; kept")
    parser.add_argument("--only", type=int, default=0)
    options = parser.parse_args()
    wrong = skipped = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.made or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        missing = make(folder, options)
        for kind, exporter, what, function in CASES:
            if options.only not in (0, kind):
                continue
            made = Made(str(pathlib.Path(options.program).resolve()), folder)
            made.python = options.python
            if exporter in missing:
                skipped += 1
                print(f"skipped {kind:2d} {exporter}: {what} ({missing[exporter]})")
                continue
            try:
                function(made)
            except Skip as why:
                skipped += 1
                print(f"skipped {kind:2d} {exporter}: {what} ({why})")
                continue
            except Exception as error:
                made.true(f"{type(error).__name__}: {str(error)[:300]}", False)
            failed = [r for r in made.results if not r[3]]
            wrong += bool(failed)
            print(f"{'WRONG' if failed else 'right'}   {kind:2d} {exporter}: {what}")
            for text, got, right, _ in failed:
                print(f"           {text}: {got}" + (f", right is {right}" if right else ""))
    print(f"{wrong} wrong, {skipped} skipped, of {len(CASES)} cases")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
