#!/usr/bin/env python3
"""Summarizes several studies by `alabaster tradeoff` in one table, printed as Markdown.

  python3 testenv/statistical/tradeoff_summary.py out/*/tradeoff.json
"""
import json
import pathlib
import sys

BIASES = ("walk", "diffusion", "lambert", "maxDepth=4", "maxDepth=8")
COSTS = ("adaptive=on", "diffusion", "lambert", "reference", "walkGuiding=off", "walkSphereSteps=off")


def last_rows(report):
    """Each configuration's row of most samples."""
    rows = {}
    for row in report["rows"]:
        if row["noise2"] and (row["configuration"] not in rows or row["samples"] > rows[row["configuration"]]["samples"]):
            rows[row["configuration"]] = row
    return rows


def cost(report, name):
    """noise^2 x CPU seconds relative to the walk, at the highest sample count that both have."""
    products = {}
    for row in report["rows"]:
        if row["noise2"] and row["configuration"] in (name, "walk"):
            products.setdefault(row["samples"], {})[row["configuration"]] = row["noise2"] * row["cpuSeconds"]
    both = [samples for samples, pair in products.items() if len(pair) == (1 if name == "walk" else 2)]
    if not both:
        return "-"
    pair = products[max(both)]
    return f"{pair[name] / pair['walk']:.2f}"


def bias(rows, name):
    if name not in rows:
        return "-"
    row = rows[name]
    # An interval that holds zero shows no bias; its upper end bounds the bias.
    if row["bias2Low"] <= 0:
        return f"< {100 * row['bias2High'] ** 0.5:.1f} %" if row["bias2High"] > 0 else "none seen"
    return f"{100 * row['bias2'] ** 0.5:.1f} %"


def main():
    reports = {}
    for file in sys.argv[1:]:
        report = json.loads(pathlib.Path(file).read_text())
        reports[pathlib.Path(report["scene"]).stem] = report
    print("Bias: the relative RMSE that remains with any number of samples, the reference's noise subtracted. '< x' means that "
          "none was found; x is the end of the 95 % interval ('none seen': x is 0). Each column differs from the walk (maxDepth 32) in one setting.\n")
    print("| scene | " + " | ".join(BIASES) + " |")
    print("|--" * (1 + len(BIASES)) + "|")
    for scene, report in reports.items():
        rows = last_rows(report)
        print(f"| {scene} | " + " | ".join(bias(rows, name) for name in BIASES) + " |")
    print("\nCost at equal noise: noise^2 x CPU seconds relative to the walk.\n")
    print("| scene | walk: noise at samples, CPU s | " + " | ".join(COSTS) + " |")
    print("|--" * (2 + len(COSTS)) + "|")
    for scene, report in reports.items():
        walk = last_rows(report)["walk"]
        first = f"{100 * walk['noise2'] ** 0.5:.1f} % at {walk['samples']}, {walk['cpuSeconds']:.1f} s"
        print(f"| {scene} | {first} | " + " | ".join(cost(report, name) for name in COSTS) + " |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
