#!/usr/bin/env python3
"""Compares the C interface with that of the last release: programs that were built against it must run with this one.

  door_abi.py HEADER DUMP           fails if anything changed but by additions at the end
  door_abi.py HEADER DUMP --write   writes the dump, at a release

Structs that begin with `size`, the table of functions among them, may grow at their end. Everything else stays. The values
of enumerators are not compared. Needs a C compiler, and abidw and abidiff of Debian's abigail-tools.
"""
import argparse
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

# The header alone has all layouts, so nothing of the library is compiled.
PROGRAM = """#include "{header}"
static const AlabasterApi table;
const AlabasterApi* alabaster_api(uint32_t version) {{ return version ? &table : 0; }}
"""
SUMMARY = re.compile(r"(Leaf changes|Changed leaf types|Removed/Changed/Added (functions|variables)) summary: ")
CHANGED = re.compile(r"'struct (\w+)' changed:$")
GROWN = re.compile(r"type size changed from (\d+) to (\d+) \(in bits\)$")
MEMBER = re.compile(r"'.*', at offset (\d+) \(in bits\)")


def compile_header(header, folder):
    library = pathlib.Path(folder) / "door.so"
    source = PROGRAM.format(header=pathlib.Path(header).resolve())
    root = pathlib.Path(__file__).resolve().parents[2]  # value_type.h is found from there
    subprocess.run(["cc", "-std=c99", "-g", "-fPIC", "-shared", f"-I{root}", "-x", "c", "-", "-o", library], input=source, text=True,
                   check=True)
    return library


def door_text(header):
    """The header with the types that it includes."""
    header = pathlib.Path(header)
    include = '#include "alabaster_types.h"'
    text = header.read_text()
    return text.replace(include, (header.parent / "alabaster_types.h").read_text()) if include in text else text


def growing_structs(header):
    text = door_text(header)
    return set(re.findall(r"typedef struct (\w+) \{[^\n]*\n  size_t size;", text))


def breaks(report, growing):
    """The lines of abidiff's report that are no addition at the end of a struct that may grow."""
    wrong, struct, old_size = [], "", 0
    for line in (line.strip() for line in report.splitlines()):
        changed, grown, member = CHANGED.match(line), GROWN.match(line), MEMBER.match(line)
        if changed:
            struct = changed.group(1)
            good = struct in growing
        elif grown:
            old_size = int(grown.group(1))
            good = int(grown.group(2)) > old_size
        elif member:
            good = int(member.group(1)) >= old_size
        else:
            good = not line or SUMMARY.match(line) or re.match(r"\d+ data member insertions?:$", line)
        if not good:
            wrong.append(f"{struct}: {line}")
    return wrong


def compare(header, dump):
    with tempfile.TemporaryDirectory() as folder:
        library = compile_header(header, folder)
        done = subprocess.run(["abidiff", "--leaf-changes-only", dump, library], capture_output=True, text=True)
    if done.returncode & 3:
        sys.exit(done.stderr or done.stdout)
    wrong = breaks(done.stdout, growing_structs(header))
    if done.returncode and not wrong and not done.stdout:
        wrong.append("abidiff says no more than that something changed")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("header")
    parser.add_argument("dump")
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    if not shutil.which("abidiff"):
        print("skipped: abidiff is missing (Debian's abigail-tools)")
        return 0
    if arguments.write:
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(["abidw", "--no-corpus-path", "--no-show-locs", "--no-comp-dir-path", "--out-file", arguments.dump,
                            compile_header(arguments.header, folder)], check=True)
        text = re.sub(r" path='[^']*'", " path='door.c'", pathlib.Path(arguments.dump).read_text())
        pathlib.Path(arguments.dump).write_text(text)
        return 0
    wrong = compare(arguments.header, arguments.dump)
    for line in wrong:
        print("error: the C interface has changed: " + line, file=sys.stderr)
    if not wrong:
        print("the C interface is that of the last release, or has additions at its end")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
