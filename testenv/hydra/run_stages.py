#!/usr/bin/env python3
"""Renders USD stages through the Hydra plug-in as usdrecord does, and judges each picture by what stage_cases.py expects.

  run_stages.py --build build/release             all stages; skipped where record_stage is not built
  run_stages.py --build build/release --results   the same, into testenv/hydra/results/
--case NAME (again and again) chooses, --keep FOLDER leaves stages and pictures there. Exit code 77: skipped.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

try:
    import numpy
except ImportError:
    numpy = None

from stage_cases import CASES

HERE = pathlib.Path(__file__).resolve().parent
SKIPPED = 77
SIZE, SAMPLES = [64, 48], 16
ANONYMOUS = ["--nosoftwareattrib", "--eraseattrib", ".*"]  # no paths of this machine in a picture


def cached(build, name):
    found = re.search(rf"^{name}:\w+=(.*)$", (build / "CMakeCache.txt").read_text(), re.M)
    return found.group(1) if found else ""


class Host:
    """Renders stages in a process of their own each."""

    def __init__(self, build, folder):
        self.build, self.folder = build, folder
        usd = pathlib.Path(cached(build, "ALABASTER_USD_LIBRARY")).parent
        libraries = next(iter(sorted(usd.parent.rglob("materialx/libraries"))), "")
        paths = [build / "lib/alabaster/hydra", usd / "usd"]
        self.environment = {**os.environ, "PXR_PLUGINPATH_NAME": ":".join(str(p) for p in paths), "PXR_MTLX_STDLIB_SEARCH_PATHS": str(libraries)}

    def run(self, name, text, options):
        """The lines that record_stage prints, and its warnings."""
        stage, file = self.folder / f"{name}.usda", self.folder / f"{name}.job.json"
        stage.write_text(text)
        file.write_text(json.dumps({"stage": str(stage), "camera": "/camera", "size": SIZE, **options}))
        done = subprocess.run([str(self.build / "bin/record_stage"), str(file)], capture_output=True, text=True,
                              env=self.environment, timeout=300)
        if done.returncode != 0:
            raise RuntimeError(f"{name}: record_stage ended with {done.returncode}\n{done.stderr[-2000:]}")
        return done.stdout, done.stderr

    def pictures(self, name, text, options, frames):
        """By frame and AOV, rows from the top down; and what was warned of."""
        out = [{**frame, "out": str(self.folder / f"{name}.{i}"), "settings": {"alabaster:samples": SAMPLES, "alabaster:filter": "box", **frame.get("settings", {})}}
               for i, frame in enumerate(frames)]
        told, warned = self.run(name, text, {**options, "frames": out})
        every = [{} for _ in frames]
        for line in told.splitlines():
            if line.startswith("PICTURE "):
                of = json.loads(line[8:])
                _, number, aov, _ = pathlib.Path(of["file"]).name.rsplit(".", 3)
                every[int(number)][aov] = numpy.fromfile(of["file"], numpy.float32).reshape(of["height"], of["width"], of["channels"])[::-1]
        return every, warned


def exr(file, size=SIZE, channels="R,G,B,A"):
    """Channels of an EXR of floats, rows from the top down. An uncompressed TIFF of OpenImageIO ends with them."""
    plain = file.with_suffix(".tif")
    subprocess.run(["oiiotool", str(file), "--fullpixels", "--ch", channels, "-d", "float", "--compression", "none", "-o", str(plain)], check=True, capture_output=True)
    (width, height), count = size, channels.count(",") + 1
    return numpy.frombuffer(plain.read_bytes()[-width * height * count * 4:], numpy.float32).reshape(height, width, count)


def differing(a, b):
    return int((a.view(numpy.uint32) != b.view(numpy.uint32)).any(axis=2).sum()) if a.shape == b.shape else a[..., 0].size


LAYERS = {"color": "R,G,B,A", "cameraDepth": "Z"}  # of a product's file
FAR = numpy.float32(1e10) if numpy else 0           # there, where no surface is; 0 in the host's buffer


def judge_files(host, name, given):
    """The files that usdrecord's own recorder, or the renderer for it, writes: each layer equal to a window of what the engine shows.

    With several frames files are those of the last, which no other frame looks like."""
    stage, files, show, frames = given["stage"], given["files"], given.get("show", {}), given.get("frames", [{}])
    frame = host.folder / f"{name}.frame"
    host.run(name, stage, {**given.get("record", {}), "record": "exr", "frames": [{**one, "out": str(frame)} for one in frames]})
    *earlier, whole = host.pictures(name + ".shown", stage, show, frames)[0]
    for one in [whole, *earlier]:
        if "cameraDepth" in one:
            one["cameraDepth"] = numpy.where(one["cameraDepth"] > 0, one["cameraDepth"], FAR)
    for aov, shown in whole.items():
        for file, (left, top, right, bottom) in files.items():
            window = numpy.s_[top:bottom, left:right]
            found = exr(host.folder / file, (right - left, bottom - top), LAYERS[aov])
            if count := differing(found, shown[window]):
                return f"{aov} of {file}: {count} pixels differ", ""
            if any(differing(found, one[aov][window]) < found[..., 0].size // 4 for one in earlier):
                return f"{aov} of {file} shows an earlier frame, too", ""
    return "", f"files: {len(files)}, layers: {len(whole)}, frames: {len(frames)}, 0 pixels differ"


def listing(file):
    """What oiiotool says of an EXR: names of channels, and a text by name of attribute."""
    said = subprocess.run(["oiiotool", "--info", "-v", str(file)], check=True, capture_output=True, text=True).stdout
    channels = re.search(r"channel list: (.*)", said).group(1)
    return re.findall(r"([^ ,]+)(?: \([a-z0-9]+\))?(?:, |$)", channels), dict(re.findall(r"^    (\S+): (.*)$", said, re.M))


def fault_of_layers(ours, theirs, wanted):
    """The layers of a file are those of the program's, and show what they must."""
    names, attributes = listing(ours)
    if sorted(names) != sorted(wanted["names"]):
        return f"has the channels {sorted(names)}"
    if sorted(listing(theirs)[0]) != sorted(names):
        return f"the program's has the channels {sorted(listing(theirs)[0])}"
    for beginning in wanted.get("attributes", []):
        mine, other = ({n: v for n, v in of.items() if n.startswith(beginning)} for of in (attributes, listing(theirs)[1]))
        if not mine or mine != other:
            return f"has the attributes {mine}, the program's {other}"
    def values(channels, file=ours):
        return exr(file, channels=",".join(channels))
    for name in names:
        mine, other = values([name]), values([name], theirs)
        if not mine.any() and name not in wanted.get("zero", []):
            return f"{name} is 0 everywhere"
        if count := differing(mine, other):
            return f"{name} is not the program's: {count} pixels differ, by {float(numpy.abs(mine - other).max())}"
    for a, b in wanted["same"]:
        if count := differing(values(a), values(b)):
            return f"{a} and {b}: {count} pixels differ"
    if not differing(*(values(channels) for channels in wanted["unlike"])):
        return f"{wanted['unlike']} are the same"
    if "sum" in wanted:
        whole, parts = values(wanted["sum"][0]), sum(values(part) for part in wanted["sum"][1])
        if numpy.abs(whole - parts).max() > 1e-4 * whole.max():
            return "the parts do not add up to the whole"
    return ""


def judge_program(host, name, given):
    """The files of products that the plug-in writes equal those that the program writes of the same stage."""
    record = {"renderSettings": "/Render/settings", "record": "exr"}
    _, warned = host.run(name, given["stage"], {**record, "frames": [{"out": str(host.folder / f"{name}.frame"), "time": 1}]})
    both, here = given.get("both", []), given.get("warns", "")
    for text in (*both, here):
        if text not in warned:
            return f"did not warn '{text}', but: {warned.strip()[-1000:]}", ""
    if "Alabaster" in warned and not here:
        return f"warned: {warned.strip()[-500:]}", ""
    folder = host.folder / f"{name}.program"
    folder.mkdir(exist_ok=True)
    stage = folder / f"{name}.usda"
    stage.write_text(given["stage"].replace(str(host.folder), str(folder)))
    done = subprocess.run([str(host.build / "bin/alabaster"), "render", "--quiet", str(stage)], capture_output=True, text=True)
    if done.returncode:
        return f"the program: {done.stderr.strip()[-500:]}", ""
    for text in both:
        if text not in done.stderr:
            return f"the program did not warn '{text}', but: {done.stderr.strip()[-1000:]}", ""
    for file, wanted in given["program"].items():
        if fault := fault_of_layers(host.folder / file, folder / file, wanted):
            return f"{file} {fault}", ""
    return "", f"files: {len(given['program'])}, channels: {sum(len(w['names']) for w in given['program'].values())}, 0 pixels differ"


def judge_nodes(host, name, given):
    """OpenUSD's registry of shaders tells applications of our nodes."""
    told, warned = host.run(name, "", {"shaders": given["nodes"]})
    nodes = {node["name"]: node for node in (json.loads(line[5:]) for line in told.splitlines() if line.startswith("NODE "))}
    fault = warned if "Alabaster" in warned or "Error" in warned else given["check"](nodes)
    return fault, f"nodes: {len(nodes)}, as expected"


def prims_of(archive):
    data = archive.read_bytes()
    length = int.from_bytes(data[:8], "little")
    begin, end = json.loads(data[8:8 + length])["scene.json"]["data_offsets"]
    return json.loads(data[8 + length + begin:8 + length + end])["prims"]


def fault_of_archive(file, materials):
    """The parameters that the plug-in wrote are those that the stage has, numbers as floats."""
    found = {prim["path"]: {name.split(".")[-1]: next(iter(value.values())) for name, value in prim["fields"] if value}
             for prim in prims_of(file) if prim["kind"] == "material"}
    for path, wanted in materials.items():
        for key, value in wanted.items():
            there = found.get(path, {}).get(key)
            if not isinstance(value, str):
                there, value = (numpy.asarray(v, numpy.float32).tolist() if v is not None else v for v in (there, value))
            if there != value:
                return f"{key} of {path} is written as {there}, not {value}"
    return ""


def judge(host, name, given):
    """(fault or nothing, what was found)"""
    if "files" in given:
        return judge_files(host, name, given)
    if "program" in given:
        return judge_program(host, name, given)
    if "nodes" in given:
        return judge_nodes(host, name, given)
    stage, equals, check = given.pop("stage"), given.pop("equals", None), given.pop("check", None)
    within, written, warns, control = given.pop("within", 0), given.pop("written", False), given.pop("warns", ""), given.pop("control", "")
    frames, materials = given.pop("frames", [{}]), given.pop("materials", {})
    if written:
        frames[-1].setdefault("settings", {})["alabaster:writeScene"] = str(host.folder / f"{name}.alab")
    pictures, warned = host.pictures(name, stage, given, frames)
    color = pictures[-1]["color"]
    if "Alabaster" in warned and not warns or warns not in warned:
        return f"warned: {warned.strip()[-500:]}", ""
    if not numpy.isfinite(color).all() or not color[..., :3].max() > 0:
        return "black or not finite", ""
    if check:
        return check(pictures), "as expected"
    if written:
        done = subprocess.run([str(host.build / "bin/alabaster"), "render", "--quiet", "--allow-outside", str(host.folder / f"{name}.alab")], capture_output=True, text=True)
        if done.returncode:
            return done.stderr.strip()[-300:], ""
        if fault := fault_of_archive(host.folder / f"{name}.alab", materials):
            return fault, ""
        other = exr(host.folder / f"{name}.exr")
    else:
        given.pop("renderSettings", None)
        last = {**frames[-1], "settings": {**frames[-1].get("settings", {}), **given.pop("other", {})}}
        unlike = given.pop("unlike", None)
        other = host.pictures(name + ".other", equals, given, [last])[0][-1]["color"]
        if unlike and not differing(color, host.pictures(name + ".unlike", equals, given, [{"settings": unlike}])[0][-1]["color"]):
            return "shows what it must not", ""
    def apart(shown):
        return float(numpy.abs(color - shown).mean() / color[..., :3].mean())
    if control and apart(host.pictures(name + ".control", control, given, frames)[0][-1]["color"]) < 0.5:
        return "shows what its control does", ""
    count, error = differing(color, other), apart(other)
    found = f"{count} pixels differ" + (f", by {error:.1e} in the mean" if count else "")
    return (found if error > within or (count and not within) else ""), found


def sheet(host, names, out):
    """The last picture of each case, clipped to 0..1, in the order of the table."""
    files = []
    for name in names:
        file = host.folder / f"{name}.ppm"
        pictures = [*host.folder.glob(f"{name}.[0-9].color.raw"), *host.folder.glob(f"{name}.shown.0.color.raw")]
        if not pictures:
            continue  # nothing was rendered
        pixels = numpy.fromfile(max(pictures), numpy.float32).reshape(SIZE[1], SIZE[0], 4)[::-1, :, :3]
        srgb = numpy.clip(pixels, 0, 1) ** (1 / 2.2)
        file.write_bytes(f"P6 {SIZE[0]} {SIZE[1]} 255\n".encode() + (srgb * 255 + 0.5).astype(numpy.uint8).tobytes())
        files.append(str(file))
    subprocess.run(["oiiotool", *files, "--mosaic:pad=4", f"7x{-(-len(files) // 7)}", "--compression", "jpeg:85", *ANONYMOUS, "-o", str(out)], check=True)


def table(rows):
    lines = ["# USD stages by the engine of usdrecord", "",
             f"OpenUSD 24.05, {SIZE[0]} x {SIZE[1]}, {SAMPLES} samples, by `run_stages.py --results`. Each stage of `stage_cases.py` against its expectation: the "
             "program's picture of the archive that the plug-in writes, another stage, or values that are known. Those that have a picture are in `stages.jpg` in this order.", "",
             "| stage | found |", "| --- | --- |"]
    return "\n".join(lines + [f"| {name.replace('_', ' ')} | {found} |" for name, found in rows]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    parser.add_argument("--case", action="append", default=[])
    parser.add_argument("--keep", type=pathlib.Path)
    parser.add_argument("--results", action="store_true")
    options = parser.parse_args()
    build = options.build.resolve()
    if not (build / "bin/record_stage").is_file():
        print("skipped: record_stage is not built (delegate/hydra/README.md says how)")
        return SKIPPED
    if numpy is None:
        print("skipped: numpy is missing: apt-get install python3-numpy")
        return SKIPPED
    failed, rows = [], []
    with tempfile.TemporaryDirectory() as temporary:
        folder = (options.keep or pathlib.Path(temporary)).resolve()
        folder.mkdir(exist_ok=True)
        host = Host(build, folder)
        for name in options.case or CASES:
            try:
                fault, found = judge(host, name, CASES[name](folder))
            except RuntimeError as error:
                fault, found = str(error), ""
            print(f"{name:28} {'FAILED: ' + fault if fault else found}", flush=True)
            failed += [name] if fault else []
            rows.append((name, "FAILED" if fault else found))
        if options.results:
            (HERE / "results/stages.md").write_text(table(rows))
            sheet(host, [name for name, _ in rows], HERE / "results/stages.jpg")
    if failed:
        print("failed: " + ", ".join(failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
