#!/usr/bin/env python3
"""Prints what a run of ctest left out and why, and how sure its statistical tests are.

  not_run.py JUNIT EVERY     files of ctest's --output-junit, and of --show-only=json-v1 with -C nightly
"""
import json
import os
import pathlib
import re
import sys
from xml.etree import ElementTree

SHOWN = 12  # names of tests that were not chosen
STATISTICS = re.compile(r"^statistical tests: (\d+), to run again: (\d+), chance of a false alarm: (\d\S*)$", re.M)
SKIPPED = re.compile(r"^\S+:\d+: Skipped\n((?:.+\n)*?)\n?\[  SKIPPED \] (\S+) \(\d+ ms\)$", re.M)  # of GoogleTest
NOT_BUILT = "_NOT_BUILT"  # discover_suites.cmake
RUN_BY = {"long": "--long runs them", "host": "--hosts installs what they need and runs them", "nightly": "--nightly runs them, for hours"}


def unchosen_reason(test):
    labels = [label for entry in test.get("properties", []) if entry["name"] == "LABELS" for label in entry["value"]]
    return next((RUN_BY[label] for label in labels if label in RUN_BY), "not chosen")


def main():
    junit, every = map(pathlib.Path, sys.argv[1:])
    if not junit.exists():
        return
    started, left_out, statistics = set(), {}, [0, 0, 0.0]
    for case in ElementTree.parse(junit).getroot().iter("testcase"):
        output = (case.findtext("system-out") or "").strip()
        started.add(case.get("name"))
        if case.find("skipped") is not None:
            reason = output.splitlines()[-1].removeprefix("skipped: ") if output else "no reason given"
            left_out.setdefault(reason, []).append(case.get("name"))
        for reason, test in SKIPPED.findall(output):
            left_out.setdefault(" ".join(reason.split()), []).append(test)
        for found in STATISTICS.findall(output):
            statistics = [sum(pair) for pair in zip(statistics, map(float, found))]
    unchosen = {}
    for test in json.loads(every.read_text())["tests"]:
        if test["name"] not in started:
            unchosen.setdefault(unchosen_reason(test), []).append(test["name"].removesuffix(NOT_BUILT))
    for reason, names in unchosen.items():
        more = [f"{len(names) - SHOWN} more"] if len(names) > SHOWN else []
        left_out.setdefault(reason, []).extend(names[:SHOWN] + more)
    if statistics[0]:
        print("statistical tests: {:.0f}, of which {:.0f} ran again; chance that other random numbers fail one of them: {:.2g}".format(*statistics))
    for reason, names in left_out.items():
        print(f"not run: {', '.join(names)} ({reason})")
    if not os.environ.get("SYSTEMS_RAN"):
        print("not run: Debian 12 and 13 from bare (--systems)")


if __name__ == "__main__":
    main()
