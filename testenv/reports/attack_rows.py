"""Rows of reports.py for the inputs of an attack: names that lead elsewhere, files that do not end, Python that misbehaves."""
import os
import resource
import subprocess
import sys
import time

from measures import exr_file, expect
from made_images import flat, png
from rows import Row, require_module

FOLDER = "attack"


def udim_outside(lab):
    """The copy's links point out of its scene."""
    secret = png(flat(255, 0, 0))
    (lab.folder / "outside").mkdir(exist_ok=True)
    (lab.folder / "outside/secret.png").write_bytes(secret)
    tile = lab.folder / "scene/tile.1001.png"
    tile.unlink(missing_ok=True)
    tile.symlink_to("../outside/secret.png")
    for model in ("model.gltf", "model_direct.gltf"):
        run = lab.run("render", f"scene/{model}", "-o", "r.png", "--size", "16x16", "--spp", "4")
        expect(run.code == 3 and not (lab.folder / "r.png").exists(), f"{model}: exit {run.code}: {run.text}")


def frames_outside(lab):
    (lab.folder / "outside").mkdir(exist_ok=True)
    precious = exr_file({c: [[1, 2], [3, 4]] for c in "RGB"})
    (lab.folder / "outside/precious.exr").write_bytes(precious)
    link = lab.folder / "scene/o.0001.exr"
    link.unlink(missing_ok=True)
    link.symlink_to("../outside/precious.exr")
    run = lab.command(["sh", "-c", f"cd scene && exec '{lab.program}' render s.json --frames 1:1"])
    expect((lab.folder / "outside/precious.exr").read_bytes() == precious, "the file outside has changed")
    expect(run.code == 3, f"exit {run.code}: {run.text}")


def palette_tga(lab):
    run = lab.run("check", "s.json")
    expect(run.code == 3, f"exit {run.code}: {run.text}")


def farm_newline(lab):
    run = lab.command(["sh", "run.sh"], {"A": str(lab.program)})
    expect("a command" not in run.text and "a line" not in run.text, run.text)


def memory_limit_in_file(lab):
    def limited(name):
        return subprocess.run([lab.program, "render", name, "-o", "x.exr"], cwd=lab.folder, capture_output=True, text=True, timeout=300,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (9_000_000_000,) * 2))
    plain, raised = limited("d0.json"), limited("d1.json")
    expect(plain.returncode == raised.returncode and raised.returncode in (3, 4), f"{plain.returncode}, {raised.returncode}: {raised.stderr}")


def python_script(lab, *words, seconds=120):
    require_module(lab)
    lab.write("alabaster.py", b"from hdalabaster import *\n")
    for file in (lab.inputs.parent / "base.py", lab.folder / words[0]):
        lab.write(file.name, file.read_bytes().replace(b"/usr/bin/python3", sys.executable.encode()))
    return subprocess.run([sys.executable, *words], cwd=lab.folder, capture_output=True, text=True, timeout=seconds,
                          env={**os.environ, "PYTHONPATH": f"{lab.module}:{lab.folder}"})


def python_text(lab):
    codes = [line.split()[0] for line in python_script(lab, "run.py").stdout.splitlines()]
    expect(codes == ["1"] * 5, f"exit codes {codes}")


def reentered(lab):
    for how in ("record", "show"):
        done = python_script(lab, "run.py", how)
        refused = done.returncode == 1 and "Error" in done.stderr
        expect("survived" in done.stdout or refused, f"{how}: exit {done.returncode}: {done.stderr[-300:]}")


def two_threads(lab):
    done = python_script(lab, "run.py")
    expect(done.returncode == 0 and "Unicode" not in done.stdout, f"exit {done.returncode}: {done.stdout[-300:]}{done.stderr[-300:]}")


def damaged_once(lab):
    begin = time.monotonic()
    run = lab.run("render", "g40.gltf", "-o", "x.exr", "--size", "8x8", "--spp", "1")
    expect(run.seconds < 10 and run.code in (3, 0), f"exit {run.code} after {time.monotonic() - begin:.1f} s: {run.text[-300:]}")


def fifo(lab):
    os.mkfifo(lab.folder / "fifo.png")
    done = subprocess.run([lab.program, "render", "model.gltf", "-o", "x.exr"], cwd=lab.folder, capture_output=True, text=True, timeout=60)
    expect(done.returncode == 3 and "not a regular file" in done.stdout + done.stderr, f"exit {done.returncode}: {done.stderr}")


def forked(lab):
    expect("the child ended" in python_script(lab, "run.py").stdout, "the child hangs at its exit")


def recorded_after_cancel(lab):
    done = python_script(lab, "run.py")
    expect(done.returncode == 0 and (lab.folder / "x.exr").exists(), f"exit {done.returncode}: {done.stderr[-300:]}")


ATTACK_ROWS = [
    Row("A01 tiles outside", "A01_", "exit code, file", "3, none", udim_outside, FOLDER),
    Row("A02 frames outside", "A02_", "exit code, the file outside", "3, unchanged", frames_outside, FOLDER),
    Row("A03 palette of TGA", "A03_", "exit code of check", "3", palette_tga, FOLDER),
    Row("A04 newline in a name", "A04_", "files that its lines make", "none", farm_newline, FOLDER),
    Row("A05 memory limit of a file", "A05_", "exit code below 9 GB", "as without, refused", memory_limit_in_file, FOLDER),
    Row("A06 text in Python", "A06_", "exit codes of five calls", "1", python_text, FOLDER),
    Row("A07 progress that records", "A07_", "exit code, two ways", "0, or refused", reentered, FOLDER),
    Row("A08 threads of Python", "A08_", "errors of decoding", "none", two_threads, FOLDER),
    Row("A11 damaged image of 40 materials", "A11_", "seconds of CPU time", "under 10", damaged_once, FOLDER),
    Row("A12 pipe as an image", "A12_", "exit code, message", "3, not a regular file", fifo, FOLDER),
    Row("A14 fork", "A14_", "the child", "ends", forked, FOLDER),
    Row("A17 record after cancel", "A17_", "exit code, file", "0, written", recorded_after_cancel, FOLDER),
]
