#!/usr/bin/env python3
"""Goes through the inputs of public bug reports, each by the right answer of its folder's README; prints a table.

  python3 testenv/reports/reports.py PROGRAM [--assets FOLDER] [--module FOLDER] [--only REGEX] [--jobs N]

--assets   holds reports/, reports2/, reports3/ and attack/ (default: $ALABASTER_TEST_ASSETS; without it the test is skipped)
--module   holds the Python module, which some rows need (default: PYTHONPATH)

A row renders files of its folder, or files that it writes, and compares what the fault would change with the right
answer. Rows that need the module are skipped without it. The exit code is 1 if a row is wrong, 77 if there are no inputs.
"""
import argparse
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import traceback

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
SKIPPED = 77
try:
    from measures import Lab, Skipped, Wrong
    from attack_rows import ATTACK_ROWS
    from later_rows import LATER_ROWS
    from rows import ROWS
except ModuleNotFoundError as missing:
    print(f"skipped: this Python has no {missing.name}")
    sys.exit(SKIPPED)


def outcome(row, arguments):
    """(row, verdict): "right", or the text of a wrong answer or an exception."""
    folder = next(iter((arguments.assets / row.round).glob(row.folder + "*")), None)
    if folder is None:
        return row, f"WRONG: {row.round}/{row.folder} is missing"
    with tempfile.TemporaryDirectory(prefix="alabaster_reports_") as scratch:
        try:
            row.check(Lab(arguments.program, folder, pathlib.Path(scratch), arguments.module))
        except Wrong as fault:
            return row, f"WRONG: {fault}"
        except Skipped as reason:
            return row, f"skipped: {reason}"
        except (OSError, ValueError, KeyError, IndexError, subprocess.SubprocessError):
            return row, "WRONG: " + traceback.format_exc(limit=-2)
    return row, "right"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--assets", type=pathlib.Path, default=os.environ.get("ALABASTER_TEST_ASSETS"))
    parser.add_argument("--module", default=os.environ.get("PYTHONPATH", ""))
    parser.add_argument("--only", default="", help="rows whose names match")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    if not arguments.assets or not (pathlib.Path(arguments.assets) / "reports").is_dir():
        print("skipped: ALABASTER_TEST_ASSETS names no folder with reports/")
        return SKIPPED
    arguments.assets = pathlib.Path(arguments.assets).resolve()
    rows = [row for row in [*ROWS, *LATER_ROWS, *ATTACK_ROWS] if re.search(arguments.only, row.name)]
    print("| input | measured | right answer | verdict |\n| --- | --- | --- | --- |")
    counts = {"right": 0, "WRONG": 0, "skipped": 0}
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for row, verdict in pool.map(lambda one: outcome(one, arguments), rows):
            counts[verdict.split(":")[0]] += 1
            verdict = verdict.strip().replace("\n", " / ")
            print(f"| {row.name} | {row.measured} | {row.right} | {verdict} |", flush=True)
    print("\n" + ", ".join(f"{count} {verdict}" for verdict, count in counts.items()))
    return 1 if counts["WRONG"] else 0


if __name__ == "__main__":
    sys.exit(main())
