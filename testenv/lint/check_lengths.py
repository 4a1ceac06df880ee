#!/usr/bin/env python3
"""Fails when a file is longer than 500 lines or a function longer than 80 (aim: 40).

Functions are found by clang-format's layout: a body opens at the end of a line at column 0 and closes with '}' at column 0.
"""
import pathlib
import re
import sys

MAX_FILE, MAX_FUNCTION = 500, 80
OPENS = re.compile(r"^[A-Za-z_].*[^;]\{$")
NOT_A_FUNCTION = re.compile(r"^(namespace|extern|struct|class|enum|union|constexpr [^(]*|inline constexpr [^(]*|TEST.*)\b")


def is_text(body):
    """True for a function that only returns a raw string."""
    return body and re.match(r'^\s*return R"\w*\(', body[0]) is not None


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    found = []
    for folder in ("core", "delegate"):
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in (".h", ".cpp"):
                continue
            lines = file.read_text().splitlines()
            path = file.relative_to(root).as_posix()
            if len(lines) > MAX_FILE:
                found.append(f"{path}: {len(lines)} lines")
            start = None
            for number, line in enumerate(lines, 1):
                if start is None and OPENS.match(line) and not NOT_A_FUNCTION.match(line):
                    start = number
                elif start is not None and line.startswith("}"):
                    if number - start > MAX_FUNCTION and not is_text(lines[start:number]):
                        found.append(f"{path}:{start}: function of {number - start} lines")
                    start = None
    print("\n".join(found) if found else "lengths are within bounds")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
