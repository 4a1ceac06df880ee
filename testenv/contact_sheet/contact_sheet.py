#!/usr/bin/env python3
"""Renders every model of the assets folder and joins the pictures into one sheet, with a table to judge them by.

  contact_sheet.py [--assets FOLDER] [--match TEXT] [--size WxH] [--spp N] [--out FOLDER] [--peer blender] [-- FLAGS]

The models are the .gltf and .glb below FOLDER/valid, sss and subdiv; FOLDER is $ALABASTER_TEST_ASSETS by default. Each is
rendered as `alabaster render` shows it to a user, with its default look and FLAGS. Writes sheet.png, one cell per model (picture,
name, verdict), and sheet.md: verdict, messages, cost, and the line of CATALOGUE.md that says what the picture should show.

The verdict comes from the exit code and the messages: "rendered"; "rendered, 2 warnings"; "refused" if an input is not
supported and a message names it; "failed" for everything else. Exits with 1 if a model failed.

--peer blender renders each model with Debian's Blender (Cycles) as well, both programs with the same camera and under a
constant dome, and writes peer.png (ours, Cycles, difference around grey) and peer.md. `mean` is our mean over theirs per channel,
`blocks` the RMS difference of blocks of 8 x 8 pixels over the mean.

Needs oiiotool (openimageio-tools) and DejaVu Sans (fonts-dejavu-core).
"""
import argparse
import dataclasses
import json
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "testenv" / "statistical" / "calibration"))
from pictures import block_means, read_exr  # noqa: E402

FONT = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"
COLUMNS, CAPTION, BLOCK = 6, 34, 8
TIME_LIMIT = 1800  # seconds for one model


@dataclasses.dataclass
class Result:
    name: str
    code: int
    messages: list
    seconds: float
    picture: pathlib.Path

    @property
    def verdict(self):
        warnings = sum(m.startswith("warning") for m in self.messages)
        if self.code == 0:
            return f"rendered, {warnings} warning{'s' * (warnings > 1)}" if warnings else "rendered"
        refused = self.code == 3 and any(m.startswith("error") and "not supported" in m for m in self.messages)
        return "refused" if refused else f"failed ({self.code})"


def find_models(assets, match):
    found = [f for folder in ("valid", "sss", "subdiv") for f in sorted((assets / folder).rglob("*.gl*"))
             if f.suffix in (".gltf", ".glb")]
    return [f for f in found if match.lower() in str(f.relative_to(assets)).lower()]


def read_catalogue(assets):
    """The column that says what a correct picture shows, by file."""
    lines = {}
    if (assets / "CATALOGUE.md").exists():
        for row in re.findall(r"^\| `([^`]+)` \|([^|]*)\|([^|]*)\|", (assets / "CATALOGUE.md").read_text(), re.M):
            lines[row[0]] = row[2].strip()
    return lines


def render(options, scene, name, output):
    """Runs the program; `name` is what the sheet calls the model."""
    library = options.program.parent.parent / "lib"
    environment = {**os.environ, "LD_LIBRARY_PATH": f"{library}:{os.environ.get('LD_LIBRARY_PATH', '')}"}
    command = [options.program, "render", scene, "--allow-outside", "--size", options.size, "--spp", str(options.spp), "--threads",
               str(options.threads), "--quiet", *options.flags, "-o", output]
    output.unlink(missing_ok=True)
    start = time.monotonic()
    try:
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=TIME_LIMIT)
        code, said = done.returncode, done.stderr
    except subprocess.TimeoutExpired:
        code, said = 124, f"error: not done after {TIME_LIMIT} s"
    messages = [line.replace(f"{scene}: ", "") for line in said.splitlines() if re.match("warning|error", line)]
    return Result(name, code, messages, time.monotonic() - start, output)


def file_name(name):
    return re.sub(r"[^\w.]+", "_", name)


def text(x, y, words, size=11, color="0.9,0.9,0.9"):
    return [f"--text:x={x}:y={y}:size={size}:font={FONT}:color={color}", words]


def write_sheet(cells, width, height, columns, output):
    """Each cell is (pictures side by side, first line, second line, colour of the second line); a missing picture stays dark."""
    columns = min(columns, len(cells))
    step_x, step_y = max(len(c[0]) for c in cells) * width + 4, height + CAPTION
    rows = -(-len(cells) // columns)
    command = ["oiiotool", "--create", f"{columns * step_x}x{rows * step_y}", "3"]
    for i, (pictures, *_) in enumerate(cells):
        x, y = i % columns * step_x, i // columns * step_y
        for k, picture in enumerate(pictures):
            if picture.exists():
                command += [picture, "--ch", "R,G,B", "--swap", "--paste", f"+{x + k * width}+{y}"]
    for i, (_, first, second, color) in enumerate(cells):
        x, y = i % columns * step_x + 4, i // columns * step_y + height
        command += text(x, y + 13, first) + text(x, y + 28, second, color=color)
    subprocess.run([*command, "-d", "uint8", "-o", output], check=True)


def escape(words):
    return words.replace("|", "\\|").replace("\n", " ")


def write_table(results, catalogue, file):
    lines = ["| file | verdict | s | should show | messages |", "| --- | --- | --- | --- | --- |"]
    for r in results:
        lines.append(f"| {r.name} | {r.verdict} | {r.seconds:.1f} | {escape(catalogue.get(r.name, ''))} | "
                     f"{'<br>'.join(map(escape, r.messages))} |")
    file.write_text("\n".join(lines) + "\n")


def color_of(verdict):
    return "0.5,0.9,0.5" if verdict == "rendered" else "1,0.4,0.4" if verdict.startswith("failed") else "0.95,0.85,0.4"


def make_sheet(options, models):
    results = []
    for model in models:
        name = str(model.relative_to(options.assets))
        results.append(render(options, model, name, options.out / f"{file_name(name)}.png"))
        print(f"{name}: {results[-1].verdict}", flush=True)
    cells = [([r.picture], pathlib.Path(r.name).name, r.verdict, color_of(r.verdict)) for r in results]
    write_sheet(cells, *options.pixels, COLUMNS, options.out / "sheet.png")
    write_table(results, read_catalogue(options.assets), options.out / "sheet.md")
    return any(r.verdict.startswith("failed") for r in results)


def run_blender(options, model, base):
    """Cycles' picture and the camera for both programs as base.exr and base.json; returns why there is none, or nothing."""
    job = {"model": str(model), "size": options.pixels, "samples": options.spp, "threads": options.threads,
           "dome": options.dome, "output": str(base)}
    base.with_suffix(".job").write_text(json.dumps(job))
    for suffix in (".exr", ".json"):
        base.with_suffix(suffix).unlink(missing_ok=True)
    command = ["blender", "-b", "--factory-startup", "-noaudio", "--python-exit-code", "3", "-P", HERE / "cycles_gltf.py", "--",
               base.with_suffix(".job")]
    # Blender takes the Python that its path finds first; numpy is with Debian's.
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "PATH": "/usr/bin:/bin"})
    if done.returncode == 0 and base.with_suffix(".exr").exists():
        return ""
    said = [line for line in (done.stdout + done.stderr).splitlines() if "Error" in line or "rror:" in line]
    return f"Cycles: {said[-1].strip() if said else 'no picture'}"


def compare(ours, theirs):
    """(ratios of the means, RMS difference of blocks over the mean)"""
    means = [[statistics.fmean(plane) for plane in picture.planes] for picture in (ours, theirs)]
    level = max(statistics.fmean(means[1]), 1e-6)
    blocks = [block_means(picture, BLOCK).planes for picture in (ours, theirs)]
    squares = [(a - b) ** 2 for plane_a, plane_b in zip(*blocks) for a, b in zip(plane_a, plane_b)]
    return [a / max(b, 1e-6) for a, b in zip(*means)], statistics.fmean(squares) ** 0.5 / level


def for_the_eye(*arguments):
    subprocess.run(["oiiotool", *map(str, arguments[:-1]), "--ch", "R,G,B", "--colorconvert", "linear", "sRGB", "-d", "uint8", "-o",
                    str(arguments[-1])], check=True)


def compare_model(options, model, base):
    """(why there is no comparison or nothing, ratios, blocks)"""
    missing = run_blender(options, model, base)
    if missing:
        return missing, None, None
    scene = {"gltf": [{"file": str(model)}], "camera": json.loads(base.with_suffix(".json").read_text()),
             "lights": [{"name": "dome", "type": "domeLight", "color": [options.dome] * 3, "visibleToCamera": True}]}
    base.with_suffix(".scene.json").write_text(json.dumps(scene))
    ours, theirs = base.with_suffix(".ours.exr"), base.with_suffix(".exr")
    result = render(options, base.with_suffix(".scene.json"), model.name, ours)
    if not ours.exists():
        return "; ".join(result.messages) or result.verdict, None, None
    for_the_eye(ours, base.with_suffix(".ours.png"))
    for_the_eye(theirs, base.with_suffix(".theirs.png"))
    for_the_eye(ours, "--ch", "R,G,B", theirs, "--ch", "R,G,B", "--sub", "--addc", "0.2", base.with_suffix(".difference.png"))
    return "", *compare(read_exr(ours), read_exr(theirs))


def make_peer_sheet(options, models):
    cells, lines = [], ["| file | mean (r, g, b) | blocks | |", "| --- | --- | --- | --- |"]
    for model in models:
        name = str(model.relative_to(options.assets))
        base = options.out / "peer" / file_name(name)
        base = base.with_name(base.name + ".x")  # with_suffix replaces this one
        missing, ratios, blocks = compare_model(options, model, base)
        found = missing or "mean " + " ".join(f"{r:.3f}" for r in ratios) + f", blocks {blocks:.3f}"
        print(f"{name}: {found}", flush=True)
        lines.append(f"| {name} | | | {escape(missing)} |" if missing else
                     f"| {name} | {', '.join(f'{r:.3f}' for r in ratios)} | {blocks:.3f} | |")
        pictures = [base.with_suffix(s) for s in (".ours.png", ".theirs.png", ".difference.png")]
        cells.append((pictures, model.name, found[:140], "0.9,0.9,0.9"))
    write_sheet(cells, *options.pixels, COLUMNS // 3, options.out / "peer.png")
    (options.out / "peer.md").write_text("\n".join(lines) + "\n")


def parse(arguments):
    own, flags = (arguments[:arguments.index("--")], arguments[arguments.index("--") + 1:]) if "--" in arguments else (arguments, [])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--assets", default=os.environ.get("ALABASTER_TEST_ASSETS"))
    parser.add_argument("--program", default=str(ROOT / "build" / "release" / "bin" / "alabaster"))
    parser.add_argument("--match", default="", help="only the files with this text in their path")
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--spp", type=int, default=32)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--out", default=str(ROOT / "build" / "contact_sheet"))
    parser.add_argument("--peer", choices=["blender"])
    parser.add_argument("--dome", type=float, default=0.6, help="radiance of the peers' dome")
    options = parser.parse_args(own)
    if not options.assets:
        parser.error("set ALABASTER_TEST_ASSETS or give --assets")
    for name in ("assets", "program", "out"):
        setattr(options, name, pathlib.Path(getattr(options, name)).resolve())
    options.flags, options.pixels = flags, [int(n) for n in options.size.split("x")]
    return options


def main():
    options = parse(sys.argv[1:])
    for need, package in (("oiiotool", "openimageio-tools"), *([("blender", "blender")] if options.peer else [])):
        if not shutil.which(need):
            sys.exit(f"no program '{need}' (apt-get install {package})")
    if not os.path.exists(FONT):
        sys.exit(f"no font {FONT} (apt-get install fonts-dejavu-core)")
    models = find_models(options.assets, options.match)
    if not models:
        sys.exit(f"no model below {options.assets} has '{options.match}' in its path")
    (options.out / "peer").mkdir(parents=True, exist_ok=True)
    failed = make_peer_sheet(options, models) if options.peer else make_sheet(options, models)
    print(f"wrote {options.out / ('peer' if options.peer else 'sheet')}.png and .md")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
