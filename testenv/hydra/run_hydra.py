#!/usr/bin/env python3
"""Renders scenes through the Hydra plug-in in Blender, and compares each pixel with the program's for the same data.

  run_hydra.py --build build/release              six scenes, as ctest runs them; skipped where the plug-in or bpy is missing
  run_hydra.py --build build/release --bindings   counts the symbols of our libraries that are bound to bpy's
  run_hydra.py --build build/release --results    all scenes of testenv/blender/scenes.py, into testenv/hydra/results/

The Python that has bpy is found beside the library that the plug-in was built for (CMake's ALABASTER_USD_LIBRARY), or named by
--python. python3.11 -m venv V && V/bin/pip install bpy==4.3.0 'numpy<2' makes one. Exit code 77: skipped.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parents[1]
sys.path.insert(0, str(TOP / "testenv/blender"))
from picture_sheet import sheet  # noqa: E402

SKIPPED = 77
QUICK = ["sun_light", "world_colour", "spot_light", "subsurface", "instances", "textured_board"]


def cached(build, name):
    found = re.search(rf"^{name}:\w+=(.*)$", (build / "CMakeCache.txt").read_text(), re.M)
    return found.group(1) if found else ""


def bpy_of(library):
    """(folder of bpy, Python) of a libusd_ms.so in the module bpy of a virtual environment, or None."""
    folder = pathlib.Path(library).parent.parent
    python = folder.parents[3] / "bin" / "python" if len(folder.parents) > 3 else folder
    return (folder, python) if folder.name == "bpy" and python.exists() else None


def run(options, folder, program, python, bpy):
    job = {"addon": str(TOP / "delegate/hydra/blender"), "program": str(program), "out": str(folder), "cycles": options.results,
           "scenes": options.scene or ([] if options.results else QUICK)}
    job.update({"width": 160, "height": 120, "samples": 128} if options.results else {"width": 96, "height": 72, "samples": 16})
    file = folder / "job.json"
    file.write_text(json.dumps(job))
    libraries = next(iter(sorted(bpy.rglob("materialx/libraries"))), "")
    environment = {**os.environ, "PXR_PLUGINPATH_NAME": str(options.build / "lib/alabaster/hydra"),
                   "PXR_MTLX_STDLIB_SEARCH_PATHS": str(libraries)}
    if options.bindings:
        environment.update({"LD_DEBUG": "bindings", "LD_DEBUG_OUTPUT": str(folder / "bindings")})
    done = subprocess.run([str(python), str(HERE / "render_in_blender.py"), str(file)], capture_output=True, text=True, env=environment)
    text = done.stdout + done.stderr
    if done.returncode != 0 or options.echo:
        print("\n".join(line for line in text.splitlines() if not line.startswith(("Fra:", "ModuleNotFoundError: No module named 'pxr"))))
    if done.returncode != 0:
        sys.exit(1)
    lines = text.splitlines()
    return next(line[8:] for line in lines if line.startswith("VERSION ")), [json.loads(line[6:]) for line in lines if line.startswith("SCENE ")], job


BOUND = re.compile(r"binding file (\S+) \[\d+\] to (\S+) \[\d+\]: \w+ symbol `([^']+)'")


def bindings(folder, bpy):
    """By library of bpy: how many symbols of the renderer's libraries were bound to it. The plug-in's own two files must be."""
    counts = {}
    for log in folder.glob("bindings.*"):
        for line in log.read_text(errors="replace").splitlines():
            found = BOUND.search(line)
            if not found:
                continue
            of, to = found.group(1), found.group(2)
            if to.startswith(str(bpy)) and not of.startswith(str(bpy)) and "python" not in of and "/alabaster/hydra/" not in of:
                counts[pathlib.Path(to).name] = counts.get(pathlib.Path(to).name, 0) + 1
    print(f"{sum(counts.values())} symbols: " + ", ".join(f"{name} {n}" for name, n in sorted(counts.items(), key=lambda one: -one[1])))


def judge(rows):
    failed = []
    for row in rows:
        wrong = row.get("error") or row.get("pixels_that_differ")
        state = row["error"] or f"{row['pixels_that_differ']} pixels differ"
        cycles = "  over Cycles: " + ", ".join(f"{c:.3f}" for c in row["over_cycles"]) if "over_cycles" in row else ""
        print(f"{row['name']:28} {state}{cycles}")
        failed += [row["name"]] if wrong or not row["mean"] > 0 else []
    return failed


def table(version, rows, job):
    lines = [f"## bpy {version}, HydraRenderEngine, export method HYDRA with MaterialX", "",
             f"{job['width']} x {job['height']}, {job['samples']} samples, by `run_hydra.py --results`. Pixels of Blender's EXR that differ from those that "
             "`alabaster render` gives for the archive that the plug-in wrote; and the mean over that of Cycles.", "",
             "| scene | pixels that differ | red, green, blue over Cycles |", "| --- | --- | --- |"]
    for row in rows:
        state = row["pixels_that_differ"] if not row["error"] else "failed"
        lines.append(f"| {row['name'].replace('_', ' ')} | {state} | {', '.join(f'{c:.3f}' for c in row['over_cycles'])} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    parser.add_argument("--python", type=pathlib.Path)
    parser.add_argument("--results", action="store_true")
    parser.add_argument("--bindings", action="store_true")
    parser.add_argument("--echo", action="store_true", help="print what Blender prints")
    parser.add_argument("--scene", action="append", default=[])
    options = parser.parse_args()
    options.build = options.build.resolve()
    if not (options.build / "lib/alabaster/hydra/hdAlabasterPlugin.so").is_file():
        print("skipped: the Hydra plug-in is not built (delegate/hydra/README.md says how)")
        return SKIPPED
    found = bpy_of(cached(options.build, "ALABASTER_USD_LIBRARY"))
    if not found:
        print("skipped: the plug-in was not built for the OpenUSD of a module bpy (ALABASTER_USD_LIBRARY)")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        program = options.build / "bin/alabaster"
        version, rows, job = run(options, pathlib.Path(folder), program, options.python or found[1], found[0])
        failed = judge(rows)
        if options.bindings:
            bindings(pathlib.Path(folder), found[0])
        if options.results:
            results = HERE / "results"
            results.mkdir(exist_ok=True)
            name = "bpy_" + "_".join(version.split(".")[:2])
            (results / f"{name}.md").write_text(table(version, rows, job))
            sheet([row["name"] for row in rows], "alabaster_hydra", folder, results / f"{name}.jpg")
    if failed:
        print(f"not equal to the program's: {', '.join(failed)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
