#!/usr/bin/env python3
"""Tests the Blender add-on in Blender, and compares its pictures with those of Cycles.

  run_blender.py --build build/release                     the tests, as ctest runs them; skipped where Blender is missing
  run_blender.py --build build/release --results           larger pictures, into testenv/blender/results
  run_blender.py --build build/release --widths            how far light travels below surfaces, into testenv/blender/results
  run_blender.py --build build/release --window            a real window under Xvfb, into testenv/blender/results/window.*
  run_blender.py --build build/release --python PYTHON     with the module bpy of that Python instead of the program blender

apt-get install blender installs Debian's. Exit code 77: skipped.
"""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from picture_sheet import ANONYMOUS, sheet

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parents[1]
SKIPPED = 77
ALPHA = 0.02  # largest RMS difference of means of blocks that is expected
PATIENCE = 120  # seconds between two turns of Blender's main loop, which software GL on a busy machine makes long


def command(options, script, job):
    if options.python:
        return [options.python, script, job]
    return ["blender", "-b", "--factory-startup", "-noaudio", "--python-exit-code", "3", "-P", script, "--", job]


def run(options, script, job, folder, echo=False):
    """The output of a script inside Blender; exits where it fails."""
    file = pathlib.Path(folder) / "job.json"
    file.write_text(json.dumps(job))
    scripts = pathlib.Path(folder) / "scripts"
    # Debian's Blender takes its modules from the first Python in the path, which must be Debian's, too.
    path = os.environ["PATH"] if options.python else "/usr/bin:/bin"
    environment = {**os.environ, "BLENDER_USER_SCRIPTS": str(scripts), "PATH": path}
    (scripts / "addons").mkdir(parents=True, exist_ok=True)
    done = subprocess.run([str(part) for part in command(options, HERE / script, file)], capture_output=True, text=True,
                          env=environment)
    text = done.stdout + done.stderr
    if done.returncode != 0 or echo:
        print("\n".join(line for line in text.splitlines() if not line.startswith("Fra:")))
    if done.returncode != 0:
        sys.exit(1)
    return text


def compare(options, base, folder):
    """Each scene's means, ours over Cycles'."""
    width, height, samples = (160, 120, 128) if options.results else (96, 72, 48)
    job = {**base, "scenes": options.scene, "width": width, "height": height, "samples": samples, "out": str(folder)}
    lines = run(options, "render_scenes.py", job, folder).splitlines()
    version = next(line[8:] for line in lines if line.startswith("VERSION "))
    return version, [json.loads(line[6:]) for line in lines if line.startswith("SCENE ")], job


def judge(rows, slack):
    failed = []
    for row in rows:
        off = 100 * max(abs(c - 1) for c in row["channels"])
        verdict = "" if off <= row["within"] + slack else f"  MORE THAN {row['within']} %"
        verdict += "" if row["alpha"] <= ALPHA else f"  ALPHA MORE THAN {ALPHA}"
        failed += [row["name"]] if verdict else []
        print(f"{row['name']:28} {row['ratio']:.4f}  off by {off:.1f} %, alpha by {row['alpha']:.4f}{verdict}")
    return failed


def table(version, rows, job):
    lines = [f"## Blender {version}", "",
             f"{job['width']} x {job['height']}, {job['samples']} samples, by `run_blender.py --results`. Ours over Cycles': the mean of the "
             "picture, its channels; the RMS difference of means of 8 x 8 pixels over the mean; and that of their alpha.", "",
             "| scene | mean | red, green, blue | blocks | alpha | why |", "| --- | --- | --- | --- | --- | --- |"]
    for row in rows:
        channels = ", ".join(f"{c:.3f}" for c in row["channels"])
        lines.append(f"| {row['name'].replace('_', ' ')} | {row['ratio']:.3f} | {channels} | {100 * row['blocks']:.1f} % | {row['alpha']:.4f} | {row['why']} |")
    return "\n".join(lines) + "\n"


def widths(options, base, folder):
    """Measures how far light travels below surfaces, in Cycles and here, and writes the table."""
    job = {**base, "cases": options.scene, "samples": 96, "columns": 192, "rows": 12, "out": str(folder)}
    lines = run(options, "subsurface_widths.py", job, folder).splitlines()
    version = next(line[8:] for line in lines if line.startswith("VERSION "))
    rows = [json.loads(line[6:]) for line in lines if line.startswith("WIDTH ")]
    text = [f"## Blender {version}", "",
            "A shadow's edge on a half-space, by `run_blender.py --widths`, radius 1: how far from the edge, in radii, the dark side falls to "
            "25, 10, 3 and 1 % of the lit one; ours over Cycles'; and of slabs lit from behind, whose thickness is 1.7 and 3.3 times the "
            "widest 10 %, ours over Cycles'.", "",
            "| | albedo | Cycles | ours over Cycles' | behind |", "| --- | --- | --- | --- | --- |"]
    for row in rows:
        theirs, ours = row["CYCLES"], row["ALABASTER"]
        cells = (" ".join("-" if not w else f"{w:.3f}" for w in theirs["widths"]),
                 " ".join(map(ratio, ours["widths"], theirs["widths"])), " ".join(map(ratio, ours["behind"], theirs["behind"])))
        text.append(f"| {row['case']} | {row['albedo']} | {' | '.join(cells)} |")
    print("\n".join(text))
    if not options.scene:
        name = "_".join(version.split(".")[:2])
        (HERE / f"results/widths_{name}.md").write_text("\n".join(text) + "\n")
    return 0


def ratio(ours, theirs):
    return f"{ours / theirs:.2f}" if ours and theirs else "-"


SENTENCES = {
    "first_picture_ms": "from Rendered to a picture that covers the viewport, export included",
    "material_edit_ms": "from a new base colour to a picture with it",
    "transform_edit_ms": "from a moved object to a picture with it",
    "camera_move_ms": "from a new view to the next whole picture: median and largest of 20",
    "blank_pictures_in_camera_moves": "pictures without content among these 20",
    "edits": "edits, by turns a colour and a move, each drawn: their seconds, those in the add-on, and resident memory",
    "draw_ms": "view_draw: median and largest",
    "beat_of_the_window_ms": "between two turns of Blender's main loop during F12: median and largest",
    "disable_ms": "to disable the add-on while it renders a frame",
    "escape_ms": "from the Escape key in F12 until Blender tells the engine, and from there until its job is over",
}


def window(options, base, folder):
    """Drives a window, and writes the table and the screenshots."""
    display, log = ":78", pathlib.Path(folder) / "window.log"
    server = subprocess.Popen(["Xvfb", display, "-screen", "0", "1280x800x24"])
    try:
        file = pathlib.Path(folder) / "job.json"
        file.write_text(json.dumps({**base, "out": folder, "edits": 500, "patience": PATIENCE}))
        environment = {**os.environ, "DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1", "PATH": "/usr/bin:/bin",
                       "BLENDER_USER_SCRIPTS": folder}
        with open(log, "w") as out:
            subprocess.run(["blender", "--factory-startup", "-noaudio", "--window-geometry", "0", "0", "1280", "800", "-P",
                            HERE / "window.py", "--", file], env=environment, stdout=out, stderr=subprocess.STDOUT, text=True)
    finally:
        server.terminate()
    lines = log.read_text().splitlines()
    line = next((one for one in lines if one.startswith("WINDOW ")), None)
    if line is None:
        print("the window stopped before its end; the last it said:", *lines[-30:], sep="\n")
        return 1
    told = json.loads(line[7:])
    rows = [f"| {sentence} | {json.dumps(told[name]).strip('{}').replace(chr(34), '')} |" for name, sentence in SENTENCES.items()]
    load = os.getloadavg()[0]
    (HERE / "results/window.md").write_text(
        f"# A window\n\nBlender {told['version']}, {told['window'][0]} x {told['window'][1]} under Xvfb with Mesa's software GL, "
        f"{os.cpu_count()} cores at a load of {load:.0f}, by `run_blender.py --window`. Milliseconds unless another unit is named.\n\n"
        "| | |\n| --- | --- |\n" + "\n".join(rows) + "\n")
    shots = [f"{folder}/{name}.png" for name in ("viewport", "after_material", "during_a_camera_move", "after_camera_moves")]
    subprocess.run(["oiiotool", *shots, "--mosaic:pad=4", "2x2", "--ch", "R,G,B", "--resize", "1280x800", "--compression", "jpeg:85",
                    *ANONYMOUS, "-o", HERE / "results/window.jpg"], check=True)
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    parser.add_argument("--python")
    parser.add_argument("--results", action="store_true")
    parser.add_argument("--window", action="store_true")
    parser.add_argument("--widths", action="store_true")
    parser.add_argument("--scene", action="append", default=[])
    options = parser.parse_args()
    if not options.python and not shutil.which("blender"):
        print("skipped: no program 'blender' (apt-get install blender)")
        return SKIPPED
    module = options.build.resolve() / "python"
    zipped = options.build.resolve() / "blender/alabaster_render.zip"
    base = {"addon": str(TOP / "delegate/blender"), "module": str(module), "zip": str(zipped) if zipped.is_file() else ""}
    with tempfile.TemporaryDirectory() as folder:
        if options.window:
            return window(options, base, folder)
        if options.widths:
            return widths(options, base, folder)
        if not options.results and not options.scene:
            print(run(options, "addon_test.py", base, folder).strip().splitlines()[-1])
            run(options, "exit_test.py", base, folder)
        version, rows, job = compare(options, base, folder)
        failed = judge(rows, 0.0 if options.results else 0.7)  # noise of few samples
        if options.results:
            name = "_".join(version.split(".")[:2])
            (HERE / f"results/blender_{name}.md").write_text(table(version, rows, job))
            sheet([row["name"] for row in rows], "alabaster", folder, HERE / f"results/blender_{name}.jpg")
    if failed:
        print(f"means differ more than expected: {', '.join(failed)}")
    return 1 if failed else 0


sys.exit(main())
