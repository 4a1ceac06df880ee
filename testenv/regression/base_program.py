#!/usr/bin/env python3
"""Builds the program of the commit that the file BASE names, for pictures_of_base.py.

  base_program.py           prints the program's path, or how to build it
  base_program.py --build   builds it, if it is not there yet

It is kept in the folder that the environment variable ALABASTER_BASE_CACHE names, by default alabaster-base in the user's
cache folder, so that each BASE is built once. Needs git, and a checkout whose history holds the commit.
"""
import argparse
import fnmatch
import os
import pathlib
import shutil
import subprocess
import sys
from typing import NamedTuple

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parents[1]
WORDS = ("random", "different")


class Base(NamedTuple):
    """The content of BASE: a commit, and the differences from it that are announced, as (word, glob of runs)."""
    commit: str
    announced: tuple

    def word(self, run):
        """"random" or "different" where BASE announces a difference of this run, else None."""
        return next((word for word, glob in self.announced if fnmatch.fnmatch(run, glob)), None)

    @property
    def folder(self):
        user = os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache"
        return pathlib.Path(os.environ.get("ALABASTER_BASE_CACHE") or pathlib.Path(user) / "alabaster-base") / self.commit

    @property
    def program(self):
        return self.folder / "source/build/release/bin/alabaster"


def read_base(text):
    lines = [line.split("#")[0].split() for line in text.splitlines()]
    lines = [line for line in lines if line]
    if not lines or len(lines[0]) != 1 or any(len(line) != 2 or line[0] not in WORDS for line in lines[1:]):
        sys.exit(f"{HERE / 'BASE'}: expected a commit, then lines 'random GLOB' or 'different GLOB'")
    return Base(lines[0][0], tuple((word, glob) for word, glob in lines[1:]))


def build(base):
    source = base.folder / "source"
    built = source / "build/release"  # where developers have it, so that ccache finds what they compiled
    shutil.rmtree(source, ignore_errors=True)
    source.mkdir(parents=True)
    archive = subprocess.run(["git", "-C", str(TOP), "archive", base.commit], capture_output=True)
    if archive.returncode:
        sys.exit(f"The history of {TOP} has no commit {base.commit}: git fetch --unshallow")
    subprocess.run(["tar", "-x", "-C", str(source)], input=archive.stdout, check=True)
    subprocess.run(["cmake", "-S", str(source), "-B", str(built), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DALABASTER_TESTS=OFF",
                    "-DALABASTER_BENCHMARKS=OFF", f"-DALABASTER_WERROR={'ON' if os.environ.get('CI') else 'OFF'}"], check=True)
    subprocess.run(["cmake", "--build", str(built), "--target", "alabaster"], check=True)
    for file in built.rglob("*.o"):
        file.unlink()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", action="store_true")
    arguments = parser.parse_args()
    base = read_base((HERE / "BASE").read_text())
    if arguments.build and not base.program.exists():
        build(base)
    print(base.program if base.program.exists() else f"not built: run {pathlib.Path(__file__).resolve()} --build")
    return 0 if base.program.exists() else 1


if __name__ == "__main__":
    sys.exit(main())
