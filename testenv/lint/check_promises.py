#!/usr/bin/env python3
"""Fails on a promise of the manual without a test, and on a test of a promise that the manual does not make.

A row of a table or a paragraph of delegate/manual that promises behaviour ends with an id, `<!-- id: pipeline.exit.usage -->`. It
begins with the name of its page, and no other has it. A table with an id has one in each row. The tests name it in a comment above them:

  // promise: pipeline.exit.usage, security.time_limit     C++, above TEST, TEST_F or TEST_P
  # promise: pipeline.exit.usage                            Python, above `def` or a row of a table; rows of promises.toml
"""
import pathlib
import re
import sys

ID = re.compile(r"(?<!`)<!-- id: (.*?) -->")
FORM = re.compile(r"[a-z_]+(\.[a-z0-9_]+)+$")
NAMED = re.compile(r"^\s*(?://|#) promise: (.+)$")
COMMENT = re.compile(r"^\s*(?://|#)")
TEST = {".cpp": re.compile(r"^TEST(_F|_P)?\("), ".py": re.compile(r"^\s*(def \w|[\"'(\[{]|\w+ = |add|Row)"), ".toml": re.compile(r"^\w+ = ")}
SEPARATOR = re.compile(r"^\|[\s|:-]+\|$")


def promises_of(name, text):
    """({id: line}, faults) of a page."""
    found, faults, table = {}, [], []

    def end_table():
        rows = [(number, line) for number, line in table if not SEPARATOR.match(line)][1:]
        if any(ID.search(line) for _, line in rows):
            faults.extend(f"{name}:{number}: a row without an id in a table of promises" for number, line in rows if not ID.search(line))
        table.clear()

    for number, line in enumerate([*text.splitlines(), ""], 1):
        if line.startswith("|"):
            table.append((number, line))
        elif table:
            end_table()
        for one in ID.findall(line):
            if not FORM.match(one) or one.split(".")[0] != pathlib.Path(name).stem:
                faults.append(f"{name}:{number}: '{one}' is not {pathlib.Path(name).stem}.NAME in small letters")
            elif one in found:
                faults.append(f"{name}:{number}: '{one}' is line {found[one]}'s, too")
            else:
                found[one] = number
    return found, faults


def tests_of(name, text):
    """([(id, line)], faults) of a file of tests."""
    found, faults, lines = [], [], text.splitlines()
    for number, line in enumerate(lines, 1):
        named = NAMED.match(line)
        if not named:
            continue
        below = next((other for other in lines[number:] if not COMMENT.match(other)), "")
        if not TEST[pathlib.Path(name).suffix].match(below):
            faults.append(f"{name}:{number}: no test below this promise")
        found += [(one, number) for one in named.group(1).split(", ")]
    return found, faults


def check(pages, tests):
    """Faults of {name: text} of pages and of tests."""
    made, kept, faults = {}, set(), []
    for name, text in pages.items():
        found, wrong = promises_of(name, text)
        made.update({one: f"{name}:{number}" for one, number in found.items()})
        faults += wrong
    for name, text in tests.items():
        found, wrong = tests_of(name, text)
        faults += wrong + [f"{name}:{number}: no page promises '{one}'" for one, number in found if one not in made]
        kept.update(one for one, _ in found)
    return faults + [f"{place}: no test names '{one}'" for one, place in made.items() if one not in kept], len(made)


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    read = {path.relative_to(root).as_posix(): path.read_text(errors="replace")
            for folder, suffixes in (("delegate/manual", {".md"}), ("testenv", set(TEST)))
            for path in sorted((root / folder).rglob("*")) if path.suffix in suffixes and path.parent.name != "lint"}
    faults, count = check({n: t for n, t in read.items() if n.endswith(".md")}, {n: t for n, t in read.items() if not n.endswith(".md")})
    print("\n".join(faults) if faults else f"{count} promises of the manual have tests")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
