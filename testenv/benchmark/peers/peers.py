#!/usr/bin/env python3
"""Compares our noise per CPU second with other renderers' on the same scenes.

  peers.py [--ours NAME=PROGRAM ...] [--scene NAME|FILE.json ...] [--lines N] [--samples N] [--rounds N] [--out FILE.md]

Renders each scene in its neutral form (neutral_scene.py) with each program, interleaved, with a new seed per round. Peers:
Debian's Blender (package blender: Cycles 3.4), and bpy 5.0.1 and Mitsuba 3.9.1 from PyPI, installed once into the work
folder by a Python 3.11. A peer that is missing is left out, and the reason is printed and written.

efficiency = 1 / (relMSE x CPU seconds). Each peer's noise is measured against its own reference; ours against one reference,
made by the first --ours, so a bias of later ones counts as their noise. relMSE: squared_error of
testenv/statistical/calibration/pictures.py. CPU seconds are the render's with N
samples less one with 1 sample, so that start-up, scene preparation and files are not counted. Writes a table to --out and all
numbers beside it as .json. References are kept in the work folder, by everything that they depend on.
"""
import argparse
import copy
import datetime
import hashlib
import json
import math
import os
import pathlib
import shutil
import statistics
import subprocess
import sys

import neutral_scene
import report

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path.insert(0, str(ROOT / "testenv" / "statistical" / "calibration"))
from pictures import Reference, block_means, read_exr  # noqa: E402

SCENES = ROOT / "testenv" / "scenes"
DEFAULT_SCENES = ["skin_closeup", "backlit", "thick_thin", "slab", "mixed_no_subsurface"]
BLOCK = 8  # pixels
PACKAGES = ["bpy==5.0.1", "mitsuba==3.9.1"]


class Missing(Exception):
    """A peer cannot be run here; the text says why."""


def digest(*parts):
    return hashlib.sha1(b"\0".join(p if isinstance(p, bytes) else str(p).encode() for p in parts)).hexdigest()[:12]


class Ours:
    def __init__(self, name, program):
        self.name, self.program, self.adaptive = name, pathlib.Path(program).resolve(), False
        if not os.access(self.program, os.X_OK):
            raise Missing(f"{program} is no program")
        self.library = self.program.parent.parent / "lib"
        libraries = sorted(p.read_bytes() for p in self.library.glob("libhdAlabaster.so*") if not p.is_symlink())
        self.identity = digest(self.program.read_bytes(), *libraries)

    def render(self, job):
        """CPU seconds of each render."""
        return [self.render_once(job, task) for task in job["renders"]]

    @staticmethod
    def setting_flags(job):
        settings = [f"glossyFilter={job['glossyFilter']}"] * (job["glossyFilter"] > 0) + ["adaptive=true"] * (job["adaptive"] > 0)
        return [word for setting in settings for word in ("--set", setting)]

    def render_once(self, job, task):
        environment = {**os.environ, "LD_LIBRARY_PATH": f"{self.library}:{os.environ.get('LD_LIBRARY_PATH', '')}"}
        process = subprocess.Popen(
            [self.program, "render", f"{job['scene']}/scene.json", "--size", f"{job['width']}x{job['height']}",
             "--spp", str(task["samples"]), "--seed", str(task["seed"]), "--threads", str(job["threads"]), "--quiet",
             "--allow-outside", "-o", task["output"], *self.setting_flags(job)], env=environment)
        _, status, usage = os.wait4(process.pid, 0)
        if status != 0:
            sys.exit(f"{self.name} failed with {os.waitstatus_to_exitcode(status)} on {job['scene']}")
        return usage.ru_utime + usage.ru_stime


class Script:
    """A peer that runs one of our scripts, which reads a job and prints PEER {json}."""

    def __init__(self, name, script, command, version):
        self.name, self.command, self.adaptive = name, [*command], False
        self.identity = digest(version, *(HERE.joinpath(f).read_bytes() for f in (script, "formulas.py")))

    def render(self, job):
        file = pathlib.Path(job["renders"][0]["output"]).with_suffix(".job.json")
        file.write_text(json.dumps(job))
        done = subprocess.run([*self.command, file], capture_output=True, text=True)
        lines = [line for line in done.stdout.splitlines() if line.startswith("PEER ")]
        if done.returncode != 0 or not lines:
            raise Missing(f"{self.name} failed: {(done.stderr or done.stdout).strip()[-300:]}".replace("\n", " "))
        return json.loads(lines[-1][5:])["cpuSeconds"]


def debian_blender():
    if not shutil.which("blender"):
        raise Missing("no program 'blender' (apt-get install blender)")
    shown = subprocess.run(["blender", "--version"], capture_output=True, text=True).stdout.split("\n")[0]
    command = ["blender", "-b", "--factory-startup", "-noaudio", "--python-exit-code", "3", "-P", HERE / "cycles_scene.py",
               "--"]
    return Script("Cycles " + shown.split()[-1], "cycles_scene.py", command, shown)


def python_with_peers(work):
    """The interpreter of a virtual environment with PACKAGES. bpy 5.0.1 has wheels for Python 3.11 only."""
    python = work / "venv" / "bin" / "python"
    if python.exists() and (work / "venv" / "complete").exists():
        return python
    base = shutil.which("python3.11")
    if not base:
        raise Missing("no python3.11, which bpy 5.0.1 needs")
    for command in ([base, "-m", "venv", work / "venv"], [python, "-m", "pip", "install", "--quiet", *PACKAGES]):
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise Missing(f"{' '.join(map(str, command[-4:]))}: {done.stderr.strip()[-300:]}")
    (work / "venv" / "complete").touch()
    return python


def from_pypi(name, script, package, work):
    return Script(name, script, [python_with_peers(work), HERE / script], package)


def find_peers(work, wanted):
    """(peers, reasons why others are left out)"""
    makers = {"debian": debian_blender,
              "bpy": lambda: from_pypi("Cycles 5.0.1", "cycles_scene.py", PACKAGES[0], work),
              "mitsuba": lambda: from_pypi("Mitsuba 3.9.1", "mitsuba_scene.py", PACKAGES[1], work)}
    peers, reasons = [], []
    for name in wanted:
        try:
            peers.append(makers[name]())
        except Missing as missing:
            reasons.append(f"{name} left out: {missing}")
            print(reasons[-1], file=sys.stderr)
    return peers, reasons


def with_adaptive(programs):
    """The programs, each followed by itself with adaptive sampling, unless it has none."""
    pairs = []
    for program in programs:
        pairs.append(program)
        if program.name.startswith("Mitsuba"):
            continue
        pairs.append(copy.copy(program))
        pairs[-1].name, pairs[-1].adaptive = f"{program.name}, adaptive", True
    return pairs


def export(scene, work):
    """(name, folder of the neutral scene); made again only if a file that it depends on has changed."""
    path = pathlib.Path(scene) if scene.endswith(".json") else SCENES / scene / f"{scene}.json"
    sources = [HERE / "neutral_scene.py", HERE / "formulas.py"]
    if scene != "slab":
        description = json.loads(path.read_text())
        sources += [path, *(path.parent / model["file"] for model in description["gltf"])]
    name = path.stem
    folder = work / "scenes" / f"{name}-{digest(*(s.read_bytes() for s in sources))}"
    if not (folder / "complete").exists():
        neutral_scene.write_slab(folder) if scene == "slab" else neutral_scene.write_neutral(path, folder)
        (folder / "complete").touch()
    return name, folder


class Comparison:
    """One scene: its references, then rounds of interleaved renders."""

    def __init__(self, options, name, folder, work):
        self.options, self.name, self.folder, self.work = options, name, folder, work
        camera = json.loads((folder / "scene.json").read_text())["camera"]
        self.height = options.lines
        self.width = round(options.lines * camera.get("horizontalAperture", 36) / camera.get("verticalAperture", 24))
        self.identity = folder.name

    def job(self, *tasks, filtered=False, adaptive=False):
        ours, cycles = self.options.glossy_filter if filtered else (0.0, 0.0)
        return {"scene": str(self.folder), "width": self.width, "height": self.height, "threads": self.options.threads,
                "glossyFilter": ours, "blurGlossy": cycles, "adaptive": self.options.adaptive if adaptive else 0,
                "renders": [{"samples": n, "seed": seed, "output": str(output)} for n, seed, output in tasks]}

    def reference(self, program):
        """(pixels, means of blocks), from two halves with seeds of their own."""
        halves, size = [], f"{self.width}x{self.height}-{self.options.reference}"
        folder = self.work / "references"
        folder.mkdir(parents=True, exist_ok=True)
        for half in (1, 2):
            file = folder / f"{self.identity}-{size}-{half}-{digest(program.identity)}.exr"
            if not file.exists():
                print(f"{self.name}: reference {half} of {program.name}", flush=True)
                made = folder / f"{file.stem}.partial.exr"
                program.render(self.job((self.options.reference, 1000 + half, made)))
                made.rename(file)
            halves.append(read_exr(file))
        return Reference(halves), Reference([block_means(half, BLOCK) for half in halves])

    def measure(self, program, seed, references):
        n = self.options.samples
        files = [self.work / "renders" / f"{k}.exr" for k in ("warm", "one", "full")]
        seconds = program.render(self.job((1, seed, files[0]), (1, seed, files[1]), (n, seed, files[2]), filtered=True,
                                          adaptive=program.adaptive))
        picture = read_exr(files[2])
        found = {"cpuSeconds": (seconds[2] - seconds[1]) * n / (n - 1), "relMse": references[0].squared_error(picture),
                 "blockRelMse": references[1].squared_error(block_means(picture, BLOCK)),
                 "mean": [statistics.fmean(plane) for plane in picture.planes]}
        print(f"{self.name}: seed {seed}, {program.name}: {found}", flush=True)
        return found

    def run(self, ours, peers):
        """(rows of the table, reasons why peers are left out)"""
        references, runs, reasons = {}, {}, []

        def leave_out(program, missing):
            references.pop(program, None)
            reasons.append(f"{self.name}: {missing}")
            print(reasons[-1], file=sys.stderr)

        for program in [*ours, *peers]:
            try:
                references[program] = references[ours[0]] if program in ours[1:] else self.reference(program)
                runs[program] = []
            except Missing as missing:
                leave_out(program, missing)
        for round_ in range(self.options.rounds):
            programs = list(references)
            for program in programs[round_ % len(programs):] + programs[:round_ % len(programs)]:
                try:
                    runs[program].append(self.measure(program, 1 + round_, references[program]))
                except Missing as missing:
                    leave_out(program, missing)
        return [self.summary(p, runs[p], p in ours) for p in references], reasons

    def summary(self, program, runs, is_ours):
        def mean(key):
            return statistics.fmean(run[key] for run in runs)

        seconds, samples = statistics.median(run["cpuSeconds"] for run in runs), self.width * self.height * self.options.samples
        row = {"scene": self.name, "lines": self.height, "program": program.name, "ours": is_ours, "rounds": runs,
               "cpuSeconds": seconds, "samplesPerCpuSecond": samples / seconds,
               "mean": [statistics.fmean(run["mean"][c] for run in runs) for c in range(3)]}
        for key, efficiency in (("relMse", "efficiency"), ("blockRelMse", "blockEfficiency")):
            row[key], row[efficiency] = mean(key), 1 / (mean(key) * seconds)
            row[key + "Error"] = (statistics.stdev(run[key] for run in runs) / math.sqrt(len(runs)) / row[key]
                                  if len(runs) > 1 else None)
        return row


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ours", action="append", help="NAME=PROGRAM; may be repeated to compare revisions")
    parser.add_argument("--scene", action="append", help="a bundled scene, 'slab', or a render description; may be repeated")
    parser.add_argument("--peers", default="debian,bpy", help="of debian, bpy and mitsuba; by default debian,bpy")
    parser.add_argument("--lines", type=int, default=240, help="height of the pictures")
    parser.add_argument("--samples", type=int, default=64, help="per pixel")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--reference", type=int, default=512, help="samples of each half of a reference")
    parser.add_argument("--threads", type=int, default=1, help="of each renderer; one gives the steadiest CPU seconds")
    parser.add_argument("--glossy-filter", type=float, nargs=2, default=[0.0, 0.0], metavar=("OURS", "CYCLES"),
                        help="glossyFilter and Cycles' Filter Glossy, which is 1 unless a user changes it; their blur "
                             "counts as noise, for references have none")
    parser.add_argument("--adaptive", type=float, default=0, metavar="THRESHOLD",
                        help="also with adaptive sampling: ours of the same samples in the mean, Cycles' of four times as many at "
                             "most, down to this noise threshold")
    parser.add_argument("--work", default=str(ROOT / "build" / "peers"), help="folder for scenes, references and packages")
    parser.add_argument("--out", default=str(ROOT / "testenv" / "benchmark" / "results" / "peers.md"))
    options = parser.parse_args(arguments)
    if options.samples < 2:
        parser.error("--samples must be at least 2")
    if not 0 <= options.adaptive < float("inf"):
        parser.error("--adaptive takes a threshold above 0, or 0 for none")
    options.ours = options.ours or [f"ours={ROOT / 'build' / 'release' / 'bin' / 'alabaster'}"]
    options.peers = [name for name in options.peers.split(",") if name]
    if not set(options.peers) <= {"debian", "bpy", "mitsuba"}:
        parser.error("--peers takes debian, bpy and mitsuba, separated by commas")
    if min(options.lines // BLOCK, options.rounds, options.reference, options.threads) < 1:
        parser.error("--lines must be at least 8, --rounds, --reference and --threads at least 1")
    if not all("=" in entry for entry in options.ours):
        parser.error("--ours takes NAME=PROGRAM")
    return options


def main():
    options = parse(sys.argv[1:])
    if not shutil.which("oiiotool"):
        sys.exit("no program 'oiiotool', which reads the pictures (apt-get install openimageio-tools)")
    work = pathlib.Path(options.work).resolve()
    (work / "renders").mkdir(parents=True, exist_ok=True)
    try:
        ours = [Ours(*entry.split("=", 1)) for entry in options.ours]
    except Missing as missing:
        sys.exit(str(missing))
    peers, reasons = find_peers(work, options.peers)
    if options.adaptive > 0:
        ours, peers = with_adaptive(ours), with_adaptive(peers)
    rows = []
    for scene in options.scene or DEFAULT_SCENES:
        try:
            name, folder = export(scene, work)
        except (neutral_scene.Unsupported, OSError, KeyError, json.JSONDecodeError) as error:
            reason = f"{error.strerror}: {pathlib.Path(error.filename).name}" if isinstance(error, OSError) else error
            reasons.append(f"{pathlib.Path(scene).name} left out: {reason}")
            print(reasons[-1], file=sys.stderr)
            continue
        more_rows, more_reasons = Comparison(options, name, folder, work).run(ours, peers)
        rows, reasons = rows + more_rows, reasons + more_reasons
        facts = {"options": vars(options), "leftOut": reasons, "date": datetime.date.today().isoformat(), "rows": rows}
        report.write(pathlib.Path(options.out), facts)
    return 0 if rows else 1


if __name__ == "__main__":
    sys.exit(main())
