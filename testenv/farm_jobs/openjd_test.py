#!/usr/bin/env python3
"""Renders a frame as a job of Open Job Description with its own runner, and compares it with one machine's.

  openjd_test.py PROGRAM          as ctest runs it; skipped where the program openjd is missing
pip install openjd-cli installs it. Exit code 77: skipped.
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

from slurm_test import HOSTILE, LOOK, SCENE, SKIPPED, check, run

TASKS = 4


# promise: farm.engine.openjd
def main():
    if not shutil.which("openjd"):
        print("skipped: openjd not found: pip install openjd-cli")
        sys.exit(SKIPPED)
    program = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as place:
        folder, frame, whole = (pathlib.Path(place) / name for name in (HOSTILE, "frame.exr", "whole.exr"))
        run(program, "farm", SCENE, "-o", frame, *LOOK, "--tasks", TASKS, "--engine", "openjd", "--folder", folder)
        template = folder / "template.json"
        run("openjd", "check", template)
        told = run("openjd", "summary", template)
        check(f"Total tasks: {TASKS + 1}" in told, f"openjd finds {TASKS} tasks and a merge")
        run("openjd", "run", template, "--step", "render", "--task-param", "Part=2")
        parts = sorted(part.name for part in folder.glob("part.*"))
        check(parts == ["part.00002.checkpoint"], "a task renders its part alone")
        merged = subprocess.run(["openjd", "run", template, "--step", "merge", "--no-run-dependencies"], capture_output=True)
        check(merged.returncode != 0 and not frame.exists(), "a merge that lacks parts fails")
        run("openjd", "run", template, "--step", "merge", "--run-dependencies")
        check(frame.exists(), "the merge runs after the tasks")
        run(program, "render", SCENE, "-o", whole, *LOOK)
        run("oiiotool", frame, whole, "--fail", "0", "--warn", "0", "--diff")
        print("holds: all layers have the bits of one machine's")


if __name__ == "__main__":
    main()
