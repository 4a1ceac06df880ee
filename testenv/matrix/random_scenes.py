#!/usr/bin/env python3
"""Twenty scenes of three features or more, drawn at random with fixed numbers, each written down in other ways: turned, mirrored, in
another order, as arrays and as copies. Each shows the picture of the scene as it is. Needs the Python module in PYTHONPATH.

  random_scenes.py [--only REGEX] [--scenes N] [--list]

Blocks of 4 x 4 pixels are compared by their means over seeds (Welch's t, as z), and so are the whole pictures. A scene fails where a z
is beyond what one in a thousand such runs shows anywhere (Sidak), twice. open_rows.txt names known faults: a scene and a way.
"""
import argparse
import random
import re
import sys
import time
from statistics import NormalDist

from body_checks import lit_blocks
from features import FEATURES, KINDS, WAYS, Scenery
from measure import SIGNIFICANCE, same_blocks
from rules import OPEN

SHAPES = ("face to face", "below glass", "glass on its face", "pyramid")  # of the main body: one, and no relief on it
VIEWS = ("cut", "camera inside")
RELIEF = ("normal map", "displacement", "inner shell")


def sceneries(count):
    """Scenes of three to five features; at most one shape, one view and one second body of another kind."""
    found, number = [], 0
    while len(found) < count:
        draw = random.Random(number)
        number += 1
        chosen = draw.sample([*FEATURES, *KINDS[1:]], draw.choice((3, 3, 4, 5)))
        shapes, views, reliefs, kinds = (sum(c in group for c in chosen) for group in (SHAPES, VIEWS, RELIEF, KINDS))
        if shapes <= 1 and views <= 1 and kinds <= 1 and not (shapes and reliefs):
            found.append(Scenery(draw.choice(KINDS), tuple(chosen)))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="")
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    chosen = [s for s in sceneries(options.scenes) if re.search(options.only, s.name)]
    if options.list:
        return print("\n".join(s.name for s in chosen))
    ways = [way for way in WAYS if way != "as is"]
    comparisons = options.scenes * len(ways) * 17
    limit = NormalDist().inv_cdf(1 - (1 - (1 - SIGNIFICANCE) ** (1 / comparisons)) / 2)
    failed = 0
    for scenery in chosen:
        begin = time.process_time()
        found = {way: same_blocks(lit_blocks(scenery, way), lit_blocks(scenery, "as is"), limit) for way in ways}
        wrong = [way for way in ways if not found[way].holds]
        fails = any((scenery.name, way) not in OPEN for way in wrong)
        failed += fails
        text = "; ".join(f"{way}: {found[way].text}" for way in wrong or ways)
        verdict = "FAILS" if fails else "open" if wrong else "holds"
        print(f"{verdict}: {scenery.name}: {text} [{time.process_time() - begin:.0f} s]", flush=True)
    print(f"{len(chosen) - failed} of {len(chosen)} scenes hold or are open; z up to {limit:.2f} of {comparisons} comparisons")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
