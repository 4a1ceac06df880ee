#!/usr/bin/env python3
"""Fails when a hop of the lists in delegate/manual/contributing.md, "The tree", names a function or type that its file does not define, or
delegate/manual/security.md, "Security, by promise", a test that there is not.

A list is a line of bold text and the numbered items below it. An item begins with a file and what to find there, each in
backticks: "1. `core/film/film.cpp` `FilmTile::add`: its part in the walk".
"""
import pathlib
import re
import sys

PAGE = "delegate/manual/contributing.md"
LISTS = 9
LEAST_TESTS = 30
SECURITY = re.compile(r"^## Security, by promise$(.*?)^## ", re.M | re.S)
SECTION = re.compile(r"^## The tree$(.*?)^## ", re.M | re.S)
LIST = re.compile(r"^\*\*.*\n(?:.+\n)*?((?:\d+\. .+\n(?:   .+\n)*)+)", re.M)
ITEM = re.compile(r"^\d+\. (.+)", re.M)
NO_TYPE = ("return", "else", "throw", "new", "case")


def defines(text, name):
    """True for a type, and for a function whose name a return type stands before."""
    if re.search(rf"\b(?:struct|class|enum|using) {name}\b(?!;)", text):
        return True
    for match in re.finditer(rf"^(.*[^\w:]|)(?:\w+::)*{name}\(", text, re.M):
        before = match.group(1).strip()
        if re.search(r"[\w>&*]$", before) and before.split()[-1] not in NO_TYPE and not before.startswith("//"):
            return True
    return False


def faults(root, items):
    for item in items:
        file, *names = re.findall(r"`([^`]+)`", item.split(": ")[0]) or [item]
        path = root / file
        if not path.is_file() or not names:
            yield f"{PAGE}: {file} is not a file of the repository with a function or type behind it"
        else:
            text = path.read_text()
            yield from (f"{PAGE}: {file} does not define {n}" for n in names if not defines(text, n))


def missing_tests(root):
    """Names of the security table that no test has. A name is `Suite.Test`; it may end with "..." or "*", and others may follow that begin so."""
    section = SECURITY.search((root / "delegate/manual/security.md").read_text())
    names = re.findall(r"`([A-Z]\w+\.\w*)(?:\.\.\.|\*)?`", section.group(1)) if section else []
    tests = {".".join(test) for file in (root / "testenv/unit").rglob("*_test.cpp")
             for test in re.findall(r"^TEST(?:_F|_P)?\((\w+), (\w+)\)", file.read_text(), re.M)}
    if len(names) < LEAST_TESTS:
        yield f'delegate/manual/security.md: "Security, by promise" names {len(names)} tests'
    yield from (f"delegate/manual/security.md: there is no test {name}" for name in names if not any(t.startswith(name) for t in tests))


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    section = SECTION.search((root / PAGE).read_text())
    lists = LIST.findall(section.group(1)) if section else []
    found = [] if len(lists) == LISTS else [f'{PAGE}: "The tree" has {len(lists)} lists of hops, expected {LISTS}']
    hops = 0
    for text in lists:
        items = ITEM.findall(text)
        hops += len(items)
        found += faults(root, items)
    found += missing_tests(root)
    print("\n".join(found) if found else f"{hops} hops are where {PAGE} says")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
