#!/usr/bin/env python3
"""The stages of public reports by their right answers: wishes.py PROGRAM. They lie in $ALABASTER_TEST_ASSETS/usd, with the check."""
import os
import re
import subprocess
import sys

OPEN = set()


def main():
    check = os.path.join(os.environ.get("ALABASTER_TEST_ASSETS", ""), "usd/check.py")
    if not os.path.exists(check):
        print("skipped: ALABASTER_TEST_ASSETS has no usd/check.py")
        sys.exit(77)
    plain = os.path.join(os.path.dirname(check), "data_window_none.usda")
    probe = subprocess.run([sys.argv[1], "check", plain], capture_output=True, text=True)
    if probe.returncode == 3 and "alabaster usd install" in probe.stderr:
        print("skipped: OpenUSD for Python is not installed (alabaster usd install)")
        sys.exit(77)
    done = subprocess.run([sys.executable, "-B", check, os.path.abspath(sys.argv[1])], capture_output=True, text=True)
    print(done.stdout + done.stderr)
    wrong = {re.match(r"WRONG (.*?)(?: \(|$)", line).group(1) for line in done.stdout.splitlines() if line.startswith("WRONG")}
    assert "of" in done.stdout and wrong == OPEN, "wrong: %s; open are: %s" % (sorted(wrong), sorted(OPEN))


if __name__ == "__main__":
    main()
