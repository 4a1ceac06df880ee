#!/usr/bin/env python3
"""Measures how long a host waits for the delegate, beside what it should wait at most, in one table.

  latency_table.py PROGRAMS [--repeats N] [--cancels N] > testenv/benchmark/results/latency.md

PROGRAMS is the folder with edit_latency, viewport_latency and cancel_latency, whose 100 repeats of each build take 20 minutes. The machine
has to be idle: two threads render throughout, and the host and the builder compute beside them.
"""
import argparse
import os
import pathlib
import platform
import re
import subprocess
import sys

from compare_programs import require_benchmark

SCENE = "testenv/scenes/skin_closeup/skin_closeup.json"
EDIT_COLUMNS = {"host's thread held": 1, "rendered": 3, "frame covered": 5}  # of edit_latency: the p50; the p99 follows
EDITS = [
    "nothing", "camera moved", "transform of a prim", "transform of a body", "constant of the bodies' material", "light moved", "dome turned",
    "points of a body, 12,288 triangles", "points of the hero, 196,608 triangles", "subsets of the hero", "one of 1000000 instances",
    "one of 1000000 instances, by a new array of all", "everything synced again"]
HELD = {name: 5 for name in EDITS[1:-1]} | {"nothing": 1}
RENDERED = {"one of 1000000 instances": 20}
COVERED = {"camera moved": 50, "constant of the bodies' material": 60, "light moved": 60, "dome turned": 60}
VIEWPORT = {
    "five AOVs resolved, stopped": 5, "five AOVs resolved again, 1 ms later": None, "five AOVs resolved, while rendering": None,
    "Restart and Execute": None, "Stop": None}
CANCELLED = 20


def run(*command):
    print(" ".join(map(str, command)), file=sys.stderr, flush=True)
    text = subprocess.run(list(map(str, command)), check=True, stdout=subprocess.PIPE, text=True).stdout
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if re.match(r"\|.*\d", line)]
    return {row[0]: row for row in rows if re.fullmatch(r"[\d.]+", row[-1])}, text


def print_row(what, p50, p99, goal, of=None):
    verdict = "" if goal is None else f"{goal} | {'yes' if float(of or p99) <= goal else 'no'}"
    print(f"| {what} | {p50} | {p99} | {verdict or '|'} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("--repeats", type=int, default=100, help="of edits and of what a viewport asks for")
    parser.add_argument("--cancels", type=int, default=100, help="of builds that are cancelled")
    arguments = parser.parse_args()
    if min(arguments.repeats, arguments.cancels) < 1:
        parser.error("--repeats and --cancels must be 1 or more")
    for program in ("edit_latency", "viewport_latency", "cancel_latency"):
        require_benchmark(arguments.programs / program)
    edits, told = run(arguments.programs / "edit_latency", "--edits", arguments.repeats)
    viewport, resolved = run(arguments.programs / "viewport_latency", SCENE, 1280, 720, 2, arguments.repeats)
    print(f"""# How long a host waits

`testenv/benchmark/latency_table.py PROGRAMS --repeats {arguments.repeats} --cancels {arguments.cancels}` on {os.cpu_count()} cores ({platform.machine()}), in ms. Two threads render at
1280 x 720 throughout. The scene of the edits has 1e6 triangles of bodies that scatter, 1000 more prims, a dome of 4096 x 2048 texels
and an instancer of 1,000,000 points. "Rendered" ends where Execute has taken the new scene up; the host asks each millisecond. A frame is covered where each pixel
shows the new scene, by a sample of its own or of a neighbour in its block. All is synced again 20 times at most. Goals are of the p99,
but for resolving, whose goal is of the p50.

| what | p50 | p99 | goal | reached |
|---|---|---|---|---|""")
    for column, goals in zip(EDIT_COLUMNS, (HELD, RENDERED, COVERED)):
        for name in EDITS:
            if column == "host's thread held" or name != "nothing":
                at = EDIT_COLUMNS[column]
                print_row(f"{column}: {name}", edits[name][at], edits[name][at + 1], goals.get(name))
    for name, goal in VIEWPORT.items():
        print_row(name, viewport[name][1], viewport[name][2], goal, of=viewport[name][1])
    cancelled, _ = run(arguments.programs / "cancel_latency", "--repeats", arguments.cancels)
    for name, row in cancelled.items():
        print_row(f"newer scene in place of a build of {name} ({row[1]} ms)", row[2], row[3], CANCELLED)
    for text in (told, resolved):
        print("\n" + text.strip().splitlines()[-1])


if __name__ == "__main__":
    main()
