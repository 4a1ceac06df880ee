#!/usr/bin/env python3
"""Renders with the program of BASE (base_program.py) and with the present one, and compares all that they write, exactly.

  pictures_of_base.py PROGRAM [--base PROGRAM [--random GLOB ...]] [--only GLOB] [--oidn LIBRARY] [--list]

Compared are the pixels of every layer of EXR, PNG, TIFF and JPEG files, attributes, statistics and the numbers that are printed,
but no dates, times and memory. Exits with 1 if anything differs, and with 77 if the program of BASE is not built. The files of
the program of BASE are kept beside it, and made once. Runs for which BASE announces other random numbers are compared by t-tests of means over the frame
and its quarters, each of SEEDS pictures; runs that it announces to be different are not compared. What BASE announces does not count for the program of --base: there
--random names the runs whose means are compared.
"""
import argparse
import fnmatch
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import compared_files
from base_program import HERE, read_base
from feature_scenes import write_scenes
from runs import BUNDLED, NOT_AOVS, SCENES, aovs_of, runs

SKIPPED = 77
SEEDS = 8
SHOWN = 8  # differences of a run
FAMILY = 1e-4  # that any t-test of a run goes wrong by chance


class RunFailed(Exception):
    pass


def perform(run, program, folder, seed=None):
    """Writes the run's files to `folder`, and output.txt."""
    folder.mkdir(parents=True)
    output = ""
    for step in run.steps:
        words = [str(program), *step, *(["--set", f"seed={seed}"] if seed is not None and step[0] == "render" else [])]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, env={**os.environ, **run.environment})
        output += done.stdout
        if done.returncode:
            raise RunFailed(f"{' '.join(words)}\nended with {done.returncode}: {done.stderr}")
    (folder / "output.txt").write_text(output)
    for file in folder.glob("*.checkpoint"):
        file.unlink()


def kept(run, base, scene_file, seed=None):
    """The folder of what the program of BASE made in this run; rendered once."""
    parent = base.folder / "renders" / run.key(scene_file)
    folder = parent / ("as_is" if seed is None else f"seed{seed}")
    if not folder.exists():
        with tempfile.TemporaryDirectory(dir=base.folder) as scratch:
            perform(run, base.program, pathlib.Path(scratch) / "made", seed)
            parent.mkdir(parents=True, exist_ok=True)
            (pathlib.Path(scratch) / "made").rename(folder)
    return folder


def compare_exactly(base, present):
    """Folders."""
    names = [{f.name for f in folder.iterdir()} for folder in (base, present)]
    found = [f"{name}: only {'BASE' if name in names[0] else 'the present program'} wrote it" for name in sorted(names[0] ^ names[1])]
    for name in sorted(names[0] & names[1]):
        found += [f"{name}: {text}" for text in compared_files.differences(name, (base / name).read_bytes(), (present / name).read_bytes())]
    return found


def tail(t, freedom):
    """P(|T| > t) of Student's distribution with an even number of degrees of freedom."""
    theta = math.atan(t / math.sqrt(freedom))
    term, total = 1.0, 1.0
    for k in range(1, freedom // 2):
        term *= (2 * k - 1) / (2 * k) * math.cos(theta) ** 2
        total += term
    return 1 - math.sin(theta) * total


def means(data):
    """{(channel, part): mean} of an EXR file's layers that are no identifiers, over the frame and its quarters."""
    attributes, at = compared_files.exr_attributes(data)
    found = {}
    for channel, values in compared_files.read_zip_channels(data, at, attributes).items():
        if channel.removesuffix(".X").endswith("Id") or not all(map(math.isfinite, values)):
            continue
        quarter = max(1, len(values) // 4)
        found[channel, "frame"] = sum(values) / len(values)
        found |= {(channel, f"rows of quarter {i}"): sum(part) / len(part) for i in range(4) if (part := values[i * quarter:(i + 1) * quarter])}
    return found


def compare_means(bases, presents):
    """Lists of folders, one for each seed."""
    found = []
    for name in sorted(f.name for f in bases[0].glob("*.exr")):
        first, second = ([means((folder / name).read_bytes()) for folder in folders] for folders in (bases, presents))
        keys = first[0].keys() & second[0].keys()
        for key in sorted(keys):
            a, b = ([of[key] for of in pictures] for pictures in (first, second))
            middles = [sum(v) / SEEDS for v in (a, b)]
            spread = sum((x - m) ** 2 for v, m in zip((a, b), middles) for x in v) / (SEEDS - 1) / SEEDS
            off = abs(middles[0] - middles[1])
            if off <= 1e-6 * abs(middles[0]) or (spread and tail(off / math.sqrt(spread), 2 * SEEDS - 2) > FAMILY / len(keys)):
                continue
            found.append(f"{name}: mean of channel {key[0]}, {key[1]}: {middles[0]:.5g} in BASE, now {middles[1]:.5g}, "
                         f"{off / math.sqrt(spread) if spread else math.inf:.1f} standard errors apart")
    return found


def differences(run, base, program, scene_file, scratch):
    try:
        return compare(run, base, program, scene_file, scratch)
    except RunFailed as failure:
        return [str(failure)]


def compare(run, base, program, scene_file, scratch):
    if base.word(run.name) == "random":
        folders = [scratch / f"seed{seed}" for seed in range(SEEDS)]
        for seed, folder in enumerate(folders):
            perform(run, program, folder, seed)
        return compare_means([kept(run, base, scene_file, seed) for seed in range(SEEDS)], folders)
    perform(run, program, scratch / "present")
    return compare_exactly(kept(run, base, scene_file), scratch / "present")


class OtherProgram:
    """A program in the place of that of BASE, whose files are kept for this process alone."""

    def __init__(self, program, random, folder):
        self.announced, self.program, self.folder = random, pathlib.Path(program).resolve(), folder

    def word(self, run):
        return "random" if any(fnmatch.fnmatch(run, glob) for glob in self.announced) else None


def compare_all(base, arguments, scratch):
    files = write_scenes(scratch / "scenes") | {name: SCENES / file for name, file in BUNDLED.items()}
    names = [aovs_of(p) for p in (base.program, arguments.program)]
    if left := sorted(set(names[0]) ^ set(names[1])):
        print(f"not compared, because one of the programs lacks them: {', '.join(left)}")
    count = different = 0
    for run in runs(files, [n for n in names[0] if n in names[1] and n not in NOT_AOVS], arguments.oidn):
        if not fnmatch.fnmatch(run.name, arguments.only):
            continue
        count += 1
        if arguments.list:
            print(run.name, base.word(run.name) or "")
        elif base.word(run.name) == "different":
            print(f"{run.name}: not compared, BASE announces that it differs")
        else:
            place = scratch / "run"
            found = differences(run, base, pathlib.Path(arguments.program).resolve(), files[run.scene], place)
            shutil.rmtree(place, ignore_errors=True)
            different += bool(found)
            for text in found[:SHOWN] + [f"and {len(found) - SHOWN} more"] * (len(found) > SHOWN):
                print(f"{run.name}: {text}", flush=True)
    print(f"{different} of {count} runs differ from BASE" if different else f"{count} runs are those of BASE")
    return 1 if different or count == 0 else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--base", help="another program in the place of that of BASE")
    parser.add_argument("--random", action="append", default=[], metavar="GLOB", help="with --base: runs of other random numbers")
    parser.add_argument("--only", default="*", metavar="GLOB", help="of SCENE/MODE")
    parser.add_argument("--oidn", help="a library in the place of Open Image Denoise")
    parser.add_argument("--list", action="store_true", help="prints the runs only")
    arguments = parser.parse_args()
    if arguments.random and not arguments.base:
        parser.error("--random is for --base; for the program of BASE, add lines to BASE")
    base = read_base((HERE / "BASE").read_text())
    with tempfile.TemporaryDirectory() as name:
        if arguments.base:
            base = OtherProgram(arguments.base, arguments.random, pathlib.Path(name))
        elif not base.program.exists():
            print(f"NOT RUN: the program of BASE ({base.commit[:12]}) is not built. Build it once: {HERE / 'base_program.py'} --build")
            return SKIPPED
        return compare_all(base, arguments, pathlib.Path(name))


if __name__ == "__main__":
    sys.exit(main())
