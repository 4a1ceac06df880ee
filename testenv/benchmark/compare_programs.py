#!/usr/bin/env python3
"""Compares the cost per sample of two builds of the program on the bundled scenes; their pictures are compared by
testenv/regression/pictures_of_base.py AFTER --base BEFORE.

  compare_programs.py BEFORE AFTER --instructions [--size WxH] [--scene NAME ...] [--aov NAME ...]

Instructions of one sample are counted with valgrind (callgrind): the difference of two renders, one with twice the samples of
the other, so that loading and building are not counted. Those of core's functions alone, because what the program does while it
waits depends on the machine's load. BEFORE and AFTER are paths of the program; each finds its library
beside itself, in ../lib.
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


def scene_file(scene):
    """The description of a bundled scene, or the file itself."""
    return SCENES / scene / f"{scene}.json" if scene in BUNDLED else pathlib.Path(scene)


def render(program, scene, output, flags, prefix=()):
    if prefix:
        with open(shutil.which(program) or program, "rb") as file:
            if file.read(4) != b"\x7fELF":
                sys.exit(f"{program} is a script, of which callgrind counts nothing: name bin/alabaster itself")
    command = [*prefix, program, "render", str(scene_file(scene)), "-o", str(output), "--quiet", *flags]
    done = subprocess.run(command, env=environment(program), capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\nended with {done.returncode}: {done.stderr}")
    return done.stderr


def instructions_of_core(counts):
    """Instructions of core's own functions, without those of the delegate and of libraries."""
    done = subprocess.run(["callgrind_annotate", "--threshold=99.99", str(counts)], capture_output=True, text=True, check=True)
    total = 0
    for line in done.stdout.splitlines():
        found = re.match(r"\s*([\d,]+) \(.*?%\)\s+(.*)", line)
        if found and "alabaster::" in found[2] and "alabaster::hd::" not in found[2].split("(")[0]:
            total += int(found[1].replace(",", ""))
    return total


def instructions_per_sample(scene, program, folder, size, more_flags=()):
    """Instructions of one camera sample in one thread, without AOVs."""
    (width, height), few = size, 4
    totals = []
    for samples in (few, 2 * few):
        flags = ["--size", f"{width}x{height}", "--spp", str(samples), "--threads", "1", *more_flags]
        prefix = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder / 'callgrind.out'}"]
        render(program, scene, folder / "cost.exr", flags, prefix)
        totals.append(instructions_of_core(folder / "callgrind.out"))
    return (totals[1] - totals[0]) / (width * height * few)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--instructions", action="store_true", required=True)
    parser.add_argument("--scene", action="append", choices=BUNDLED, help="only this scene; may be repeated")
    parser.add_argument("--aov", action="append", default=[], help="AFTER renders it, too (BEFORE and AFTER may be one program)")
    add_size(parser)
    arguments = parser.parse_args()
    require(arguments.before, arguments.after, "valgrind", "callgrind_annotate")
    with tempfile.TemporaryDirectory() as name:
        print("| scene | before: instructions a sample | after | after / before |\n|--|--|--|--|")
        for scene in arguments.scene or BUNDLED:
            flags = [word for aov in arguments.aov for word in ("--aov", aov)]
            before, after = (instructions_per_sample(scene, program, pathlib.Path(name), arguments.size, more)
                             for program, more in ((arguments.before, ()), (arguments.after, flags)))
            print(f"| {scene} | {before:.0f} | {after:.0f} | {after / before:.3f} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
