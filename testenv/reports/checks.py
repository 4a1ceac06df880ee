#!/usr/bin/env python3
"""Runs the check of each input of one round of public bug reports; prints a table.

  python3 testenv/reports/checks.py ROUND PROGRAM [--assets FOLDER] [--module FOLDER] [--only REGEX]

ROUND      is the folder of the inputs, such as reports4; each input is a folder with a check.py (its README)
--assets   holds the round (default: $ALABASTER_TEST_ASSETS; without it the test is skipped)
--module   holds the Python module (default: PYTHONPATH); checks that need it are not run without it

The exit code is 1 if an answer is wrong, 77 if there are no inputs.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile

NOT_RUN = 77
VERDICTS = {0: "right", NOT_RUN: "not run"}


def prefix_of(module, scratch):
    """A folder in which the module lies where an installation has it."""
    version = "python%d.%d" % sys.version_info[:2]
    place = scratch / "prefix" / "lib" / version / "dist-packages"
    place.parent.mkdir(parents=True)
    if module and (pathlib.Path(module) / "hdalabaster").is_dir():
        place.symlink_to(pathlib.Path(module).resolve())
    return scratch / "prefix"


def verdict_of(check, program, prefix, out):
    command = [sys.executable, "-B", str(check), str(program), str(prefix), str(out)]
    if re.search(r"^def check\(run\)", check.read_text(), re.M):  # a function, for the runner of a round
        runner = next(r / "run.py" for r in [check.parents[1], *sorted(check.parents[2].iterdir())] if (r / "run.py").exists())
        cases = out.parent / ("only_" + check.parent.name)
        cases.mkdir()
        (cases / check.parent.name).symlink_to(check.parent)
        command = [sys.executable, "-B", str(runner), str(program), "-", str(cases)]
    try:
        run = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", timeout=1200)
    except subprocess.TimeoutExpired:
        return "WRONG", "no answer within 20 minutes"
    lines = (run.stdout + run.stderr).strip().splitlines()[-3:]
    return VERDICTS.get(run.returncode, "WRONG"), " / ".join(lines).replace("|", "\\|")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("round")
    parser.add_argument("program", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--assets", default=os.environ.get("ALABASTER_TEST_ASSETS"))
    parser.add_argument("--module", default=os.environ.get("PYTHONPATH", ""))
    parser.add_argument("--only", default="", help="inputs whose names match")
    arguments = parser.parse_args()
    inputs = pathlib.Path(arguments.assets or "/nonexistent").resolve() / arguments.round
    checks = [check for check in sorted(inputs.glob("*/check.py")) if re.search(arguments.only, check.parent.name)]
    if not checks:
        print(f"skipped: ALABASTER_TEST_ASSETS names no folder with {arguments.round}/")
        return NOT_RUN
    print("| input | verdict | found |\n| --- | --- | --- |")
    counts = {"right": 0, "WRONG": 0, "not run": 0}
    with tempfile.TemporaryDirectory(prefix="alabaster_checks_") as scratch:
        prefix = prefix_of(arguments.module, pathlib.Path(scratch))
        for check in checks:
            verdict, found = verdict_of(check, arguments.program, prefix, pathlib.Path(scratch) / "out")
            counts[verdict] += 1
            print(f"| {check.parent.name} | {verdict} | {found} |", flush=True)
    print("\n" + ", ".join(f"{count} {verdict}" for verdict, count in counts.items()))
    return 1 if counts["WRONG"] else 0


if __name__ == "__main__":
    sys.exit(main())
