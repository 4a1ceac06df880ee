#!/usr/bin/env python3
"""The order of the layers of a scene (delegate/manual/pipeline.md, "The order of layers"), a row each, through the command line.

  layers_table.py PROGRAM [--only REGEX]

Layers meet in a render. Its files must be those of another render, in which the layer that counts stands alone, and not those of a
third, in which the other one does.
"""
import argparse
import json
import pathlib
import re
import sys
import tempfile
from typing import NamedTuple

from flag_runs import Runs
from flag_scenes import COLORS, write_flag_scenes

PRESET = next(p for p in json.loads((pathlib.Path(__file__).resolve().parents[2] / "schemas/quality_presets.json").read_text())["presets"]
              if p["name"] == "preview")["settings"]
SHORT = ("--spp", "2", "--target-error", "0", "--time-limit", "0")  # of a preset's render
DEEP, FLAT = {"maxDepth": 8}, {"maxDepth": 0}


class Case(NamedTuple):
    """A render of a description, or of a file of an earlier step."""
    scene: object
    flags: tuple = ()
    outputs: tuple = ("-o", "a.exr")
    first: tuple = ()  # calls before it


class Row(NamedTuple):
    met: Case
    like: Case
    unlike: Case


def scene(settings=(), model=(), **parts):
    return {"models": [{"file": "model.glb", **dict(model)}], "settings": {"resolution": [24, 16], "samples": 2, **dict(settings)}, **parts}


def case(settings=(), *flags, model=(), **parts):
    return Case(scene(settings, model, **parts), flags)


def shown(look, *flags):
    return Case(scene(ocio="colors.ocio", products=[{"file": "a.png", **look}]), flags, ())


def converted(*flags, over=(), of=("--set", "maxDepth=0", "--set", "samples=2", "--set", "resolution=[24, 16]")):
    """An archive with settings, or a description of it."""
    made = ("convert", "model.glb", "-o", "made.alab", *of)
    return Case({"models": [{"file": "made.alab"}], "settings": dict(over)} if over else "made.alab", flags, first=(made,))


BRIGHT = {"exposure": 2}
LOOK = {"lookAt": {"eye": [1, 1, 3], "target": [0, 0.5, 0]}}
MOVES = {"shutterOpen": -6, "shutterClose": 6}
RED, GREEN = ({"match": "chalk", "set": {"baseColor": color}} for color in ([1, 0, 0], [0, 1, 0]))
SKY = {"name": "dome", "type": "domeLight", "color": [0, 0, 1]}
KEY = {"name": "key", "type": "sphereLight", "transform": {"translate": [1, 3, 2]}}
ROWS = {
    # promise: pipeline.order.own
    "own": Row(case(), case((), "--camera", "front"), case((), "--camera", "near")),
    # promise: pipeline.order.archive
    "archive": Row(converted(over=DEEP), case(DEEP), converted()),
    # promise: pipeline.order.file_preset
    "file_preset": Row(case({"quality": "preview", **FLAT}, *SHORT), case({**PRESET, **FLAT}, *SHORT), case({"quality": "preview"}, *SHORT)),
    # promise: pipeline.order.file_entries
    "file_entries": Row(case(materials=[RED, GREEN]), case(materials=[GREEN]), case(materials=[RED])),
    # promise: pipeline.order.choice
    "choice": Row(case((), "--variant", "warm", model={"variant": "cold"}), case(model={"variant": "warm"}), case(model={"variant": "cold"})),
    # promise: pipeline.order.time
    "time": Row(case((), "--time", "0.5", model={"time": 0.25}), case((), "--time", "0.75"), case((), "--time", "0.5")),
    # promise: pipeline.order.camera
    "camera": Row(case((), "--camera", "near", camera={"use": "front", **BRIGHT}), case((), "--camera", "near"),
                  case(camera={"use": "near", **BRIGHT})),
    # promise: pipeline.order.own_camera
    "own_camera": Row(case((), "--camera", "camera", camera={**LOOK, **BRIGHT}), case(camera={**LOOK, **BRIGHT}), case(camera=LOOK)),
    # promise: pipeline.order.shutter
    "shutter": Row(case((), "--time", "0.5", "--shutter", "0:0", camera=MOVES), case((), "--time", "0.5"), case((), "--time", "0.5", camera=MOVES)),
    # promise: pipeline.order.quality
    "quality": Row(case(FLAT, "--quality", "preview", *SHORT), case(PRESET, *SHORT), case(FLAT, *SHORT)),
    # promise: pipeline.order.flags
    "flags": Row(case(DEEP, "--max-depth", "0", "--quality", "preview", *SHORT), case({**PRESET, **FLAT}, *SHORT), case(PRESET, *SHORT)),
    # promise: pipeline.order.set
    "set": Row(case((), "--camera", "near", "--set", "camera.exposure=2", "--set", "maxDepth=0", "--max-depth", "8"),
               case(FLAT, camera={"use": "near", **BRIGHT}), case(DEEP, camera={"use": "near", **BRIGHT})),
    # promise: pipeline.order.set_order
    "set_order": Row(case((), "--set", "maxDepth=8", "--set", "maxDepth=0"), case(FLAT), case(DEEP)),
    # promise: pipeline.order.set_quality
    "set_quality": Row(case((), "--max-depth", "0", "--set", "quality=preview", "--set", "samples=2", "--set", "targetError=0", "--set", "timeLimit=0"),
                       case(PRESET, *SHORT), case({**PRESET, **FLAT}, *SHORT)),
    # promise: pipeline.order.samples
    "samples": Row(case((), "--samples", "0:3", "--checkpoint", "c.checkpoint", "--set", "samples=2"), case({"samples": 3}), case()),
    # promise: pipeline.order.size
    "size": Row(Case(scene(products=[{"file": "a.exr", "resolution": [12, 8]}]), ("--size", "30x20", "--set", "resolution=[6, 4]"), ()),
                case({"resolution": [30, 20]}), case({"resolution": [12, 8]})),
    # promise: pipeline.order.crop
    "crop": Row(Case(scene({"crop": [0, 0, 4, 4]}, products=[{"file": "a.exr", "crop": [0, 0, 8, 8]}]), ("--crop", "2,2,9,9"), ()),
                case({"crop": [2, 2, 9, 9]}), case({"crop": [0, 0, 8, 8]})),
    # promise: pipeline.order.dome
    "dome": Row(case((), "--dome", "0,1,0", "--set", "lights/key.intensity=4", lights=[SKY, KEY]),
                case(lights=[{**KEY, "intensity": 4}, {**SKY, "color": [0, 1, 0]}]), case(lights=[SKY, {**KEY, "intensity": 4}])),
    # promise: pipeline.order.outputs
    "outputs": Row(case(products=[{"file": "b.exr"}]), case(), Case(scene(products=[{"file": "b.exr"}]), (), ())),
    # promise: pipeline.order.look
    "look": Row(shown({"view": "dim"}, "--view", "plain"), shown({"view": "plain"}), shown({"view": "dim"})),
    # promise: pipeline.order.ocio
    "ocio": Row(shown({}, "--ocio", "dark.ocio"), shown({"view": "dim"}), shown({})),
    # promise: pipeline.order.file_ocio
    "file_ocio": Row(shown({}), shown({}, "--ocio", "colors.ocio"), Case(scene(products=[{"file": "a.png"}]), (), ())),
    # promise: pipeline.order.converted
    "converted": Row(converted("--max-depth", "8"), case(DEEP), converted()),
}


def pictures(run, number, one):
    """{name: what it shows}"""
    name = one.scene
    if not isinstance(name, str):
        name = f"{number}.json"
        (run.scenes / name).write_text(json.dumps(one.scene))
    done = run(*one.first, ("render", name, *one.outputs, *one.flags, "--threads", "1", "--quiet"))
    if done.code:
        raise RuntimeError(f"exit code {done.code}: {done.err.strip()[-300:]}")
    found = {file: done.color(file) for file in done.names() if file.endswith(".exr")}
    return {**found, **{file: done.pixels(file) for file in done.names() if file.endswith(".png") and file != "broken.png"}}


def fault_of(run, number, row):
    try:
        met, like, unlike = (pictures(run, 3 * number + i, one) for i, one in enumerate(row))
    except RuntimeError as error:
        return str(error)
    if met != like:
        return f"it shows {sorted(met)}, not what the layer that counts does"
    return "both layers alone show the same" if like == unlike else ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--only", default="", metavar="REGEX", help="of a row's name")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        scenes = pathlib.Path(name) / "scenes"
        scenes.mkdir()
        write_flag_scenes(scenes)
        (scenes / "dark.ocio").write_text(COLORS.replace("!<View> {name: plain, colorspace: linear}", "!<View> {name: plain, colorspace: half}"))
        run = Runs(str(arguments.program.resolve()), scenes, pathlib.Path(name), {"OCIO": str(scenes / "dark.ocio")})
        found = {name: fault_of(run, i, row) for i, (name, row) in enumerate(ROWS.items()) if re.search(arguments.only, name)}
    faults = [f"{name}: {fault}" for name, fault in found.items() if fault]
    print("\n".join(faults) if faults else f"{len(found)} rows hold")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
