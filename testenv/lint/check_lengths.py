#!/usr/bin/env python3
"""Fails when a C++ file is longer than 600 lines, a straight function longer than 120, or one that branches longer than 40.

  check_lengths.py [--list]

A function branches if its body has more than 5 decisions: if, for, while, case, catch, &&, || and ?. Lines are those of signature and
body. Functions that were longer before they counted stand in long_functions.txt, with their lines. They may not grow, and the list
may only shrink: a line that is no longer needed fails too. --list prints what it should be.
"""
import pathlib
import sys

from function_finder import find_functions

MAX_FILE, MAX_STRAIGHT, MAX_BRANCHING, DECISIONS = 600, 120, 40, 5
FOLDERS = ("core", "delegate", "testenv")
LIST = pathlib.Path(__file__).resolve().with_name("long_functions.txt")


def too_long(text):
    """(function, limit) of each function that is longer than its limit."""
    for function in find_functions(text):
        limit = MAX_BRANCHING if function.decisions > DECISIONS else MAX_STRAIGHT
        if function.lines > limit:
            yield function, limit


def faults(path, text, allowed):
    """`allowed`: {name: lines} of the file's functions in the list. Names that are found are taken out of it."""
    length = len(text.splitlines())
    if length > MAX_FILE:
        yield f"{path}: {length} lines; at most {MAX_FILE}: split the file"
    for function, limit in too_long(text):
        before = allowed.pop(function.name, None)
        if before is None:
            kind = f"with {function.decisions} decisions " if limit == MAX_BRANCHING else ""
            yield f"{path}:{function.first}: {function.name} {kind}has {function.lines} lines; at most {limit}"
        elif function.lines > before:
            yield f"{path}:{function.first}: {function.name} has grown from {before} to {function.lines} lines; at most {limit} are wanted"
        elif function.lines < before:
            yield f"{path}:{function.first}: {function.name} has {function.lines} lines: say so in {LIST.name}, which has {before}"
    for name in allowed:
        yield f"{path}: {name} is no longer too long: take it out of {LIST.name}"


def read_list(text):
    found = {}
    for line in text.splitlines():
        if line and not line.startswith("#"):
            path, name, lines = line.split()
            found.setdefault(path, {})[name] = int(lines)
    return found


def main():
    root = LIST.parents[2]
    files = {p.relative_to(root).as_posix(): p.read_text() for folder in FOLDERS for p in sorted((root / folder).rglob("*"))
             if p.suffix in (".h", ".cpp")}
    if sys.argv[1:] == ["--list"]:
        print("\n".join(f"{path} {f.name} {f.lines}" for path, text in files.items() for f, _ in too_long(text)))
        return 0
    allowed = read_list(LIST.read_text())
    found = [fault for path, text in files.items() for fault in faults(path, text, allowed.pop(path, {}))]
    found += [f"{path}: there is no such file: take it out of {LIST.name}" for path in allowed]
    print("\n".join(found) if found else f"the functions of {len(files)} files are short enough")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
