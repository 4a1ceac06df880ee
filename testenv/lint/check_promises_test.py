#!/usr/bin/env python3
"""The check of promises finds each kind of orphan, and lets the others through."""
import unittest

from check_promises import check

PAGE = "| code | |\n| --- | --- |\n| 0 | done <!-- id: files.done --> |\n| 2 | usage <!-- id: files.usage --> |\n\nText. <!-- id: files.text -->\n"
CPP = "// promise: files.done, files.usage\n// Another comment.\nTEST_F(A, B) {\n}\n"
PYTHON = "class T:\n    # promise: files.text\n    def test_text(self):\n        pass\n"


def faults(page=PAGE, cpp=CPP, python=PYTHON):
    return check({"manual/files.md": page}, {"a_test.cpp": cpp, "b.py": python})[0]


class Promises(unittest.TestCase):
    def test_promises_with_tests_pass(self):
        self.assertEqual(faults(), [])
        self.assertEqual(faults(python='# promise: files.text\n"--flag": [Row()],\n'), [])

    def test_an_example_is_no_promise(self):
        self.assertEqual(faults(PAGE + "An id is `<!-- id: PAGE.NAME -->`.\n"), [])

    def test_a_promise_without_a_test(self):
        self.assertEqual(faults(python=""), ["manual/files.md:6: no test names 'files.text'"])

    def test_a_test_without_a_promise(self):
        self.assertEqual(faults(cpp=CPP.replace("usage", "usage, files.gone")), ["a_test.cpp:1: no page promises 'files.gone'"])

    def test_a_row_without_an_id(self):
        self.assertEqual(faults(PAGE.replace("\n\nText", "\n| 3 | input |\n\nText")),
                         ["manual/files.md:5: a row without an id in a table of promises"])
        self.assertEqual(faults("| a | b |\n| - | - |\n| no | promise |\n\n" + PAGE), [])

    def test_ids_are_of_their_page_and_once(self):
        self.assertIn("manual/files.md:6: 'other.text' is not files.NAME in small letters", faults(PAGE.replace("files.text", "other.text")))
        self.assertIn("manual/files.md:6: 'files.done' is line 3's, too", faults(PAGE.replace("files.text", "files.done")))

    def test_a_promise_above_no_test(self):
        self.assertEqual(faults(cpp=CPP.replace("TEST_F(A, B) {", "int helper() {")), ["a_test.cpp:1: no test below this promise"])


if __name__ == "__main__":
    unittest.main()
