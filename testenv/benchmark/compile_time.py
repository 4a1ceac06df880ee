#!/usr/bin/env python3
"""Measures what the program of a checkout costs to compile, without ccache.

  compile_time.py CHECKOUT [CHECKOUT ...] [--jobs N]

Each checkout is configured as testenv/quickstart.sh does, and its target alabaster is built in a temporary folder. A row tells the CPU
seconds of the objects of delegate/ and of core/, and the wall seconds. Nothing else should run on the machine.
"""
import argparse
import collections
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

LOG = "ALABASTER_COMPILE_LOG"


def compile_one(command):
    """As CMake's launcher of the compiler: runs it, and notes the object and its CPU seconds."""
    code = subprocess.run(command).returncode
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    if LOG in os.environ:
        with open(os.environ[LOG], "a") as log:
            log.write(json.dumps([command[command.index("-o") + 1], used.ru_utime + used.ru_stime]) + "\n")
    return code


def measure(checkout, jobs):
    with tempfile.TemporaryDirectory() as folder:
        log = pathlib.Path(folder) / "objects"
        subprocess.run(["cmake", "-S", checkout, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DALABASTER_TESTS=OFF",
                        "-DALABASTER_BENCHMARKS=OFF", "-DALABASTER_CCACHE=NO",
                        f"-DCMAKE_CXX_COMPILER_LAUNCHER={sys.executable};{os.path.abspath(__file__)};--object"],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        begun = time.monotonic()
        subprocess.run(["cmake", "--build", folder, "-j", str(jobs), "--target", "alabaster"], check=True, stdout=subprocess.DEVNULL,
                       env={**os.environ, LOG: str(log)})
        wall, rooms = time.monotonic() - begun, collections.Counter()
        for line in log.read_text().splitlines():
            name, seconds = json.loads(line)
            rooms[name.split("/")[0]] += seconds
    revision = subprocess.run(["git", "-C", checkout, "rev-parse", "--short", "HEAD"], check=True, capture_output=True, text=True)
    print(f"| {revision.stdout.strip()} | {rooms['delegate']:.0f} | {rooms['core']:.0f} | {wall:.0f} |", flush=True)


def main():
    if sys.argv[1:2] == ["--object"]:
        return compile_one(sys.argv[2:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkouts", nargs="+")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    print("| revision | delegate, CPU s | core, CPU s | wall, s |\n| --- | --- | --- | --- |", flush=True)
    for checkout in options.checkouts:
        measure(checkout, options.jobs)


if __name__ == "__main__":
    sys.exit(main())
