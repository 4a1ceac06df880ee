#!/usr/bin/env python3
"""Ten scattering models whose materials are parts of one surface, each beside the same surface as one primitive.

  many_materials.py PROGRAM [--out FOLDER] [--only NAME] [--size 200x200] [--spp 64]

A model is a glTF mesh with a primitive for each material, as exporters write it. The same as one primitive has one material whose
texture gives every face the colour of its part. Both scatter by the same distances, so the two pictures agree but for noise, which
is printed beside the difference. Writes FOLDER/NAME_parts.png and NAME_one.png and, with oiiotool, FOLDER/sheet.jpg: a row has two models.
many_materials.jpg is that sheet, with --size 128x128 --spp 24.
The exit status is 1 if two means differ by more than one percent, or one of the meshes is reported as open.
"""
import argparse
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import numpy as np  # noqa: E402
from made_images import png  # noqa: E402
from made_models import Model  # noqa: E402
from public_reports import read_layers  # noqa: E402

MODELS = []  # (name, function)


def model(function):
    MODELS.append((function.__name__, function))
    return function


class Surface:
    """Triangles over shared points, each with the number of its part."""

    def __init__(self, points, faces, part=0):
        self.points, self.faces = np.asarray(points, float), np.asarray(faces, int)
        self.parts = np.full(len(self.faces), part)

    def cut(self, field, part, within=None):
        """Faces where field(points) > 0 become `part`, of those parts that are listed. Edges are cut where the field is zero."""
        value = field(self.points)
        value[np.abs(value) < 1e-9] = 1e-9
        points, faces, parts, cuts = list(self.points), [], [], {}

        def between(a, b):
            key = (min(a, b), max(a, b))
            if key not in cuts:
                a, b = key
                t = value[a] / (value[a] - value[b])
                cuts[key] = len(points)
                points.append(self.points[a] + t * (self.points[b] - self.points[a]))
            return cuts[key]
        for face, old in zip(self.faces, self.parts):
            inside = value[face] > 0
            new = part if within is None or old in within else old
            if inside.all() or not inside.any():
                faces.append(face)
                parts.append(new if inside.all() else old)
                continue
            alone = inside if inside.sum() == 1 else ~inside
            k = int(np.argmax(alone))
            a, b, c = face[k], face[(k + 1) % 3], face[(k + 2) % 3]
            ab, ac = between(a, b), between(a, c)
            one, two = (new, old) if inside[k] else (old, new)
            faces += [(a, ab, ac), (ab, b, c), (ab, c, ac)]
            parts += [one, two, two]
        self.points, self.faces, self.parts = np.array(points), np.array(faces), np.array(parts)
        return self

    def join(self, other):
        self.faces = np.vstack([self.faces, other.faces + len(self.points)])
        self.points = np.vstack([self.points, other.points])
        self.parts = np.concatenate([self.parts, other.parts])
        return self

    def moved(self, change):
        self.points = change(self.points)
        return self

    def normals(self):
        a, b, c = (self.points[self.faces[:, k]] for k in range(3))
        face = np.cross(b - a, c - a)
        total = np.zeros_like(self.points)
        for k in range(3):
            np.add.at(total, self.faces[:, k], face)
        return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-30)


def revolved(profile, rows=96, columns=128, part=0):
    """A closed surface of revolution about y. profile(t) gives radius and height, and has radius 0 at t = 0 (top) and 1."""
    points = [(0, profile(0)[1], 0)]
    for i in range(1, rows):
        r, y = profile(i / rows)
        points += [(r * math.sin(2 * math.pi * j / columns), y, r * math.cos(2 * math.pi * j / columns)) for j in range(columns)]
    points.append((0, profile(1)[1], 0))

    def at(i, j):
        return 0 if i == 0 else len(points) - 1 if i == rows else 1 + (i - 1) * columns + j % columns
    faces = []
    for i in range(rows):
        for j in range(columns):
            if i < rows - 1:
                faces.append((at(i, j), at(i + 1, j), at(i + 1, j + 1)))
            if i > 0:
                faces.append((at(i, j), at(i + 1, j + 1), at(i, j + 1)))
    return Surface(points, faces, part)


def ball(radius=1.0, centre=(0, 0, 0), stretch=(1, 1, 1), part=0, rows=96, columns=128):
    made = revolved(lambda t: (math.sin(math.pi * t), math.cos(math.pi * t)), rows, columns, part)
    return made.moved(lambda p: p * radius * np.array(stretch) + np.array(centre))


def smooth_profile(knots):
    """A curve through (radius, height), rounded by averaging."""
    knots = np.array(knots, float)
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1))])
    t = np.linspace(0, 1, 400)
    curve = np.stack([np.interp(t * length[-1], length, knots[:, c]) for c in range(2)], axis=1)
    window = np.hanning(21) / np.hanning(21).sum()
    padded = np.vstack([curve[10:0:-1] * (-1, 1), curve, curve[-2:-12:-1] * (-1, 1)])
    for c in range(2):
        curve[:, c] = np.convolve(padded[:, c], window, "same")[10:-10]
    curve[0, 0] = curve[-1, 0] = 0

    def at(s):
        return tuple(float(np.interp(s, t, curve[:, c])) for c in range(2))
    return at


def bump(p, centre, radius):
    return np.exp(-np.sum((p - np.array(centre)) ** 2, axis=1) / radius ** 2)


def disc(centre, radius, stretch=(1, 1, 1)):
    """Above zero within an ellipsoid about the centre."""
    return lambda p: 1 - np.sqrt(np.sum(((p - np.array(centre)) / (radius * np.array(stretch))) ** 2, axis=1))


def band(low, high):
    return lambda p: np.minimum(p[:, 1] - low, high - p[:, 1])


@model
def head():
    def shape(p):
        p = p * (.66, 1, .82)
        p[:, 2] += .12 * np.clip((-.2 - p[:, 1]) * 2, 0, 1) * np.clip((1.02 + p[:, 1]) * 5, 0, 1) * (p[:, 2] > 0)
        p[:, 2] += .3 * bump(p, (0, -.08, .9), .17) + .14 * bump(p, (0, -.42, .82), .2) + .12 * bump(p, (0, -.8, .6), .25)
        for side in (-1, 1):
            p[:, 2] -= .11 * bump(p, (side * .27, .14, .75), .15)
            p[:, 0] += side * .13 * bump(p, (side * .66, 0, .02), .17)
        return p
    made = revolved(smooth_profile([(0, 1), (.55, .88), (.92, .45), (1, 0), (.9, -.5), (.62, -.84), (.48, -1), (.46, -1.25), (.62, -1.42), (0, -1.42)]), 200, 200).moved(shape)
    made.cut(lambda p: p[:, 1] - .35 - .55 * np.clip(p[:, 2], -.6, 1) + .25 * np.abs(p[:, 0]), 1)  # hair
    for side in (-1, 1):
        made.cut(disc((side * .26, .14, .66), .135, (1, .55, 2.5)), 2, {0})  # white of the eye
        made.cut(disc((side * .25, .14, .66), .07, (1, 1, 5)), 3, {2})  # iris
        made.cut(disc((side * .27, .31, .66), .18, (1, .17, 2.5)), 1, {0})  # brow
    made.cut(disc((0, -.42, .85), .2, (1, .34, 1.5)), 4, {0})  # lips
    return made, [(.8, .5, .36), (.1, .04, .02), (.85, .84, .8), (.06, .16, .24), (.55, .11, .1)], (.06, .03, .02)


@model
def bottle():
    made = revolved(smooth_profile([(0, 1.1), (.2, 1.1), (.2, .75), (.24, .62), (.58, .38), (.62, .2), (.62, -1), (.55, -1.08), (0, -1.08)]), 160, 128)
    made.cut(lambda p: np.minimum(band(-.75, .05)(p), p[:, 2] + .15), 1)
    made.cut(lambda p: np.minimum(disc((0, -.35, .62), .3)(p), p[:, 2]), 2, {1})
    made.cut(lambda p: p[:, 1] - .78, 3)
    return made, [(.12, .45, .25), (.9, .87, .75), (.75, .12, .1), (.15, .15, .17)], (.06, .08, .05)


@model
def plant():
    made = revolved(smooth_profile([(0, -.35), (.44, -.35), (.46, -.2), (.58, -.2), (.58, -.38), (.52, -.42), (.38, -1.1), (0, -1.1)]), 128, 96)
    made.cut(lambda p: np.minimum(.44 - np.hypot(p[:, 0], p[:, 2]), p[:, 1] + .6), 1)  # soil
    made.cut(band(-.75, -.6), 2, {0})  # a painted band
    for k in range(7):
        turn, lean = 2.4 * k, .35 + .1 * (k % 3)
        leaf = ball(1, (0, 0, 0), (.16, .55, .03), 3, 40, 48)

        def place(p, turn=turn, lean=lean, size=1 + .12 * (k % 4)):
            y = (p[:, 1] + .55) * size
            x, z = p[:, 0], p[:, 2] + lean * y ** 2 + .12
            return np.stack([math.cos(turn) * x + math.sin(turn) * z, y - .42, -math.sin(turn) * x + math.cos(turn) * z], axis=1)
        leaf.cut(lambda p: .028 - np.abs(p[:, 0]), 4, {3})  # vein
        made.join(leaf.moved(place))
    return made, [(.7, .33, .2), (.07, .045, .03), (.85, .8, .7), (.1, .35, .05), (.35, .6, .15)], (.03, .04, .015)


@model
def apple():
    def shape(p):
        r = np.hypot(p[:, 0], p[:, 2])
        p[:, 1] -= .42 * np.exp(-(r / .3) ** 2) * np.sign(p[:, 1]) * (1 - .3 * (p[:, 1] < 0))
        p[:, 0] *= 1 + .08 * p[:, 1]
        p[:, 2] *= 1 + .08 * p[:, 1]
        return p * (.95, .86, .95)
    made = ball().moved(shape)
    made.cut(lambda p: .36 - np.hypot(p[:, 0], p[:, 2]) + .08 * np.sin(5 * np.arctan2(p[:, 0], p[:, 2])) - (p[:, 1] < 0), 1)  # green about the stem
    made.cut(lambda p: .09 - np.hypot(p[:, 0], p[:, 2]) - (p[:, 1] > 0), 2)  # calyx
    stem = revolved(smooth_profile([(0, 1.02), (.06, 1.02), (.04, .9), (.035, .4), (0, .4)]), 40, 32, 2)
    stem.moved(lambda p: p + np.stack([.15 * (p[:, 1] - .4) ** 2, 0 * p[:, 0], 0 * p[:, 0]], axis=1))
    leaf = ball(1, (0, 0, 0), (.34, .03, .15), 3, 40, 48).moved(lambda p: p + np.stack([p[:, 0] * 0 + .4, .86 + .35 * p[:, 0] - .5 * p[:, 0] ** 2 + .25 * p[:, 2], 0 * p[:, 0]], axis=1))
    return made.join(stem).join(leaf), [(.62, .03, .03), (.5, .58, .1), (.12, .06, .03), (.1, .32, .04)], (.025, .014, .009)


@model
def candle():
    def shape(p):
        turn = np.arctan2(p[:, 0], p[:, 2])
        drip = np.clip(.12 * np.sin(3 * turn) + .1 * np.sin(7 * turn + 1), 0, 1)
        p[:, 1] += np.where(p[:, 1] > .6, .12 * np.sin(turn * 2), 0)
        scale = 1 + drip * np.clip((p[:, 1] + .2) / 1.2, 0, 1)
        return p * np.stack([scale, np.ones_like(scale), scale], axis=1)
    made = revolved(smooth_profile([(0, .74), (.22, .72), (.46, .82), (.52, .75), (.5, -1), (.46, -1.06), (0, -1.06)]), 140, 160).moved(shape)
    made.cut(band(-.62, -.38), 1)
    made.cut(band(-.2, -.12), 1)
    wick = revolved(smooth_profile([(0, 1.06), (.035, 1.06), (.035, .4), (0, .4)]), 60, 32, 2)
    wick.moved(lambda p: p + np.stack([.3 * np.clip(p[:, 1] - .74, 0, 1) ** 2, 0 * p[:, 0], 0 * p[:, 0]], axis=1))
    wick.cut(lambda p: p[:, 1] - .95, 3)
    return made.join(wick), [(.9, .8, .6), (.6, .05, .08), (.75, .7, .6), (.05, .04, .04)], (.14, .09, .05)


def superball(stretch, power=4.0, part=0, rows=128, columns=160):
    """A ball with the sides of a box, rounded."""
    def shape(p):
        return p / (np.sum(np.abs(p) ** power, axis=1, keepdims=True) ** (1 / power)) * np.array(stretch)
    return ball(1, part=part, rows=rows, columns=columns).moved(shape)


@model
def soap():
    made = superball((1, .36, .66), 5).moved(lambda p: p @ np.array([[1, 0, 0], [0, .77, .64], [0, -.64, .77]]))

    def inlay(p):
        q = p @ np.array([[1, 0, 0], [0, .77, -.64], [0, .64, .77]])
        return np.minimum(1 - np.hypot(q[:, 0] / .6, q[:, 2] / .36), q[:, 1])

    def star(p):
        q = p @ np.array([[1, 0, 0], [0, .77, -.64], [0, .64, .77]])
        turn, r = np.arctan2(q[:, 0], q[:, 2]), np.hypot(q[:, 0], q[:, 2])
        return np.minimum(.2 + .07 * np.cos(5 * turn) - r, q[:, 1])
    made.cut(inlay, 1).cut(star, 2, {1})
    return made, [(.8, .45, .42), (.16, .4, .65), (.92, .9, .85)], (.07, .05, .04)


@model
def mushroom():
    made = revolved(smooth_profile([(0, .95), (.5, .82), (.95, .3), (.92, .16), (.3, .12), (.26, -.6), (.36, -.95), (.3, -1.05), (0, -1.05)]), 160, 160)
    made.cut(lambda p: np.minimum(p[:, 1] - .2, 2), 1)
    made.cut(lambda p: np.minimum(band(.05, .2)(p), np.hypot(p[:, 0], p[:, 2]) - .31), 3)
    for k in range(14):
        r, turn = .12 + .8 * math.sqrt(k / 14), 2.4 * k
        height = .95 - .26 * r if r < .5 else .82 - 1.155 * (r - .5)
        made.cut(disc((r * math.sin(turn), height, r * math.cos(turn)), .07 + .025 * (k % 3), (1, 2, 1)), 2, {1})
    return made, [(.8, .72, .55), (.6, .03, .02), (.9, .86, .75), (.7, .55, .36)], (.07, .045, .03)


@model
def cake():
    made = superball((.9, .62, .9), 9)
    made.cut(band(-.36, -.24), 1).cut(band(.06, .18), 1)
    made.cut(lambda p: p[:, 1] - .42 + .09 * np.sin(6 * np.arctan2(p[:, 0], p[:, 2])) + .06 * np.sin(11 * np.arctan2(p[:, 0], p[:, 2])), 2)
    cherry = ball(.2, (0, .74, 0), (1, .95, 1), 3, 48, 64)
    return made.join(cherry), [(.7, .38, .13), (.92, .86, .72), (.22, .07, .035), (.55, .01, .03)], (.06, .04, .025)


@model
def egg():
    made = ball(1, stretch=(.74, 1, .74)).moved(lambda p: p * np.stack([1 - .14 * p[:, 1], np.ones(len(p)), 1 - .14 * p[:, 1]], axis=1))

    def wave(low, high):
        return lambda p: band(low, high)(p + np.stack([0 * p[:, 0], .06 * np.sin(8 * np.arctan2(p[:, 0], p[:, 2])), 0 * p[:, 0]], axis=1))
    made.cut(wave(.42, .58), 1).cut(wave(-.58, -.42), 1).cut(band(-.18, .18), 2)
    for k in range(10):
        turn = 2 * math.pi * k / 10
        made.cut(disc((.74 * math.sin(turn), 0, .74 * math.cos(turn)), .12), 3, {2})
    return made, [(.88, .8, .66), (.75, .12, .25), (.1, .4, .55), (.9, .65, .1)], (.06, .05, .035)


@model
def jelly():
    def shape(p):
        turn = np.arctan2(p[:, 0], p[:, 2])
        scale = 1 + .07 * np.cos(10 * turn) * np.clip((.75 - p[:, 1]) * 3, 0, 1)
        return p * np.stack([scale, np.ones_like(scale), scale], axis=1)
    made = revolved(smooth_profile([(0, .72), (.3, .76), (.5, .66), (.62, .3), (.78, -.7), (.72, -.82), (0, -.82)]), 140, 200).moved(shape)
    made.cut(band(-.9, -.4), 1).cut(band(-.4, -.05), 2).cut(band(-.05, .3), 3)
    return made, [(.8, .04, .08), (.1, .5, .15), (.9, .85, .75), (.95, .45, .04)], (.14, .11, .09)


def write(surface, colors, parts, file):
    """With `parts`, a primitive for each; otherwise one, whose texture has a texel for each part."""
    made, normals = Model(camera=False), surface.normals()
    groups = [[p] for p in range(len(colors))] if parts else [list(range(len(colors)))]
    texture = None
    if not parts:
        bytes_of = [[round(255 * (12.92 * v if v <= .0031308 else 1.055 * v ** (1 / 2.4) - .055)) for v in color] for color in colors]
        texture = made.image(png(np.array([bytes_of])))
    primitives = []
    for group in groups:
        chosen = np.isin(surface.parts, group)
        corners, owners = surface.faces[chosen], surface.parts[chosen]
        keys, indices = np.unique(np.stack([corners.ravel(), np.repeat(owners, 3)], axis=1), axis=0, return_inverse=True)
        attributes = {"NORMAL": normals[keys[:, 0]]}
        base = {"metallicFactor": 0, "roughnessFactor": .4}
        if texture is None:  # the colours that the texture has, so that only the splitting differs
            base["baseColorFactor"] = [*rounded(colors[group[0]]), 1]
        else:
            base["baseColorTexture"] = {"index": texture}
            attributes["TEXCOORD_0"] = np.stack([(keys[:, 1] + .5) / len(colors), np.full(len(keys), .5)], axis=1)
        material = made.add("materials", {"name": f"m{len(primitives)}", "pbrMetallicRoughness": base})
        primitive = made.primitive(surface.points[keys[:, 0]], None, attributes, material=material)
        primitive["indices"] = made.accessor(indices.ravel(), "u4")
        primitives.append(primitive)
    made.node(mesh=made.mesh(*primitives))
    made.write(file)


def rounded(color):
    from made_images import to_linear
    return [to_linear(round(255 * (12.92 * v if v <= .0031308 else 1.055 * v ** (1 / 2.4) - .055))) for v in color]


def write_paper(low, file):
    """A sheet that lies at height `low` and bends up behind."""
    made, points, normals, columns = Model(camera=False), [], [], 24
    for z, y, nz, ny in [(6, 0, 0, 1), (-2, 0, 0, 1), *((-2 - 2 * math.sin(a), 2 - 2 * math.cos(a), math.sin(a), math.cos(a))
                                                        for a in np.linspace(0, math.pi / 2, 17)[1:]), (-4, 12, 1, 0)]:
        for x in np.linspace(-12, 12, columns):
            points.append((x, y + low, z))
            normals.append((0, ny, nz))
    rows = len(points) // columns
    faces = [(a, a + 1, a + columns + 1, a, a + columns + 1, a + columns) for i in range(rows - 1) for a in range(i * columns, (i + 1) * columns - 1)]
    material = made.add("materials", {"name": "paper", "pbrMetallicRoughness": {"baseColorFactor": [.32, .33, .35, 1], "metallicFactor": 0}, "doubleSided": True})
    made.node(mesh=made.mesh(made.primitive(points, np.array(faces).ravel(), {"NORMAL": normals}, material=material)))
    made.write(file)


def scene_of(name, distance, size, samples, surface):
    """Before a paper that bends up behind; a key light from the left, a rim behind, so that thin parts glow."""
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    target, far = [0, float(low[1] + high[1]) / 2, 0], 3.05 * float(max(high[1] - low[1], 1.05 * (high[0] - low[0])))
    return {
        "models": [{"file": name}, {"file": "paper.glb"}],
        "materials": [{"match": "m*", "set": {"scatterDistance": list(distance), "roughness": .4, "ior": 1.4}}],
        "lights": [{"name": "key", "type": "rectLight", "width": 2.2, "height": 2.2, "intensity": 7, "position": [-3, 3.2, 3.2], "target": [0, 0, 0]},
                   {"name": "rim", "type": "rectLight", "width": 1.6, "height": 2.2, "intensity": 13, "position": [2.6, 2.2, -3], "target": [0, 0, 0]},
                   {"name": "sky", "type": "domeLight", "intensity": .28, "color": [.85, .93, 1]}],
        "camera": {"lookAt": {"eye": [0, target[1] + .12 * far, far], "target": target}, "focalLength": 58, "horizontalAperture": 24, "verticalAperture": 24},
        "settings": {"resolution": list(size), "samples": samples, "studio": "off"}}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda name: str(pathlib.Path(name).resolve()))
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("build/many_materials"))
    parser.add_argument("--only", default="")
    parser.add_argument("--size", default="200x200")
    parser.add_argument("--spp", type=int, default=64)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    size, wrong, pictures = [int(v) for v in options.size.split("x")], 0, []
    for name, function in MODELS:
        if options.only not in name:
            continue
        surface, colors, distance = function()
        rgb, text, low = {}, "", float(surface.points[:, 1].min())
        write_paper(low, options.out / "paper.glb")
        for kind in ("parts", "one"):
            write(surface, colors, kind == "parts", options.out / f"{name}_{kind}.glb")
            scene = scene_of(f"{name}_{kind}.glb", distance, size, options.spp, surface)
            (options.out / "scene.json").write_text(json.dumps(scene))
            done = subprocess.run([options.program, "render", "scene.json", "-o", f"{name}_{kind}.png", "-o", "picture.exr"], cwd=options.out,
                                  capture_output=True, text=True)
            if done.returncode != 0:
                sys.exit(f"{name}: {done.stderr}")
            text += done.stdout + done.stderr
            layers = read_layers(options.out / "picture.exr")
            rgb[kind] = np.stack([np.reshape(layers[c], size[::-1]) for c in "RGB"], axis=-1)
            pictures.append(f"{name}_{kind}.png")
        mean = [rgb[k].mean(axis=(0, 1)) for k in ("parts", "one")]
        ratio = mean[0] / mean[1]
        rms = math.sqrt(((rgb["parts"] - rgb["one"]) ** 2).mean()) / mean[1].mean()
        noise = re.search(r"noise: (\S+) %", text)
        bad = bool(np.abs(ratio - 1).max() > .01) or "not closed" in text
        wrong += bad
        print(f"{'WRONG' if bad else 'right'}  {name}: {len(colors)} materials, {len(surface.faces)} triangles; means parts / one "
              f"{ratio[0]:.4f} {ratio[1]:.4f} {ratio[2]:.4f}, RMS difference {rms:.4f}, noise of each {noise.group(1) if noise else '?'} %"
              + ("; a message that the mesh is open" if "not closed" in text else ""), flush=True)
    if shutil.which("oiiotool") and not options.only:
        rows = -(-len(pictures) // 4)
        subprocess.run(["oiiotool", *pictures, "--mosaic:pad=4", f"4x{rows}", "--ch", "R,G,B", "--attrib:type=string", "Compression", "jpeg:88", "-o", "sheet.jpg"],
                       cwd=options.out, check=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
