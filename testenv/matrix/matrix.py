#!/usr/bin/env python3
"""Features of bodies, sheets and metals, each with each, and what must hold of every pair. Needs the Python module in PYTHONPATH.

  matrix.py [--quick] [--only REGEX] [--check REGEX] [--jobs N] [--save FILE] [--list]
  matrix.py --table BEFORE AFTER

A row is a scene and a check. --quick takes the rows of QUICK. The run fails if a row fails that is neither in OPEN nor in
EXEMPT (rules.py). MATRIX_PRECISION=2 in the environment halves the noise of furnaces and ratios, at four
times the cost. --save continues a run: rows that FILE holds are not run again. --table prints two saved runs as results/matrix.md has them.
"""
import argparse
import itertools
import json
import multiprocessing
import pathlib
import re
import sys
import time

import body_checks
import sheet_checks
from features import FEATURES, KINDS, Scenery
from rules import EXEMPT, MOST_EXEMPT, OPEN, QUICK
from sheet_checks import OF_METALS, Sheet


ALONE = ("face to face", "below glass", "glass on its face", "pyramid")  # not with each other feature


def bodies():
    opaque, others = KINDS[0], KINDS[1:]
    features = [f for f in FEATURES if f not in ALONE]
    yield from (Scenery(kind, ()) for kind in KINDS)
    yield from (Scenery(kind, (feature,)) for kind in KINDS for feature in FEATURES if feature != "pyramid")
    yield from (Scenery(kind, ("opacity", "pyramid")) for kind in KINDS)
    yield from (Scenery(opaque, (kind,)) for kind in others)
    yield Scenery("cloudy body", ("glass",))
    yield from (Scenery(opaque, pair) for pair in itertools.combinations(features, 2))
    # Bodies within others, and cameras within them.
    yield from (Scenery(kind, pair) for kind in others for pair in
                itertools.combinations(("opacity", "inner shell", "union", "touching", "cut", "camera inside"), 2))
    yield from (Scenery("cloudy body", (feature, "ball within")) for feature in FEATURES if feature != "ball within")
    yield from (Scenery(opaque, (kind, feature)) for kind in others for feature in ("opacity", "cut", "camera inside", "motion"))


def sheets():
    for metal, names in ((False, tuple(sheet_checks.FEATURES)), (True, OF_METALS)):
        yield Sheet(metal, ())
        yield from (Sheet(metal, (name,)) for name in names)
        yield from (Sheet(metal, pair) for pair in itertools.combinations(names, 2))
    yield from (Sheet(False, ("thin", passing, layer)) for passing in ("diffTrans", "specTrans") for layer in ("coat", "sheen"))
    for anisotropic, roughness in ((0.9, 0.2), (0.9, 1.0), (1.0, 0.2), (1.0, 1.0), (1.11, 0.5), (1.11, 1.0)):
        yield Sheet(True, (), (("anisotropic", anisotropic), ("roughness", roughness)))
    yield Sheet(False, (), (("anisotropic", 0.9), ("roughness", 0.2), ("ior", 4.0)))
    yield Sheet(False, (), (("anisotropic", 1.0), ("roughness", 0.1)))


def rows():
    for scenes, checks in ((bodies(), body_checks.CHECKS), (sheets(), sheet_checks.CHECKS)):
        for scene in scenes:
            yield from ((scene, check) for check in checks if check.asks(scene))


def run(row):
    scene, check = row
    begin = time.process_time()
    try:
        holds, worst, text = check.run(scene)
    except Exception as error:  # a row that cannot be asked fails, and the others go on
        holds, worst, text = False, 1e9, f"{type(error).__name__}: {error}"
    return {"scene": scene.name, "check": check.name, "holds": bool(holds), "worst": float(worst), "given": text,
            "seconds": time.process_time() - begin}


def judge(found):
    """Adds the verdict of a row; True if the run may pass."""
    holds, exempt = found["holds"], next((e for e in EXEMPT if e.covers(found["scene"], found["check"])), None)
    if exempt:
        good = holds or found["worst"] <= exempt.bound
        found["verdict"] = ("holds, though it is exempt" if holds else
                            f"exempt to {exempt.bound:g}: {exempt.reason}" if good else
                            f"FAILS beyond {exempt.bound:g}, to which it is exempt")
        return good
    if (found["scene"], found["check"]) in OPEN:
        found["verdict"] = "holds, though it is listed as open" if holds else "open"
        return True
    found["verdict"] = "holds" if holds else "FAILS"
    return holds


def line(found):
    return (f"{found['scene']:<44} {found['check']:<24} {found['worst']:>9.2f}  {found['given']}  "
            f"[{found['seconds']:.1f} s] {found['verdict']}")


def show(results):
    print("\nThe worst ten, in units of what the rule allows:")
    for found in sorted(results, key=lambda f: -f["worst"])[:10]:
        print(line(found))
    print()
    for check in dict.fromkeys(f["check"] for f in results):
        of = [f for f in results if f["check"] == check]
        count = {v: sum(f["verdict"].startswith(v) for f in of) for v in ("holds", "open", "exempt")}
        print(f"{check:<26} {len(of):>4} rows: {count['holds']} hold, {count['open']} open, {count['exempt']} exempt, "
              f"{len(of) - sum(count.values())} fail")
    print(f"{len(results)} rows, {sum(f['seconds'] for f in results):.0f} s of processor time")


def short(found):
    return "-" if found is None else ("" if found["holds"] else "**FAILS** ") + found["given"]


def table(before, after):
    old, new = ({(f["scene"], f["check"]): f for f in json.load(open(name))} for name in (before, after))
    everything = list(dict.fromkeys([*old, *new]))

    def fails(one, key):
        return key in one and not one[key]["holds"]
    print("| check | rows before | failed | rows after | fail |\n| --- | --- | --- | --- | --- |")
    for check in dict.fromkeys(c for _, c in everything):
        keys = [k for k in everything if k[1] == check]
        print(f"| {check} | " + " | ".join(f"{sum(k in one for k in keys)} | {sum(fails(one, k) for k in keys)}" for one in (old, new)) + " |")
    for title, chosen in (("Rows that fail after", [k for k in everything if fails(new, k)]),
                          ("Rows that failed before and hold after", [k for k in everything if fails(old, k) and k in new and not fails(new, k)]),
                          ("Rows that failed before and were not run after", [k for k in everything if fails(old, k) and k not in new]),
                          ("The closest ten of those that held before",
                           sorted((k for k in old if not fails(old, k)), key=lambda k: -old[k]["worst"])[:10])):
        print(f"\n## {title}\n\n| scene | check | before | after |\n| --- | --- | --- | --- |")
        for key in chosen:
            print(f"| {key[0]} | {key[1]} | {short(old.get(key))} | {short(new.get(key))} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--check", default="")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--save")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--table", nargs=2)
    options = parser.parse_args()
    if options.table:
        return table(*options.table)
    chosen = [(s, c) for s, c in rows() if re.search(options.only, s.name) and re.search(options.check, c.name)
              and (not options.quick or c.name in QUICK.get(s.name, ()))]
    if options.list:
        return print("\n".join(f"{s.name}: {c.name}" for s, c in chosen))
    if not chosen:
        sys.exit("no row matches")
    results, good = [], True
    if options.save and pathlib.Path(options.save).exists():
        results = json.loads(pathlib.Path(options.save).read_text())
        good = all([judge(found) for found in results])
        done = {(f["scene"], f["check"]) for f in results}
        chosen = [(s, c) for s, c in chosen if (s.name, c.name) not in done]
    with multiprocessing.get_context("spawn").Pool(options.jobs) as pool:
        for found in pool.imap(run, chosen):
            good = judge(found) and good
            results.append(found)
            print(line(found), flush=True)
            if options.save:
                part = pathlib.Path(options.save + ".part")
                part.write_text(json.dumps(results, indent=0))
                part.replace(options.save)
    show(results)
    everything = list(rows())
    exempt = sum(any(e.covers(s.name, c.name) for e in EXEMPT) for s, c in everything)
    print(f"{exempt} of all {len(everything)} rows are exempt, {100 * exempt / len(everything):.1f} %")
    if exempt > MOST_EXEMPT * len(everything):
        sys.exit(f"at most {100 * MOST_EXEMPT:g} % may be")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
