#!/usr/bin/env python3
"""Tests door_abi.py with changes of the header that it must let pass or must find."""
import pathlib
import re
import shutil
import tempfile
import unittest

import door_abi

HERE = pathlib.Path(__file__).resolve().parent
HEADER = door_abi.door_text(HERE.parents[1] / "delegate/c_api/alabaster.h")


@unittest.skipUnless(shutil.which("abidiff"), "abidiff is missing (Debian's abigail-tools)")
class DoorAbi(unittest.TestCase):
    def changes(self, pattern, replacement):
        text, count = re.subn(pattern, replacement, HEADER, count=1, flags=re.M)
        self.assertEqual(count, 1, pattern)
        with tempfile.TemporaryDirectory() as folder:
            header = pathlib.Path(folder) / "alabaster.h"
            header.write_text(text)
            return door_abi.compare(header, HERE / "door_abi.xml")

    def test_additions_at_the_end_pass(self):
        self.assertEqual(self.changes(r"^} AlabasterApi;", "  int (*more)(void);\n} AlabasterApi;"), [])
        self.assertEqual(self.changes(r"^} AlabasterFrame;", "  int32_t more, still_more;\n} AlabasterFrame;"), [])

    def test_everything_else_is_found(self):
        for pattern, replacement in [
                (r"^  AlabasterStatus \(\*scene_clear\)", r"  int (*more)(void);\n\g<0>"),  # in the middle
                (r"(\(\*scene_clear\)\(AlabasterScene\*)\)", r"\1, int32_t all)"),  # an argument
                (r"^  int32_t window_policy;.*\n", ""),
                (r"^  double fraction;", "  float fraction;"),
                (r"^} AlabasterParameter;", "  int32_t more;\n} AlabasterParameter;")]:  # stands in arrays
            self.assertNotEqual(self.changes(pattern, replacement), [], pattern)


if __name__ == "__main__":
    unittest.main()
