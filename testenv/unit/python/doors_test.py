"""Tests that a scene is the same scene through fields of Python, a description, overrides and an archive. Values are drawn at random."""
import json
import pathlib
import random
import re
import struct
import tempfile
import unittest

import hdalabaster
from square_scene import BACK, CORNERS, draw, moved

SOURCES = pathlib.Path(__file__).resolve().parents[3]
# The list of a description, the prim that it edits there, what is before the names of its fields, and the schema.
PARTS = [("materials", "/wax", "surface.", "disney_material"), ("meshes", "/square", "", "mesh"), ("lights", "/key", "", "lights"),
         ("camera", "/camera", "", "camera")]


def drawn(name, row, numbers):
    """A value near the default of a row; None: it takes no number, word or flag."""
    if name == "shutterOpen":  # before it closes
        return -numbers.random()
    kind = row["anyOf"][0] if "anyOf" in row else row

    def number(kind, fallback):
        value = fallback * numbers.uniform(.5, 1.5) if fallback > 0 else numbers.random()
        return min(max(value, kind.get("minimum", value)), kind.get("maximum", value))
    if "enum" in kind:
        return numbers.choice(kind["enum"])
    if kind["type"] == "boolean":
        return numbers.random() < .5
    if kind["type"] == "array" and kind.get("maxItems") == 3:
        return [number(kind["items"], value) for value in row["default"]]
    return number(kind, row["default"]) if kind["type"] == "number" else None


def metres(millimetres):
    """As the reader of descriptions computes them, in single precision."""
    def single(value):
        return struct.unpack("f", struct.pack("f", value))[0]
    return single(single(millimetres) * single(.001))


def plain():
    scene = hdalabaster.Scene()
    scene.set_mesh("/square", CORNERS, [[0, 1, 2, 3]], material="/wax")
    scene.set_material("/wax")
    scene.set_light("/key", "rectLight", moved(0, 0, 3))
    scene.set_camera("/camera", BACK, focalLength=.05, horizontalAperture=.036, verticalAperture=.036)
    return scene


class Doors(unittest.TestCase):
    def state(self, scene, renderer=None):
        renderer = renderer or hdalabaster.Renderer(scene, samples=2)
        pixels = bytes(draw(renderer)["color"])
        return re.sub(r" prim \d+", "", renderer.command("dumpScene")), pixels

    def load(self, folder, file, **options):
        scene = hdalabaster.Scene()
        scene.load(pathlib.Path(folder) / file, **options)
        return self.state(scene)

    def test_a_scene_is_the_same_through_all(self):
        for seed in range(3):
            numbers = random.Random(seed)
            scene, description, overrides = plain(), {"models": [{"file": "plain.alab"}]}, []
            with tempfile.TemporaryDirectory() as folder, self.subTest(seed=seed):
                scene.write(pathlib.Path(folder) / "plain.alab", camera="/camera")
                for part, path, prefix, schema in PARTS:
                    entry = {}
                    for name, row in json.loads((SOURCES / "schemas" / f"{schema}.json").read_text())["properties"].items():
                        value = drawn(name, row, numbers) if "rectLight" in row.get("appliesTo", ["rectLight"]) else None
                        if value is None or numbers.random() < .3:
                            continue
                        entry[name] = value
                        place = f"camera.{name}" if part == "camera" else f"{part}/{path}.{name}"
                        overrides.append(f"{place}={value if isinstance(value, str) else json.dumps(value)}")
                        scene.edit(path, {prefix + name: metres(value) if "unitInDescription" in row else value})
                    entry = {"set": entry} if part == "materials" else entry
                    description[part] = dict(entry, use=path) if part == "camera" else [dict(entry, match=path)]
                (pathlib.Path(folder) / "scene.json").write_text(json.dumps(description))
                scene.write(pathlib.Path(folder) / "edited.alab", camera="/camera")
                expected = self.state(scene)
                self.assertEqual(self.load(folder, "scene.json"), expected)
                self.assertEqual(self.load(folder, "plain.alab", camera="/camera", overrides=overrides), expected)
                self.assertEqual(self.load(folder, "edited.alab"), expected)

    def test_any_sequence_of_edits_leaves_the_scene_that_is_made_at_once(self):
        for seed in range(3):
            numbers = random.Random(seed)
            scene, asked = plain(), {}
            renderer = hdalabaster.Renderer(scene, samples=2)
            for step in range(40):
                _, path, prefix, schema = numbers.choice(PARTS)
                rows = json.loads((SOURCES / "schemas" / f"{schema}.json").read_text())["properties"]
                name = numbers.choice(list(rows))
                value = None if numbers.random() < .2 else drawn(name, rows[name], numbers)
                scene.edit(path, {prefix + name: value})
                asked[path, prefix + name] = value
                if step % 7 == 0:
                    draw(renderer)
            fresh, order = plain(), list(asked)
            numbers.shuffle(order)
            for path, name in order:
                fresh.edit(path, {name: asked[path, name]})
            with self.subTest(seed=seed):
                self.assertEqual(self.state(scene, renderer), self.state(fresh))
