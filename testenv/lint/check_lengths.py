#!/usr/bin/env python3
"""Fails when a C++ file is longer than 450 lines or a function longer than 60 (aim: 40), signature and braces included."""
import pathlib
import sys

from function_finder import find_functions

MAX_FILE, MAX_FUNCTION = 450, 60
FOLDERS = ("core", "delegate", "testenv")


def faults(path, text):
    length = len(text.splitlines())
    if length > MAX_FILE:
        yield f"{path}: {length} lines; at most {MAX_FILE}: split the file"
    for function in find_functions(text):
        if function.lines > MAX_FUNCTION:
            yield f"{path}:{function.first}: {function.name} has {function.lines} lines; at most {MAX_FUNCTION}"


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    found, functions = [], 0
    files = [p for folder in FOLDERS for p in sorted((root / folder).rglob("*")) if p.suffix in (".h", ".cpp")]
    for file in files:
        text = file.read_text()
        found += faults(file.relative_to(root).as_posix(), text)
        functions += len(find_functions(text))
    print("\n".join(found) if found else f"{functions} functions in {len(files)} files are short enough")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
