#!/usr/bin/env python3
"""Fails when a scene's script no longer makes the files beside it, byte for byte, or when a file is too large.

Every NAME/make_NAME.py writes NAME.glb and any further files into the folder of the path that it is given.
"""
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
LARGEST = 400_000  # bytes


def problems_of(folder, scratch):
    script = folder / ("make_%s.py" % folder.name)
    run = subprocess.run([sys.executable, "-B", str(script), str(scratch / (folder.name + ".glb"))], capture_output=True,
                         text=True)
    if run.returncode:
        return ["%s failed:\n%s" % (script.name, run.stderr)]
    made = sorted(scratch.iterdir())
    found = [] if made else ["%s made nothing" % script.name]
    for file in made:
        kept = folder / file.name
        if not kept.exists():
            found.append("%s is missing beside its script: run %s and add it" % (kept, script))
        elif kept.read_bytes() != file.read_bytes():
            found.append("%s differs from its script's result: run %s" % (kept, script))
        if file.stat().st_size > LARGEST:
            found.append("%s has %d bytes; at most %d" % (kept, file.stat().st_size, LARGEST))
    return found


def main():
    folders = sorted(p.parent for p in HERE.glob("*/make_*.py") if p.name == "make_%s.py" % p.parent.name and
                     (p.parent / (p.parent.name + ".json")).exists())
    if not folders:
        print("no scenes found in %s" % HERE)
        return 1
    found = []
    for folder in folders:
        with tempfile.TemporaryDirectory() as scratch:
            found += problems_of(folder, pathlib.Path(scratch))
    print("\n".join(found) if found else "%d scenes are up to date" % len(folders))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
