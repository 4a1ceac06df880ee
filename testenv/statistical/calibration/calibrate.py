#!/usr/bin/env python3
"""Calibrates the renderer's promises about errors, measured from outside with the program; prints Markdown.

  interval    the true error of many short renders, compared with the 95 % interval that each reports
  target      the true error at which --target-error ends
  presets     the true error at which --quality ends, with its bias
  bias        the bias of each bound on bounces, from renders of equal random numbers
  law         how the squared error falls with the number of samples, compared with the law that the estimate extends it by
  prediction  the predictions of alabaster info --predict, compared with the renders
  adaptive    error^2 x CPU time of adaptive sampling relative to uniform: below 1 it wins at equal time

  python3 testenv/statistical/calibration/calibrate.py [--program PATH] [--part NAME ...] [--scene FILE ...]
      > testenv/statistical/results/calibration.md

The scenes are bundled ones and those of make_scenes.py, which no setting was chosen by. Renders and references are kept
in --folder, so that the next run begins where an interrupted one ended. A program that renders or estimates differently needs a new folder. With
--processes N, N renders of one thread each run at a time. Renders that are not begun within --seconds are left out and counted;
with --cheap-first those that need the most samples are.
"""
import argparse
import concurrent.futures
import json
import math
import os
import pathlib
import re
import shlex
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from typing import NamedTuple

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path.insert(0, str(HERE))
from make_scenes import write_all  # noqa: E402
from pictures import Reference, read_exr  # noqa: E402

BUNDLED = ["skin_closeup", "backlit", "mixed_no_subsurface", "hard_light", "dome_high_contrast", "thick_thin"]
REFERENCE_SEED = 1000000  # far from the seeds of other renders
PRESETS = ROOT / "schemas/quality_presets.json"
PROMISES = {preset["name"]: preset["promisedError"] for preset in json.loads(PRESETS.read_text())["presets"] if "promisedError" in preset}


def say(text):
    print(text, file=sys.stderr, flush=True)


def mean_and_error(values):
    """The mean and its standard error (0 for one value)."""
    spread = statistics.stdev(values) / math.sqrt(len(values)) if len(values) > 1 else 0.0
    return statistics.fmean(values), spread


class Job(NamedTuple):
    """A render, kept under the names of its scene and its own."""
    scene: pathlib.Path
    name: str
    size: str
    arguments: tuple

    @property
    def key(self):
        return f"{self.scene.stem}-{self.name}"


class Prediction(NamedTuple):
    scene: pathlib.Path
    target: str
    size: str

    @property
    def key(self):
        return f"{self.scene.stem}-predict-{self.size}-{self.target}"


class Bench:
    """Renders and their costs, kept in the folder under the names of the requests."""

    def __init__(self, options, folder):
        self.options = options
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.references, self.failures, self.left_out = {}, [], 0
        self.ends = time.monotonic() + options.seconds
        self.lock = threading.Lock()
        self.rows = []  # of all tables, for --json

    def run(self, arguments):
        """The program's output, and its wall and CPU seconds from start to end."""
        own_thread = ["--threads", 1] if self.options.processes else []
        start = time.monotonic()
        with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as errors:
            process = subprocess.Popen([str(word) for word in [self.options.program, *arguments, *own_thread]], stdout=output,
                                       stderr=errors)
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            wall = time.monotonic() - start
            output.seek(0), errors.seek(0)
            if process.returncode != 0:
                raise RuntimeError(f"alabaster {shlex.join(map(str, arguments))} ended with {process.returncode}:\n{errors.read()}")
            return output.read(), wall, usage.ru_utime + usage.ru_stime

    def do(self, job):
        file = self.folder / (job.key + ".json")
        if file.exists():
            return
        if time.monotonic() > self.ends:
            with self.lock:
                self.left_out += 1
            return
        try:
            record = self.predict(job) if isinstance(job, Prediction) else self.render(job)
        except (RuntimeError, OSError, ValueError) as problem:
            with self.lock:
                self.failures.append(f"{job.key}: {problem}")
            return
        part = file.with_suffix(".part")
        part.write_text(json.dumps(record))
        os.replace(part, file)
        say(f"{job.key} {record.get('process', {}).get('cpu', 0):.1f}")

    def do_all(self, jobs):
        with concurrent.futures.ThreadPoolExecutor(self.options.processes or 1) as pool:
            list(pool.map(self.do, jobs))

    def render(self, job):
        """Statistics of a render, with `process` seconds added."""
        stats = self.folder / (job.key + ".stats")
        _, wall, cpu = self.run(["render", job.scene, "-o", self.picture(job), "--size", job.size, "--stats", stats, "--quiet",
                                 *job.arguments])
        record = json.loads(stats.read_text())
        stats.unlink()
        if "error" not in record and record["samples"]["perPixel"] >= 2:
            raise RuntimeError("the render reports no error")
        return {**{key: record.get(key) for key in ("samples", "error", "phases", "peakMemory")}, "target": record.get("target"),
                "groupsOverFrame": record["delegate"][0].get("error.groupsOverFrame"), "process": {"wall": wall, "cpu": cpu}}

    def predict(self, job):
        """{quantity: [value, low, high]}, as printed by info --predict."""
        text, _, _ = self.run(["info", job.scene, "--predict", job.target, "--size", job.size])
        pattern = re.compile(r"^  (samples per pixel|wall time|CPU time|peak memory) +([\d.e+]+)(?: \w+)? \(([\d.e+]+) to ([\d.e+]+)\)", re.M)
        found = {name: [float(v) for v in values] for name, *values in pattern.findall(text)}
        if len(found) != 4:
            raise RuntimeError(f"unexpected output of info --predict:\n{text}")
        return found

    def record(self, job):
        """None: it has not been made."""
        file = self.folder / (job.key + ".json")
        return json.loads(file.read_text()) if file.exists() else None

    def picture(self, job):
        return self.folder / (job.key + ".exr")

    def pictures(self, jobs):
        """None unless all are there."""
        return [read_exr(self.picture(job)) for job in jobs] if all(self.record(job) for job in jobs) else None

    def reference(self, scene):
        """None: parts of it are missing."""
        if scene not in self.references:
            parts = self.pictures(reference_jobs(self.options, scene))
            self.references[scene] = Reference(parts) if parts else None
        return self.references[scene]

    def measured(self, job):
        """(true error, record) of a render of the reference's size; None where one of the two is missing."""
        record, reference = self.record(job), self.reference(job.scene)
        if not record or not reference:
            return None
        squared = reference.squared_error(read_exr(self.picture(job)))
        row = {"render": job.key, "trueSquared": squared, "referenceSquared": reference.own_squared_error(), **record}
        self.rows.append(row)
        return squared, record


def root(squared):
    return math.sqrt(max(0.0, squared))


def deep(o):
    """All renders but those of presets have the reference's bounces: their errors are noise alone."""
    return ("--max-depth", o.depth)


def size_of(o, scene):
    return o.size_of.get(scene.stem, o.size)


def reference_jobs(o, scene):
    each, size = o.reference // o.reference_parts, size_of(o, scene)
    return [Job(scene, f"reference-{size}-{each}-{i}", size, (*deep(o), "--spp", each, "--seed", REFERENCE_SEED + i))
            for i in range(o.reference_parts_of.get(scene.stem, o.reference_parts))]


def interval_jobs(o, scene, spp):
    return [Job(scene, f"interval-{size_of(o, scene)}-{spp}-{seed}", size_of(o, scene), (*deep(o), "--spp", spp, "--seed", seed))
            for seed in range(1, o.seeds + 1)]


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def print_interval(bench):
    o = bench.options
    print(f"\n## Interval\n\n{o.seeds} renders for each row. Errors are relative RMSE; the range of the true error holds 19 of 20 renders. "
          "Width: high over low. An error that is not known counts as inside if it is at least the reported bound.\n")
    print("| scene | samples | true error | its range | reference's own | inside | not known | width, median | reported / true | least | most |")
    print("|--|--|--|--|--|--|--|--|--|--|--|")
    inside = total = unknown = wrong = 0
    widths = []
    for scene in o.scene:
        for spp in o.spp:
            rows = [row for job in interval_jobs(o, scene, spp) if (row := bench.measured(job))]
            if not rows:
                continue
            truths, errors = [root(squared) for squared, _ in rows], [record["error"] for _, record in rows]
            is_known = [error["isKnown"] for error in errors]
            hits = sum(error["low95"] <= t and (t <= error["high95"] or not known)
                       for t, error, known in zip(truths, errors, is_known))
            ratios = [error["relativeRmse"] / t if t > 0 else math.inf for t, error in zip(truths, errors)]
            wide = [error["high95"] / error["low95"] for error in errors if error["low95"] > 0]
            low, high = percentile(truths, 0.025), percentile(truths, 0.975)
            print(f"| {scene.stem} | {spp} | {statistics.fmean(truths):.4f} | {low:.4f} to {high:.4f} "
                  f"| {root(bench.reference(scene).own_squared_error()):.4f} | {hits} of {len(rows)} | {len(rows) - sum(is_known)} "
                  f"| {statistics.median(wide) if wide else math.inf:.2f} | {statistics.median(ratios):.3f} | {min(ratios):.3f} | {max(ratios):.3f} |")
            inside, total, unknown = inside + hits, total + len(rows), unknown + len(rows) - sum(is_known)
            wrong += sum(not known for known in is_known) if high < 2 * low else 0
            widths += wide
    if total:
        print(f"\n**{inside} of {total}** true errors lie within the interval that their render reports (required: 95 of 100). The error of "
              f"**{unknown}** is not known (at most 10 of 100), of {wrong} of them on rows whose true errors lie within a factor of 2. "
              f"Median width: {statistics.median(widths):.2f}.")


def target_jobs(o, scene):
    return [Job(scene, f"target-{size_of(o, scene)}-{o.target:g}-{seed}", size_of(o, scene), (*deep(o), "--target-error", o.target, "--seed", seed, "--spp", o.most))
            for seed in range(1, o.target_seeds + 1)]


def print_target(bench):
    o = bench.options
    print(f"\n## Target\n\n`--target-error {o.target:g} --spp {o.most}`: the true error at the end is at most {1.2 * o.target:g}, or the render says "
          "that it missed, or may have. True over asked: below 1 the render took longer than the target needs. Groups over frame: the errors of "
          "groups of pixels, which end others, over the frame's at the last check.\n")
    print("| scene | seed | samples per pixel | groups over frame | reported | true | reference's own | true over asked | met | says that it missed |")
    print("|--|--|--|--|--|--|--|--|--|--|")
    rows = []
    for scene in o.scene:
        for seed, job in enumerate(target_jobs(o, scene), 1):
            if not (row := bench.measured(job)):
                continue
            squared, record = row
            truth, missed = root(squared), record["target"]["missed"]
            reached = truth / o.target
            print(f"| {scene.stem} | {seed} | {record['samples']['perPixel']:.0f} | {record.get('groupsOverFrame') or math.nan:.2f} "
                  f"| {record['error']['relativeRmse']:.4f} | {truth:.4f} | {root(bench.reference(scene).own_squared_error()):.4f} | {reached:.2f} | {'yes' if reached <= SLACK else 'no'} "
                  f"| {'yes' if missed else 'no'} |")
            rows.append((reached, missed))
    print(kept_or_told(rows))


SLACK = 1.2  # a fifth more than the target or the promise counts as met


def kept_or_told(rows):
    """`rows`: (true error over the one that was asked for, says that it missed)."""
    if not rows:
        return ""
    met, told = sum(reached <= SLACK for reached, _ in rows), sum(reached > SLACK and missed for reached, missed in rows)
    needless = sum(reached <= SLACK and missed for reached, missed in rows)
    silent = [reached for reached, missed in rows if not missed]
    text = (f"\n**{met + told} of {len(rows)}** renders reached the error or reported a miss. Reached: {met}. Missed and reported: {told}. "
            f"Reached, but reported as a miss: {needless}.")
    if silent:
        text += (f" The ratio of true to requested error over renders without a report has the median {statistics.median(silent):.2f} "
                 f"and the range {min(silent):.2f} to {max(silent):.2f}.")
    return text


def preset_jobs(o, scene):
    cap = ("--spp", o.preset_most) if o.preset_most else ()
    return [(preset, seed, Job(scene, f"preset-{preset}-{o.preset_most}-{size_of(o, scene)}-{seed}", size_of(o, scene), ("--quality", preset, "--seed", seed, *cap)))
            for preset in o.preset for seed in range(1, o.preset_seeds + 1)]


def print_presets(bench):
    o = bench.options
    caps = f", with at most {o.preset_most} samples" if o.preset_most else ""
    print(f"\n## Presets\n\n`--quality`{caps}. The true error includes the bias: the reference has {o.depth} bounces. Promised: "
          + ", ".join(f"{name} {error:g}" for name, error in PROMISES.items()) + ". A fifth more counts as met.\n")
    print("| scene | preset | seed | samples per pixel | ended by | reported noise | true error | reference's own | met | says that it missed | CPU |")
    print("|--|--|--|--|--|--|--|--|--|--|--|")
    tally, worst = {}, []
    for scene in o.scene:
        for preset, seed, job in preset_jobs(o, scene):
            if not (row := bench.measured(job)):
                continue
            squared, record = row
            truth, target = root(squared), record["target"]
            reached = truth / PROMISES[preset]
            print(f"| {scene.stem} | {preset} | {seed} | {record['samples']['perPixel']:.0f} | {target['endedBy']} | {record['error']['relativeRmse']:.4f} "
                  f"| {truth:.4f} | {root(bench.reference(scene).own_squared_error()):.4f} | {'yes' if reached <= SLACK else 'no'} "
                  f"| {'yes' if target['missed'] else 'no'} | {record['process']['cpu']:.1f} s |")
            rows, capped = tally.setdefault(preset, ([], []))
            rows.append((reached, target["missed"]))
            capped += [scene.stem] if target["endedBy"] == "samples" else []
            worst.append((reached, f"{scene.stem} at {preset}"))
    for preset, (rows, capped) in tally.items():
        print(f"\n{preset}: {kept_or_told(rows).strip()} Renders ended by the sample limit: {len(capped)}.")
    if worst:
        print("\nThe four worst: " + "; ".join(f"{name} ({ratio:.2f} of the promise)" for ratio, name in sorted(worst, reverse=True)[:4]) + ".")


FEWEST_SCENES = 12


def write_presets(bench):
    """Puts what the presets reach into their file: of each preset that enough scenes have been measured with. Scenes that it has with the same
    settings and that were not measured now stay."""
    o, file = bench.options, json.loads(PRESETS.read_text())
    for preset in file["presets"]:
        if preset["name"] not in o.preset:
            continue
        scenes = {}
        for scene in o.scene:
            rows = [bench.measured(job) for name, _, job in preset_jobs(o, scene) if name == preset["name"]]
            if not rows or not all(rows):
                continue
            records = [record for _, record in rows]
            scenes[scene.stem] = {
                "resolution": size_of(o, scene), "samples": round(statistics.fmean(r["samples"]["perPixel"] for r in records)),
                "endedBy": records[0]["target"]["endedBy"],
                "saidMissed": records[0]["target"]["missed"], "noise": digits(statistics.fmean(r["error"]["relativeRmse"] for r in records)),
                "error": digits(root(statistics.fmean(squared for squared, _ in rows))),
                "cpuSeconds": digits(statistics.fmean(r["process"]["cpu"] for r in records))}
        limit = {"samples": o.preset_most} if o.preset_most else {}
        measured = {"settings": {**preset["settings"], **limit}, "command": command_line(), "scenes": scenes}
        if preset["measured"]["settings"] == measured["settings"] and set(preset["measured"]["scenes"]) - set(scenes):
            measured["scenes"] = {**preset["measured"]["scenes"], **scenes}
            measured["command"] = "; ".join(dict.fromkeys([*preset["measured"]["command"].split("; "), command_line()]))
        if len(measured["scenes"]) < FEWEST_SCENES:
            say(f"{preset['name']}: {len(measured['scenes'])} scenes have been measured, so its part of the presets' file stays as it is")
            continue
        preset["measured"] = measured
    PRESETS.write_text(json.dumps(file, indent=2) + "\n")


def command_line():
    """Without the paths and the time of this run."""
    words, left = [], iter(sys.argv[1:])
    for word in left:
        if word in ("--program", "--folder", "--json", "--seconds"):
            next(left)
        elif word != "--write-presets":
            words.append(word)
    return "python3 testenv/statistical/calibration/calibrate.py " + shlex.join(words)


def digits(value):
    return float(f"{value:.3g}")


def bias_jobs(o, scene, depth):
    return [Job(scene, f"depth-{depth}-{size_of(o, scene)}-{o.bias_spp}-{i}", size_of(o, scene), ("--max-depth", depth, "--spp", o.bias_spp, "--seed", 500 + i))
            for i in range(4)]


def print_bias(bench):
    o = bench.options
    print(f"\n## Bias of the bounds on bounces\n\nRelative RMSE against {o.depth} bounces, from 4 renders of {o.bias_spp} samples with the same random "
          "numbers. ± is the noise of that. `level`: change of the frame's mean.\n")
    print("| scene | " + " | ".join(f"{depth} bounces | level" for depth in o.depths) + " |")
    print("|--|" + "--|--|" * len(o.depths))
    for scene in o.scene:
        reference, whole = bench.reference(scene), bench.pictures(bias_jobs(o, scene, o.depth))
        cells = []
        for depth in o.depths:
            parts = bench.pictures(bias_jobs(o, scene, depth))
            if not reference or not whole or not parts:
                cells += ["", ""]
                continue
            squared, noise = reference.squared_difference(parts, whole)
            level = sum(map(sum, (p for part in parts for p in part.planes))) / sum(map(sum, (p for part in whole for p in part.planes)))
            bench.rows.append({"bias": scene.stem, "depth": depth, "squared": squared, "noise": noise, "level": level - 1})
            cells += [f"{root(squared):.4f} ± {root(noise) / 2:.4f}", f"{100 * (level - 1):+.1f} %"]
        print(f"| {scene.stem} | " + " | ".join(cells) + " |")


LAW_SAMPLES = [1, 2, 4, 8, 16, 32, 64]


def law_jobs(o, scene, spp):
    return [Job(scene, f"law-{size_of(o, scene)}-{spp}-{seed}", size_of(o, scene), (*deep(o), "--spp", spp, "--seed", seed)) for seed in range(1, o.law_seeds + 1)]


def print_law(bench):
    """The three differences are those of core/convergence/frame_error.md, "The law of convergence", without their noise."""
    o = bench.options
    print(f"\n## Law of convergence\n\nMean E^2 of {o.law_seeds} renders with 1 to {LAW_SAMPLES[-1]} samples, times their number, and ± its standard error; "
          "independent samples have the same in all columns. E^2 at the last number over what the law makes of it from the last four: above 1 it is "
          "estimated too high.\n")
    print("| scene | " + " | ".join(str(m) for m in LAW_SAMPLES) + " | previous, earlier | E^2 by the law : E^2 |")
    print("|--|" + "--|" * (len(LAW_SAMPLES) + 2))
    for scene in o.scene:
        errors = {}
        for m in LAW_SAMPLES:
            pictures, reference = bench.pictures(law_jobs(o, scene, m)), bench.reference(scene)
            if pictures and reference:
                errors[m] = mean_and_error([reference.squared_error(picture) for picture in pictures])
        if len(errors) < len(LAW_SAMPLES):
            continue
        v = [errors[m][0] for m in LAW_SAMPLES]
        latest, previous, earlier = v[-2] - v[-1], (v[-3] - v[-2]) / (v[-2] - v[-1]), (v[-4] - v[-3]) / (v[-2] - v[-1])
        a = (16 - earlier) / 12
        law = a + (1 + previous - 3 * a) / 15
        cells = [f"{m * mean:.3f} ± {m * spread:.3f}" for m, (mean, spread) in errors.items()]
        print(f"| {scene.stem} | " + " | ".join(cells) + f" | {previous:.2f}, {earlier:.2f} | {law * latest / v[-1]:.2f} |")


def predictions(o, scene):
    return [(Prediction(scene, target, size), Job(scene, f"predicted-{size}-{target}", size, ("--target-error", target))) for target, size in o.case]


def print_prediction(bench):
    o = bench.options
    print("\n## Prediction\n\n`alabaster info --predict E` (about three seconds) compared with the render to E: wall and CPU time "
          "of the whole process, and its peak memory. `in`: within the predicted range.\n")
    print("| scene | E | size | samples: predicted | taken | wall: predicted | taken | ratio | in | CPU: predicted | taken | ratio | in "
          "| memory: predicted | taken |")
    print("|--|--|--|--|--|--|--|--|--|--|--|--|--|--|--|")
    ratios = {"wall": [], "cpu": []}
    for scene in o.scene:
        for prediction, job in predictions(o, scene):
            said, taken = bench.record(prediction), bench.record(job)
            if not said or not taken:
                continue
            cells = [scene.stem, prediction.target, prediction.size, f"{said['samples per pixel'][0]:.0f}", f"{taken['samples']['perPixel']:.0f}"]
            for name, key in (("wall time", "wall"), ("CPU time", "cpu")):
                value, low, high = said[name]
                actual = taken["process"][key]
                ratios[key].append(value / actual)
                cells += [f"{value:.1f} s", f"{actual:.1f} s", f"{value / actual:.2f}", "yes" if low <= actual <= high else "no"]
            cells += [f"{said['peak memory'][0]:.0f} MB", f"{taken['peakMemory'] / 1e6:.0f} MB"]
            print("| " + " | ".join(cells) + " |")
    good = {key: sum(1 / 1.5 <= r <= 1.5 for r in values) for key, values in ratios.items()}
    print(f"\nWithin a factor of 1.5: wall time **{good['wall']} of {len(ratios['wall'])}**, CPU time **{good['cpu']} of "
          f"{len(ratios['cpu'])}** (required: 8 of 10).")


def ratio_with_error(pairs):
    """Ratio of the means of adaptive and uniform, and its standard error by the delta method. The renders of a pair were
    measured one after the other."""
    (a, sa), (u, su) = mean_and_error([p[0] for p in pairs]), mean_and_error([p[1] for p in pairs])
    return a / u, a / u * math.hypot(sa / a, su / u)


def adaptive_pairs(o, scene, spp):
    return [[Job(scene, f"adaptive-{word}-{size_of(o, scene)}-{spp}-{seed}", size_of(o, scene), (*deep(o), "--spp", spp, "--seed", seed, "--set", f"adaptive={word}"))
             for word in ("true", "false")] for seed in range(1, o.adaptive_seeds + 1)]


def print_adaptive(bench):
    o = bench.options
    print(f"\n## Adaptive sampling\n\n{o.adaptive_seeds} pairs of renders per row. Error^2 x CPU seconds does not depend on the "
          "number of samples, so its ratio decides at equal time: adaptive sampling wins below 1. ± is the standard error.\n")
    print("| scene | samples per pixel | error, uniform | error^2, adaptive : uniform | CPU | error^2 x CPU | verdict | inside, adaptive |")
    print("|--|--|--|--|--|--|--|--|")
    inside = total = 0
    for scene in o.scene:
        for spp in o.adaptive_spp:
            both = [[bench.measured(job) for job in pair] for pair in adaptive_pairs(o, scene, spp)]
            both = [[(squared, stats["phases"]["render"]["cpu"], stats["error"]) for squared, stats in pair] for pair in both if all(pair)]
            if not both:
                continue
            hits = sum(error["low95"] <= root(squared) <= error["high95"] for (squared, _, error), _ in both)
            error, cpu, product = (ratio_with_error([tuple(map(value, pair)) for pair in both])
                                   for value in (lambda r: r[0], lambda r: r[1], lambda r: r[0] * r[1]))
            distance = (product[0] - 1) / product[1] if product[1] > 0 else 0.0
            verdict = "wins" if distance < -2 else "loses" if distance > 2 else "no difference found"
            uniform = root(statistics.fmean(pair[1][0] for pair in both))
            print(f"| {scene.stem} | {spp} | {uniform:.4f} | {error[0]:.3f} ± {error[1]:.3f} | {cpu[0]:.3f} ± {cpu[1]:.3f} "
                  f"| {product[0]:.3f} ± {product[1]:.3f} | {verdict} | {hits} of {len(both)} |")
            inside, total = inside + hits, total + len(both)
    print(f"\n{inside} of {total} true errors of adaptive renders lie within the interval that they report.")


def jobs_of(o):
    """Long ones first, so that the last to run are short; or short ones first, so that few are missing at the end of the time."""
    part = lambda name: o.scene if name in o.part else []  # noqa: E731
    jobs = [job for scene in o.scene for job in reference_jobs(o, scene)] if set(o.part) != {"prediction"} else []
    presets = [row for scene in part("presets") for row in preset_jobs(o, scene)]
    jobs += [job for _, _, job in sorted(presets, key=lambda row: PROMISES[row[0]], reverse=o.cheap_first)]
    jobs += [job for scene in part("target") for job in target_jobs(o, scene)]
    jobs += [job for scene in part("adaptive") for spp in o.adaptive_spp for pair in adaptive_pairs(o, scene, spp) for job in pair]
    jobs += [job for scene in part("bias") for depth in (*o.depths, o.depth) for job in bias_jobs(o, scene, depth)]
    jobs += [job for scene in part("law") for m in LAW_SAMPLES for job in law_jobs(o, scene, m)]
    jobs += [job for scene in part("prediction") for pair in predictions(o, scene) for job in pair]
    return jobs + [job for scene in part("interval") for spp in o.spp for job in interval_jobs(o, scene, spp)]


QUICK = """--size 12x8 --reference 256 --seeds 2 --spp 16 --target 0.3 --most 512 --target-seeds 1 --preset preview --preset-seeds 1 --preset-most 64
           --bias-spp 8 --depths 2 --law-seeds 2 --case 0.5@12x8 --adaptive-spp 32 --adaptive-seeds 2""".split()
PARTS = {"interval": print_interval, "target": print_target, "presets": print_presets, "bias": print_bias, "law": print_law,
         "prediction": print_prediction, "adaptive": print_adaptive}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("--program", default=str(ROOT / "build/release/bin/alabaster"))
    add("--folder", default=str(ROOT / "build/calibration"), type=pathlib.Path, help="keeps renders and references")
    add("--quick", action="store_true", help="a tiny run on two scenes, in a folder of its own, as a test of this script")
    add("--part", nargs="+", choices=PARTS, default=["interval", "target", "presets", "bias", "prediction"])
    add("--scene", nargs="+", type=pathlib.Path, help="default: the bundled ones and those of make_scenes.py")
    add("--processes", type=int, default=0, help="renders of one thread at a time; 0: one render with all cores")
    add("--seconds", type=float, default=1e9, help="after which no render is begun")
    add("--cheap-first", action="store_true", help="begin with the presets that promise least")
    add("--json", type=pathlib.Path, help="file for all numbers")
    add("--write-presets", action="store_true", help="put what part `presets` measured into schemas/quality_presets.json")
    add("--size", default="48x32", help="resolution of everything but predictions")
    add("--size-of", nargs="+", default=[], metavar="SCENE=SIZE", help="another resolution of a scene, where light is rare")
    add("--depth", type=int, default=64, help="bounces of references")
    add("--reference", type=int, default=16384, help="samples per pixel, in independent parts")
    add("--reference-parts", type=int, default=8)
    add("--reference-parts-of", nargs="+", default=[], metavar="SCENE=PARTS", help="more parts as large, where light is rare")
    add("--seeds", type=int, default=20, help="interval: renders per row")
    add("--spp", nargs="+", type=int, default=[16, 64], help="interval: samples per pixel")
    add("--target", type=float, default=0.05)
    add("--target-seeds", type=int, default=2)
    add("--most", type=int, default=16384, help="target: samples per pixel, at most")
    add("--preset", nargs="+", choices=PROMISES, default=list(PROMISES))
    add("--preset-seeds", type=int, default=1)
    add("--preset-most", type=int, default=0, help="samples per pixel in the place of the presets' own limits; 0: those")
    add("--bias-spp", type=int, default=256)
    add("--depths", nargs="+", type=int, default=[4, 6, 8, 12, 16, 32])
    add("--law-seeds", type=int, default=8)
    add("--case", nargs="+", default=["0.05@96x64"], help="prediction: error@size")
    add("--adaptive-spp", nargs="+", type=int, default=[64, 256])
    add("--adaptive-seeds", type=int, default=4)
    options = parser.parse_args(QUICK + sys.argv[1:] if "--quick" in sys.argv[1:] else None)
    options.reference_parts_of = {name: int(parts) for name, parts in (word.split("=") for word in options.reference_parts_of)}
    options.size_of = dict(word.split("=") for word in options.size_of)
    options.case = [tuple(case.split("@")) for case in options.case]
    if any(len(case) != 2 for case in options.case):
        parser.error("--case: write error@size, for example 0.1@384x256")
    for scene in options.scene or []:
        if not scene.is_file():
            parser.error(f"{scene}: there is no such scene; name others with --scene")
    if options.scene and len({scene.stem for scene in options.scene}) < len(options.scene):
        parser.error("--scene: two scenes have the same name and would share their renders")
    if min(options.reference // options.reference_parts, options.seeds, options.target_seeds, options.adaptive_seeds,
           options.reference_parts - 1) < 1 or options.processes < 0:
        parser.error("counts must be positive, and --reference at least --reference-parts, which are at least 2")
    return options


def scenes(folder, quick):
    bundled, own = [ROOT / f"testenv/scenes/{name}/{name}.json" for name in BUNDLED], write_all(folder / "scenes")
    return [ROOT / "testenv/scenes/sample/sample.json", own[0]] if quick else bundled + own


def main():
    options = arguments()
    with tempfile.TemporaryDirectory() as scratch:
        bench = Bench(options, scratch if options.quick else options.folder)
        options.scene = options.scene or scenes(bench.folder, options.quick)
        bench.do_all(jobs_of(options))
        print("# Calibration of what the renderer promises about errors\n\nMade by\n")
        print("    " + command_line())
        but = f" ({', '.join(f'{size} on {name}' for name, size in options.size_of.items())})" if options.size_of else ""
        print(f"\nReferences: {options.size} pixels{but}, {options.reference} samples per pixel in {options.reference_parts} independent parts, "
              f"{options.depth} bounces. Their scatter gives the reference's own noise, which is subtracted from every true error.")
        for part in options.part:
            PARTS[part](bench)
        if bench.left_out:
            print(f"\n{bench.left_out} renders were left out: they were not begun within {options.seconds:.0f} seconds.")
        if options.write_presets:
            write_presets(bench)
        if options.json:
            options.json.write_text(json.dumps(bench.rows))
    for failure in bench.failures:
        say(failure)
    return 1 if bench.failures else 0


if __name__ == "__main__":
    sys.exit(main())
