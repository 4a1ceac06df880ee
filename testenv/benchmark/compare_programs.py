#!/usr/bin/env python3
"""Compares pictures and cost per sample of two builds of the program on the bundled scenes.

  compare_programs.py BEFORE AFTER [--instructions [--size WxH]] [--scene NAME ...]

Pictures: every scene is rendered small in several modes with every layer; all channels of the EXR are compared exactly.
--instructions counts the instructions of one sample with valgrind (callgrind): the difference of two renders, one with
twice the samples of the other, so that loading and building are not counted. BEFORE and AFTER are paths of the program;
each finds its library beside itself, in ../lib. Exits with 1 if a picture differs.
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SCENES = pathlib.Path(__file__).resolve().parents[1] / "scenes"
BUNDLED = ["backlit", "dome_high_contrast", "hard_light", "mixed_no_subsurface", "skin_closeup", "thick_thin"]
LAYERS = ["depth", "cameraDepth", "normal", "albedo", "primId", "instanceId", "elementId", "sampleCount", "diffuse", "specular",
          "emission", "subsurface", "subsurfaceUnscattered", "subsurfaceSingle", "subsurfaceMultiple", "error"]
MODES = {  # every scene is rendered in each
    "walk": [],
    "walk with layers": [flag for layer in LAYERS for flag in ("--aov", layer)],
    "reference": ["--subsurface", "reference"],
    "diffusion": ["--subsurface", "diffusion"],
    "lambert": ["--subsurface", "lambert"],
    "adaptive": ["--set", "adaptive=true", "--spp", "40", "--size", "40x28"],
    "target error": ["--target-error", "0.5", "--spp", "64", "--size", "40x28"],
    "chiang2016": ["--inversion", "chiang2016"],
}
PACKAGES = {"valgrind": "valgrind", "callgrind_annotate": "valgrind", "oiiotool": "openimageio-tools"}
WIDTH, HEIGHT = 48, 32  # of the frames whose instructions are counted


def environment(program):
    lib = pathlib.Path(program).resolve().parent.parent / "lib"
    return {**os.environ, "LD_LIBRARY_PATH": str(lib)}


def require(*tools):
    """Ends with what is missing, if one of these programs is."""
    for tool in tools:
        if not shutil.which(tool):
            package = PACKAGES.get(tool)
            sys.exit(f"There is no program {tool}" + (f": apt-get install {package}" if package else ""))


def require_benchmark(file):
    """Ends with how to build a benchmark's file, if it is missing."""
    if not pathlib.Path(file).exists():
        sys.exit(f"There is no {file}: build the benchmarks (cmake -DALABASTER_BENCHMARKS=ON)")


def add_size(parser):
    parser.add_argument("--size", default=f"{WIDTH}x{HEIGHT}", type=parsed_size, metavar="WxH", help="of the frames whose instructions are counted; default: %(default)s")


def parsed_size(text):
    found = re.fullmatch(r"([1-9]\d*)x([1-9]\d*)", text)
    if not found:
        raise argparse.ArgumentTypeError(f"'{text}' is not a size: write for example 48x32")
    return int(found[1]), int(found[2])


def render(program, scene, output, flags, prefix=()):
    command = [*prefix, program, "render", str(SCENES / scene / f"{scene}.json"), "-o", str(output), "--quiet", *flags]
    done = subprocess.run(command, env=environment(program), capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\nended with {done.returncode}: {done.stderr}")
    return done.stderr


def pictures_equal(scene, mode, flags, programs, folder):
    files = []
    for name, program in zip(("before", "after"), programs):
        files.append(folder / f"{scene}.{mode.replace(' ', '_')}.{name}.exr")
        sized = ["--size", "96x64"] if "--size" not in flags else []
        counted = ["--spp", "4"] if "--spp" not in flags else []
        render(program, scene, files[-1], [*sized, *counted, *flags])
    done = subprocess.run(["oiiotool", str(files[0]), str(files[1]), "--fail", "0", "--warn", "0", "--diff"], capture_output=True, text=True)
    return done.returncode == 0, done.stdout


def instructions_per_sample(scene, program, folder, size):
    """Instructions of one camera sample in one thread, without AOVs."""
    (width, height), few = size, 4
    totals = []
    for samples in (few, 2 * few):
        flags = ["--size", f"{width}x{height}", "--spp", str(samples), "--threads", "1"]
        prefix = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder / 'callgrind.out'}"]
        text = render(program, scene, folder / "cost.exr", flags, prefix)
        totals.append(int(re.search(r"Collected : (\d+)", text).group(1)))
    return (totals[1] - totals[0]) / (width * height * few)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--instructions", action="store_true", help="count instructions instead of comparing pictures")
    parser.add_argument("--scene", action="append", choices=BUNDLED, help="only this scene; may be repeated")
    add_size(parser)
    arguments = parser.parse_args()
    require(arguments.before, arguments.after, "valgrind" if arguments.instructions else "oiiotool")
    programs = (arguments.before, arguments.after)
    scenes = arguments.scene or BUNDLED
    different = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if arguments.instructions:
            print("| scene | before: instructions a sample | after | after / before |\n|--|--|--|--|")
            for scene in scenes:
                before, after = (instructions_per_sample(scene, program, folder, arguments.size) for program in programs)
                print(f"| {scene} | {before:.0f} | {after:.0f} | {after / before:.3f} |", flush=True)
            return 0
        for scene in scenes:
            for mode, flags in MODES.items():
                equal, text = pictures_equal(scene, mode, flags, programs, folder)
                if not equal:
                    different += 1
                    print(f"{scene}, {mode}: DIFFERENT\n{text}")
        print("SAME: all pictures are equal to the bit" if different == 0 else f"{different} pictures differ")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
