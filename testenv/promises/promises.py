#!/usr/bin/env python3
"""Runs the claims of the documents at a reduced size: one row of promises.toml each.

  python3 testenv/promises/promises.py [--program PATH] [--tier fast|long] [--row NAME ...] [--wrong] [--list]

A row has a name, the `document` and the `claim` in its words, a `command` for sh and a `bound`. Every number of the last line that the
command prints must lie in the bound: "== 0", "<= 0.2", ">= 8" or "0.9 .. 1.1". Rows of tier `long` take longer than a few seconds.
`wrong` has an old and a new text: with --wrong each command is run with the new text in the place of the old, must still end well, and its
numbers must miss the bound, which shows that the row can fail. Rows with `because` are not run, for that reason.

A command runs in an empty folder of its own. It finds the program as `alabaster`, measure.py as `measure`, and the variables $scenes
(testenv/scenes), $source (the repository), $build (the folder of the program's build) and $shared (a folder for all rows of a run).
"""
import argparse
import os
import pathlib
import re
import resource
import shlex
import subprocess
import sys
import tempfile
import tomllib
from typing import NamedTuple

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TABLE = HERE / "promises.toml"
FIELDS = {"name", "document", "claim", "command", "bound", "wrong", "tier", "because"}
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?"


class Row(NamedTuple):
    name: str
    document: str
    claim: str
    command: str = ""
    bound: str = ""
    wrong: tuple = ()
    tier: str = "fast"
    because: str = ""


def holds(bound, value):
    """True if a number lies in a bound."""
    if match := re.fullmatch(rf"({NUMBER}) \.\. ({NUMBER})", bound):
        return float(match[1]) <= value <= float(match[2])
    match = re.fullmatch(rf"(==|<=|>=) ({NUMBER})", bound)
    limit = float(match[2])
    return {"==": value == limit, "<=": value <= limit, ">=": value >= limit}[match[1]]


def is_bound(text):
    return re.fullmatch(rf"(?:==|<=|>=) {NUMBER}|{NUMBER} \.\. {NUMBER}", text) is not None


def in_words(text):
    """Without line ends, so that a claim may be found where its lines break."""
    return " ".join(text.split())


def faults_of(row, values, documents):
    """The faults of a row of the table, as sentences."""
    faults = [f"unknown field {field}" for field in values.keys() - FIELDS]
    if in_words(row.claim) not in documents(row.document):
        faults.append(f"{row.document} no longer says: {row.claim}")
    if row.because:
        return faults + (["it has a reason not to be run, and a command"] if row.command else [])
    if not is_bound(row.bound):
        faults.append(f"bound {row.bound!r} is none of '== x', '<= x', '>= x', 'x .. y'")
    if row.tier not in ("fast", "long"):
        faults.append(f"tier {row.tier!r} is neither fast nor long")
    if len(row.wrong) != 2 or row.wrong[0] not in row.command:
        faults.append("wrong must be a text of the command and another one")
    return faults


def read_table(file=TABLE):
    """The rows, after all of them have been checked."""
    read = {}

    def documents(name):
        if name not in read:
            read[name] = in_words((ROOT / name).read_text())
        return read[name]

    rows, faults = [], []
    for values in tomllib.loads(file.read_text())["promise"]:
        row = Row(**{key: tuple(value) if key == "wrong" else value for key, value in values.items() if key in FIELDS})
        faults += [f"{row.name}: {fault}" for fault in faults_of(row, values, documents)]
        faults += [f"{row.name}: the name is used twice"] if row.name in {other.name for other in rows} else []
        rows.append(row)
    if faults:
        sys.exit("\n".join(faults))
    return rows


class Result(NamedTuple):
    numbers: list
    output: str
    cpu: float


def run(command, program, shared):
    """Runs a command; numbers are None where it failed."""
    with tempfile.TemporaryDirectory() as folder:
        binaries = pathlib.Path(folder) / "bin"
        work = pathlib.Path(folder) / "work"
        binaries.mkdir(), work.mkdir()
        (binaries / "measure").write_text(f"#!/bin/sh\nexec {shlex.join([sys.executable, '-B', str(HERE / 'measure.py')])} \"$@\"\n")
        (binaries / "measure").chmod(0o755)
        (binaries / "alabaster").write_text(f"#!/bin/sh\nexec {shlex.quote(str(program))} \"$@\"\n")
        (binaries / "alabaster").chmod(0o755)
        environment = {**os.environ, "PATH": f"{binaries}:{os.environ['PATH']}", "scenes": str(ROOT / "testenv/scenes"), "source": str(ROOT),
                       "build": str(program.parents[1]), "shared": str(shared), "python": sys.executable, "LC_ALL": "C"}
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        process = subprocess.run(["sh", "-euc", command], cwd=work, env=environment, capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    lines = process.stdout.strip().splitlines()
    words = lines[-1].split() if lines else []
    good = process.returncode == 0 and words and all(re.fullmatch(NUMBER, word) for word in words)
    output = process.stdout + process.stderr + (f"exit code {process.returncode}\n" if process.returncode else "")
    return Result([float(word) for word in words] if good else None, output,
                  after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def verdict(row, result, wrong):
    """None where the row is as it should be, else why not."""
    if result.numbers is None:
        return "the command failed or printed no numbers:\n" + result.output
    met = all(holds(row.bound, number) for number in result.numbers)
    if met == wrong:
        return "the wrong command meets the bound, so the row cannot fail" if wrong else "out of bounds"
    return None


def run_rows(rows, program, wrong):
    """The number of rows that are not as they should be."""
    bad, cpu = 0, 0.0
    with tempfile.TemporaryDirectory() as shared:
        for row in rows:
            result = run(row.command.replace(*row.wrong) if wrong else row.command, program, shared)
            problem = verdict(row, result, wrong)
            numbers = " ".join(f"{number:g}" for number in result.numbers or [])
            print(f"{'BAD ' if problem else 'good'} {row.name}: {numbers} ({'must miss' if wrong else 'bound'} {row.bound}, {result.cpu:.1f} s)", flush=True)
            if problem:
                print(f"     {row.document}: {row.claim}\n     {problem}", flush=True)
            bad, cpu = bad + (problem is not None), cpu + result.cpu
    print(f"{len(rows)} promises, {bad} bad, {cpu:.1f} CPU seconds")
    return bad


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/bin/alabaster")
    parser.add_argument("--tier", choices=("fast", "long"), default="fast")
    parser.add_argument("--row", nargs="+", help="these rows alone, whatever their tier")
    parser.add_argument("--wrong", action="store_true", help="show that the rows can fail")
    parser.add_argument("--list", action="store_true", help="print the table and run nothing")
    options = parser.parse_args()
    rows = read_table()
    if options.list:
        for row in rows:
            print(f"{row.name} ({row.because or row.tier + ', ' + row.bound}): {row.document}: {row.claim}")
        return 0
    for name in options.row or []:
        if name not in {row.name for row in rows}:
            sys.exit(f"{TABLE} has no row {name}; --list prints their names")
    chosen = [row for row in rows if not row.because and (row.name in options.row if options.row else row.tier == options.tier)]
    return 1 if run_rows(chosen, options.program.resolve(), options.wrong) else 0


if __name__ == "__main__":
    sys.exit(main())
