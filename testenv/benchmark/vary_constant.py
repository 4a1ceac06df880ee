#!/usr/bin/env python3
"""Measures what other values of a constant of the source would gain: how constants of the sampling are chosen.

  vary_constant.py FILE NAME VALUE [VALUE ...] [-- FLAGS OF noise_gain.py]

  vary_constant.py core/integrator/path.cpp kRouletteBelow 0.25f 0.0625f -- --scene hard_light --seeds 6

Builds the program as it is committed, then with each value in the place of the constant's own, in a clone below --work that
later runs build on. Each is compared with the first by noise_gain.py: a gain above one speaks for the value. FILE is a path from
the top of the repository, and NAME stands there once as `NAME = value`, followed by a comma or a semicolon.
"""
import argparse
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nended with {done.returncode}: {(done.stderr or done.stdout)[-2000:]}")
    return done.stdout


def with_value(text, name, value):
    """The source with another value, or an end with the reason."""
    pattern = re.compile(rf"(\b{re.escape(name)}\s*=(?!=)\s*)([^,;]+)(?=[,;])")
    found = pattern.findall(text)
    if len(found) != 1:
        sys.exit(f"'{name} = value' stands {len(found)} times in the file; it must stand there once")
    return pattern.sub(lambda m: m[1] + value, text), found[0][1]


def build(folder, programs, name):
    """The program of the build, copied with its library."""
    run("ninja", "-C", folder, "alabaster")
    shutil.rmtree(programs / name, ignore_errors=True)
    for kept in ("bin", "lib"):
        shutil.copytree(folder / kept, programs / name / kept, symlinks=True)
    return programs / name / "bin" / "alabaster"


def main():
    mine, theirs = sys.argv[1:], []
    if "--" in mine:
        mine, theirs = mine[:mine.index("--")], mine[mine.index("--") + 1:]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("name")
    parser.add_argument("value", nargs="+")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build" / "vary_constant")
    arguments = parser.parse_args(mine)
    if pathlib.PurePath(arguments.file).is_absolute() or ".." in pathlib.PurePath(arguments.file).parts:
        sys.exit(f"{arguments.file}: give the path from the top of the repository")
    clone, programs = arguments.work / "source", arguments.work / "programs"
    folder = clone / "build" / "release"  # as deep as the usual one, so that ccache knows its files
    if not (clone / ".git").exists():
        run("git", "clone", "--quiet", "--shared", ROOT, clone)
    run("git", "-C", clone, "fetch", "--quiet", "origin")
    run("git", "-C", clone, "checkout", "--quiet", "--force", run("git", "-C", ROOT, "rev-parse", "HEAD").strip())
    run("cmake", "-S", clone, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DALABASTER_TESTS=OFF",
        "-DALABASTER_BENCHMARKS=OFF")
    file = clone / arguments.file
    if not file.is_file():
        sys.exit(f"no file {arguments.file} in the repository")
    text = file.read_text()
    _, own = with_value(text, arguments.name, arguments.value[0])
    before = build(folder, programs, "before")
    try:
        for value in arguments.value:
            file.write_text(with_value(text, arguments.name, value)[0])
            after = build(folder, programs, "after")
            print(f"\n{arguments.name} = {value} instead of {own}:\n", flush=True)
            subprocess.run([sys.executable, HERE / "noise_gain.py", before, after, *theirs], check=True)
    finally:
        file.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
