#!/usr/bin/env python3
"""Situations of public reports against other programs, and further cases of each kind of input of reports4 (checks.py).

  round4.py PROGRAM [--module FOLDER] [--only TEXT]

FOLDER holds the Python module hdalabaster (default: PYTHONPATH) for this Python, which needs numpy. Inputs are made by script. Prints two
tables. A verdict is "right", "refused" (by a message that names the cause), "WRONG", or "not run" where the machine lacks something. The
exit code is 1 if a verdict is WRONG. round4.md has the tables.
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import zlib

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "benchmark")]
import numpy as np  # noqa: E402
import named_edits  # noqa: E402
from made_images import exr, flat, png, tiff  # noqa: E402
from made_models import CUBE, CUBE_SIDES, Model  # noqa: E402
from public_reports import read_layers  # noqa: E402
from pictures import exr_attributes  # noqa: E402

ROWS = []  # (name, situation, right answer, function); the name of a kind is its number
COLOUR = np.array([1, .25, .0625])  # linear Rec. 709
CURVE = [round(65535 * (1.055 * v ** (1 / 2.4) - .055)) for v in COLOUR]
AP1 = np.array([[.6130974, .3395231, .0473795], [.0701937, .9163539, .0134524], [.0206156, .1095698, .8698146]]) @ COLOUR  # in ACEScg
SIGNALS = [signal.SIGHUP, signal.SIGINT, signal.SIGTERM, signal.SIGPIPE, signal.SIGXCPU, signal.SIGXFSZ]
SHARE = r"""
#define _GNU_SOURCE
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>
static int there(int file) {
  char link[64], path[4096] = "";
  sprintf(link, "/proc/self/fd/%d", file);
  return readlink(link, path, 4095) > 0 && strstr(path, "/share/");
}
#define FAILS(name) if (getenv(#name) && there(file)) return errno = atoi(getenv(#name)), -1
int fsync(int file) { FAILS(FSYNC); return syscall(SYS_fsync, file); }
int fchmod(int file, mode_t mode) { FAILS(CHMOD); return syscall(SYS_fchmod, file, mode); }
int fchown(int file, uid_t user, gid_t group) { FAILS(CHOWN); return syscall(SYS_fchown, file, user, group); }
ssize_t write(int file, const void* data, size_t size) { FAILS(WRITE); return syscall(SYS_write, file, data, size); }
"""
PRELUDE = """import functools, gc, os, time, weakref, hdalabaster, numpy as np
CARD = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
CAMERA = dict(focalLength=50, horizontalAperture=36, verticalAperture=36, transform=np.eye(4) + np.outer([0, 0, 0, 4], [0, 0, 1, 0]))
def refused(call, *arguments, **more):
    try: call(*arguments, **more)
    except (ValueError, TypeError, hdalabaster.Error): return True
    return False
def told(what, values): print(f"{what}: {sum(map(bool, values))} of {len(values)}" + ("" if all(values) else f" {values}"), end="; ")
def card():
    scene = hdalabaster.Scene()
    scene.set_mesh("/card", points=CARD, indices=[[0, 1, 2, 3]])
    scene.set_light("/sky", "domeLight")
    return scene
"""


class NotRun(Exception):
    pass


def row(name, situation, answer):
    def register(function):
        ROWS.append((str(name), situation, answer, function))
        return function
    return register


def host(name, situation, answer, code, make=lambda c: c.card()):
    """A case in Python. Its code tells how many answers are right, of each kind, and which."""
    def check(c):
        make(c)
        status, text = c.run("-c", PRELUDE + code, command=[sys.executable], PYTHONPATH=c.module)
        if "No module named" in text:
            raise NotRun("no Python module")
        return verdict(status == 0 and text and "False" not in text and "None" not in text, text.strip(" ;\n")[-500:])
    row(name, situation, answer)(check)


class Case:
    def __init__(self, program, module, folder):
        self.program, self.module, self.folder = program, module, folder
        self.plain = {k: v for k, v in os.environ.items() if not k.startswith("OCIO") and k not in ("TMPDIR", "PYTHONPATH")}
        for name in "share", "kept", "disk", "scenes", "tex":  # which some of the cases use
            (folder / name).mkdir()

    def run(self, *arguments, command=None, **environment):
        environment = {**self.plain, "LC_ALL": "C.UTF-8", **environment}
        if command and not shutil.which(command[0]):
            raise NotRun("no " + command[0])
        done = subprocess.run([*(command or [self.program]), *map(str, arguments)], stdin=subprocess.DEVNULL, capture_output=True,
                              text=True, errors="replace", cwd=self.folder, timeout=300, env=environment)
        return done.returncode, done.stdout + done.stderr

    def render(self, scene, *options, file="out.exr", samples=("--spp", 1), **environment):
        return self.run("render", scene, "-o", file, "--size", "8x8", *samples, "--quiet", "--studio", "off", *options, **environment)

    def middle(self, scene, *options):
        """Red, green and blue of a pixel in the middle, with four digits."""
        code, text = self.render(scene, *options)
        if code != 0:
            raise RuntimeError(f"exit code {code}: {text.strip()}")
        layers = read_layers(self.folder / "out.exr")
        return [round(float(layers[c][36]), 4) for c in "RGB"]

    def write(self, name, value):
        data = value if isinstance(value, bytes) else (value if isinstance(value, str) else json.dumps(value)).encode()
        (self.folder / name).write_bytes(data)
        return name

    def card(self, name="card.gltf", material=lambda model: model.unlit([*COLOUR, 1]), attributes=None, change=None):
        """A square that fills the picture, of a material that a function makes. `attributes`: {name: (values, type)}."""
        model = Model()
        shown = material(model)
        more = {n: model.accessor(v, d, **({} if d == "f4" else {"normalized": True})) for n, (v, d) in (attributes or {}).items()}
        model.square(shown, more)
        if change:
            change(model)
        model.write(self.folder / name)
        return name

    def painted(self, image):
        paint = {"match": "*", "set": {"emission": {"file": image}}}
        return self.write("painted.json", {"models": [{"file": self.card()}], "materials": [paint], "settings": {"studio": "off"}})

    def acescg(self):
        return self.write("acescg.ocio", re.sub(r"scene_linear: .*", "scene_linear: ACEScg", self.run("ocio", "--export")[1]))

    def share(self, **answers):
        """The system fails with these numbers in the folder `share`."""
        if self.run("-shared", "-fPIC", "-o", "share.so", self.write("share.c", SHARE), command=["cc"])[0]:
            raise NotRun("no C compiler")
        return {"LD_PRELOAD": str(self.folder / "share.so"), "TMPDIR": str(self.folder / "kept"), **{k: str(v) for k, v in answers.items()}}

    def mounted(self, options, *arguments):
        """Runs the program where the folder `disk` is a file system of its own, which is gone afterwards."""
        script = f'mount -t tmpfs -o {options} none disk || exit 77; exec "$0" "$@"'
        code, text = self.run(script, self.program, *arguments, command=["unshare", "-rm", "sh", "-c"], TMPDIR=str(self.folder / "kept"))
        if code in (1, 77):
            raise NotRun("no mounts")
        return code, text

    def take_kept(self):
        """The number of pictures that are kept in $TMPDIR, which are removed."""
        files = list((self.folder / "kept").rglob("*.exr"))
        whole = sum(f.read_bytes()[:4] == b"\x76\x2f\x31\x01" for f in files)
        for file in files:
            file.unlink()
        return whole

    def chunks(self, name):
        data, at, found = (self.folder / name).read_bytes(), 8, {}
        while at < len(data):
            size = int.from_bytes(data[at:at + 4], "big")
            found[data[at + 4:at + 8].decode()] = data[at + 8:at + 8 + size]
            at += 12 + size
        return found


def near(a, b):
    return np.allclose(a, b, rtol=0, atol=.004)


def verdict(ok, *found):
    return "right" if ok else "WRONG", ", ".join(map(str, found))


def named(code_text, word):
    """Refused by an error with the word."""
    code, text = code_text
    errors = " ".join(line[7:] for line in text.splitlines() if line.startswith("error: "))
    brief = errors[:100] + "..." * (len(errors) > 100)
    return "refused" if code in (2, 3) and word in errors else "WRONG", f"{code}: {brief or text.strip()}"


def worst(*verdicts):
    return min((v for v, _ in verdicts), key=["WRONG", "right", "refused"].index), "; ".join(f for _, f in verdicts)


@row("glTF-Blender-Exporter 206; glTF 1638", "one colour as baseColorFactor, as COLOR_0 of floats and of shorts, and as texture; ACEScg",
     "one picture")
def vertex_colours(c):
    def image(model):
        return model.unlit(texture=model.image(png(flat(*CURVE), 16)))
    colours = {"f4": [COLOUR] * 4, "u2": [np.round(65535 * COLOUR)] * 4}
    models = [c.card(), *(c.card(t + ".gltf", Model.unlit, {"COLOR_0": (v, t)}) for t, v in colours.items()), c.card("image.gltf", image)]
    seen = [c.middle(m, "--ocio", c.acescg()) for m in models]
    return verdict(all(near(v, AP1) for v in seen), *seen)


def parts(c, scene, *options, **environment):
    """Renders a part of one sample for each list of options, and returns their names."""
    for i, more in enumerate(options):
        own = "--samples", f"{i}:{i + 1}", "--checkpoint", f"part{i}"
        code, text = c.run("render", scene, "--size", "8x8", "--studio", "off", *own, *more, **environment)
        if code:
            raise RuntimeError(text)
    return [f"part{i}" for i in range(len(options))]


def same(c, one, other):
    if one.endswith(".exr"):
        a, b = (read_layers(c.folder / f) for f in (one, other))
        return a.keys() == b.keys() and all(np.array_equal(a[k], b[k]) for k in a)
    return c.chunks(one)["IDAT"] == c.chunks(other)["IDAT"]


@row("deadline-cloud-for-maya 379; ayon-blender 71", "parts are rendered with $OCIO and merged without; then its config is gone",
     "the files of one render; refused by its name")
def merge_without_variable(c):
    config, files = str(c.folder / c.acescg()), ("-o", "one.exr", "-o", "one.png")
    c.run("render", c.card(), *files, "--size", "8x8", "--spp", "2", "--studio", "off", OCIO=config)
    merge = ["merge", *parts(c, "card.gltf", files, files, OCIO=config)]
    code, text = c.run(*merge, "-o", "merged.exr", "-o", "merged.png")
    c.run("render", "card.gltf", *files, "--size", "8x8", "--spp", "2", "--studio", "off", OCIO=config)
    equal = code == 0 and [same(c, "one" + e, "merged" + e) for e in (".exr", ".png")]
    os.remove(config)
    return worst(verdict(equal == [True, True], f"{code}, equal: {equal}"), named(c.run(*merge, "-o", "late.exr"), "acescg.ocio"))


@row("syncthing 5704; borg 1290; ShareX 6363",
     "a frame is replaced where fsync, fchmod and fchown answer ENOTSUP, EPERM, EINVAL or ENOSYS", "written")
def courtesies(c):
    errors = (95, 1), (22, 22), (38, 95), (95, 38)
    codes = [c.render(c.card(), file="share/f.exr", **c.share(FSYNC=f, CHMOD=m, CHOWN=m))[0] for f, m in errors]
    return verdict(codes == [0] * 4 and os.listdir(c.folder / "share") == ["f.exr"], "exit codes", *codes)


@row("gyroflow 967", "the disk is full when a frame is written", "exit 5, the picture in $TMPDIR")
def full_disk(c):
    large = "--size", "400x400", "--aov", "normal", "--spp", "1", "--studio", "off", "--quiet"
    code, text = c.mounted("size=4k", "render", c.card(), "-o", "disk/frame.exr", *large)
    return verdict(code == 5 and c.take_kept() == 1, code, text.strip())


def sent(c, number, ignore):
    """How a render ends that gets a signal, and which ones it leaves ignored."""
    shell = ["sh", "-c", ("trap '' " + " ".join(s.name[3:] for s in SIGNALS) + "; " if ignore else "") + 'exec "$0" "$@"', c.program]
    render = "render", c.card(), "-o", "job.exr", "--size", "64x64", "--spp", "1000000", "--time-limit", "30", "--quiet"
    job = subprocess.Popen([*shell, *render], cwd=c.folder, env=c.plain, stderr=subprocess.DEVNULL)
    time.sleep(1.5)
    status = pathlib.Path(f"/proc/{job.pid}/status").read_text()
    mask = int(re.search(r"SigIgn:\s*(\w+)", status)[1], 16)
    job.send_signal(number)
    try:
        return job.wait(1 if ignore else 20), [s.name for s in SIGNALS if mask >> (s - 1) & 1]
    except subprocess.TimeoutExpired:
        job.kill()
        job.wait()
        return "goes on", [s.name for s in SIGNALS if mask >> (s - 1) & 1]


@row("fish-shell 4007; mir 1734; oq-engine 4025",
     "a shell ignores HUP, INT, TERM, PIPE, XCPU and XFSZ; the mask in /proc, and the signals are sent", "all stay ignored")
def ignored_signals(c):
    answers = [sent(c, number, True) for number in SIGNALS[:4]]
    return verdict(all(a == "goes on" and len(mask) == len(SIGNALS) for a, mask in answers), *(a for a, _ in answers), *answers[0][1])


host("pyepics 10; viser 518; kivy 2566", "a host whose method is the report, bound, in a partial or in a lambda, and which has rendered",
     "freed by the collector", """
class Host:
    def __init__(self, wrap):
        self.scene = hdalabaster.Scene(report=wrap(self))
        self.scene.set_mesh("/card", points=CARD, indices=[[0, 1, 2, 3]])
        self.renderer = hdalabaster.Renderer(self.scene, samples=1, report=wrap(self))
        self.render = self.renderer.render(width=4, height=4, camera=CAMERA)
    def log(self, *report): pass
for wrap in (lambda h: h.log), (lambda h: functools.partial(Host.log, h)), (lambda h: lambda *r: h.log(*r)):
    seen = [weakref.ref(Host(wrap)) for _ in range(3)]
    gc.collect()
    told("freed", [one() is None for one in seen])
""")
host("tucanos 221; PyOP2 224", "points, faces and matrices in Fortran's order, strided, reversed, of other types, big-endian",
     "as in C's order, or refused", """
f32, faces = np.array(CARD, np.float32) * np.float32([1, .5, 1]) + np.float32([.2, 0, 0]), np.array([[0, 1, 2, 3]])
matrix = np.array([[.8, .6, 0, 0], [-.6, .8, 0, 0], [0, 0, 1, 0], [.1, .2, 0, 1]])
def seen(points, faces, matrix):
    scene = hdalabaster.Scene()
    scene.set_mesh("/card", points=points, indices=faces, transform=matrix)
    camera = dict(CAMERA, transform=np.asfortranarray(CAMERA["transform"], float))
    return hdalabaster.Renderer(scene, samples=4).render(width=16, height=12, camera=camera, aovs=["depth"])["depth"].numpy().copy()
right, F = seen(f32.tolist(), [[0, 1, 2, 3]], matrix.tolist()), np.asfortranarray
told("as in C", [right.min() < 1] + [np.array_equal(seen(p, i, m), right) for p, i, m in (
    (F(f32), F(faces, np.int32), F(matrix)), (np.repeat(f32, 2, 0)[::2], faces.astype(np.uint8), matrix.T.copy().T),
    (f32[::-1].copy()[::-1], faces[:, ::-1].copy()[:, ::-1], matrix), (np.ascontiguousarray(f32.T).T, faces.astype(np.int64), matrix))])
big = (f32.astype(">f4"), faces, matrix), (f32, faces.astype(">i4"), matrix), (f32, faces, matrix.astype(">f8"))
told("big-endian refused", [refused(seen, *a) for a in big])
""")


def image_named(c, uri, name="uri.gltf"):
    def change(model):
        model.json["images"] = [{"uri": uri}]
        model.json["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": model.texture(0)}}}]
    return c.card(name, change=change)


@row("panda3d-gltf 131; blend2bam 89; BabylonJS Exporters 685", r"images C:\tex\a.png, c%3A/tex/a.png; ..%5Ctex%5Ca.png, which exists",
     "a drive letter; outside, or read if allowed")
def drives(c):
    c.write("tex/a.png", png(flat(255, 0, 0)))
    scene = image_named(c, r"..%5Ctex%5Ca.png", "scenes/model.gltf")
    code, text = c.run("check", scene, "--allow-outside")
    refusals = [named(c.run("check", image_named(c, u)), "drive letter") for u in (r"C:\tex\a.png", "c%3A/tex/a.png")]
    return worst(*refusals, named(c.run("check", scene), "outside"), verdict(code == 0, "allowed:", code))


def tile_set(c, *tiles):
    for tile in tiles:
        c.write(f"t.{tile}.png", png(flat(255, 255, 255)))
    c.write("new.png", png(flat(0, 255, 0)))
    return c.painted("t.<UDIM>.png")


host("Auto_Reload_Blender_addon 22; OpenUSD 1352", "a tile of a <UDIM> set is edited while a host has it; command flush",
     "the new picture", """
scene = hdalabaster.Scene()
settings, renderer = scene.load("painted.json")["settings"], hdalabaster.Renderer(scene, samples=1)
def seen(): return renderer.render(settings=settings, width=4, height=4)["color"].numpy()[1, 1, :3].tolist()
told("before", [seen() == [1, 1, 1]])
os.replace("new.png", "t.1001.png")
renderer.command("flush")
told("after", [seen() == [0, 1, 0]])
""", lambda c: tile_set(c, 1001, 1002))


@row("w3c/png 423; darktable 3283", "PNG of 8 and 16 bits, TIFF and JPEG for P3-D65, Rec.2100-PQ, Rec.709 and sRGB",
     "tagged, or a warning; nothing for sRGB")
def tagged(c):
    ok, found = True, []
    for display in "P3-D65", "Rec.2100-PQ", "Rec.709", "sRGB":
        for file, bits in ("p.png", 8), ("p.png", 16), ("p.tif", 16), ("p.jpg", 8):
            product = {"file": file, "display": display, "dataType": f"uint{bits}"}
            scene = c.write("p.json", {"models": [{"file": c.card()}], "products": [product]})
            code, text = c.run("render", scene, "--size", "8x8", "--spp", "1", "--studio", "off")
            has = c.chunks(file) if file == "p.png" else {}
            tags = [k + "/".join(["", *map(str, has[k])] if k == "cICP" else "") for k in has if k in ("cICP", "iCCP", "gAMA", "cHRM")]
            said = tags + ["warning"] * ("warning" in text)
            ok &= code == 0 and bool(said) == (display != "sRGB")
            found.append(f"{display} {file[2:]} {bits}: {' '.join(said) or 'nothing'}")
    return verdict(ok, *found)


@row(1, "colour of a point, spot and directional light, over that of a white one; ACEScg", "the colour converted")
def light_colours(c):
    def lit(colour, kind):
        def change(model):
            light = {"type": kind, "color": list(colour), "intensity": 5, **({"spot": {}} if kind == "spot" else {})}
            model.json["extensions"] = {"KHR_lights_punctual": {"lights": [light]}}
            model.use("KHR_lights_punctual")
            model.node(translation=[0, 0, 3], extensions={"KHR_lights_punctual": {"light": 0}})
        grey = {"pbrMetallicRoughness": {"baseColorFactor": [.5, .5, .5, 1], "metallicFactor": 0}}
        return np.array(c.middle(c.card(material=lambda m: m.add("materials", grey), change=change), "--ocio", c.acescg()))
    ratios = [(lit(COLOUR, k) / lit([1, 1, 1], k)).round(3).tolist() for k in ("point", "spot", "directional")]
    return verdict(all(near(r, AP1) for r in ratios), *ratios)


@row(1, "attenuationColor after attenuationDistance, through a cube of ior 1; ACEScg", "the colour converted")
def attenuation(c):
    def cube(model):
        volume = {"thicknessFactor": 1, "attenuationColor": list(COLOUR), "attenuationDistance": 2}
        glass = {"pbrMetallicRoughness": {"roughnessFactor": 0, "metallicFactor": 0}, "extensions": {
            "KHR_materials_ior": {"ior": 1}, "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": volume}}
        model.json["meshes"] = [{"primitives": [model.primitive(CUBE, CUBE_SIDES, material=model.add("materials", glass))]}]
        model.json["nodes"][1]["scale"] = [2, 2, 1]
    sky = {"name": "sky", "type": "domeLight", "visibleToCamera": True}
    seen = c.middle(c.write("sky.json", {"models": [{"file": c.card(change=cube)}], "lights": [sky]}), "--ocio", c.acescg())
    return verdict(near(seen, AP1), seen)


@row(1, "factor (1, .25, .0625) times texture, or COLOR_0, of (.0625, .25, 1); ACEScg", "each converted, and multiplied in the rendering space (manual/pipeline.md)")
def products(c):
    def image(model):
        return model.unlit([*COLOUR, 1], model.image(png(flat(*CURVE[::-1]), 16)))
    models = c.card("t.gltf", image), c.card("v.gltf", attributes={"COLOR_0": ([COLOUR[::-1]] * 4, "f4")})
    seen = [c.middle(m, "--ocio", c.acescg()) for m in models]
    return verdict(all(near(v, [.1196, .0741, .0920]) for v in seen), *seen)


@row(2, "one of two parts has --exposure 1, or --display P3-D65: merged in both orders, then with that option",
     "one picture, or refused by name; the option counts")
def options_of_parts(c):
    ok, found = True, []
    for option, value in ("--exposure", 1), ("--display", "P3-D65"):
        for part in "part0", "part1":
            (c.folder / part).unlink(missing_ok=True)
        a, b = parts(c, c.card(), ["-o", "p.png", option, value], ["-o", "p.png"])
        runs = [c.run("merge", *order, "-o", f"{i}.png") for i, order in enumerate(((a, b), (b, a)))]
        own = c.run("merge", a, b, "-o", "own.png", option, value)
        c.render("card.gltf", option, value, file="one.png", samples=("--spp", 2))
        one_picture = all(code == 0 for code, _ in runs) and same(c, "0.png", "1.png")
        ok &= one_picture or all(code in (2, 3) and option[2:] in text for code, text in runs)
        ok &= own[0] == 0 and same(c, "own.png", "one.png")
        found.append(f"{option[2:]}: {[code for code, _ in runs]}, {'one picture' if one_picture else 'two pictures'}")
    return verdict(ok, *found)


@row(2, "parts of a scene whose products are an EXR with colorSpace ACEScg and a PNG of a view and an exposure; -o names them",
     "the files of one render, or a message")
def several_products(c):
    kinds = {"a.exr": {"colorSpace": "ACEScg"}, "b.png": {"view": "Un-tone-mapped", "exposure": 1}}
    scene = c.write("scene.json", {"models": [{"file": c.card()}], "products": [{"file": f, **more} for f, more in kinds.items()]})
    merge = ["merge", *parts(c, scene, [], []), *(w for f in kinds for w in ("-o", f)), "--quiet"]
    c.run("render", scene, "--size", "8x8", "--spp", "2", "--studio", "off")
    for name in kinds:
        os.rename(c.folder / name, c.folder / ("one_" + name))
    code, text = c.run(*merge)
    equal = {name: code == 0 and same(c, name, "one_" + name) for name in kinds}
    return verdict(all(equal.values()) or code in (2, 3) or "warning" in text, f"{code} {text}".strip(), "as of one render:", equal)


@row(2, "parts of two configs, also with --ocio", "refused")
def two_configs(c):
    merge = ["merge", *parts(c, c.card(), ["--ocio", c.acescg()], []), "-o", "m.exr"]
    return worst(*(named(c.run(*merge, *more), "colour configuration") for more in ([], ["--ocio", "acescg.ocio"])))


@row(3, "EIO and ESTALE from fsync, ENOSPC and EDQUOT from write, where a frame is replaced",
     "exit 5, kept in $TMPDIR, the earlier frame stays")
def disk_errors(c):
    c.render(c.card(), file="share/f.exr")
    before, found = (c.folder / "share/f.exr").read_bytes(), []
    for call, number in ("FSYNC", 5), ("FSYNC", 116), ("WRITE", 28), ("WRITE", 122):
        code, text = c.render("card.gltf", "--seed", "7", file="share/f.exr", **c.share(**{call: number}))
        found.append((code, c.take_kept(), (c.folder / "share/f.exr").read_bytes() == before, len(os.listdir(c.folder / "share"))))
    return verdict(set(found) == {(5, 1, True, 1)}, "code, kept, frame as it was, files there:", *found)


@row(3, "a file system that is read only", "refused before the render")
def read_only(c):
    start = time.time()
    code, text = c.mounted("ro", "render", c.card(), "-o", "disk/f.exr", "--spp", "1000000", "--time-limit", "20")
    return verdict(code == 5 and time.time() - start < 10, f"{time.time() - start:.1f} s", code, text.strip())


def growth(what, seconds, n=4000):
    """Of the seconds of n and of 4 n."""
    few, many = seconds(n), seconds(4 * n)
    return verdict(many < .5 or many < 7 * few, f"{what}: {few:.2f} and {many:.2f} s")


@row(4, "4000 and 16000 lights by name, links, models of one file, subsets, parts of an archive", "four times, at most seven")
def named_kinds(c):
    kinds = "lights", "links", "models", "subsets", "archive"
    return worst(*(growth(k, lambda n: named_edits.measure(c.program, k, n, c.folder)) for k in kinds))


host(4, "Python sets, binds and edits 4000 and 16000 materials and meshes", "the same", """
def seconds(n):
    scene, start = hdalabaster.Scene(), time.process_time()
    for i in range(n):
        scene.set_material(f"/m{i}", roughness=.5)
        scene.set_mesh(f"/o{i}", points=CARD, indices=[[0, 1, 2, 3]], material=f"/m{i}")
    for i in range(n): scene.edit(f"/m{i}", {"surface.roughness": .25})
    hdalabaster.Renderer(scene, samples=1).render(width=1, height=1, camera=CAMERA)
    return time.process_time() - start
few, many = seconds(4000), seconds(16000)
told(f"{few:.2f} and {many:.2f} s", [many < 7 * few])
""")


@row(5, "TERM, PIPE, INT and XCPU are sent to a render whose parent ignores none", "exit 130, the picture is marked")
def caught_signals(c):
    codes = [sent(c, number, False)[0] for number in SIGNALS[1:5]]
    marked = "alabaster/incomplete" in exr_attributes((c.folder / "job.exr").read_bytes())[0]
    return verdict(set(codes) == {130} and marked, codes, f"marked: {marked}")


@row(5, "the reader of the messages has gone; PIPE is ignored, and not", "the whole picture; exit 130")
def closed_pipe(c):
    codes = []
    for trap in "trap '' PIPE; ", "":
        script = trap + f'"{c.program}" render card.gltf -o "{len(trap)}.exr" --size 8x8 --spp 1; echo $? > code'
        c.card()
        c.run("-c", f"({script}) 2>&1 >/dev/null | true", command=["bash"])
        time.sleep(.5)
        codes.append((c.folder / "code").read_text().strip())
    return verdict(codes[0] == "0" and codes[1] in ("0", "130") and (c.folder / "14.exr").exists(), codes)


host(6, "Render.read into other orders, types and sizes, read-only; into the pixels' own and one axis", "refused; the pixels", """
render = hdalabaster.Renderer(card(), samples=1).render(width=6, height=4, camera=CAMERA, aovs=["color", "primId"])
shape, f, locked = (4, 6, 4), np.float32, np.zeros((4, 6, 4), np.float32)
locked.flags.writeable = False
wrong = [np.zeros(shape, f, order="F"), np.zeros((4, 6, 8), f)[:, :, ::2], np.zeros(shape, f)[::-1], locked]
wrong += [np.zeros(s, f) for s in ((8, 8, 4), (4, 6, 3), (6, 4, 4), (97,), (95,), ())]
wrong += [np.zeros(384, "u1"), np.zeros((4, 6), "f4,f4,f4,f4")] + [np.zeros(shape, t) for t in ("f8", "f2", "i4", "u4", "u1", ">f4")]
told("color refused", [refused(render.read, "color", a) for a in wrong])
told("primId refused", [refused(render.read, "primId", np.zeros((4, 6), t)) for t in ("f4", "u4", "i8", "i2", ">i4")])
right = [(aov, np.zeros(s, t)) for aov, s, t in (("color", shape, f), ("color", 96, f), ("primId", (4, 6), "i4"), ("primId", 24, "i4"))]
for aov, array in right: render.read(aov, array)
told("read", [np.array_equal(array.ravel(), render[aov].numpy().ravel()) for aov, array in right])
told("untouched", [not a.tobytes().strip(bytes(1)) for a in wrong])
""")
host(6, "faces as rows of tuples and arrays of 3 to 5 corners; rows of 2, 1, 0 corners, nested, of fractions, of text",
     "all drawn; refused or reported", """
POINTS = [(-1, -1, 0), (0, -1, 0), (0, 1, 0), (-1, 1, 0), (1, 0, 0), (1, -1, 0), (1, 1, 0)]
def covered(indices, counts=None, said=None):
    report = lambda *r: said is not None and said.append(r)
    scene = hdalabaster.Scene(report=report)
    scene.set_mesh("/card", points=POINTS, indices=indices, counts=counts)
    return hdalabaster.Renderer(scene, samples=4, report=report).render(width=16, height=16, camera=CAMERA)["color"].numpy()[:, :, 3].mean()
def seen(rows):
    said = []
    return refused(covered, rows, None, said) or bool(said)
four, five = covered([0, 1, 2, 3, 1, 4, 2], [4, 3]), covered([1, 5, 4, 6, 2, 0, 1, 2, 3], [5, 4])
rows = [(0, 1, 2, 3), (1, 4, 2)], ((1, 4, 2), (0, 1, 2, 3)), [np.array([0, 1, 2, 3]), np.array([1, 4, 2])], [[0, 1, 2, 3], (1, 4, 2)]
told("drawn", [covered(r) == four for r in rows] + [covered([[1, 5, 4, 6, 2], [0, 1, 2, 3]]) == five])
told("refused or reported", [seen([[0, 1, 2, 3], r]) for r in ([1, 4], [1], [], [[1, 4, 2]], [1, 4.5, 2], 1, "142", [1, 4, 9], [1, 4, -1])])
""")
host(6,
     "2.5 as samples (of numpy's types, too), seed, maxDepth, width, refineLevel, counts, index, pick; 2.0 and int64", "refused; taken", """
from fractions import Fraction
scene = card()
renderer = hdalabaster.Renderer(scene, samples=1)
render = renderer.render(width=4, height=4, camera=CAMERA, aovs=["primId"])
broken = 2.5, np.float64(2.5), np.float32(2.5), np.float16(2.5), Fraction(5, 2), np.nan, "2"
told("samples refused", [refused(renderer.set, samples=v) for v in broken])
told("others refused", [refused(renderer.set, seed=1.5), refused(renderer.set, maxDepth=2.5), refused(renderer.start, width=4.5, height=4),
     refused(hdalabaster.Scene(report=lambda *r: None).load, "card.gltf", overrides=["samples=2.5"]),
     refused(scene.edit, "/card", {"refineLevel": 1.5}), refused(scene.set_render_settings, "/s", width=4.5),
     refused(scene.set_mesh, "/o", points=CARD, indices=np.array([0., 1.5, 2.])),
     refused(scene.set_mesh, "/o", points=CARD, indices=[0, 1, 2], counts=[2.5]), refused(render.pick, (0, 0, 1.5, 1))])
whole = 2, 2.0, np.int64(2), np.float64(2), Fraction(2), np.uint8(2)
told("whole ones taken", [not refused(renderer.set, samples=v) and renderer.get("samples") == 2 for v in whole])
""")


URIS = {"http://example.com/a.png": "http:", "file:///tmp/a.png": "file:", r"\\server\share\a.png": "share of Windows",
        r"C:\tex\a.png": "drive letter", "/abs/a.png": "absolute path", "../b.png": "outside",
        "data:image/png;base64,!!!!": "data", "data:image/png,abc": "data"}


@row(7, "images of a glTF file, textures and models of a description: " + ", ".join(f"`{u}`" for u in URIS), "refused by cause")
def uris(c):
    found = []
    for uri, word in URIS.items():
        model = c.write("m.json", {"models": [{"file": uri.replace(".png", ".gltf")}]})
        found.append(worst(*(named(c.run("check", s), word) for s in (image_named(c, uri), c.painted(uri), model))))
    return worst(*((v, f"`{word}`" if v == "refused" else f) for word, (v, f) in zip(URIS.values(), found)))


@row(7, "a tile of a <UDIM> set is added, removed or renamed after convert", "reported")
def tiles(c):
    found = []
    for change in "added", "removed", "renamed":
        tile_set(c, 1001, 1002)
        c.run("convert", "painted.json", "-o", "set.alab")
        old, new = "new.png" if change == "added" else "t.1002.png", "tex/x" if change == "removed" else "t.1003.png"
        os.rename(c.folder / old, c.folder / new)
        code, text = c.run("check", "set.alab")
        said = text.split(".png: ")[-1].split(".")[0]
        found.append((code == 3 or "has changed" in text, f"{change}: {code} {said}"))
        (c.folder / "t.1003.png").unlink(missing_ok=True)
    return verdict(all(ok for ok, _ in found), *(f for _, f in found))


@row(8, "TMPDIR is empty: a frame that cannot be written", "kept in /tmp")
def empty_tmpdir(c):
    code, text = c.render(c.card(), file="share/f.exr", **{**c.share(FSYNC=5), "TMPDIR": ""})
    kept = pathlib.Path(re.search(r"kept as ([^:]+)|$", text)[1] or "/nonexistent")
    whole = kept.exists() and str(c.folder) not in str(kept)
    if whole:
        kept.unlink()
        kept.parent.rmdir()
    return verdict(code == 5 and whole, code, text.strip())


@row(8, "animations named \"1\" and \"0\" in this order, and asked for as 1, 0 and 2", "by name; 2 is refused")
def numbered_names(c):
    def change(model):
        times = model.accessor([0., 1.])
        for name, y in ("1", 0), ("0", 9):  # the one named 0 moves the card out of the picture
            sampler = {"input": times, "output": model.accessor([[0, y, 0]] * 2)}
            channel = {"sampler": 0, "target": {"node": 1, "path": "translation"}}
            model.add("animations", {"name": name, "samplers": [sampler], "channels": [channel]})
    seen = [c.middle(c.card(change=change), "--time", "0.5", "--animation", n)[0] for n in "10"]
    return worst(verdict(seen == [1, 0], seen), named(c.render("card.gltf", "--animation", "2"), "has no animation '2'"))


@row(9, "PNG of 2^31-1 pixels a side, EXR with a window of 2^30, TIFF and Radiance without their rows, TGA without bits, GIF, BMP",
     "refused by the file's name")
def damaged(c):
    wide, window = bytearray(png(flat(1, 2, 3))), bytearray(exr(4, 4, {k: (np.ones((4, 4)), 2, 1, 1) for k in "RGB"}))
    wide[16:24] = b"\x7f\xff\xff\xff" * 2
    wide[29:33] = zlib.crc32(wide[12:29]).to_bytes(4, "big")
    at = window.index(b"dataWindow\0box2i\0") + 29
    window[at:at + 8] = (2 ** 30).to_bytes(4, "little") * 2
    files = {"a.png": wide, "a.exr": window, "a.tif": tiff(np.ones((64, 64, 3), np.uint8))[:300],
             "a.tga": bytes([0, 0, 2] + [0] * 9 + [4, 0, 4, 0, 0, 0]),
             "a.hdr": b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 4\n", "a.gif": b"GIF89a\1\0\1\0\0\0\0", "a.bmp": b"BM" + bytes(52)}
    return worst(*(named(c.run("check", c.painted(c.write(name, bytes(data)))), name) for name, data in files.items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda text: str(pathlib.Path(text).resolve()))
    parser.add_argument("--module", default=os.environ.get("PYTHONPATH", ""))
    parser.add_argument("--only", default="", help="rows that have this text")
    options = parser.parse_args()
    counts = {}
    for head in "report", "kind":
        print(f"\n| {head} | situation | right answer | verdict | seen |\n| --- | --- | --- | --- | --- |")
        rows = [r for r in ROWS if r[0].isdigit() == (head == "kind") and options.only in " ".join(r[:2])]
        for name, situation, answer, function in rows:
            with tempfile.TemporaryDirectory(prefix="alabaster_round4_") as folder:
                try:
                    judged, found = function(Case(options.program, options.module, pathlib.Path(folder)))
                except NotRun as why:
                    judged, found = "not run", str(why)
                except Exception as error:
                    traceback.print_exc()
                    judged, found = "WRONG", f"{type(error).__name__}: {error}"
            counts[judged] = counts.get(judged, 0) + 1
            found = re.sub(r"\s+", " ", found.replace(folder + "/", "").replace("|", "\\|"))
            print(re.sub(r"<(?=[A-Z])", "&lt;", f"| {name} | {situation} | {answer} | {judged} | {found} |"), flush=True)
    print("\n" + ", ".join(f"{n} {v}" for v, n in sorted(counts.items())))
    return 1 if counts.get("WRONG") or not counts else 0


if __name__ == "__main__":
    sys.exit(main())
