#!/usr/bin/env python3
"""Runs the commands of the manual: every block of sh in delegate/manual, and those of the README that begin with `alabaster`, in a folder
with the files that they name.

  run_blocks.py PROGRAM [--no-hosts]

Blocks of c and cpp are hosts. They are compiled against the library of PROGRAM's build, and run, except with --no-hosts.

A file of --stats has the keys that pipeline.md, "Statistics", lists: all that are always there, and no others.

The folder holds model.glb, scene.json (the render description of pipeline.md) and sky.hdr. `alabaster` is PROGRAM, but for pictures
of 24x16 pixels and studies of seconds. A block fails if one of its commands does, or if it names an output that is not there.
"""
import json
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

TOP = pathlib.Path(__file__).resolve().parents[2]
MANUAL = TOP / "delegate/manual"
SCENES = TOP / "testenv/scenes"
LEAST_BLOCKS = 10
SIZED = ("render", "farm", "convert")
REDUCED = {"--size": "24x16", "--budget": "0.03"}
OUTPUT = re.compile(r"(?:-o|--stats|--checkpoint) (\S+)")
STATISTICS = re.compile(r"^## Statistics$(.*?)^## ", re.M | re.S)


def blocks(kind):
    """(page, text) of each block of code."""
    for page in [TOP / "README.md", *sorted(MANUAL.rglob("*.md"))]:
        for text in re.findall(rf"^```{kind}\n(.*?)^```", page.read_text(), re.M | re.S):
            if page.parent != TOP or text.startswith("alabaster "):
                yield page.relative_to(TOP).as_posix(), text


def reduced(arguments):
    """Arguments of the program, for small pictures."""
    words = list(arguments)
    for flag, value in REDUCED.items():
        while flag in words:
            del words[words.index(flag):words.index(flag) + 2]
        sized = words[:1] and words[0] in SIZED and "--pixel" not in words and words[1:2] != ["status"]
        if flag == "--size" and (sized or words[:1] == ["tradeoff"]) or flag == "--budget" and words[:1] == ["tradeoff"]:
            words += [flag, value]
    return words


def make_folder(folder, program):
    """Fills a folder with what the blocks name. `alabaster` in its bin is this file, with `reduced` arguments."""
    (folder / "bin").mkdir()
    shim = folder / "bin/alabaster"
    shim.write_text(f"#!/bin/sh\nexec {shlex.join([sys.executable, '-B', __file__, '--as', str(program)])} \"$@\"\n")
    shim.chmod(0o755)
    shutil.copy(SCENES / "hard_light/hard_light.glb", folder / "model.glb")
    shutil.copy(SCENES / "dome_high_contrast/sky.hdr", folder / "sky.hdr")
    (folder / "scene.json").write_text(next(text for page, text in blocks("json")))


def fault_of_statistics(file):
    """Compares the keys of a file of statistics with those of the table; "": they agree."""
    section = STATISTICS.search((MANUAL / "pipeline.md").read_text()).group(1)
    listed = {name: always for names, always in re.findall(r"^\| (`.+?) \|.*\| (yes|no) \|$", section, re.M)
              for name in re.findall(r"`(\w+)`", names)}
    written = set(json.loads(file.read_text()))
    required = {name for name, always in listed.items() if always == "yes"}
    wrong = sorted(written - set(listed)) + sorted(required - written)
    return f"keys that the table and {file.name} do not share: {' '.join(wrong)}" if wrong else ""


def fault_of(text, program):
    """Runs a block in a folder of its own; "": it did as it says."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make_folder(folder, program)
        script = f"set -e\nPATH={shlex.quote(str(folder / 'bin'))}:$PATH\n{text}"
        ran = subprocess.run(["sh", "-c", script], cwd=folder, capture_output=True, text=True, timeout=600)
        if ran.returncode != 0:
            return f"exit code {ran.returncode}\n{ran.stdout}{ran.stderr}"
        missing = [one for one in OUTPUT.findall(text) if not any(folder.glob(one.replace("#", "[0-9]")))]
        if missing:
            return f"it does not write {' '.join(missing)}"
        return "".join(fault_of_statistics(folder / file) for file in re.findall(r"--stats (\S+)", text))


def fault_of_host(text, kind, program):
    """Compiles and runs a host in a folder with the files that blocks name; "": both went well."""
    library = program.parents[1] / "lib"
    warnings = ["-Wall", "-Wextra", "-pedantic", "-Werror"]
    compilers = [["cc", f"-std=c{n}", *warnings] for n in (11, 17, 99)] if kind == "c" else [["c++", f"-std=c++{n}", *warnings] for n in (20, 17)]
    compile_host = ["-I.", f"-I{TOP}", f"host.{kind}"]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make_folder(folder, program)
        (folder / "alabaster").symlink_to(TOP / "delegate/c_api")
        (folder / f"host.{kind}").write_text(text)
        for command in (*([*compiler, *compile_host, "-fsyntax-only"] for compiler in compilers[:-1]),
                        [*compilers[-1], *compile_host, "-o", "host", f"-L{library}", "-lhdAlabaster", f"-Wl,-rpath,{library}"], ["./host"]):
            ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=600)
            if ran.returncode != 0:
                return f"{shlex.join(command)}: exit code {ran.returncode}\n{ran.stdout}{ran.stderr}"
    return ""


# promise: pipeline.archive.convert
def main():
    if sys.argv[1:2] == ["--as"]:
        return subprocess.run([sys.argv[2], *reduced(sys.argv[3:])]).returncode
    program = pathlib.Path(sys.argv[1]).resolve()
    ran, faults = 0, 0
    hosts = [] if "--no-hosts" in sys.argv else [(*block, kind) for kind in ("c", "cpp") for block in blocks(kind)]
    for page, text, kind in [*((*block, "sh") for block in blocks("sh")), *hosts]:
        fault = fault_of(text, program) if kind == "sh" else fault_of_host(text, kind, program)
        ran, faults = ran + 1, faults + bool(fault)
        print(f"{page}: {'FAILED: ' + fault if fault else 'ok'}\n  " + text.strip().replace("\n", "\n  "), flush=True)
    if ran < LEAST_BLOCKS:
        print(f"{MANUAL} has {ran} blocks of commands, expected {LEAST_BLOCKS} or more")
    return 1 if faults or ran < LEAST_BLOCKS else 0


if __name__ == "__main__":
    sys.exit(main())
