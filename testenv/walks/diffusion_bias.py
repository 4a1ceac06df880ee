#!/usr/bin/env python3
"""Measures the bias of each subsurface mode by scatter distance over feature size; prints Markdown.

Runs `alabaster tradeoff` on thick_thin, whose fins are 1.8 mm thick, once for each scatter distance (of the red channel; the
others keep the scene's proportion). Studies are kept in --folder and resumed.

  python3 testenv/walks/diffusion_bias.py [--program PATH] [--budget MINUTES] > testenv/statistical/results/diffusion_bias.md
"""
import argparse
import json
import pathlib
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "testenv/scenes/thick_thin/thick_thin.json"
MATERIAL = "0_wax"
FIN = 0.0018  # metres, make_thick_thin.py
PROPORTION = (1.0, 0.45, 0.225)
RUNGS = ("lambert", "diffusion", "walk")


def study(options, ratio):
    folder = pathlib.Path(options.folder) / f"{ratio:g}"
    folder.mkdir(parents=True, exist_ok=True)
    distance = ",".join(f"{ratio * FIN * p:.3g}" for p in PROPORTION)
    command = [options.program, "tradeoff", str(SCENE), "-o", str(folder), "--only", "^(lambert|diffusion)$", "--size",
               options.size, "--budget", str(options.budget), "--set", f"materials/{MATERIAL}.scatterDistance=[{distance}]", "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{shlex.join(command)}\nended with {done.returncode}:\n{done.stderr}")
    report = json.loads((folder / "tradeoff.json").read_text())
    missing = [name for name in RUNGS if not any(row["configuration"] == name and row["noise2"] for row in report["rows"])]
    if missing:
        sys.exit(f"{options.budget:g} minutes are too few to measure {', '.join(missing)} at d = {ratio:g}: give more with --budget. The renders "
                 "so far are kept")
    return report


def percent(squared):
    return f"{100 * max(0.0, squared) ** 0.5:.1f}"


def cells(report):
    last = {}
    for row in report["rows"]:
        if row["noise2"] and (row["configuration"] not in last or row["samples"] > last[row["configuration"]]["samples"]):
            last[row["configuration"]] = row
    shared = min(last[name]["samples"] for name in RUNGS)
    cost = {r["configuration"]: r["noise2"] * r["cpuSeconds"] for r in report["rows"] if r["samples"] == shared}
    for name in RUNGS:
        row = last[name]
        yield (f"{percent(row['bias2'])} % ({percent(row['bias2Low'])} to {percent(row['bias2High'])}), "
               f"{100 * row['levelBias']:+.1f} %")
    for name in RUNGS[:-1]:
        yield f"{cost[name] / cost['walk']:.2f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/alabaster"))
    parser.add_argument("--folder", default=str(ROOT / "build/diffusion_bias"))
    parser.add_argument("--size", default="96x64")
    parser.add_argument("--budget", type=float, default=2, help="minutes per row")
    parser.add_argument("--ratio", type=float, nargs="+", default=[0.03, 0.1, 0.3, 1, 3])
    options = parser.parse_args()
    print("# Subsurface modes by scatter distance over feature size\n")
    print("    python3 testenv/walks/diffusion_bias.py " + shlex.join(sys.argv[1:]))
    print(f"\n`thick_thin` at {options.size}, {options.budget:g} minutes per row. d: scatterDistance of red over the thickness of "
          "the fins. Bias against the mode `reference`: relative RMSE over the frame with its 95 % interval, then the error of the "
          "mean level. Cost: noise^2 x CPU seconds relative to the walk.\n")
    print("| d | " + " | ".join(f"{name}: bias" for name in RUNGS) + " | " + " | ".join(f"{name}: cost" for name in RUNGS[:-1]) + " |")
    print("|--" * (2 * len(RUNGS)) + "|")
    for ratio in options.ratio:
        print(f"| {ratio:g} | " + " | ".join(cells(study(options, ratio))) + " |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
