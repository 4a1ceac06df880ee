#!/usr/bin/env python3
"""Calibrates the renderer's error estimates on five scenes, measured from outside with the program; prints Markdown.

  interval    the true error of many short renders, compared with the 95 % interval that each reports
  target      the true error at which --target-error ends
  prediction  the predictions of alabaster info --predict, compared with the renders
  adaptive    error^2 x CPU time of adaptive sampling relative to uniform: below 1 it wins at equal time

  python3 testenv/statistical/calibration/calibrate.py [--program PATH] [--part NAME ...] [--scene FILE ...]
      > testenv/statistical/results/calibration.md

Renders and references are kept in --folder, so that an interrupted run can be resumed. A program that renders differently
needs a new folder (references may be copied: --reference N of the same scenes). Needs oiiotool.
"""
import argparse
import json
import math
import os
import pathlib
import re
import resource
import shlex
import statistics
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path.insert(0, str(HERE))
from pictures import Reference, read_exr  # noqa: E402

SCENES = ["skin_closeup", "backlit", "mixed_no_subsurface", "hard_light", "dome_high_contrast"]
REFERENCE_PARTS = 4
REFERENCE_SEED = 1000000  # far from the seeds of other renders


def say(text):
    print(text, file=sys.stderr, flush=True)


def mean_and_error(values):
    """The mean and its standard error (0 for one value)."""
    spread = statistics.stdev(values) / math.sqrt(len(values)) if len(values) > 1 else 0.0
    return statistics.fmean(values), spread


class Bench:
    """Renders and their costs, kept in the folder under the names of the requests."""

    def __init__(self, options, folder):
        self.options = options
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.references = {}

    def run(self, arguments):
        """The program's output, and its wall and CPU seconds from start to end."""
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
        done = subprocess.run([self.options.program, *map(str, arguments)], capture_output=True, text=True)
        wall, after = time.monotonic() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode != 0:
            sys.exit(f"alabaster {shlex.join(map(str, arguments))}\nended with {done.returncode}:\n{done.stderr}")
        return done.stdout, wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def kept(self, name, measure):
        """The record `name`. `measure`, which returns a dictionary, makes it if it does not exist yet."""
        file = self.folder / (name + ".json")
        if not file.exists():
            record = measure()
            part = file.with_suffix(".part")
            part.write_text(json.dumps(record))
            os.replace(part, file)
        return json.loads(file.read_text())

    def render(self, scene, name, size, arguments):
        """Statistics of a render of `scene`, with `process` seconds added. The picture is at `picture(scene, name)`."""
        def measure():
            picture, stats = self.picture(scene, name), self.folder / "stats.json"
            _, wall, cpu = self.run(["render", scene, "-o", picture, "--size", size, "--stats", stats, "--quiet", *arguments])
            return {**json.loads(stats.read_text()), "process": {"wall": wall, "cpu": cpu}}
        record = self.kept(f"{scene.stem}-{name}", measure)
        if "error" not in record:
            sys.exit(f"{scene.stem}-{name}: the render reports no error")
        return record

    def picture(self, scene, name):
        return self.folder / f"{scene.stem}-{name}.exr"

    def reference(self, scene):
        if scene not in self.references:
            each = self.options.reference // REFERENCE_PARTS
            parts = []
            for i in range(REFERENCE_PARTS):
                say(f"{scene.stem}: reference, part {i + 1} of {REFERENCE_PARTS}, {each} samples per pixel")
                name = f"reference-{self.options.size}-{each}-{i}"
                self.render(scene, name, self.options.size, ["--spp", each, "--seed", REFERENCE_SEED + i])
                parts.append(read_exr(self.picture(scene, name)))
            self.references[scene] = Reference(parts)
        return self.references[scene]

    def true_squared_error(self, scene, name, arguments):
        """E^2 of a render of the reference's size, with the render's statistics."""
        stats = self.render(scene, name, self.options.size, arguments)
        return self.reference(scene).squared_error(read_exr(self.picture(scene, name))), stats


def print_interval(bench):
    o = bench.options
    print(f"\n## Interval\n\n{o.seeds} renders of {o.spp} samples per pixel for each scene; the reference has "
          f"{o.reference / o.spp:.0f} times as many. Errors are relative RMSE.\n")
    print("| scene | true error | reference's own | inside | reported / true | spread of the ratio | least | most |")
    print("|--|--|--|--|--|--|--|--|")
    inside = total = 0
    for scene in o.scene:
        ratios, truths, hits = [], [], 0
        for seed in range(o.seeds):
            squared, stats = bench.true_squared_error(scene, f"interval-{o.size}-{o.spp}-{seed}", ["--spp", o.spp, "--seed", seed])
            error, truth = stats["error"], math.sqrt(max(0.0, squared))
            hits += error["low95"] <= truth <= error["high95"]
            truths.append(truth)
            ratios.append(error["relativeRmse"] / truth if truth > 0 else math.inf)
        own = math.sqrt(bench.reference(scene).own_squared_error())
        spread = statistics.stdev(ratios) if len(ratios) > 1 else 0.0
        print(f"| {scene.stem} | {statistics.fmean(truths):.4f} | {own:.4f} | {hits} of {o.seeds} | {statistics.fmean(ratios):.3f} "
              f"| {spread:.3f} | {min(ratios):.3f} | {max(ratios):.3f} |", flush=True)
        inside, total = inside + hits, total + o.seeds
    print(f"\n**{inside} of {total}** true errors lie within the interval that their render reports (required: 90 of 100).")


def print_target(bench):
    o = bench.options
    low, high = 0.8 * o.target, 1.2 * o.target
    print(f"\n## Target\n\n`--target-error {o.target:g}`: the true error at the end should lie between {low:g} and {high:g}.\n")
    print("| scene | seed | samples per pixel | reference : samples | reported | true | within |")
    print("|--|--|--|--|--|--|--|")
    hits = total = 0
    for scene in o.scene:
        for seed in range(1, o.target_seeds + 1):
            say(f"{scene.stem}: to {o.target:g}, seed {seed}")
            squared, stats = bench.true_squared_error(scene, f"target-{o.size}-{o.target:g}-{seed}",
                                                      ["--target-error", o.target, "--seed", seed])
            truth, samples = math.sqrt(max(0.0, squared)), stats["samples"]["perPixel"]
            good = low <= truth <= high
            print(f"| {scene.stem} | {seed} | {samples:.0f} | {o.reference / samples:.1f} | {stats['error']['relativeRmse']:.4f} "
                  f"| {truth:.4f} | {'yes' if good else 'no'} |", flush=True)
            hits, total = hits + good, total + 1
    print(f"\n**{hits} of {total}** within a fifth of the target (required: 9 of 10).")


def predicted(bench, scene, case):
    """{quantity: [value, low, high]}, as printed by info --predict."""
    target, size = case
    text, _, _ = bench.run(["info", scene, "--predict", target, "--size", size])
    pattern = re.compile(r"^  (samples per pixel|wall time|CPU time|peak memory) +([\d.e+]+)(?: \w+)? \(([\d.e+]+) to ([\d.e+]+)\)", re.M)
    found = {name: [float(v) for v in values] for name, *values in pattern.findall(text)}
    if len(found) != 4:
        sys.exit(f"{scene}: unexpected output of info --predict:\n{text}")
    return found


def print_prediction(bench):
    o = bench.options
    print("\n## Prediction\n\n`alabaster info --predict E` (about three seconds) compared with the render to E: wall and CPU time "
          "of the whole process, and its peak memory. `in`: within the predicted range.\n")
    print("| scene | E | size | samples: predicted | taken | wall: predicted | taken | ratio | in | CPU: predicted | taken | ratio | in "
          "| memory: predicted | taken |")
    print("|--|--|--|--|--|--|--|--|--|--|--|--|--|--|--|")
    ratios = {"wall": [], "cpu": []}
    for scene in o.scene:
        for case in o.case:
            target, size = case
            say(f"{scene.stem}: predicting {target} at {size}")
            said = bench.kept(f"{scene.stem}-predict-{size}-{target}", lambda: predicted(bench, scene, case))
            taken = bench.render(scene, f"predicted-{size}-{target}", size, ["--target-error", target])
            cells = [scene.stem, target, size, f"{said['samples per pixel'][0]:.0f}", f"{taken['samples']['perPixel']:.0f}"]
            for name, key in (("wall time", "wall"), ("CPU time", "cpu")):
                value, low, high = said[name]
                actual = taken["process"][key]
                ratios[key].append(value / actual)
                cells += [f"{value:.1f} s", f"{actual:.1f} s", f"{value / actual:.2f}", "yes" if low <= actual <= high else "no"]
            cells += [f"{said['peak memory'][0]:.0f} MB", f"{taken['peakMemory'] / 1e6:.0f} MB"]
            print("| " + " | ".join(cells) + " |", flush=True)
    good = {key: sum(1 / 1.5 <= r <= 1.5 for r in values) for key, values in ratios.items()}
    print(f"\nWithin a factor of 1.5: wall time **{good['wall']} of {len(ratios['wall'])}**, CPU time **{good['cpu']} of "
          f"{len(ratios['cpu'])}** (required: 8 of 10).")


def ratio_with_error(pairs):
    """Ratio of the means of adaptive and uniform, and its standard error by the delta method. The renders of a pair were
    measured one after the other."""
    (a, sa), (u, su) = mean_and_error([p[0] for p in pairs]), mean_and_error([p[1] for p in pairs])
    return a / u, a / u * math.hypot(sa / a, su / u)


def print_adaptive(bench):
    o = bench.options
    print(f"\n## Adaptive sampling\n\n{o.adaptive_seeds} pairs of renders per row. Error^2 x CPU seconds does not depend on the "
          "number of samples, so its ratio decides at equal time: adaptive sampling wins below 1. ± is the standard error.\n")
    print("| scene | samples per pixel | error, uniform | error^2, adaptive : uniform | CPU | error^2 x CPU | verdict | inside, adaptive |")
    print("|--|--|--|--|--|--|--|--|")
    inside = total = 0
    for scene in o.scene:
        for spp in o.adaptive_spp:
            pairs, hits = {"error": [], "cpu": [], "product": []}, 0
            for seed in range(1, o.adaptive_seeds + 1):
                both = []
                for word in ("true", "false"):
                    squared, stats = bench.true_squared_error(scene, f"adaptive-{word}-{o.size}-{spp}-{seed}",
                                                              ["--spp", spp, "--seed", seed, "--set", f"adaptive={word}"])
                    both.append((squared, stats["phases"]["render"]["cpu"]))
                    if word == "true":
                        hits += stats["error"]["low95"] <= math.sqrt(max(0.0, squared)) <= stats["error"]["high95"]
                pairs["error"].append((both[0][0], both[1][0]))
                pairs["cpu"].append((both[0][1], both[1][1]))
                pairs["product"].append((both[0][0] * both[0][1], both[1][0] * both[1][1]))
            error, cpu, product = (ratio_with_error(pairs[key]) for key in ("error", "cpu", "product"))
            distance = (product[0] - 1) / product[1] if product[1] > 0 else 0.0
            verdict = "wins" if distance < -2 else "loses" if distance > 2 else "no difference found"
            uniform = math.sqrt(max(0.0, statistics.fmean(p[1] for p in pairs["error"])))
            print(f"| {scene.stem} | {spp} | {uniform:.4f} | {error[0]:.3f} ± {error[1]:.3f} | {cpu[0]:.3f} ± {cpu[1]:.3f} "
                  f"| {product[0]:.3f} ± {product[1]:.3f} | {verdict} | {hits} of {o.adaptive_seeds} |", flush=True)
            inside, total = inside + hits, total + o.adaptive_seeds
    print(f"\n{inside} of {total} true errors of adaptive renders lie within the interval that they report.")


QUICK = ["--scene", str(ROOT / "testenv/scenes/sample/sample.json"), *"""--size 12x8 --reference 256 --seeds 2 --target 0.3
         --target-seeds 1 --case 0.5@12x8 --adaptive-spp 32 --adaptive-seeds 2""".split()]
PARTS = {"interval": print_interval, "target": print_target, "prediction": print_prediction, "adaptive": print_adaptive}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("--program", default=str(ROOT / "build/release/bin/alabaster"))
    add("--folder", default=str(ROOT / "build/calibration"), help="keeps renders and references")
    add("--quick", action="store_true", help="a tiny run on the sample scene, in a folder of its own, as a test of this script")
    add("--part", nargs="+", choices=PARTS, default=list(PARTS))
    add("--scene", nargs="+", type=pathlib.Path, default=[ROOT / f"testenv/scenes/{n}/{n}.json" for n in SCENES])
    add("--size", default="96x64", help="resolution of everything but predictions")
    add("--reference", type=int, default=32768, help="samples per pixel, in %d independent parts" % REFERENCE_PARTS)
    add("--seeds", type=int, default=20, help="interval: renders per scene")
    add("--spp", type=int, default=16, help="interval: samples per pixel")
    add("--target", type=float, default=0.02)
    add("--target-seeds", type=int, default=2)
    add("--case", nargs="+", default=["0.1@384x256", "0.05@192x128"], help="prediction: error@size")
    add("--adaptive-spp", nargs="+", type=int, default=[64, 256])
    add("--adaptive-seeds", type=int, default=8)
    options = parser.parse_args(QUICK + sys.argv[1:] if "--quick" in sys.argv[1:] else None)
    options.case = [tuple(case.split("@")) for case in options.case]
    if any(len(case) != 2 for case in options.case):
        parser.error("--case: write error@size, for example 0.1@384x256")
    for scene in options.scene:
        if not scene.is_file():
            parser.error(f"{scene}: there is no such scene; name others with --scene")
    if len({scene.stem for scene in options.scene}) < len(options.scene):
        parser.error("--scene: two scenes have the same name and would share their renders")
    if min(options.reference // REFERENCE_PARTS, options.seeds, options.spp, options.target_seeds, options.adaptive_seeds) < 1:
        parser.error(f"counts must be positive, and --reference at least {REFERENCE_PARTS}")
    return options


def main():
    options = arguments()
    print("# Calibration of the renderer's error estimates\n\nMade by\n")
    print("    python3 testenv/statistical/calibration/calibrate.py " + shlex.join(sys.argv[1:]))
    print(f"\nReferences: {options.size} pixels, {options.reference} samples per pixel in {REFERENCE_PARTS} independent parts. Their "
          "scatter gives the reference's own noise, which is subtracted from every true error.")
    with tempfile.TemporaryDirectory() as scratch:
        bench = Bench(options, scratch if options.quick else options.folder)
        for part in options.part:
            PARTS[part](bench)
    return 0


if __name__ == "__main__":
    sys.exit(main())
