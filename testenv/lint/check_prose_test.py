#!/usr/bin/env python3
"""Tests check_prose.py on sample texts."""
import unittest

from check_prose import faults


def kinds(path, text):
    return [fault.split(": ", 1)[1] for fault in faults(path, text)]


class Comments(unittest.TestCase):
    def test_openers(self):
        for word in ("Of", "Its", "Whether", "That", "What", "Ditto"):
            self.assertEqual(len(kinds("a.h", f"/// {word} a mesh is closed.\nint a;\n")), 1, word)
            self.assertEqual(len(kinds("a.cpp", f"int a;  // {word} a mesh is closed\n")), 1, word)
            self.assertEqual(len(kinds("a.py", f'"""{word} a mesh is closed."""\n')), 1, word)
            self.assertEqual(len(kinds("a.sh", f"#!/bin/sh\n# {word} a mesh is closed.\n")), 1, word)
        self.assertEqual(kinds("a.h", "/// Offsets of rays. Its sign is that of the normal.\nint a;\n"), [])
        self.assertEqual(len(kinds("a.h", "/// Offsets of rays. What is\n/// left is zero.\nint a;\n")), 1)
        self.assertEqual(kinds("a.h", "// What does it cost?\nint a;\n"), [])

    def test_strings_are_no_comments(self):
        self.assertEqual(kinds("a.cpp", 'f("https://example.org // What it is");  // a page\n'), [])
        self.assertEqual(kinds("a.cpp", 'f(R"(// What it is)");\n'), [])

    def test_banned_phrases_in_comments_and_joined_strings(self):
        self.assertEqual(kinds("a.cpp", "// The time is foretold.\n"), ["holds 'foretold'"])
        self.assertEqual(kinds("a.cpp", 'f("so what there "\n  "is is kept");\n'), ["holds 'what there is'"])
        self.assertEqual(kinds("a.py", 'print("nothing is foretold")\n'), ["holds 'foretold'"])
        self.assertEqual(kinds("a.json", '{"description": "Begins anew."}\n'), ["holds 'anew'"])

    def test_lines_that_a_formatter_broke(self):
        full = "// " + "word " * 23 + "end"
        self.assertEqual(kinds("a.cpp", f"{full}\n// of\n// the rest of it.\n"), ["line breaks early"])
        self.assertEqual(kinds("a.cpp", f"{full}\n// of the rest of it.\n"), [])
        self.assertEqual(kinds("a.cpp", f"{full}\n// here:\n//   a list\n"), [])


class Pages(unittest.TestCase):
    def test_sentences(self):
        self.assertEqual(len(kinds("a.md", "# What it does\n\nRays. Whether they\nhit is counted.\n")), 2)
        self.assertEqual(len(kinds("a.md", "| a | b |\n|--|--|\n| 1 | What it is |\n")), 1)
        self.assertEqual(kinds("a.md", "That is a ray. Its origin is `o`.\n\n```\nWhat it prints\n```\n"), [])


if __name__ == "__main__":
    unittest.main()
