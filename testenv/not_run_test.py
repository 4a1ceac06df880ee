#!/usr/bin/env python3
"""The last lines of a run of tests name each test that did not run, with the option that runs it or the reason."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

JUNIT = """<testsuite>
<testcase name="ran"><system-out>statistical tests: 3, to run again: 1, chance of a false alarm: 1e-9
a_test.cpp:1: Skipped
no assets

[  SKIPPED ] A.B (0 ms)
</system-out></testcase>
<testcase name="slurm"><skipped/><system-out>skipped: no Slurm</system-out></testcase>
</testsuite>"""


def test(name, *labels):
    return {"name": name, "properties": [{"name": "LABELS", "value": list(labels)}]}


class NotRun(unittest.TestCase):
    def test_every_test_that_did_not_run_has_a_reason(self):
        tests = [test("ran", "fast"), test("slurm", "host"), test("other", "fast"), test("blender", "host"), test("days", "nightly"),
                 test("statistical_tests_NOT_BUILT", "long"), *(test(f"many{i}", "long") for i in range(20))]
        with tempfile.TemporaryDirectory() as folder:
            junit, every = pathlib.Path(folder) / "junit.xml", pathlib.Path(folder) / "every.json"
            junit.write_text(JUNIT)
            every.write_text(json.dumps({"tests": tests}))
            said = subprocess.run([sys.executable, pathlib.Path(__file__).with_name("not_run.py"), junit, every], capture_output=True,
                                  text=True, check=True).stdout.splitlines()
        long_ones = ", ".join(["statistical_tests", *(f"many{i}" for i in range(11))])
        self.assertEqual(said, [
            "statistical tests: 3, of which 1 ran again; chance that other random numbers fail one of them: 1e-09",
            "not run: A.B (no assets)",
            "not run: slurm (no Slurm)",
            "not run: other (not chosen)",
            "not run: blender (--hosts installs what they need and runs them)",
            "not run: days (--nightly runs them, for hours)",
            f"not run: {long_ones}, 9 more (--long runs them)",
            "not run: Debian 12 and 13 from bare (--systems)"])


if __name__ == "__main__":
    unittest.main()
