#!/usr/bin/env python3
"""Writes cost and error of the quality presets, measured by `alabaster tradeoff`, into schemas/quality_presets.json.

  for scene in ...; do alabaster tradeoff $scene --only '^quality=' -o out/$scene; done
  presets_from_tradeoff.py --command 'the line above' out/*/tradeoff.json

Each tradeoff.json has a configuration quality=NAME for each preset, at several numbers of samples. A preset ends where its
noise reaches its targetError, or at its 'samples'. Time and noise there are interpolated between the rungs by power laws
(straight lines of the logarithms), and extrapolated beyond the last rung as noise^2 ~ 1 / samples and time ~ samples. The
error is the root of noise^2 + bias^2. A bias that the measurement cannot distinguish from zero counts as zero.
"""
import argparse
import json
import math
import os
import pathlib
import sys
import tempfile

PRESETS = pathlib.Path(__file__).resolve().parents[2] / "schemas" / "quality_presets.json"
MINIMUM_SAMPLES = 2  # of a render that its noise ends


class Unusable(Exception):
    """A message for people: the file, the fault and the remedy."""


def read(file):
    try:
        report = json.loads(pathlib.Path(file).read_text())
        report["rows"], report["scene"], report["configurations"]
        return report
    except (OSError, ValueError, KeyError, TypeError) as problem:
        raise Unusable(f"{file}: not a report of alabaster tradeoff ({problem}): measure the scene again") from problem


def check_settings(report, file, preset):
    """Checks that the preset's settings were measured, except those that only end the render."""
    name = "quality=" + preset["name"]
    texts = [c["settings"] for c in report["configurations"] if c["name"] == name]
    if not texts:
        raise Unusable(f"{file}: '{name}' was not measured: run alabaster tradeoff with --only '^quality='")
    measured = {key: value.strip('"') for key, value in (part.split(" ", 1) for part in texts[0].split("; "))}
    for key, value in preset["settings"].items():
        if key in ("samples", "targetError"):
            continue
        wanted = str(value).lower() if isinstance(value, bool) else str(value)
        if measured.get(key) != wanted:
            raise Unusable(f"{file}: '{name}' was measured with {key} {measured.get(key)}, but the preset has {wanted}: "
                           "measure the scene again with a build that has this preset")


def rungs(report, file, name):
    rows = [r for r in report["rows"] if r["configuration"] == name and r["noise2"] and r["cpuSeconds"]]
    rows.sort(key=lambda r: r["samples"])
    if len(rows) < 2:
        raise Unusable(f"{file}: '{name}' has fewer than two rungs: give alabaster tradeoff a larger --budget")
    return rows


def on_power_law(rows, key, samples, beyond):
    """rows[key] at `samples`; `beyond`: the exponent after the last rung."""
    last = rows[-1]
    if samples >= last["samples"]:
        return last[key] * (samples / last["samples"]) ** beyond
    upper = max(1, next(i for i, r in enumerate(rows) if r["samples"] > samples))
    a, b = rows[upper - 1], rows[upper]
    share = math.log(samples / a["samples"]) / math.log(b["samples"] / a["samples"])
    return math.exp((1 - share) * math.log(a[key]) + share * math.log(b[key]))


def samples_to_reach(rows, target, most):
    """The least number of samples whose noise is at most `target`."""
    low, high = MINIMUM_SAMPLES, most
    if on_power_law(rows, "noise2", high, -1) > target ** 2:
        return most
    while low < high:
        middle = (low + high) // 2
        if on_power_law(rows, "noise2", middle, -1) <= target ** 2:
            high = middle
        else:
            low = middle + 1
    return low


def digits(value):
    return float(f"{value:.3g}")


def measured(report, file, preset):
    rows = rungs(report, file, "quality=" + preset["name"])
    settings = preset["settings"]
    samples = samples_to_reach(rows, settings["targetError"], settings["samples"])
    noise = math.sqrt(on_power_law(rows, "noise2", samples, -1))
    best = rows[-1]
    bias = math.sqrt(max(0, best["bias2"])) if (best["bias2Low"] or 0) > 0 else 0
    return {"highestRung": best["samples"], "samples": samples, "noise": noise, "bias": bias, "error": math.hypot(noise, bias),
            "cpuSeconds": on_power_law(rows, "cpuSeconds", samples, 1)}


def scene_name(report):
    path = pathlib.Path(report["scene"])
    return path.parent.name if path.stem in ("scene", "render") else path.stem


def write(file, presets):
    text = json.dumps(presets, indent=2, ensure_ascii=False) + "\n"
    handle, temporary = tempfile.mkstemp(dir=file.parent, prefix=".quality_presets")
    with os.fdopen(handle, "w") as out:
        out.write(text)
    os.chmod(temporary, 0o644)
    os.replace(temporary, file)


def run(arguments):
    presets = json.loads(arguments.presets.read_text())
    for preset in presets["presets"]:
        preset["measured"] = {"settings": preset["settings"], "command": arguments.command, "scenes": {}}
    for file in arguments.reports:
        report = read(file)
        name = scene_name(report)
        numbers = {}
        for preset in presets["presets"]:
            if name in preset["measured"]["scenes"]:
                raise Unusable(f"{file}: the scene '{name}' is given twice: give each scene once")
            check_settings(report, file, preset)
            numbers[preset["name"]] = measured(report, file, preset)
        production = numbers["production"]
        for preset in presets["presets"]:
            own = numbers[preset["name"]]
            own["errorOfProduction"] = own["error"] / production["error"]
            own["timeOfProduction"] = own["cpuSeconds"] / production["cpuSeconds"]
            rounded = {key: value if key in ("samples", "highestRung") else digits(value) for key, value in own.items()}
            preset["measured"]["scenes"][name] = {"resolution": "x".join(str(n) for n in report["resolution"]), **rounded}
    write(arguments.presets, presets)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reports", nargs="+", metavar="tradeoff.json")
    parser.add_argument("--command", required=True, help="the command that made the reports, stored beside the numbers")
    parser.add_argument("--presets", type=pathlib.Path, default=PRESETS, metavar="FILE",
                        help="default: schemas/quality_presets.json")
    try:
        run(parser.parse_args())
    except Unusable as problem:
        print(f"error: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
