#!/usr/bin/env python3
"""Tests what contact_sheet.py concludes from a render and reads from the catalogue."""
import pathlib
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import contact_sheet  # noqa: E402
from pictures import Picture  # noqa: E402


def verdict(code, *messages):
    return contact_sheet.Result("box.glb", code, list(messages), 0, pathlib.Path("box.png")).verdict


class ContactSheet(unittest.TestCase):
    def test_only_a_named_feature_counts_as_refused(self):
        self.assertEqual(verdict(0), "rendered")
        self.assertEqual(verdict(0, "warning: a", "warning: b"), "rendered, 2 warnings")
        self.assertEqual(verdict(3, "error: EXT_x is not supported; re-export without it"), "refused")
        self.assertEqual(verdict(3, "error: the buffer is too short"), "failed (3)")
        self.assertEqual(verdict(-11), "failed (-11)")
        self.assertEqual(verdict(4, "warning: x is not supported"), "failed (4)")

    def test_the_catalogue_says_what_a_file_should_show(self):
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "CATALOGUE.md").write_text(
                "| file | exercises | correct render shows |\n|---|---|---|\n| `valid/a.glb` | boxes | a box | 12 |\n")
            self.assertEqual(contact_sheet.read_catalogue(pathlib.Path(folder)), {"valid/a.glb": "a box"})

    def test_means_are_ours_over_theirs_and_blocks_are_relative(self):
        flat = Picture(16, 8, [[0.5] * 128, [0.25] * 128, [0.75] * 128])
        left_brighter = Picture(16, 8, [([v * 1.5] * 8 + [v] * 8) * 8 for v in (0.5, 0.25, 0.75)])
        ratios, blocks = contact_sheet.compare(left_brighter, flat)
        self.assertEqual(ratios, [1.25, 1.25, 1.25])
        self.assertAlmostEqual(blocks, ((0.25**2 + 0.125**2 + 0.375**2) / 6) ** 0.5 / 0.5)


if __name__ == "__main__":
    unittest.main()
