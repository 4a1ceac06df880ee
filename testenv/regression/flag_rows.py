"""The rows of flags_table.py: a command's arguments without a flag and with it, and what must differ."""
import json
import struct
from typing import Callable, NamedTuple

RENDER = ("render", "model.glb", "-o", "a.exr", "--size", "24x16", "--spp", "2", "--stats", "s.json", "--threads", "1")
SHOWN = (*RENDER, "-o", "a.png", "--ocio", "colors.ocio")
LATER = (*RENDER, "--time", "0.5")
PARTS = tuple(("render", "model.glb", "--size", "24x16", "--threads", "1", "--aov", "depth", "-o", "part.exr", "--samples", f"{a}:{b}",
               "--checkpoint", f"{a}.checkpoint") for a, b in ((0, 2), (2, 3)))
MERGE = ("merge", "0.checkpoint", "2.checkpoint")
MERGED = (*MERGE, "-o", "a.exr", "-o", "a.png", "--ocio", "colors.ocio")
FARM = ("farm", "model.glb", "-o", "a.exr", "--spp", "8")
FARM_OF_TWO = (*FARM, "--tasks", "2")
REPEATED = {"-o", "--set", "--aov"}


class Row(NamedTuple):
    """`holds(before, after)`: Outcomes of `plain`, and of `plain` with `words`, whose flags replace those of `plain`. `first`: calls that come
    before, in the same folder."""
    words: tuple
    holds: Callable
    plain: tuple = RENDER
    first: tuple = ()
    instead: tuple = ()  # of `plain` with `words`

    def changed(self):
        if self.instead:
            return self.instead
        given, words, kept = {w for w in self.words if w.startswith("--")} - REPEATED, list(self.plain), []
        while words:
            if words[0] in given:
                del words[:2]
            else:
                kept.append(words.pop(0))
        return (*kept, *self.words)


def picture(a, b):
    return a.color() != b.color()


def same_picture(a, b):
    return a.color() == b.color()


def only_display(a, b):
    """EXR files stay scene-linear."""
    return same_picture(a, b) and a.pixels() != b.pixels()


def has_tiles(a, b):
    """Of 16 x 16 pixels, at one level; program_test.cpp compares the pixels."""
    return "tiles" not in a.attributes() and b.attributes()["tiles"] == struct.pack("<IIB", 16, 16, 0)


def setting(name, value):
    """The statistics hold the setting, with another value than before."""
    return lambda a, b: a.stats["settings"][name] != value == b.stats["settings"][name]


def both(*rules):
    return lambda a, b: all(rule(a, b) for rule in rules)


def codes(before, after):
    return lambda a, b: (a.code, b.code) == (before, after)


def samples(count):
    return lambda a, b: a.stats["samples"]["perPixel"] != count == b.stats["samples"]["perPixel"]


def channels(*names):
    return lambda a, b: set(names) <= b.layers().keys() - a.layers().keys()


def window(*box):
    return lambda a, b: a.attributes()["dataWindow"] != b.attributes()["dataWindow"] == b"".join(i.to_bytes(4, "little", signed=True) for i in box)


def writes(*names):
    return lambda a, b: b.code == 0 and set(names) <= b.names() - a.names()


def consistent(_, after):
    """Each number of the statistics is the renderer's of the same meaning, and the noise lies within its interval."""
    stats = after.stats
    renderer, error = stats["delegate"][0], stats["error"]
    same = {"rays": ("camera", "bounce", "shadow", "walk", "probe"), "walks": ("count", "events", "exits", "lost")}
    names = {("walks", name): f"walk.{name}" for name in same["walks"]} | {("rays", name): f"rays.{name}" for name in same["rays"]}
    known = [stats[group][name] == renderer[key] for (group, name), key in names.items()]
    known += [renderer[key] > 0 for key in names.values() if key != "rays.probe"]  # else a mix-up would not be seen
    known += [abs(stats["walks"]["lostShare"] - renderer["walk.lostEnergy"] / renderer["walk.count"]) < 1e-12, stats["walks"]["segments"] == renderer["rays.walk"], len(set(stats["rays"].values())) == 5,
              stats["samples"] == {"perPixel": renderer["numCompletedSamples"], "total": renderer["rays.camera"]},
              renderer["rays.camera"] == 24 * 16 * 8, 0 < error["low95"] < error["relativeRmse"] < error["high95"],
              (error["low95"], error["high95"]) == (renderer["error.low"], renderer["error.high"])]
    return all(known) and noise_of_file(_, after)


def noise_of_file(_, after):
    """An EXR file holds the noise, within its interval, as the statistics have it."""
    held, error = after.doubles(), after.stats["error"]
    return [held["error/" + key] for key in ("low", "relativeRmse", "high")] == [error[key] for key in ("low95", "relativeRmse", "high95")]


def frame_row(number, *words):
    """Frame `number` is the picture of half a second, with the noise of that frame."""
    plain = (*RENDER, "--time", "0.5", "--set", f"frame={number}")
    return Row(words, lambda a, b: b.color(f"f.{number}.exr") == a.color() != b.color("f.03.exr"), plain,
               instead=("render", "model.glb", "-o", "f.##.exr", *RENDER[4:], "--frames", f"3:{number}:{number - 3}", *words))


def like_the_whole(a, b):
    return b.code == 0 and same_picture(a, b)


def rate(outcome):
    """Frames per second as a ratio, and the time code of frame 100 without its other half: hours, minutes, seconds and frames, two digits each."""
    held = outcome.attributes("f.100.exr")
    return (*struct.unpack("<iI", held["framesPerSecond"]), struct.unpack("<II", held["timeCode"])[0])


SEQUENCE = ("render", "model.glb", "-o", "f.#.exr", *RENDER[4:], "--frames", "1:2")
CHECKPOINT = (*RENDER, "--checkpoint", "c.checkpoint")
MORE = (*RENDER[:6], "--spp", "3", *RENDER[8:])
RENDER_ROWS = {
    "--camera": [Row(("--camera", "near"), picture)],
    "--time": [Row(("--time", "0.5"), picture)],
    "--scene": [Row(("--scene", "bare"), picture), Row(("--scene", "1"), picture)],
    "--animation": [Row(("--animation", "up"), picture, LATER)],
    "--variant": [Row(("--variant", "cold"), picture)],
    "--dome": [Row(("--dome", "0.2,0.4,1"), picture)],
    "--ocio": [Row(("--ocio", "colors.ocio"), only_display, (*RENDER, "-o", "a.png"))],
    "--set": [Row(("--set", "samples=3"), samples(3), ("render", *RENDER[1:6], *RENDER[8:]))],
    "--allow-outside": [Row(("--allow-outside",), codes(3, 0), ("render", "inner/outside.json", *RENDER[2:]))],
    "--output": [Row(("-o", "a.png", "-o", "a.jpg", "-o", "a.tif"), writes("a.png", "a.jpg", "a.tif"))],
    # promise: pipeline.animation
    "--frames": [frame_row(12)],  # of 24 in a second, unless --fps is given
    "--start-frame": [Row(("--start-frame", "4"), lambda a, b: b.color("f.12.exr") != a.color("f.12.exr"), ("render", "model.glb", "-o", "f.##.exr", *RENDER[4:], "--frames", "12"))],
    "--skip-existing": [Row(("--skip-existing",), lambda a, b: a.stats["frames"] == [1, 2] and b.stats["frames"] == [], SEQUENCE, first=(SEQUENCE,))],
    "--turntable": [Row(("--turntable", "4"), writes("f.4.exr"), SEQUENCE, instead=(*SEQUENCE[:-2], "--turntable", "4"))],
    "--turntable-lights": [Row(("--turntable-lights",), lambda a, b: b.color("f.2.exr") != a.color("f.2.exr"), (*SEQUENCE[:-2], "--turntable", "4"))],
    # promise: pipeline.name.sequence
    "--fps": [Row(("--fps", "25"), lambda a, b: (rate(a), rate(b)) == ((24, 1, 0x0404), (25, 1, 0x0400)), ("render", "model.glb", "-o", "f.###.exr", *RENDER[4:], "--frames", "100")),
              frame_row(10, "--fps", "20"), Row(("--fps", "12"), picture, (*LATER, "--shutter", "-3:3"))],
    # promise: pipeline.animation
    "--shutter": [Row(("--shutter", "-6:6"), picture, LATER)],
    "--size": [Row(("--size", "20x10"), window(0, 0, 19, 9))],
    "--crop": [Row(("--crop", "4,3,20,12"), window(4, 3, 19, 11))],
    "--quality": [Row(("--quality", "draft"), both(setting("maxDepth", 16), setting("targetError", 0.055)))],
    # promise: trade_off.ends.samples
    "--spp": [Row(("--spp", "3"), samples(3))],
    # promise: pipeline.stats.target, trade_off.ends.error
    "--target-error": [Row(("--target-error", "0.9", "--spp", "256"), lambda a, b: b.stats["target"]["endedBy"] == "targetError" and
                           b.stats["samples"]["total"] < 24 * 16 * 256)],
    "--time-limit": [Row(("--time-limit", "0.05"), lambda a, b: b.stats["delegate"][0]["endedBy"] == "timeLimit", ("render", *RENDER[1:6], *RENDER[8:]))],
    # promise: pipeline.stats.settings
    "--seed": [Row(("--seed", "5"), both(picture, setting("seed", 5)))],
    "--threads": [Row(("--threads", "2"), both(same_picture, setting("threads", 2)))],
    "--max-depth": [Row(("--max-depth", "0"), both(picture, setting("maxDepth", 0)))],
    "--subsurface": [Row(("--subsurface", "lambert"), both(picture, setting("subsurface", "lambert")))],
    "--studio": [Row(("--studio", "off"), picture), Row(("--studio", "on"), picture)],
    "--inversion": [Row(("--inversion", "chiang2016"), both(picture, setting("inversion", "chiang2016")))],
    "--memory-limit": [Row(("--memory-limit", "1"), codes(0, 4), ("render", "heavy.json", *RENDER[2:]))],
    "--texture-memory": [Row(("--texture-memory", "7"), both(same_picture, setting("textureMemory", 7)))],
    "--display": [Row(("--display", "second"), only_display, SHOWN)],
    "--view": [Row(("--view", "dim"), only_display, SHOWN)],
    "--look": [Row(("--look", "warm"), only_display, SHOWN)],
    "--compression": [Row(("--compression", "piz"), lambda a, b: b.attributes()["compression"] != a.attributes()["compression"]),
                      Row(("--compression", "dwaa", "--aov", "depth"), codes(0, 2))],
    "--tiles": [Row(("--tiles", "16"), has_tiles), Row(("--tiles", "0"), same_picture), Row(("--tiles", "8"), codes(0, 2))],
    "--exposure": [Row(("--exposure", "-1"), only_display, SHOWN)],
    # promise: pipeline.name.layers
    "--aov": [Row(("--aov", "normal", "--aov", "error"), channels("N.X", "N.Y", "N.Z", "error.X")),
              Row(("--aov", "normal=nrm"), channels("nrm.X", "nrm.Y", "nrm.Z")), Row(("--aov", "normal="), codes(0, 2))],
    "--denoise": [Row(("--denoise",), both(channels("denoised.R"), lambda a, b: a.pixels() != b.pixels()), (*RENDER, "-o", "a.png"))],
    "--pixel": [Row(("--pixel", "12,8"), lambda a, b: len(b.out) > len(a.out) and not b.file("a.exr").exists())],
    # promise: pipeline.stats.delegate, pipeline.stats.error, pipeline.stats.rays, pipeline.stats.samples
    # promise: pipeline.stats.walks
    "--stats": [Row(("--stats", "s.json", "--spp", "8"), consistent, ("render", "open.json", *RENDER[2:8], "--threads", "1")),
                Row(("--stats", "s.json", "--subsurface", "diffusion"), lambda a, b: b.stats["rays"]["probe"] == b.stats["delegate"][0]["rays.probe"] > 0,
                    RENDER[:8])],
    # promise: pipeline.exit.degraded
    "--keep-going": [Row(("--keep-going",), both(codes(3, 6), lambda a, b: b"missing.png" in b.attributes()["alabaster/sceneFaults"]),
                         ("render", "gap.json", *RENDER[2:]))],
    "--quiet": [Row(("--quiet",), lambda a, b: len(a.err + a.out) > 0 == len(b.err + b.out))],
    "--checkpoint": [Row(("--checkpoint", "c.checkpoint"), writes("c.checkpoint"))],
    "--checkpoint-interval": [Row(("--checkpoint-interval", "0.05"), lambda a, b: b.stats["delegate"][0]["checkpoint.count"] >
                                  a.stats["delegate"][0]["checkpoint.count"] == 1, (*CHECKPOINT, "--set", "samples=300"))],
    # promise: farm.resume.not_overwritten, farm.resume.samples
    "--resume": [Row(("--resume",), like_the_whole, MORE, (CHECKPOINT,), (*MORE, "--checkpoint", "c.checkpoint", "--resume")),
                 Row(("--resume",), codes(2, 0), (*MORE, "--checkpoint", "c.checkpoint"), (CHECKPOINT,))],
    "--live": [Row(("--live", "0.001"), same_picture), Row(("--live", "0"), codes(0, 2))],
    # promise: farm.running
    "--running": [Row(("--running", "r.running"), both(same_picture, lambda a, b: not b.file("r.running").exists())),
                  Row(("--running", "absent/r.running"), codes(0, 5))],
    "--inputs": [Row(("--inputs", "model_farm/inputs.txt"), same_picture, RENDER, (FARM_OF_TWO,)),
                 Row(("--inputs", "model_farm/inputs.txt"), codes(0, 3), SHOWN, (FARM_OF_TWO,))],
    "--samples": [Row(("--samples", "1:3", "--checkpoint", "c.checkpoint"), both(picture, lambda a, b: b.stats["samples"]["total"] == 24 * 16 * 2),
                      ("render", *RENDER[1:6], *RENDER[8:], "--set", "samples=3"))],
}
MERGE_ROWS = {
    "--inputs": [Row(("--inputs", "model_farm/inputs.txt"), same_picture, (*MERGE, "-o", "a.exr"), (*PARTS, FARM_OF_TWO)),
                 Row(("--inputs", "model_farm/inputs.txt"), codes(0, 3), MERGED, (*PARTS, FARM_OF_TWO))],
    "--output": [Row(("-o", "whole.exr"), writes("whole.exr"), MERGE, PARTS)],
    "--ocio": [Row(("--ocio", "colors.ocio"), only_display, (*MERGE, "-o", "a.exr", "-o", "a.png"), PARTS)],
    "--display": [Row(("--display", "second"), only_display, MERGED, PARTS)],
    "--view": [Row(("--view", "dim"), only_display, MERGED, PARTS)],
    "--look": [Row(("--look", "warm"), only_display, MERGED, PARTS)],
    "--compression": [Row(("--compression", "piz"), lambda a, b: b.attributes()["compression"] != a.attributes()["compression"], MERGED, PARTS),
                      Row(("--compression", "dwaa", "--aov", "depth"), codes(0, 2), MERGED, PARTS)],
    "--tiles": [Row(("--tiles", "16"), has_tiles, MERGED, PARTS)],
    "--exposure": [Row(("--exposure", "-1"), only_display, MERGED, PARTS)],
    "--aov": [Row(("--aov", "depth"), channels("depth.Z"), MERGED, PARTS)],
    "--quiet": [Row(("--quiet",), lambda a, b: len(a.err + a.out) > 0 == len(b.err + b.out), (*MERGE, "-o", "a.exr"), PARTS)],
}
CHECK_ROWS = {
    "--set": [Row(("--set", "memoryLimit=1"), codes(0, 4), ("check", "heavy.json"))],
    # promise: pipeline.check
    "--time-limit": [Row(("--time-limit", "0.001"), codes(0, 4), ("check", "heavy.json"))],
    "--memory-limit": [Row(("--memory-limit", "1"), codes(0, 4), ("check", "heavy.json"))],
    "--ocio": [Row(("--ocio", "absent.ocio"), codes(0, 3), ("check", "model.glb"))],
    "--allow-outside": [Row(("--allow-outside",), codes(3, 0), ("check", "inner/outside.json"))],
    "--quiet": [Row(("--quiet",), lambda a, b: "can be rendered" in a.err + a.out and not b.err + b.out, ("check", "model.glb"))],
}


def triangles(level):
    """A face corner becomes 4^(level - 1) quads: those of a ball's 24 quads, a box's 54 and a floor."""
    cage, refined = (24 + 54 + 1) * 2, (54 + 1) * 2 * 16 + 24 * 2 * 4 ** level
    return lambda a, b: f"({cage} triangles as modelled, {refined} as rendered)" in b.out and a.out != b.out


def predicted(_, after):
    return "predicted for 50 % relative RMSE" in after.out


def listed(outcome):
    return json.loads(outcome.out)["renders"][0]


def shows(name, value):
    return lambda a, b: listed(a)["settings"].get(name) != value == listed(b)["settings"][name]


def told(text):
    return lambda a, b: text in b.out and text not in a.out


LISTED = ("info", "model.glb", "--json")
PREDICTED = ("info", "model.glb", "--size", "24x16", "--predict", "0.05")
INFO_ROWS = {
    "--set": [Row(("--set", f"meshes/*ball*.refineLevel={level}"), triangles(level), ("info", "model.glb")) for level in (0, 1, 3)],
    "--camera": [Row(("--camera", "near"), lambda a, b: (a.code, b.code) == (0, 0), ("info", "model.glb")), Row(("--camera", "none"), codes(0, 2), ("info", "model.glb"))],
    "--dome": [Row(("--dome", "0.2,0.4,1"), lambda a, b: "dome" in b.out and a.out != b.out, ("info", "model.glb"))],
    "--predict": [Row(("--predict", "0.5"), predicted, ("info", "model.glb", "--size", "24x16"))],
    "--size": [Row(("--size", "30x20"), lambda a, b: "render /render: 30x20" in b.out and "30x20" not in a.out, ("info", "model.glb"))],
    "--crop": [Row(("--crop", "4,3,20,12"), lambda a, b: listed(b)["crop"] == [4, 3, 20, 12], LISTED)],
    **{flag: [Row((flag, given) if given else (flag,), shows(name, value), LISTED)] for flag, given, name, value in (
        ("--quality", "draft", "maxDepth", 16), ("--seed", "7", "seed", 7), ("--threads", "1", "threads", 1), ("--max-depth", "3", "maxDepth", 3),
        ("--target-error", "0.5", "samples", 65536), ("--subsurface", "lambert", "subsurface", "lambert"),
        ("--inversion", "chiang2016", "inversion", "chiang2016"), ("--memory-limit", "900", "memoryLimit", 900),
        ("--texture-memory", "90", "textureMemory", 90), ("--denoise", None, "denoise", True))},
    "--spp": [Row(("--spp", "3"), told("stops at 3 samples per pixel"), PREDICTED)],
    "--time-limit": [Row(("--time-limit", "1e-9"), told("its time limit of 1e-09 s comes first"), PREDICTED)],
    "--studio": [Row(("--studio", "on"), told("added a studio"), ("info", "model.glb"))],
    "--fps": [Row(("--fps", "0"), codes(0, 2), ("info", "model.glb"))],
    "--shutter": [Row(("--shutter", "-6:6"), lambda a, b: '"shutterClose": 6' in b.out and '"shutterClose": 6' not in a.out, LISTED)],
    "--output": [Row(("-o", "absent/a.png"), lambda a, b: listed(b)["files"] == ["absent/a.png"] and not b.names() - a.names(), LISTED)],
    "--aov": [Row(("--aov", "depth"), codes(0, 2), ("info", "model.glb", "-o", "a.png"))],
    **{flag: [Row((flag, "1"), codes(0, 2), ("info", "model.glb", "-o", "a.exr"))] for flag in ("--display", "--view", "--look", "--exposure")},
    "--compression": [Row(("--compression", "piz"), codes(0, 2), ("info", "model.glb", "-o", "a.png"))],
    "--tiles": [Row(("--tiles", "16"), codes(0, 2), ("info", "model.glb", "-o", "a.png"))],
    "--json": [Row(("--json",), lambda a, b: b.out.startswith('{\n  "scene": "model.glb",') and a.out != b.out, ("info", "model.glb"))],
    "--ocio": [Row(("--ocio", "absent.ocio"), codes(0, 3), ("info", "model.glb"))],
    "--allow-outside": [Row(("--allow-outside",), codes(3, 0), ("info", "inner/outside.json"))],
}
TABLES = {"render": RENDER_ROWS, "merge": MERGE_ROWS, "check": CHECK_ROWS, "info": INFO_ROWS}
# Exit codes that depend on the scene file alone, not on a flag: (command line, exit code).
# promise: pipeline.check
CODES = [(("check", "model.glb"), 0), (("check", "gap.json"), 3), (("check", "broken.json"), 3), (("check", "bad_view.json"), 3),
         (("render", "broken.json", "-o", "a.exr"), 3), (("info", "gap.json"), 3)]
