#!/usr/bin/env python3
"""Each flag of the program's commands, and what must differ when it is given: pixels, statistics, files, exit codes.

  flags_table.py PROGRAM [--oidn LIBRARY] [--only REGEX] [--minute]

A flag that --help lists without a row fails. Commands tradeoff, farm and view have tests of their own (testenv/unit/delegate/tradeoff,
testenv/unit/delegate/cli/farm_test.cpp, testenv/view), and so have flags of stages, which need OpenUSD (testenv/usd). --minute tests that a checkpoint is written each minute instead.
"""
import argparse
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

from flag_rows import CODES, TABLES
from flag_runs import Runs
from flag_scenes import write_flag_scenes

FLAG = re.compile(r"^  (?:-\w,)?(--[a-z-]+)", re.M)
OF_STAGES = pathlib.Path(__file__).resolve().parents[1] / "usd" / "usd_test.py"


def faults_of(run, flag, row):
    before, after = run(*row.first, row.plain), run(*row.first, row.changed())
    try:
        if row.holds(before, after):
            return []
        why = "has not the effect of its row"
    except Exception as error:  # a file or a number is missing
        why = f"has not the effect of its row: {type(error).__name__}: {error}"
    return [f"{row.plain[0]} {flag}: {' '.join(row.words)} {why}\n  exit codes {before.code}, {after.code}; {after.err.strip()[-300:]}"]


def faults(run, arguments):
    of_stages = set(re.findall(r'"(--[a-z-]+)"', OF_STAGES.read_text()))
    for command, rows in TABLES.items():
        listed = set(FLAG.findall(run((command, "--help")).out)) - {"--help"} - (of_stages - rows.keys())
        yield from (f"{command} {flag}: there is no row for this flag" for flag in sorted(listed - rows.keys()))
        yield from (f"{command} {flag}: there is no such flag" for flag in sorted(rows.keys() - listed))
        for flag in sorted(listed & rows.keys()):
            for row in rows[flag]:
                if re.search(arguments.only, f"{command} {flag}"):
                    yield from faults_of(run, flag, row)
    for words, code in CODES:
        if re.search(arguments.only, " ".join(words)) and run(words).code != code:
            yield f"{' '.join(words)}: exit code {run(words).code}, expected {code}: {run(words).err.strip()}"


def faults_of_a_minute(run):
    """The render is stopped while time goes by, so that the minute costs no CPU time."""
    file = run.scenes / "c.checkpoint"
    process = subprocess.Popen([run.program, "render", "model.glb", "-o", "a.exr", "--size", "24x16", "--spp", "1000000", "--quiet",
                                "--threads", "1", "--checkpoint", file.name], cwd=run.scenes)
    try:
        for seconds, expected in ((50, False), (12, True)):
            time.sleep(1)
            process.send_signal(signal.SIGSTOP)
            time.sleep(seconds)
            process.send_signal(signal.SIGCONT)
            time.sleep(2)
            if file.exists() != expected:
                yield f"render --checkpoint: {'no' if expected else 'a'} checkpoint after about {seconds + (55 if expected else 3)} seconds"
    finally:
        process.kill()
        process.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--oidn", help="a library in the place of Open Image Denoise")
    parser.add_argument("--only", default="", metavar="REGEX", help="of COMMAND FLAG")
    parser.add_argument("--minute", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        scenes = pathlib.Path(name) / "scenes"
        scenes.mkdir()
        write_flag_scenes(scenes)
        run = Runs(str(arguments.program.resolve()), scenes, pathlib.Path(name), {"ALABASTER_OIDN": arguments.oidn or ""})
        found = list(faults_of_a_minute(run) if arguments.minute else faults(run, arguments))
    passed = "the minute holds" if arguments.minute else f"{sum(len(rows) for rows in TABLES.values())} flags have the effects of their rows"
    print("\n".join(found) if found else passed)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
