#!/usr/bin/env python3
"""Each render setting, and what must differ when it is changed alone: pixels, samples, statistics. Needs the Python module.

  settings_table.py [SETTING ...]

A setting that has no row fails, and so does a choice of a setting that gives the picture of another choice. Rows also say whether a
checkpoint can be resumed after the setting has changed. Needs a denoiser, which testenv/support/fake_oidn stands in for: $ALABASTER_OIDN.
"""
import os
import pathlib
import struct
import sys
import tempfile
import zlib
from typing import Callable, NamedTuple

import hdalabaster
from small_scene import HEIGHT, WIDTH, at, draw, set_ball, small_scene

BASIC = {"samples": 4}


class Result(NamedTuple):
    pixels: dict  # {AOV: bytes}
    stats: dict

    @property
    def sample_counts(self):
        return set(struct.unpack(f"{WIDTH * HEIGHT}i", self.pixels["sampleCount"]))


class Row(NamedTuple):
    """`differs(before, after)`: Results without and with `change`. `given` holds for both, and `scene` changes their scene."""
    change: dict
    differs: Callable
    given: dict = {}
    scene: Callable = lambda scene: None
    refused: str = "setting"  # how a checkpoint made before the change is refused; empty: it is resumed


def color(before, after):
    return before.pixels["color"] != after.pixels["color"]


def same_color(before, after):
    return not color(before, after)


def thick_body(scene):
    scene.set_material("/wax", baseColor=(1, 1, 1), scatterDistance=(0.02, 0.02, 0.02))  # only long walks take such steps
    set_ball(scene, "/wax_ball", at(0, 1.5, 1, 1.5), material="/wax", refine_level=3)


def large_image(scene):
    """2048 x 1024 texels, more than half of 1 MiB."""
    file = pathlib.Path(FOLDER) / "large.png"
    if not file.exists():
        def chunk(tag, data):
            return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))
        rows = zlib.compress((b"\0" + bytes(range(256)) * 24) * 1024)
        header = struct.pack(">IIBBBBB", 2048, 1024, 8, 2, 0, 0, 0)
        file.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", rows) + chunk(b"IEND", b""))
    scene.set_material("/floor", nodes={"surface": {"baseColor": ("image", "rgb")}, "image": {"type": "AlabasterTexture", "file": str(file)}})


def memory(before, after):
    return same_color(before, after) and after.stats["memoryInUse"] < before.stats["memoryInUse"] - 1_000_000


TABLE = {
    "samples": [Row({"samples": 5}, lambda a, b: color(a, b) and (a.sample_counts, b.sample_counts) == ({4}, {5}), refused="")],
    "firstSample": [Row({"firstSample": 1}, lambda a, b: color(a, b) and (a.sample_counts, b.sample_counts) == ({4}, {3}), refused="it has samples 0:4")],
    "targetError": [Row({"targetError": 0.5}, lambda a, b: b.stats["endedBy"] == "targetError" and min(b.sample_counts) < 64 == min(a.sample_counts),
                        {"samples": 64})],
    "adaptive": [Row({"adaptive": True}, lambda a, b: len(a.sample_counts) == 1 < len(b.sample_counts), {"samples": 48})],
    "timeLimit": [Row({"timeLimit": 0.02}, lambda a, b: b.stats["endedBy"] == "timeLimit" and min(b.sample_counts) < 400, {"samples": 400},
                      refused="")],
    "seed": [Row({"seed": 1}, color)],
    "frame": [Row({"frame": 1}, color)],
    "maxDepth": [Row({"maxDepth": 1}, color), Row({"maxDepth": 0}, color, {"maxDepth": 1})],
    # promise: farm.resume.settings
    "threads": [Row({"threads": 2}, same_color, {"threads": 1}, refused="")],  # and test_threads
    "subsurface": [Row({"subsurface": "reference"}, color, {"walkGuiding": False, "walkSphereSteps": False})],  # twins are a shortcut
    "inversion": [Row({"inversion": "chiang2016"}, color)],
    "walkGuiding": [Row({"walkGuiding": False}, color), Row({"walkGuiding": False}, same_color, {"subsurface": "reference"})],
    "walkSphereSteps": [Row({"walkSphereSteps": False}, color, scene=thick_body),
                        Row({"walkSphereSteps": False}, same_color, {"subsurface": "reference"}, thick_body)],
    "energy": [Row({"energy": "conserving"}, color)],
    # promise: farm.resume.settings
    "textureMemory": [Row({"textureMemory": 1}, memory, scene=large_image, refused="")],
    "memoryLimit": [Row({"memoryLimit": 64}, lambda a, b: same_color(a, b) and b.stats["memoryLimit"] == 64 << 20 != a.stats["memoryLimit"],
                        refused="")],
    "textureFilter": [Row({"textureFilter": 1.0}, color)],
    "glossyFilter": [Row({"glossyFilter": 0.5}, color), Row({"glossyFilter": 0.5}, same_color, {"subsurface": "reference"})],
    "refineEdgeLength": [Row({"refineEdgeLength": 0.5}, color, refused="mesh")],
    "filter": [Row({"filter": "box"}, color)],
    # Of AOVs alone: testenv/unit/core/integrator/ambient_occlusion_test.cpp, testenv/unit/delegate/rendering/hit_vectors_test.cpp.
    "ambientOcclusionDistance": [Row({"ambientOcclusionDistance": 0.5}, same_color)],
    "motionShutter": [Row({"motionShutter": "camera"}, same_color, refused="")],
    "cryptoRanks": [Row({"cryptoRanks": 2}, same_color, refused="")],  # of files alone: testenv/unit/delegate/host/cryptomatte_test.cpp
    # promise: farm.resume.denoise
    "denoise": [Row({"denoise": True}, lambda a, b: color(a, b) and "denoiser" in b.stats and "denoiser" not in a.stats, refused="the AOVs")],
}


def renderer_of(row, settings):
    scene = small_scene(FOLDER)
    row.scene(scene)
    scene.set_render_settings("/settings", camera="/camera", width=WIDTH, height=HEIGHT)
    return hdalabaster.Renderer(scene, report=lambda *_: None, **settings)


def render(row, settings):
    renderer = renderer_of(row, settings)
    pixels = draw(renderer, ("color", "sampleCount"), settings="/settings")
    return Result(pixels, renderer.stats())


def fault_of_resuming(row):
    """Why a render with the change cannot continue one without it; empty if it does."""
    file, frame = str(pathlib.Path(FOLDER) / "row.checkpoint"), {"width": WIDTH, "height": HEIGHT, "settings": "/settings"}
    renderer = renderer_of(row, {**BASIC, **row.given})
    kept = renderer.render(**frame)  # noqa: F841, a checkpoint is of the frame that is there
    if fault := renderer.command("writeCheckpoint", file=file):
        raise RuntimeError(fault)
    renderer = renderer_of(row, {**BASIC, **row.given, **row.change})
    if fault := renderer.command("resumeCheckpoint", file=file):
        return fault
    try:
        renderer.render(**frame)
    except hdalabaster.RenderError as error:
        return str(error)
    return ""


def faults_of(name, rows):
    for row in rows:
        settings = {**BASIC, **row.given}
        if not row.differs(render(row, settings), render(row, {**settings, **row.change})):
            yield f"{name}: {row.change} has not the effect of its row ({row.differs.__name__}), given {row.given}"
    why = fault_of_resuming(rows[0])
    expected = f"setting {name} " if rows[0].refused == "setting" else rows[0].refused
    if bool(expected) != bool(why) or expected not in why:
        yield f"{name}: a checkpoint is refused after {rows[0].change} for '{why}'; expected '{expected}'"


def faults_of_choices(name, choices):
    seen = {}
    for choice in choices:
        seen.setdefault(render(TABLE[name][0]._replace(scene=lambda scene: None), {**BASIC, name: choice}).pixels["color"], []).append(choice)
    for alike in seen.values():
        if len(alike) > 1 and name != "motionShutter":  # of an AOV alone
            yield f"{name}: {alike} give the same picture"


def faults_of_threads():
    """Must run before anything else has started workers."""
    counts = []
    for threads in (1, 2):
        renderer = renderer_of(TABLE["threads"][0], {**BASIC, "samples": 64, "threads": threads})
        draw(renderer)
        counts.append(len(os.listdir("/proc/self/task")))
    if (os.cpu_count() or 1) > 1 and not counts[0] < counts[1]:
        yield f"threads: the process has {counts[0]} threads after a render with one, and {counts[1]} after one with two"


def main():
    chosen, found = sys.argv[1:], list(faults_of_threads())
    known = hdalabaster.Renderer().describe_settings()
    found += [f"{name}: there is no row for this setting" for name in sorted(known.keys() - TABLE.keys())]
    found += [f"{name}: there is no such setting" for name in sorted(TABLE.keys() - known.keys())]
    for name in sorted(known.keys() & TABLE.keys()):
        if not chosen or name in chosen:
            found += faults_of(name, TABLE[name])
            found += faults_of_choices(name, known[name]["choices"])
    print("\n".join(found) if found else f"{len(known)} settings have the effects of their rows")
    return 1 if found else 0


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as FOLDER:
        sys.exit(main())
