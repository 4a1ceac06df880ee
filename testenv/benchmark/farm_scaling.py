#!/usr/bin/env python3
"""Tells how a frame scales over the tasks of `alabaster farm`, from measured parts of its cost.

  farm_scaling.py PROGRAM [--scene NAME ...] [--size WxH] [--spp N] [--threads N] [--parts N ...] [--checks N ...]

Measured, in CPU seconds of one process with one thread: a task's start (loading, refinement, the tracing builds), a sample of all
pixels, and the merge of 1 to 64 parts, to which a line is fitted. Then, for a machine a task with N threads:

  frame = start + spp / tasks x sample / threads + merge(tasks)

Start and merge are taken to use one thread each, so the model is pessimistic where they use more. It leaves out the engine's
queue and the network. Farms of a few tasks are run to check it: the longest task against start + spp / tasks x sample.
Makes testenv/benchmark/results/farm_scaling.md on standard output.
"""
import argparse
import datetime
import os
import pathlib
import subprocess
import sys
import tempfile

TOP = pathlib.Path(__file__).resolve().parents[2]
CHECKED_SPP = 16


def cpu_seconds(*words):
    """CPU seconds and peak MB of a program."""
    process = subprocess.Popen([str(word) for word in words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    error = process.stderr.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f"{' '.join(str(word) for word in words)}\nended with {os.waitstatus_to_exitcode(status)}: {error}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


class Farm:
    def __init__(self, options, scene, folder):
        self.options, self.folder = options, pathlib.Path(folder)
        self.scene = TOP / "testenv/scenes" / scene / f"{scene}.json"

    def part(self, begin, end, name):
        """CPU seconds of samples begin to end."""
        return cpu_seconds(self.options.program, "render", self.scene, "--size", self.options.size, "--threads", 1, "--quiet",
                           "--samples", f"{begin}:{end}", "--checkpoint", self.folder / name)[0]

    def measure_task(self):
        """Start and cost of a sample: the least of three."""
        short = min(self.part(0, 1, f"short{i}") for i in range(3))
        long = min(self.part(0, 9, f"long{i}") for i in range(3))
        sample = (long - short) / 8
        return max(0.0, short - sample), sample

    def measure_merge(self, count):
        parts = [self.folder / f"merge{k}" for k in range(count)]
        for k, part in enumerate(parts):
            if not part.exists():
                self.part(k, k + 1, part.name)
        return cpu_seconds(self.options.program, "merge", *parts, "-o", self.folder / "merged.exr", "--quiet")

    def check(self, tasks):
        """The longest of a farm's tasks, run one after the other."""
        bounds = [k * CHECKED_SPP // tasks for k in range(tasks + 1)]
        return max(self.part(bounds[k], bounds[k + 1], f"check{tasks}_{k}") for k in range(tasks))


def fit_line(points):
    """Intercept and slope by least squares."""
    n, sx, sy = len(points), sum(x for x, _ in points), sum(y for _, y in points)
    sxx, sxy = sum(x * x for x, _ in points), sum(x * y for x, y in points)
    slope = (n * sxy - sx * sy) / (n * sxx - sx * sx)
    return (sy - slope * sx) / n, slope


def print_scene(options, name, farm):
    start, sample = farm.measure_task()
    merges = [(count, *farm.measure_merge(count)) for count in options.parts]
    base, slope = fit_line([(count, seconds) for count, seconds, _ in merges])
    print(f"\n## {name}, {options.size}, {options.spp} samples per pixel\n")
    print(f"Start {start:.2f} s, a sample of all pixels {sample:.3f} s, merge {max(0.0, base):.2f} s + {slope * 1000:.0f} ms a part.\n")
    print("| parts merged | CPU s | peak MB |\n|--|--|--|")
    for count, seconds, memory in merges:
        print(f"| {count} | {seconds:.2f} | {memory:.0f} |")
    print(f"\n| tasks, {CHECKED_SPP} samples | longest task, CPU s | model | model / measured |\n|--|--|--|--|")
    for tasks in options.checks:
        measured, model = farm.check(tasks), start + CHECKED_SPP / tasks * sample
        print(f"| {tasks} | {measured:.2f} | {model:.2f} | {model / measured:.2f} |")
    print(f"\n| tasks | start s | render s | merge s | frame s | speed-up | efficiency | longest |\n|--|--|--|--|--|--|--|--|")
    alone = start + options.spp * sample / options.threads
    for tasks in (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1000):
        if tasks > options.spp:
            break
        share = {"start": start, "render": -(-options.spp // tasks) * sample / options.threads,
                 "merge": max(0.0, base + slope * tasks) if tasks > 1 else 0.0}
        frame = sum(share.values())
        print(f"| {tasks} | {share['start']:.2f} | {share['render']:.2f} | {share['merge']:.2f} | {frame:.2f} | {alone / frame:.1f} | "
              f"{alone / frame / tasks:.0%} | {max(share, key=share.get)} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--scene", action="append", help="bundled scenes; default: skin_closeup and still_life")
    parser.add_argument("--size", default="480x320")
    parser.add_argument("--spp", type=int, default=4096)
    parser.add_argument("--threads", type=int, default=16)
    parser.add_argument("--parts", type=int, nargs="+", default=[1, 2, 4, 8, 16, 32, 64], help="that are merged to fit the line")
    parser.add_argument("--checks", type=int, nargs="*", default=[1, 2, 4, 8], help="numbers of tasks of the farms that check the model")
    options = parser.parse_args()
    if len(set(options.parts)) < 2:
        parser.error("--parts takes two numbers at least: a line is fitted to them")
    commit = subprocess.run(["git", "-C", TOP, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    words = " ".join(word for word in sys.argv[2:])
    print(f"# A frame over many tasks\n\nMade by `farm_scaling.py PROGRAM{' ' + words if words else ''}` on {datetime.date.today()} at commit {commit}.")
    print("\n".join(__doc__.strip().splitlines()[4:-1]))
    print(f"\nThe model's machines have {options.threads} threads each.")
    for name in options.scene or ["skin_closeup", "still_life"]:
        with tempfile.TemporaryDirectory() as folder:
            print_scene(options, name, Farm(options, name, folder))
        sys.stdout.flush()


if __name__ == "__main__":
    main()
